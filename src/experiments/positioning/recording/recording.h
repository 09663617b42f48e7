#pragma once

#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cosiva/base/pose.h"
#include "cosiva/base/result.h"

/// What was recorded of one drive: what the vehicle was told by its sensors, and where it truly was.
namespace cosiva::experiments {

struct Recording {
  struct Step {
    double t_s;         ///< when it was complete
    double duration_s;  ///< since when it counts
    double distance_m;
    double turn_rad;
    double distance_variance_m2{0.0};  ///< what it may be off by beyond the odometer's own figures
    double turn_variance_rad2{0.0};
    double left_m{0.0};  ///< sideways, of who can
  };
  struct ReceivedRange {
    double t_s;
    std::uint32_t station;
    double range_m;
  };
  struct Sighted {
    double t_s;
    std::uint32_t fiducial;
    Point2 detected_B;
  };
  struct True {
    double t_s;
    Point2 position_M;
    double heading_rad;
  };

  std::string name;
  std::vector<Step> odometry;         ///< stamps rise
  bool odometry_had_speeds{false};    ///< which have become distances
  bool turns_from_wheels{false};      ///< from how differently they roll; else a gyroscope may have told them
  std::vector<ReceivedRange> ranges;  ///< in the order of their stamps, as are readings
  std::vector<Sighted> readings;
  std::vector<True> ground_truth;  ///< stamps rise
  bool ground_truth_has_heading{false};
  std::map<std::uint32_t, Point2> beacons;  ///< stations and marks, by number
  std::map<std::string, double> sensors;    ///< figures of sensors that came with it, by their names in SensorModel
  std::vector<std::string> diagnostics{};   ///< what was made of it, in sentences
};

/// A folder's files, by name.
using RecordingFiles = std::map<std::string, std::string>;

/// Our own tables: odometry.csv (time_s, delta_distance_m, delta_heading_rad; or time_s, speed_mps, turn_radps; and
/// delta_left_m or speed_left_mps of who goes sideways, too), groundtruth.csv (time_s, x_m, y_m, and heading_rad where
/// it is known), beacons.csv (beacon_id, x_m, y_m), ranges.csv (time_s, receiver_id or beacon_id, range_m),
/// readings.csv (time_s, beacon_id, and ahead_m, left_m where the reader tells them), sensors.csv (name, value). Or
/// libRSF's text: one file …Input.txt with range2 and odom2diff or odom2, one …GT.txt with point2 and perhaps angle.
/// Fails ("recording.…") with file and line.
[[nodiscard]] Result<Recording> read_recording(std::string_view name, const RecordingFiles& files);

}  // namespace cosiva::experiments
