#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cosiva/app/gvs/images.h"
#include "cosiva/base/json_value.h"
#include "cosiva/base/time.h"
#include "cosiva/physical/vision/calibration.h"
#include "cosiva/physical/vision/painter.h"
#include "cosiva/physical/vision/points.h"
#include "cosiva/physical/vision/scene.h"
#include "cosiva/zone/drawing/draw.h"
#include "cosiva/zone/layout/traffic_zone.h"

/// The emulated world as a camera's scene: for `cosiva gvs render`, and for a platform without a real camera.
namespace cosiva::app {

/// The selectable properties of a camera above the centre of a zone.
struct SceneChoice {
  std::uint32_t size_px{1024};
  double height_m{3.3};
  double tag_height_m{0.10};
  double exposure_ms{4.0};
  double rolling_ms{0.0};
  double noise_grey{2.0};
  double brightness{1.0};
};
/// A camera whose focal length is the longest that shows all of the area.
[[nodiscard]] vision::SceneCamera camera_over(const zone::Bounds& bounds, const SceneChoice& choice);
/// The painted lines of a zone's drawing.
[[nodiscard]] std::vector<vision::SceneLine> lines_of(const std::vector<zone::Primitive>& primitives);
/// The corners of a printed grid as read off an image: 0.1 m apart on floors of a room's size.
[[nodiscard]] std::vector<vision::FloorPoint> corners_of(const vision::SceneCamera& camera, std::uint64_t seed);

/// A vehicle's ground truth from the plant (wire::ground_truth_topic).
struct TruthfulVehicle {
  std::uint32_t number{};
  Pose2 X_MB{};
  double speed_mps{};
};
struct GroundTruth {
  SimTime at{};
  std::vector<TruthfulVehicle> vehicles;
};
/// Nothing where the message is no ground truth: any client may publish on the topic.
[[nodiscard]] std::optional<GroundTruth> read_plant_ground_truth(const std::string& json);

/// The emulated world's camera over a running plant's zone. Its knowledge is that of a real camera's owner: the camera
/// is calibrated from floor corners, and delivers images. AIV n carries tag n.
class EmulatedCamera {
 public:
  static constexpr std::uint32_t size_px = 960;  ///< the page shows half of it
  static constexpr double tag_px_min = 24.0;     ///< with smaller tags the camera observes only the centre of the zone

  /// Fails as vision::calibrate does.
  [[nodiscard]] static Result<EmulatedCamera> over(const zone::TrafficZone& zone);
  [[nodiscard]] const vision::Calibration& calibration() const { return calibration_; }
  [[nodiscard]] double tag_side_m() const { return tag_side_m_; }
  [[nodiscard]] double exposure_s() const { return painter_.camera().exposure_s; }
  /// Width of the floor in the image, from side to side.
  [[nodiscard]] double width_m() const { return width_m_; }
  /// Renders all vehicles at that moment. Vehicles turn as they did since the previous ground truth.
  [[nodiscard]] vision::Image take(const GroundTruth& ground_truth, const std::optional<GroundTruth>& before);

 private:
  EmulatedCamera(vision::Calibration calibration, vision::Painter painter, zone::VehicleShape shape, double tag_side_m,
                 double width_m);
  vision::Calibration calibration_;
  vision::Painter painter_;
  zone::VehicleShape shape_;
  double tag_side_m_;
  double width_m_;
  std::uint64_t images_{0};
};

}  // namespace cosiva::app
