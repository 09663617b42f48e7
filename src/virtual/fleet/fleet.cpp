#include "cosiva/virtual/fleet/fleet.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "cosiva/base/expect.h"
#include "cosiva/virtual/fleet/crossing_grants.h"
#include "cosiva/virtual/fleet/fleet_metrics.h"
#include "cosiva/virtual/fleet/fleet_orders.h"
#include "cosiva/virtual/fleet/fleet_tables.h"
#include "cosiva/virtual/fleet/leaders.h"
#include "cosiva/virtual/fleet/path_survey.h"
#include "cosiva/virtual/fleet/paths.h"
#include "cosiva/virtual/fleet/placement.h"
#include "cosiva/virtual/fleet/pose_writer.h"
#include "cosiva/virtual/fleet/presence.h"
#include "cosiva/virtual/fleet/section_changes.h"
#include "cosiva/virtual/fleet/spread.h"
#include "cosiva/virtual/fleet/stepper.h"

namespace cosiva::virtual_side {

/// Invariant: the components hold references to the tables next to them, so an Impl is never moved.
struct Fleet::Impl {
  Impl(Ground ground, const FleetOptions& options, std::optional<FleetRules> rules, std::size_t vehicles)
      : tables{std::move(ground), options}, stepper{tables, grants, changes, poses, std::move(rules), vehicles} {}

  FleetTables tables;
  Paths paths{tables};
  Leaders leaders{tables, paths};
  PathSurvey survey{tables, paths};
  CrossingGrants grants{tables, leaders, survey};
  SectionChanges changes{tables, paths, leaders, survey, grants};
  FleetOrders orders{tables, paths, leaders, survey, grants, changes};
  PoseWriter poses{tables, paths};
  Presence presence{tables, leaders, survey, grants, orders, poses};
  Stepper stepper;
};

Fleet::Fleet(std::unique_ptr<Impl> impl) : in_{std::move(impl)} {}
Fleet::Fleet(Fleet&&) noexcept = default;
Fleet& Fleet::operator=(Fleet&&) noexcept = default;
Fleet::~Fleet() = default;

std::vector<FleetStart> Fleet::spread(const zone::TrafficZone& zone, std::size_t count, std::uint32_t copy) {
  return spread_starts(zone, count, copy);
}

Result<Fleet> Fleet::make(std::shared_ptr<const zone::TrafficZone> zone, const FleetOptions& options,
                          std::span<const FleetStart> starts) {
  if (!(options.step > SimDuration::zero() && options.step <= std::chrono::milliseconds{200}))
    return fail("fleet.options", "a fleet's step is longer than 0 and at most 200 ms", "step");
  auto ground = Ground::make(std::move(zone));
  if (!ground) return tl::unexpected(ground.error());
  std::optional<FleetRules> rules;
  if (options.rules) {
    auto narrowed = narrow(*options.rules);
    if (!narrowed) return tl::unexpected(narrowed.error());
    rules = std::move(*narrowed);
  }
  auto impl = std::make_unique<Impl>(std::move(*ground), options, std::move(rules), starts.size());
  Placement placement{impl->tables, impl->leaders, impl->survey, impl->presence};
  if (auto placed = placement.put(starts); !placed) return tl::unexpected(placed.error());
  impl->poses.write(0, static_cast<std::uint32_t>(starts.size()));
  return Fleet{std::move(impl)};
}

void Fleet::step() {
  AloneWorker alone;
  in_->stepper.step(alone, 1);
}
void Fleet::step(Workers& workers, std::uint32_t steps) { in_->stepper.step(workers, steps); }
std::uint64_t Fleet::steps() const { return in_->tables.step_number; }
SimDuration Fleet::time() const { return in_->tables.options.step * in_->tables.step_number; }

bool Fleet::send(Vehicle vehicle, std::span<const zone::SectionId> route, double goal_s_m) {
  return in_->orders.send(vehicle, route, goal_s_m);
}
void Fleet::circulate(Vehicle vehicle) { in_->orders.circulate(vehicle); }
std::span<const zone::SectionId> Fleet::committed(Vehicle vehicle) { return in_->orders.committed(vehicle); }
void Fleet::set_priority(Vehicle vehicle, std::int32_t priority) {
  in_->grants.set_priority(vehicle, static_cast<std::int16_t>(std::clamp(priority, 0, zone::priority_max)));
}
void Fleet::limit_speed(Vehicle vehicle, double speed_mps) {
  COSIVA_EXPECT(speed_mps > 0.0);
  in_->tables.state.own[vehicle].own_mps = std::min(speed_mps, far_m);
  in_->tables.numbers.has_caps |= speed_mps < far_m;
  if (!is_away(vehicle)) in_->survey.survey(vehicle);
}
void Fleet::impose(Vehicle vehicle, std::optional<aiv::Profile> profile) {
  std::uint8_t& imposed = in_->tables.state.imposed[vehicle];
  in_->tables.commanded_vehicles -= imposed != no_profile ? 1 : 0;
  imposed = profile ? static_cast<std::uint8_t>(*profile) : no_profile;
  in_->tables.commanded_vehicles += imposed != no_profile ? 1 : 0;
}

bool Fleet::take_away(Vehicle vehicle) { return in_->presence.take_away(vehicle); }
bool Fleet::bring(Vehicle vehicle, zone::TrackPosition position, std::int32_t priority) {
  return in_->presence.bring(vehicle, position, static_cast<std::int16_t>(std::clamp(priority, 0, zone::priority_max)));
}
bool Fleet::may_stop(zone::TrackPosition position) const {
  return position.section < zone().circuit.size() && in_->tables.ground.may_stop(position);
}
bool Fleet::is_away(Vehicle vehicle) const { return (in_->tables.state.mode[vehicle] & Mode::absent) != 0; }

std::size_t Fleet::size() const { return in_->tables.state.s_m.size(); }
std::uint32_t Fleet::copies() const { return static_cast<std::uint32_t>(in_->tables.copies.size() - 1); }
const zone::TrafficZone& Fleet::zone() const { return in_->tables.ground.zone(); }
std::span<const Fleet::Vehicle> Fleet::arrived() const {
  return std::span(in_->tables.arrived).first(in_->tables.arrivals);
}
bool Fleet::has_goal(Vehicle vehicle) const {
  return (in_->tables.state.mode[vehicle] & (Mode::sent | Mode::absent)) == Mode::sent;
}
bool Fleet::is_at_goal(Vehicle vehicle) const {
  return (in_->tables.state.mode[vehicle] & (Mode::at_goal | Mode::absent)) == Mode::at_goal;
}
std::uint32_t Fleet::copy_of(Vehicle vehicle) const { return in_->tables.state.own[vehicle].copy; }
zone::TrackPosition Fleet::track_position(Vehicle vehicle) const {
  return {in_->tables.state.section[vehicle], in_->tables.state.s_m[vehicle]};
}
Pose2 Fleet::pose(Vehicle vehicle) const {
  return {in_->tables.state.x_m[vehicle], in_->tables.state.y_m[vehicle], in_->tables.state.heading_rad[vehicle]};
}
std::span<const double> Fleet::x_m() const { return in_->tables.state.x_m; }
std::span<const double> Fleet::y_m() const { return in_->tables.state.y_m; }
std::span<const double> Fleet::heading_rad() const { return in_->tables.state.heading_rad; }
std::span<const double> Fleet::speed_mps() const { return in_->tables.state.v_mps; }
aiv::Profile Fleet::profile(Vehicle vehicle) const {
  return static_cast<aiv::Profile>(std::max<int>(0, in_->tables.state.profile[vehicle]));
}
Fleet::Ahead Fleet::ahead(Vehicle vehicle) const {
  const std::uint32_t leader = in_->tables.state.leader[vehicle];
  if (leader == vehicle) return {};
  return {leader, in_->leaders.gap_m(vehicle)};
}
double Fleet::sensed_m() const { return in_->tables.numbers.sensed_m; }
Fleet::Vehicle Fleet::holder(std::uint32_t copy, std::size_t crossing) const {
  return in_->tables.crossings[std::size_t{copy} * zone().crossings.size() + crossing].holder;
}

double Fleet::distance_m(Vehicle vehicle) const {
  return in_->tables.state.own[vehicle].traversed_m + in_->tables.state.s_m[vehicle];
}
SimDuration Fleet::waiting(Vehicle vehicle) const {
  return in_->tables.options.step * in_->tables.state.waited_steps[vehicle];
}
std::uint32_t Fleet::laps(Vehicle vehicle) const { return in_->tables.state.own[vehicle].laps; }

Fleet::CrossingMetrics Fleet::crossing(std::size_t crossing) const { return crossing_metrics(in_->tables, crossing); }
SimDuration Fleet::occupancy(zone::SectionId section) const { return virtual_side::occupancy(in_->tables, section); }
double Fleet::smallest_gap_m() const { return virtual_side::smallest_gap_m(in_->tables); }
std::uint64_t Fleet::collisions() const { return virtual_side::collisions(in_->tables); }
std::size_t Fleet::stuck() const { return in_->grants.stuck(); }
std::uint64_t Fleet::digest() const { return fleet_digest(in_->tables); }
std::size_t Fleet::bytes() const { return in_->tables.bytes() + in_->poses.bytes(); }

}  // namespace cosiva::virtual_side
