#pragma once

#include <memory>
#include <string>

#include "cosiva/physical/vision/image.h"

/// What stands between the command and OpenCV, whose forty libraries are opened only where a picture needs them
/// (pictures.cpp opens cosiva_opencv.so, opencv_pictures.cpp is it).
namespace cosiva::app {

class OpencvStream {
 public:
  virtual ~OpencvStream() = default;
  /// False: there are no more.
  [[nodiscard]] virtual bool next(vision::Image& image, double& stamp_s) = 0;
};

class Opencv {
 public:
  virtual ~Opencv() = default;
  /// An encoded picture's bytes. False: they are none that it knows.
  [[nodiscard]] virtual bool decode(const std::string& bytes, vision::Image& image) const = 0;
  /// Null where it cannot be opened.
  [[nodiscard]] virtual std::unique_ptr<OpencvStream> open_video(const std::string& file) const = 0;
  [[nodiscard]] virtual std::unique_ptr<OpencvStream> open_camera(int number) const = 0;
};

}  // namespace cosiva::app
