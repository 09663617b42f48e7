#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cosiva/app/gvs/gvs_source.h"
#include "cosiva/base/time.h"
#include "cosiva/physical/vision/calibration.h"
#include "cosiva/physical/vision/tracker.h"
#include "cosiva/wire/own/gvs.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::app {

/// Turns images into the published detections: vehicles found, named and stamped by our clock, and the small preview
/// image for display. The pipeline knows no camera, no broker and no clock.
class GvsCamera {
 public:
  /// Largest width and height of the preview image: grey, 230 kB.
  static constexpr std::size_t shown_px_max = 480;

  GvsCamera(vision::Calibration calibration, const vision::TrackerOptions& options, std::map<int, std::string> names);

  /// Fails ("gvs.image") on an image of another size than the calibration's.
  /// @param began  when the exposure of the image's first row began; must rise (other images are ignored without
  /// detections)
  [[nodiscard]] Result<wire::GvsDetections> see(const vision::Image& image, SimTime began, double period_s);
  /// The last processed image, smaller, as Netpbm's P5. Its comment lists the vehicles' positions in the image:
  /// {"timestamp","detections":[{"vehicle","tag","x","y","heading","outline":[[u,v]…],"nose":[u,v]}]}.
  /// @param body  whose outline is drawn
  [[nodiscard]] std::string shown(const vision::Image& image, const wire::GvsDetections& detections,
                                  const zone::VehicleShape& body) const;
  /// The part of the floor that the camera observes such that a whole tag is in the image.
  [[nodiscard]] const std::vector<Point2>& field() const { return field_; }

 private:
  [[nodiscard]] std::string name_of(int tag) const;
  [[nodiscard]] std::optional<vision::PixelPoint> pixel_of(Point2 position, int tag) const;

  vision::Calibration calibration_;
  vision::Tracker tracker_;
  std::map<int, std::string> names_;
  std::vector<Point2> field_;
  std::optional<SimTime> first_;
  SimTime last_{};
  std::uint32_t header_id_{0};
};

/// "7=CoSiVA/AIV1" …; a tag without a given name is `AIV <tag>`, a CoSiVA vehicle. Fails ("gvs.vehicle").
[[nodiscard]] Result<std::map<int, std::string>> read_vehicle_names(const std::vector<std::string>& given);
/// The tracker's options for this source.
[[nodiscard]] vision::TrackerOptions tracker_options(const GvsSource& source);

}  // namespace cosiva::app
