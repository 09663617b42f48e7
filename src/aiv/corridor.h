#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <vector>

#include "wire/board.h"
#include "zone/traffic_zone.h"

namespace cosiva::aiv {

/// What the vehicle's body will sweep on its way ahead, and whether something stands in it.
///
/// Echoes count when they can lie within the body's width plus a margin on each side of the circuit's own curve ahead
/// of the believed place: on an arc the corridor bends, and the neighbouring lane stays outside.
class Corridor {
 public:
  struct Model {
    double margin_m{0.02};         ///< on each side of the body
    double sample_m{0.03};         ///< between two points of the way ahead
    double reach_m{1.30};          ///< of the vehicle's middle, ahead
    double beam_share{1.0 / 3.0};  ///< an echo may come from this share of a beam's width to either side of its middle
  };
  explicit Corridor(const zone::TrafficZone& zone) : Corridor{zone, Model{}} {}
  Corridor(const zone::TrafficZone& zone, Model model);

  /// Distance along the way from the vehicle's front to the nearest echo in its corridor; infinite when none is.
  /// @param here  where the vehicle's middle is
  [[nodiscard]] double obstacle_ahead_m(zone::Place here, const wire::Ranges& ranges);

 private:
  void sample_way(zone::Place here);
  struct Beside {
    std::size_t sample;
    double distance2_m2;
  };
  /// The sample of the way nearest to p.
  [[nodiscard]] Beside beside(Point2 p_B) const;
  /// From the vehicle's middle along the way to the place beside p, near the sample.
  [[nodiscard]] double along_way_m(Point2 p_B, std::size_t sample) const;
  /// From the vehicle's front along the way to one echo; infinite outside the corridor.
  [[nodiscard]] double echo_ahead_m(double range_m, double bearing_rad, double spread_rad) const;

  const zone::TrafficZone& zone_;
  Model model_;
  std::vector<Point2> way_B_;  ///< points ahead, in the body frame; kept to spare allocations
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
  std::array<double, 3> seen_m_{nothing, nothing, nothing};  ///< along the odometer
  std::size_t next_{0};
  double median_m_{nothing};
};

}  // namespace cosiva::aiv
