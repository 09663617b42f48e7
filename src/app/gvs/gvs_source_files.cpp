#include "cosiva/app/gvs/gvs_source_files.h"

#include "cosiva/adapters/files.h"
#include "cosiva/physical/vision/calibration_json.h"

namespace cosiva::app {

Result<std::unique_ptr<ImageSource>> open_images(const GvsSource& source) {
  if (!source.images_folder.empty()) return folder_images(source.images_folder, source.rate_hz);
  if (!source.video_file.empty()) return video_images(source.video_file);
  return camera_images(source.camera.value_or(0));
}

Result<vision::Calibration> read_calibration_file(const std::string& file) {
  const auto text = adapters::read_file(file);
  if (!text) return tl::unexpected(text.error());
  return vision::read_calibration(*text, file);
}

}  // namespace cosiva::app
