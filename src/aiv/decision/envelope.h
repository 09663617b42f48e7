#pragma once

#include <cstddef>
#include <limits>
#include <vector>

#include "cosiva/aiv/motion/formulas.h"
#include "cosiva/aiv/motion/outlook.h"
#include "cosiva/aiv/order/order_book.h"
#include "cosiva/base/time.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::aiv {

/// Where crossings lie on the way ahead. Those that follow each other too closely for a vehicle to stand between count
/// as one: a chain.
class CrossingLookAhead {
 public:
  explicit CrossingLookAhead(const zone::TrafficZone& zone);

  /// The first chain that the vehicle's middle has not entered yet; distances along its way.
  struct Chain {
    double entry_m{std::numeric_limits<double>::infinity()};  ///< ≥ 0
    double exit_m{std::numeric_limits<double>::infinity()};
  };
  /// Looks `reach_m` ahead for an entry; a chain found is followed to its exit however long it is.
  [[nodiscard]] Chain first(const Outlook& outlook, double reach_m) const;

 private:
  struct Span {
    double from_m;
    double to_m;
  };
  const zone::Circuit& circuit_;
  double gap_m_;                          ///< shorter gaps join
  std::vector<std::vector<Span>> spans_;  ///< by section, merged, in order of s
};

/// How fast it comes to a bend on the spot.
inline constexpr double bend_creep_mps = 0.05;

/// How fast the vehicle may go, whatever its agent wishes (DESIGN §4.5): crisp, and it can only lower.
struct Limit {
  double speed_mps;           ///< ≥ 0
  double braking_mps2;        ///< the profile's, or the hardest where the profile's does not suffice any more
  bool by_obstacle{false};    ///< an obstacle is what limits
  double crossing_ahead_m{};  ///< to the next crossing it may not enter yet; infinite when none is near
  double bend_ahead_m{std::numeric_limits<double>::infinity()};  ///< to the next bend on the spot, if one is near
};

/// How late what it decides shows at the wheels; its envelope allows for that much.
struct Lateness {
  double command_s{reaction_s};
  double obstacle_s{obstacle_reaction_s};
  /// Of a vehicle that decides, and whose boards speak, once in `cycle`.
  [[nodiscard]] static Lateness of(SimDuration cycle);
};

class Envelope {
 public:
  explicit Envelope(const zone::TrafficZone& zone, Lateness late = {});

  struct View {
    Outlook outlook;
    double speed_mps;
    double obstacle_ahead_m;  ///< from the vehicle's front; infinite: none
    const OrderBook& order;
  };
  /// @param wish  the profile's kinematics; its speed may be lower than the profile's
  [[nodiscard]] Limit limit(const View& view, const zone::SpeedProfile& target_speed) const;
  /// Of one that joins a line: only what it feels before it limits.
  [[nodiscard]] Limit limit_off_line(double obstacle_ahead_m, const zone::SpeedProfile& target_speed) const;

 private:
  [[nodiscard]] double section_limit_mps(const View& view, const zone::SpeedProfile& target_speed,
                                         double reach_m) const;
  /// To the first joint on the way where the vehicle turns on the spot; infinite beyond reach.
  [[nodiscard]] double bend_ahead_m(const Outlook& outlook, double reach_m) const;
  [[nodiscard]] double edge_limit_mps(const View& view, const zone::SpeedProfile& target_speed) const;

  const zone::TrafficZone& zone_;
  Lateness late_;
  CrossingLookAhead crossings_;
  double braking_mps2_max_;
  bool sections_have_limits_;
  bool has_bends_;
};

}  // namespace cosiva::aiv
