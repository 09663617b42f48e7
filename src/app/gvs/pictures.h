#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/physical/vision/image.h"

namespace cosiva::app {

/// One picture, and when the exposure of its first row began, by the clock of whoever took it.
struct Picture {
  vision::Image image;
  double stamp_s{};
  std::string name;  ///< file, or number
};

/// Pictures one after the other, from wherever they come.
class Pictures {
 public:
  virtual ~Pictures() = default;
  /// Nothing: there are no more. Fails ("gvs.picture") on one that cannot be read.
  [[nodiscard]] virtual Result<std::optional<Picture>> next() = 0;
};

/// The pictures of a folder by their names: Netpbm by ourselves, all else by OpenCV. Their stamps stand in its
/// stamps.csv
/// ("file,stamp_s"), else they are so many a second. Fails ("gvs.pictures") where there are none, and where a stamp is
/// missing or stamps do not rise; ("opencv.missing") where OpenCV is needed and not there.
[[nodiscard]] Result<std::unique_ptr<Pictures>> folder_pictures(const std::string& folder, double rate_hz);
/// A video file's, stamped as it says, from 0. Fails ("opencv.missing", "gvs.pictures").
[[nodiscard]] Result<std::unique_ptr<Pictures>> video_pictures(const std::string& file);
/// A camera's (V4L2), stamped by its driver.
[[nodiscard]] Result<std::unique_ptr<Pictures>> camera_pictures(std::uint32_t number);
/// One picture file of any kind.
[[nodiscard]] Result<vision::Image> read_picture(const std::string& file);

}  // namespace cosiva::app
