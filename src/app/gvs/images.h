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
struct Frame {
  vision::Image image;
  double stamp_s{};
  std::string name;  ///< file, or number
};

/// Pictures one after the other, from wherever they come.
class ImageSource {
 public:
  virtual ~ImageSource() = default;
  /// Nothing: there are no more. Fails ("gvs.image") on one that cannot be read.
  [[nodiscard]] virtual Result<std::optional<Frame>> next() = 0;
};

/// The pictures of a folder by their names: Netpbm by ourselves, all else by OpenCV. Their stamps stand in its
/// stamps.csv
/// ("file,stamp_s"), else they are so many a second. Fails ("gvs.images") where there are none, and where a stamp is
/// missing or stamps do not rise; ("opencv.missing") where OpenCV is needed and not there.
[[nodiscard]] Result<std::unique_ptr<ImageSource>> folder_images(const std::string& folder, double rate_hz);
/// A video file's, stamped as it says, from 0. Fails ("opencv.missing", "gvs.images").
[[nodiscard]] Result<std::unique_ptr<ImageSource>> video_images(const std::string& file);
/// A camera's (V4L2), stamped by its driver.
[[nodiscard]] Result<std::unique_ptr<ImageSource>> camera_images(std::uint32_t number);
/// One picture file of any kind.
[[nodiscard]] Result<vision::Image> read_image(const std::string& file);

}  // namespace cosiva::app
