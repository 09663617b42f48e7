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

/// From pictures to what is said of them on the bus: vehicles found, named and stamped by our clock, and the small
/// picture for people. It knows no camera, no broker and no clock.
class GvsCamera {
 public:
  /// The page's picture is at most so wide and high: grey, 230 kB.
  static constexpr std::size_t shown_px_max = 480;

  GvsCamera(vision::Calibration calibration, const vision::TrackerOptions& options, std::map<int, std::string> names);

  /// Fails ("gvs.image") on a picture of another size than the calibration's.
  /// @param began  when the exposure of its first row began; it rises (others are passed over: nothing is seen)
  [[nodiscard]] Result<wire::GvsDetections> see(const vision::Image& image, SimTime began, double period_s);
  /// The last picture that was seen, smaller, as Netpbm's P5. Its comment says where its vehicles are on it:
  /// {"timestamp","sights":[{"vehicle","tag","x","y","heading","outline":[[u,v]…],"nose":[u,v]}]}.
  /// @param body  whose outline is drawn
  [[nodiscard]] std::string shown(const vision::Image& image, const wire::GvsDetections& detections,
                                  const zone::VehicleShape& body) const;
  /// What of the floor it sees so that a whole tag fits in.
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

/// "7=CoSiVA/AIV1" …; a tag that nobody names is `AIV <tag>` of ours. Fails ("gvs.vehicle").
[[nodiscard]] Result<std::map<int, std::string>> read_vehicle_names(const std::vector<std::string>& given);
/// What a tracker is told of this source.
[[nodiscard]] vision::TrackerOptions tracker_options(const GvsSource& source);

}  // namespace cosiva::app
