#include "cosiva/virtual/server/reports/forecast.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "cosiva/aiv/decision/speed_rules.h"
#include "cosiva/aiv/motion/formulas.h"
#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {
namespace {

constexpr double nothing = std::numeric_limits<double>::infinity();
/// Reach of the obstacle sensor, and of the agent's view of the next crossing.
constexpr double detects_within_m = 1.0;
constexpr double crossing_within_m = 0.6;

}  // namespace

void Forecast::set_map(const WaypointGraph* map) {
  map_ = map;
  rules_.reset();
  crossings_.reset();
  zone_ = map == nullptr ? nullptr : context_.simulator.zone();
  if (map == nullptr) return;
  COSIVA_EXPECT(zone_ && zone_->name == map->zone().name);
  auto rules = aiv::make_speed_policy(context_.options.virtual_rules, zone_->profiles);
  COSIVA_EXPECT(rules.has_value());
  rules_ = std::move(*rules);
  crossings_.emplace(*zone_);
}

std::optional<Expectation> Forecast::expectation_of(VehicleIndex vehicle, const Twin& twin) const {
  const AivProxy& proxy = context_.registry[vehicle];
  const wire::State* state = proxy.state();
  if (rules_ == nullptr || state == nullptr || !proxy.is_cosiva() || !context_.options.anticipation)
    return std::nullopt;
  const zone::TrafficZone& zone = map_->zone();
  Expectation expected{zone.profiles.medium, twin.progress().base_left_m};
  expected.trend_mps2 = twin.progress().trend_mps2;
  const Traffic::Leader& leader = master_.traffic.ahead(vehicle);
  if (leader.vehicle != no_vehicle && leader.distance_m - zone.vehicle.length_m < detects_within_m) {
    expected.leader_gap_m = leader.distance_m - zone.vehicle.length_m;
    const AivProxy& leading = context_.registry[leader.vehicle];
    if (leading.twin()) expected.leader_mps = std::max(0.0, context_.simulator.twin(*leading.twin()).progress().mps);
  }
  const bool stays = !state->driving && std::fabs(twin.progress().mps) < aiv::stopped_mps;
  const bool may_drive = !state->paused && !stays;
  const auto [profile, ratio] =
      may_drive ? rules_->target(situation_of(vehicle, twin, expected)) : aiv::SpeedChoice{aiv::Profile::stop, 1.0};
  expected.target = aiv::kinematics(zone.profiles, profile);
  expected.target.speed_mps *= ratio;
  if (const auto& section_mps = zone.circuit.part(twin.reported_position().section).speed_mps_max)
    expected.target.speed_mps = std::min(expected.target.speed_mps, *section_mps);
  return expected;
}

aiv::Situation Forecast::situation_of(VehicleIndex vehicle, const Twin& twin, const Expectation& near) const {
  const AivProxy& proxy = context_.registry[vehicle];
  const aiv::Outlook outlook{twin.reported_position(), twin.remaining(twin.reported_position().section)};
  const auto chain = crossings_->first(outlook, crossing_within_m);
  const bool more_announced = !std::ranges::all_of(proxy.state()->node_states, &wire::NodeState::released);
  const double speed_mps = twin.progress().mps;
  return {.speed_mps = speed_mps,
          .obstacle_ahead_m = near.leader_gap_m,
          .end_of_base_m = near.end_m,
          .crossing_ahead_m = near.end_m < chain.exit_m ? chain.entry_m : nothing,
          .charge = proxy.state()->battery.charge_percent / 100.0,
          .imposed = proxy.reported_state.imposed(),
          .closing_mps = near.leader_gap_m < nothing ? std::optional{speed_mps - near.leader_mps} : std::nullopt,
          .release_distance_m = more_announced ? near.end_m : nothing,
          .passed_m = crossings_->passed_m(outlook, crossing_within_m)};
}

}  // namespace cosiva::virtual_side
