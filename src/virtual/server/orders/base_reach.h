#pragma once

#include <optional>

#include "cosiva/base/time.h"
#include "cosiva/virtual/server/orders/order_rules.h"
#include "cosiva/virtual/server/registry/proxy.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::virtual_side {

/// How far a released base may reach beyond the last reported position of its vehicle.
///
/// A CoSiVA vehicle brakes by itself when it receives nothing more from its server or broker: its base reaches
/// OrderRules::base_reach_m, and to the node beyond. A third-party vehicle drives on to its last released node (VDA
/// 5050 §6.10), so that its base is limited to the distance that it drives within OrderRules::permitted_time. The time
/// counts from the last report: from an old report, a base is extended no further than from a new one.
///
/// The limit is never below the distance that keeps the vehicle at its speed until the next update reaches it: the
/// distance driven between a report and the update that follows it, and the braking distance. For this distance a node
/// beyond the limit is released where there is no nearer one, and a crossing is released as a whole.
///
/// Invariant: 0 < needed_m() <= limit_m() at each speed.
class BaseReach {
 public:
  /// @param now  the server's time, for the age of the vehicle's last report
  BaseReach(const AivProxy& vehicle, const zone::TrafficZone& zone, const OrderRules& rules, SimTime now);

  /// Whether a base that reaches `reach_m` is extended to `end_m` [m], both from the last reported position.
  /// @param speed_mps_max  the speed limit of the extension; nothing: the zone's fast speed
  [[nodiscard]] bool extends(double reach_m, double end_m, std::optional<double> speed_mps_max = {}) const;

  /// No base that reaches as far is extended [m].
  [[nodiscard]] double wanted_m() const { return wanted_m_; }
  /// The distance that keeps the vehicle at its speed until the next update [m].
  [[nodiscard]] double needed_m(std::optional<double> speed_mps_max = {}) const;
  /// Infinite: no limit [m].
  [[nodiscard]] double limit_m(std::optional<double> speed_mps_max = {}) const;

 private:
  [[nodiscard]] double speed_mps(std::optional<double> speed_mps_max) const;

  bool limited_;
  double speed_mps_;     ///< the highest speed of the vehicle's orders
  double braking_mps2_;  ///< by which the vehicle can stop
  double latency_s_;     ///< from a report to the wheels, through the next update
  double permitted_s_;
  double wanted_m_;
};

}  // namespace cosiva::virtual_side
