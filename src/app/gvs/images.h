#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/physical/vision/image.h"

namespace cosiva::app {

/// One image, and when the exposure of its first row began, by the clock of its source.
struct Frame {
  vision::Image image;
  double stamp_s{};
  std::string name;  ///< file, or number
};

/// Images in sequence, from any source.
class ImageSource {
 public:
  virtual ~ImageSource() = default;
  /// Nothing: there are no more images. Fails ("gvs.image") on an image that cannot be read.
  [[nodiscard]] virtual Result<std::optional<Frame>> next() = 0;
};

/// The images of a folder in the order of their names: Netpbm is read directly, all else by OpenCV. Their stamps are
/// those of its stamps.csv ("file,stamp_s"), else they follow from the rate. Fails ("gvs.images") where there are no
/// images, and where a stamp is missing or stamps do not rise; ("opencv.missing") where OpenCV is needed and missing.
[[nodiscard]] Result<std::unique_ptr<ImageSource>> folder_images(const std::string& folder, double rate_hz);
/// The images of a video file, with the stamps of the file, from 0. Fails ("opencv.missing", "gvs.images").
[[nodiscard]] Result<std::unique_ptr<ImageSource>> video_images(const std::string& file);
/// The images of a camera (V4L2), stamped by its driver.
[[nodiscard]] Result<std::unique_ptr<ImageSource>> camera_images(std::uint32_t number);
/// One image file of any kind.
[[nodiscard]] Result<vision::Image> read_image(const std::string& file);

}  // namespace cosiva::app
