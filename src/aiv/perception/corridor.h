#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <optional>

#include "cosiva/aiv/perception/path_look_ahead.h"
#include "cosiva/wire/messages/board.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::aiv {

/// What the vehicle's body will sweep on its way ahead, and whether something stands in it.
///
/// Echoes count when they can lie within the body's width plus a margin on each side of the circuit's own curve ahead
/// of the believed place, along the way it will take: on an arc the corridor bends, and the neighbouring lane stays
/// outside.
class Corridor {
 public:
  struct Model {
    double margin_m{0.02};         ///< on each side of the body
    double sample_m{0.03};         ///< between two points of the way ahead
    double reach_m{1.30};          ///< of the vehicle's middle, ahead
    double beam_ratio{1.0 / 3.0};  ///< an echo may come from this share of a beam's width to either side of its middle
  };
  explicit Corridor(const zone::TrafficZone& zone) : Corridor{zone, Model{}} {}
  Corridor(const zone::TrafficZone& zone, Model model);

  /// Distance along the way from the vehicle's front to the nearest echo in its corridor; infinite when none is.
  [[nodiscard]] double obstacle_ahead_m(const Outlook& outlook, const wire::Ranges& ranges) {
    return scan(outlook, ranges).ahead_m;
  }

  /// The nearest echo in the corridor, and which beam brought it.
  struct Scan {
    double ahead_m{std::numeric_limits<double>::infinity()};
    std::size_t beam{};
  };
  [[nodiscard]] Scan scan(const Outlook& outlook, const wire::Ranges& ranges);
  /// From the vehicle's middle to the nearest echo all around, as far as the beams look; infinite when there is none.
  /// What matters to a body that turns on the spot.
  [[nodiscard]] double nearest_m(const wire::Ranges& ranges) const;
  /// Whether `test` holds for an echo, in the body's frame, in the middle of its beam.
  template <class Test>
  [[nodiscard]] bool any_echo(const wire::Ranges& ranges, Test test) const {
    for (std::size_t beam = 0; beam < ranges.range_mm.size(); ++beam)
      if (ranges.range_mm[beam] != wire::no_echo && test(echo(ranges, beam))) return true;
    return false;
  }
  /// So far from its front the vehicle can tell whether its way is free.
  [[nodiscard]] double reach_m() const { return model_.reach_m - 0.5 * zone_.vehicle.length_m; }

 private:
  [[nodiscard]] Point2 echo(const wire::Ranges& ranges, std::size_t beam) const;
  /// From the vehicle's front along the way to one echo; infinite outside the corridor.
  [[nodiscard]] double echo_ahead_m(double range_m, double bearing_rad, double spread_rad) const;

  const zone::TrafficZone& zone_;
  Model model_;
  PathLookAhead path_ahead_;
};

/// The median of the last three frames: neither one echo missed nor one echo too many changes what the agent does.
class ObstacleFilter {
 public:
  /// @param travelled_m  the vehicle's own odometer, so that old frames stay comparable while it drives
  void add(double obstacle_ahead_m, double travelled_m);
  [[nodiscard]] double obstacle_ahead_m(double travelled_m) const { return median_m_ - travelled_m; }
  void clear() { *this = {}; }

 private:
  static constexpr double nothing = std::numeric_limits<double>::infinity();
  std::array<double, 3> detected_m_{nothing, nothing, nothing};  ///< along the odometer
  std::size_t next_{0};
  double median_m_{nothing};
};

}  // namespace cosiva::aiv
