#pragma once

#include <memory>
#include <string>

#include "cosiva/app/gvs/gvs_source.h"
#include "cosiva/app/gvs/images.h"
#include "cosiva/base/result.h"
#include "cosiva/physical/vision/calibration.h"

namespace cosiva::app {

/// Opens the images of a real camera: a folder's, a video's or the camera itself. Fails as folder_images,
/// video_images and camera_images do.
/// @param source  not the emulated world's camera
[[nodiscard]] Result<std::unique_ptr<ImageSource>> open_images(const GvsSource& source);
/// A calibration from its file. Fails as reading a file and vision::read_calibration do.
[[nodiscard]] Result<vision::Calibration> read_calibration_file(const std::string& file);

}  // namespace cosiva::app
