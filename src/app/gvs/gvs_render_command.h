#pragma once

#include <cstdint>
#include <string>

namespace cosiva::app {

/// The options of `cosiva gvs render`.
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

/// `cosiva gvs render`: renders images of the emulated world, with the ground truth. Gives the exit status: 0 done, 1
/// the run's own checks failed, 2 bad usage or bad input.
int run_gvs_render(const GvsRenderArguments& arguments);

}  // namespace cosiva::app
