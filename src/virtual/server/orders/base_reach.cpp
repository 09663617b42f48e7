#include "cosiva/virtual/server/orders/base_reach.h"

#include <algorithm>
#include <limits>

#include "cosiva/base/expect.h"
#include "cosiva/virtual/server/right_of_way/traffic.h"

namespace cosiva::virtual_side {
namespace {

/// The lower value. A factsheet reports 0 for a value that it does not state.
double lower(double of_zone, double of_factsheet) {
  return of_factsheet > 0.0 ? std::min(of_zone, of_factsheet) : of_zone;
}

}  // namespace

BaseReach::BaseReach(const AivProxy& vehicle, const zone::TrafficZone& zone, const OrderRules& rules, SimTime now)
    : limited_{!vehicle.is_cosiva() && rules.permitted_time > SimDuration::zero()},
      speed_mps_{zone.profiles.fast.speed_mps},
      braking_mps2_{zone.profiles.medium.braking_mps2},
      latency_s_{Traffic::latency_s + to_seconds(rules.update_period)},
      permitted_s_{to_seconds(rules.permitted_time)},
      wanted_m_{rules.base_reach_m} {
  if (!limited_) return;
  if (const wire::Factsheet* sheet = vehicle.factsheet.last()) {
    speed_mps_ = lower(speed_mps_, sheet->speed_max_mps);
    braking_mps2_ = lower(braking_mps2_, sheet->deceleration_max_mps2);
  }
  // Since its last report the vehicle has driven at most this far.
  const double driven_m = speed_mps_ * std::max(0.0, to_seconds(now - vehicle.reports.reported_at()));
  wanted_m_ = std::max(wanted_m_, needed_m() + driven_m);
  COSIVA_EXPECT(needed_m() > 0.0 && needed_m() <= limit_m());
}

double BaseReach::speed_mps(std::optional<double> speed_mps_max) const {
  return speed_mps_max && *speed_mps_max > 0.0 ? std::min(speed_mps_, *speed_mps_max) : speed_mps_;
}

double BaseReach::needed_m(std::optional<double> speed_mps_max) const {
  if (!limited_) return wanted_m_;
  const double v_mps = speed_mps(speed_mps_max);
  return v_mps * latency_s_ + 0.5 * v_mps * v_mps / braking_mps2_;
}

double BaseReach::limit_m(std::optional<double> speed_mps_max) const {
  if (!limited_) return std::numeric_limits<double>::infinity();
  return std::max(needed_m(speed_mps_max), speed_mps(speed_mps_max) * permitted_s_);
}

bool BaseReach::extends(double reach_m, double end_m, std::optional<double> speed_mps_max) const {
  if (reach_m >= wanted_m_) return false;
  return reach_m < needed_m(speed_mps_max) || end_m <= limit_m(speed_mps_max);
}

}  // namespace cosiva::virtual_side
