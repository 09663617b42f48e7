#pragma once

#include <cstdint>
#include <optional>

#include "aiv/motion.h"
#include "zone/traffic_zone.h"

namespace cosiva::aiv {

/// What the vehicle knows about its own sensors, and how it doubts them.
struct EstimatorModel {
  double sigma_start_m{0.01};        ///< standard deviation of a place that was told
  double sigma_fix_m{0.004};         ///< after a tag or beacon
  double variance_per_m{1e-4};       ///< of odometry: 1 cm per √m
  double antenna_range_m{0.020};     ///< a tag reports when it enters the field: this long before the antenna is on it
  double reading_latency_s{0.020};   ///< from the field to the age stamp of the frame, and the way of the frame to us
  double beacon_gate_m{0.30};        ///< a beacon further from the belief than this contradicts it
  double tag_gate_m{0.60};           ///< likewise a tag
  double sigma_reset_m{0.05};        ///< added when the odometer starts anew
  double odometry_step_m_max{0.50};  ///< more between two readings is a board that counts from zero again
};

/// Where the vehicle believes it is: the article's motion on the circuit fed by odometry, rectified at tags and beacons
/// (A21). It knows nothing until somebody tells a place or a tag is read.
class PositionEstimator {
 public:
  explicit PositionEstimator(const zone::TrafficZone& zone, EstimatorModel model = {});

  [[nodiscard]] bool known() const { return known_; }
  [[nodiscard]] zone::Place place() const { return motion_.place(zone_.circuit); }
  [[nodiscard]] Pose2 pose() const { return motion_.pose(zone_.circuit); }
  [[nodiscard]] const AivMotion& motion() const { return motion_; }
  /// Standard deviation along the circuit; grows with the distance since the last fix.
  [[nodiscard]] double sigma_m() const;
  /// Total of all odometry steps, forwards positive, whatever the corrections.
  [[nodiscard]] double travelled_m() const { return travelled_m_; }
  [[nodiscard]] std::optional<std::int64_t> odometer_um() const { return odometer_um_; }

  /// Somebody tells the place: configuration, memory, initPosition.
  void place_at(zone::Place place);
  /// The nearest place on the circuit to a pose, within `distance_m_max` and looking the same way; nothing otherwise.
  [[nodiscard]] std::optional<zone::Place> on_circuit(const Pose2& X_MB, double distance_m_max) const;

  /// Takes the odometer's reading. Gives the step that the belief made [m].
  double on_odometry(std::int64_t distance_um);
  /// The board counts from zero again: the next reading is a new beginning, and what rolled meanwhile is not known.
  void on_odometer_reset();

  enum class FixKind {
    none,       ///< an unknown number, or a beacon that says nothing
    corrected,  ///< the belief moved a little along the circuit
    relocated,  ///< the belief was wrong, and jumped
    outlier,    ///< it contradicts the belief and is alone in that
  };
  struct Fix {
    FixKind kind{FixKind::none};
    double correction_m{};  ///< for `corrected`: along the circuit, forwards positive
  };
  /// @param number     a tag's, or a beacon's
  /// @param age_s      how long ago it was read when its frame was sent
  /// @param speed_mps  of the vehicle since
  Fix on_tag(std::uint32_t number, double age_s, double speed_mps);
  /// Beacons stand elsewhere now: the last strange one tells nothing any more.
  void forget_doubt() { doubt_.reset(); }

  [[nodiscard]] std::optional<zone::TagNumber> last_tag() const { return last_tag_; }
  [[nodiscard]] double since_last_tag_m() const { return travelled_m_ - last_tag_travelled_m_; }

 private:
  struct Sighting {
    Point2 beacon;
    double travelled_m;
  };
  /// `latency_m`: driven since the reading.
  Fix on_landmark(zone::Place place, double latency_m);
  Fix on_beacon(Point2 beacon, double latency_m);
  Fix on_strange_beacon(Point2 beacon, double latency_m);
  Fix jump_to(zone::Place place);
  /// Along the circuit from the belief to `place`, negative backwards; nothing beyond `limit_m`.
  [[nodiscard]] std::optional<double> offset_to(zone::Place place, double limit_m) const;

  const zone::TrafficZone& zone_;
  EstimatorModel model_;
  bool known_{false};
  AivMotion motion_;
  double variance_m2_{};
  double travelled_m_{};
  std::optional<std::int64_t> odometer_um_;
  std::optional<zone::TagNumber> last_tag_;
  double last_tag_travelled_m_{};
  std::optional<Sighting> doubt_;  ///< the last beacon, when it contradicted the belief
};

}  // namespace cosiva::aiv
