#pragma once

#include <memory>
#include <string>

#include "cosiva/physical/vision/image.h"

/// The interface between the command and OpenCV, whose forty libraries are opened only where an image needs them
/// (images.cpp opens cosiva_opencv.so, which is built from opencv_images.cpp).
namespace cosiva::app {

class OpencvStream {
 public:
  virtual ~OpencvStream() = default;
  /// False: there are no more images.
  [[nodiscard]] virtual bool next(vision::Image& image, double& stamp_s) = 0;
};

class Opencv {
 public:
  virtual ~Opencv() = default;
  /// Decodes an image's bytes. False: the format is unknown.
  [[nodiscard]] virtual bool decode(const std::string& bytes, vision::Image& image) const = 0;
  /// Null where the source cannot be opened.
  [[nodiscard]] virtual std::unique_ptr<OpencvStream> open_video(const std::string& file) const = 0;
  [[nodiscard]] virtual std::unique_ptr<OpencvStream> open_camera(int number) const = 0;
};

}  // namespace cosiva::app
