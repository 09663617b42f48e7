#include "cosiva/app/gvs/gvs_source.h"

#include <filesystem>
#include <string>

#include "cosiva/app/gvs/camera_pipeline.h"
#include "cosiva/app/gvs/gvs_source_files.h"

namespace cosiva::app {

Result<void> check_gvs_source(const GvsSource& source, const std::string& prefix) {
  if (auto names = read_vehicle_names(source.vehicles); !names) {
    Error error = names.error();
    error.location = prefix + "vehicle";
    return tl::unexpected(error);
  }
  if (source.emulated()) {
    if (source.exposure_ms > 0.0 || source.line_us > 0.0 || source.tag_side_m > 0.0 || !source.vehicles.empty()) {
      return fail("gvs.images",
                  "exposure, line, tag-side and vehicle are of a real camera; the emulated world's is known. Give " +
                      prefix + "images DIR, " + prefix + "video FILE or " + prefix + "camera N",
                  prefix + "camera");
    }
    if (source.calibration_file.empty()) return {};
    return fail("gvs.images",
                "the source of the images is missing. Give " + prefix + "images DIR, " + prefix + "video FILE or " +
                    prefix + "camera N; the emulated world's camera needs no calibration",
                prefix + "calibration");
  }
  if (source.calibration_file.empty()) {
    return fail("gvs.calibration", "images of a real camera need its calibration, written by `cosiva gvs calibrate`",
                prefix + "calibration");
  }
  if (auto calibration = read_calibration_file(source.calibration_file); !calibration)
    return tl::unexpected(calibration.error());
  if (source.camera) {
    const std::string device = "/dev/video" + std::to_string(*source.camera);
    if (!std::filesystem::exists(device)) return fail("gvs.images", "there is no such camera", device);
    return {};
  }
  if (auto opened = open_images(source); !opened) return tl::unexpected(opened.error());
  return {};
}

}  // namespace cosiva::app
