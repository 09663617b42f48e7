#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace cosiva::app {

/// The options of `cosiva gvs calibrate`.
struct GvsCalibrateArguments {
  std::string points_file;
  std::string board_file;
  std::string images_folder;
  std::string size{"2048x2048"};
  std::string model{"best"};
  std::uint32_t degree{5};
  double block_m{0.8};
  double camera_height_m{0.0};
  std::vector<double> camera_foot_m;
  double tag_height_m{0.0};
  std::optional<double> tag_height_error_m;
  std::optional<double> mount_error_m;
  std::vector<double> mount;  ///< x, y [m], heading [deg] of the tag on its vehicle
  std::string poses_file;
  std::vector<double> pose_xs_m;
  std::vector<double> pose_ys_m;
  std::uint32_t pose_headings{8};
  std::string name;
  std::string out_folder;
  bool json{false};
};

/// `cosiva gvs calibrate`: a camera's calibration from floor points or from images of a board. Gives the exit status: 0
/// done, 1 the run's own checks failed, 2 bad usage or bad input.
int run_gvs_calibrate(const GvsCalibrateArguments& arguments);

}  // namespace cosiva::app
