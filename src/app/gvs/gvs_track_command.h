#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace cosiva::app {

/// The options of `cosiva gvs track`.
struct GvsTrackArguments {
  std::string calibration_file;
  std::string images_folder;
  std::string video_file;
  std::optional<std::uint32_t> camera;
  double rate_hz{20.0};
  std::uint32_t images_max{0};  ///< 0: all
  double exposure_ms{0.0};
  double line_us{0.0};
  double tag_side_m{0.0};
  std::vector<int> expected;
  std::vector<std::string> against;  ///< "TAG=FILE" or a folder of tag_N.tum
  std::string out_folder;
  bool json{false};
};

/// `cosiva gvs track`: tracks the vehicles in recorded images. Gives the exit status: 0 done, 1 the run's own checks
/// failed, 2 bad usage or bad input.
int run_gvs_track(const GvsTrackArguments& arguments);

}  // namespace cosiva::app
