#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "cosiva/aiv/perception/path_look_ahead.h"
#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/math.h"
#include "cosiva/wire/messages/board.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::aiv {

/// The floor that the vehicle's body will sweep on its path ahead, and whether an obstacle is in it.
///
/// Echoes count when they can lie within the body's width plus a margin on each side of the circuit's own curve ahead
/// of the estimated position, along the vehicle's route: on an arc the corridor bends, and the neighbouring lane stays
/// outside. Invariant: the corridor is at least as wide as the body, and an echo lies within its own beam.
class Corridor {
 public:
  struct Model {
    double margin_m{0.02};         ///< on each side of the body
    double sample_m{0.03};         ///< between two points of the path ahead
    double reach_m{1.30};          ///< of the body origin, ahead
    double beam_ratio{1.0 / 3.0};  ///< an echo may lie this ratio of a beam's width to either side of the beam's centre
  };
  explicit Corridor(const zone::TrafficZone& zone) : Corridor{zone, Model{}} {}
  Corridor(const zone::TrafficZone& zone, Model model);

  /// Distance along the path from the vehicle's front to the nearest echo in its corridor; infinite when there is none.
  [[nodiscard]] double obstacle_ahead_m(const Outlook& outlook, const wire::Ranges& ranges) {
    return scan(outlook, ranges).ahead_m;
  }

  /// The nearest echo in the corridor, and the beam that measured it.
  struct Scan {
    double ahead_m{std::numeric_limits<double>::infinity()};
    std::size_t beam{};
  };
  [[nodiscard]] Scan scan(const Outlook& outlook, const wire::Ranges& ranges);
  /// From the body origin to the nearest echo in any direction, as far as the beams reach; infinite when there is none.
  /// Relevant to a body that turns on the spot.
  [[nodiscard]] double nearest_m(const wire::Ranges& ranges) const;
  /// Whether `test` holds for an echo, in the body's frame, at the centre of its beam.
  template <class Test>
  [[nodiscard]] bool any_echo(const wire::Ranges& ranges, Test test) const {
    for (std::size_t beam = 0; beam < ranges.range_mm.size(); ++beam)
      if (ranges.range_mm[beam] != wire::no_echo && test(echo(ranges, beam))) return true;
    return false;
  }
  /// Distance from the vehicle's front up to which its sensors can establish that the path is free.
  [[nodiscard]] double reach_m() const { return model_.reach_m - 0.5 * zone_.vehicle.length_m; }

 private:
  [[nodiscard]] Point2 echo(const wire::Ranges& ranges, std::size_t beam) const;
  /// Along a beam's centre, and along the lines to both of its sides on which an echo may lie.
  using Beam = std::array<SinCos, 3>;
  /// From the vehicle's front along the path to one echo; infinite outside the corridor.
  [[nodiscard]] double echo_forward_m(double range_m, const Beam& beam, double spread_rad) const;
  /// Computes the beams' directions, unless they are those of the frame before, as for one sensor they always are.
  void aim(const wire::Ranges& ranges);

  const zone::TrafficZone& zone_;
  Model model_;
  PathLookAhead look_ahead_;
  std::vector<Beam> beams_;  ///< of frames with this first bearing and width
  std::int16_t first_bearing_crad_{};
  std::uint16_t beam_width_crad_{};
};

/// The last three frames' median: one missed or false echo changes no decision. Invariant: two frames on either side.
class ObstacleFilter {
 public:
  /// @param travelled_m  the vehicle's own odometer, so that old frames stay comparable while it drives
  void add(double obstacle_ahead_m, double travelled_m);
  [[nodiscard]] double obstacle_ahead_m(double travelled_m) const { return median_m_ - travelled_m; }
  void clear() { *this = {}; }
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  static constexpr double nothing = std::numeric_limits<double>::infinity();
  std::array<double, 3> detected_m_{nothing, nothing, nothing};  ///< along the odometer
  std::size_t next_{0};
  double median_m_{nothing};
};

}  // namespace cosiva::aiv
