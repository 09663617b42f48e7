#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/physical/vision/floor_map.h"

/// The inputs of a calibration: floor positions with known pixels, and vehicles at surveyed poses.
namespace cosiva::vision {

struct FloorPoint {
  Point2 floor;      ///< surveyed [m]
  PixelPoint pixel;  ///< detected
  friend bool operator==(const FloorPoint&, const FloorPoint&) = default;
};

/// A CSV file whose first line names its columns world_x, world_y [m], image_x, image_y [px], in any order, separated
/// by semicolons or commas (one of the two throughout; a separator may end the line). Comments begin with '#'. Fails
/// ("gvs.points") with file and line on a missing or duplicate column, on a line of another width, on a value that is
/// no finite number, on a duplicate pixel or position, and on a file without points.
[[nodiscard]] Result<std::vector<FloorPoint>> read_points(std::string_view text, const std::string& file);
[[nodiscard]] std::string write_points(const std::vector<FloorPoint>& points);

/// The camera's measurement of a vehicle that was stopped at a surveyed pose, averaged over its samples.
struct SurveyedPose {
  Pose2 surveyed;         ///< of the vehicle's reference point [m, rad]
  Pose2 detected;         ///< of its marker, assumed to lie on the floor
  std::size_t samples{};  ///< that `detected` is the mean of
  double stopped_m{};     ///< standard deviation of one sample's position: the stability of the image
};

/// A CSV file with the columns true_x, true_y, true_heading_deg, seen_x, seen_y, seen_heading_deg. Fails ("gvs.poses")
/// as read_points does.
[[nodiscard]] Result<std::vector<SurveyedPose>> read_poses(std::string_view text, const std::string& file);

/// A grid of poses, as a laboratory surveys them: in each x of `xs`, nested in each y of `ys`, every heading.
struct PoseGrid {
  std::vector<double> xs_m;
  std::vector<double> ys_m;
  std::vector<double> headings_rad;
};
/// Lines "x, y, cos, sin, weight," of samples, one pose after the other, without a separator between the poses (CPM
/// Lab's ips_pose_calibration): two rows further apart than `leap` in (x, y, cos, sin) are of two poses, and the poses
/// are in the grid's order: y slowest, then x, heading fastest. Fails ("gvs.poses") on a bad line, and where the number
/// of poses is not that of the grid.
[[nodiscard]] Result<std::vector<SurveyedPose>> read_pose_stops(std::string_view text, const std::string& file,
                                                                const PoseGrid& grid, double leap = 0.4);

}  // namespace cosiva::vision
