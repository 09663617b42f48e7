#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cosiva/base/result.h"

namespace cosiva::app {

/// The image source of a running platform and its properties, as given on the command line (`cosiva gvs watch`, `cosiva
/// up --gvs`).
struct GvsSource {
  std::string calibration_file;  ///< empty: the emulated world's own camera
  std::string images_folder;
  std::string video_file;
  std::optional<std::uint32_t> camera;
  double rate_hz{4.0};
  double exposure_ms{0.0};
  double line_us{0.0};
  double tag_side_m{0.0};
  std::vector<std::string> vehicles;  ///< "7=CoSiVA/AIV1"

  [[nodiscard]] bool emulated() const { return images_folder.empty() && video_file.empty() && !camera; }
};

/// Checks that the source's files and its camera exist and can be read, without using any. Fails ("gvs.images",
/// "gvs.calibration") with the wrong option.
/// @param prefix  of the options, for messages: "--", or "--gvs-" for `up`
[[nodiscard]] Result<void> check_gvs_source(const GvsSource& source, const std::string& prefix);

}  // namespace cosiva::app
