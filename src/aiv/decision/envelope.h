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

/// Where crossings lie on the path ahead. Crossings that follow each other too closely for a vehicle to stop between
/// count as one: a chain.
class CrossingLookAhead {
 public:
  explicit CrossingLookAhead(const zone::TrafficZone& zone);

  /// The first chain that the body origin has not entered yet; distances along the path.
  struct Chain {
    double entry_m{std::numeric_limits<double>::infinity()};  ///< ≥ 0
    double exit_m{std::numeric_limits<double>::infinity()};
  };
  /// Searches for an entry up to `reach_m` ahead; a chain found is followed to its exit whatever its length.
  [[nodiscard]] Chain first(const Outlook& outlook, double reach_m) const;
  /// From the exit of the last crossing to the body origin, along default predecessors; 0 in a crossing; infinite:
  /// there is none on the sections that begin within `reach_m` behind.
  [[nodiscard]] double passed_m(const Outlook& outlook, double reach_m) const;

 private:
  struct Span {
    double from_m;
    double to_m;
  };
  const zone::Circuit& circuit_;
  double gap_m_;                          ///< shorter gaps join
  std::vector<std::vector<Span>> spans_;  ///< by section, merged, in order of s
};

/// Speed of the approach to a bend on the spot.
inline constexpr double bend_creep_mps = 0.05;

/// Upper limit of the vehicle's speed, whatever the agent's target: crisp, and only lowering.
struct Limit {
  double speed_mps;           ///< ≥ 0
  double braking_mps2;        ///< the profile's, or the hardest where the profile's does not suffice any more
  bool by_obstacle{false};    ///< the limit is due to an obstacle
  double crossing_ahead_m{};  ///< to the next crossing that the vehicle may not enter yet; infinite when none is near
  double bend_ahead_m{std::numeric_limits<double>::infinity()};  ///< to the next bend on the spot, if one is near
  /// To where the vehicle must stop whatever happens: the end of the base, or the stop line of a crossing before it.
  double end_m{std::numeric_limits<double>::infinity()};
};

/// Delay until a decision takes effect at the wheels; the envelope allows for this delay.
struct Lateness {
  double command_s{reaction_s};
  double obstacle_s{obstacle_reaction_s};
  /// Of a vehicle that decides, and whose boards report, once in `cycle`.
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
    /// To the first crossing that the vehicles have not agreed upon yet (CrossingNegotiation); infinite: the order
    /// alone determines which crossings the vehicle may enter.
    double barrier_m{std::numeric_limits<double>::infinity()};
    /// To the end of a commanded move, or to a stop for actions (OrderProgress); infinite: neither is near.
    double path_left_m{std::numeric_limits<double>::infinity()};
  };
  /// @param target_speed  the profile's kinematics; its speed may be lower than the profile's
  [[nodiscard]] Limit limit(const View& view, const zone::SpeedProfile& target_speed) const;
  /// As Limit::crossing_ahead_m, but from further away, for the rules.
  [[nodiscard]] double foreseen_m(const Outlook& outlook, const OrderBook& order) const;
  /// From the exit of the last crossing; infinite: none is near.
  [[nodiscard]] double passed_m(const Outlook& outlook) const;
  /// Of a vehicle that joins a path: only a perceived obstacle ahead limits the speed.
  [[nodiscard]] Limit limit_off_path(double obstacle_ahead_m, const zone::SpeedProfile& target_speed) const;

 private:
  [[nodiscard]] double section_limit_mps(const View& view, const zone::SpeedProfile& target_speed,
                                         double reach_m) const;
  /// To the first joint on the path where the vehicle turns on the spot; infinite beyond reach.
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
