#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cosiva/app/cli/common_arguments.h"
#include "cosiva/app/gvs/gvs_source.h"
#include "cosiva/base/result.h"

/// What the command line said of `cosiva gvs`, as plain values.
namespace cosiva::app {

struct GvsRenderArguments {
  std::string zone{"lacet4"};
  std::uint32_t aivs{20};
  double seconds{1.0};
  double warm_up_s{5.0};
  double rate_hz{20.0};
  std::uint32_t size_px{2048};
  double height_m{3.3};
  double tag_height_m{0.10};
  double tag_side_m{0.08};
  double exposure_ms{4.0};
  double rolling_ms{0.0};
  double noise_grey{2.0};
  double brightness{1.0};
  double late_ms{0.0};
  std::uint64_t seed{1};
  std::string out_folder;
  bool json{false};
};

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

struct GvsTrackArguments {
  std::string calibration_file;
  std::string images_folder;
  std::string video_file;
  std::optional<std::uint32_t> camera;
  double rate_hz{20.0};
  std::uint32_t pictures_max{0};  ///< 0: all
  double exposure_ms{0.0};
  double line_us{0.0};
  double tag_side_m{0.0};
  std::vector<int> expected;
  std::vector<std::string> against;  ///< "TAG=FILE" or a folder of tag_N.tum
  std::string out_folder;
  bool json{false};
};

struct GvsWatchArguments {
  PartArguments part;
  GvsSource source;
};

struct GvsArguments {
  GvsRenderArguments render;
  GvsCalibrateArguments calibrate;
  GvsTrackArguments track;
  GvsWatchArguments watch;
};

int run_gvs_render(const GvsRenderArguments& arguments);
int run_gvs_calibrate(const GvsCalibrateArguments& arguments);
int run_gvs_track(const GvsTrackArguments& arguments);
int run_gvs_watch(const GvsWatchArguments& arguments);

/// Whether its files and its camera are there and can be read, without using any yet.
/// @param prefix  of its options, for messages: "--", or "--gvs-" for `up`
[[nodiscard]] Result<void> check_gvs_source(const GvsSource& source, const std::string& prefix);

}  // namespace cosiva::app
