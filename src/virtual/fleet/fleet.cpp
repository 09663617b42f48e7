#include "cosiva/virtual/fleet/fleet.h"

#include <algorithm>
#include <utility>

#include "cosiva/base/digest.h"
#include "cosiva/base/expect.h"
#include "cosiva/virtual/fleet/inside.h"

namespace cosiva::virtual_side {

Fleet::Inside::Inside(Ground fleet_ground, const FleetOptions& fleet_options)
    : ground{std::move(fleet_ground)},
      options{fleet_options},
      numbers{numbers_of(ground.zone(), options)},
      poses{ground.circuit()},
      overtaken_after_steps{static_cast<std::uint32_t>(
          std::clamp<std::int64_t>((options.overtaken_at_most + options.step - SimDuration{1}) / options.step, 0,
                                   std::numeric_limits<std::int32_t>::max()))} {
  numbers.has_limits = ground.has_limits();
  numbers.has_turns = ground.has_turns();
}

Fleet::Fleet(std::unique_ptr<Inside> inside) : in_{std::move(inside)} {}
Fleet::Fleet(Fleet&&) noexcept = default;
Fleet& Fleet::operator=(Fleet&&) noexcept = default;
Fleet::~Fleet() = default;

Result<Fleet> Fleet::make(std::shared_ptr<const zone::TrafficZone> zone, const FleetOptions& options,
                          std::span<const FleetStart> starts) {
  if (!(options.step > SimDuration::zero() && options.step <= std::chrono::milliseconds{200}))
    return fail("fleet.options", "a fleet's step is longer than 0 and at most 200 ms", "step");
  auto ground = Ground::make(std::move(zone));
  if (!ground) return tl::unexpected(ground.error());
  auto inside = std::make_unique<Inside>(std::move(*ground), options);
  if (options.rules) {
    auto rules = narrow(*options.rules);
    if (!rules) return tl::unexpected(rules.error());
    inside->rules = std::move(*rules);
  }
  if (auto placed = inside->place(starts); !placed) return tl::unexpected(placed.error());
  inside->smallest_gap_m.assign(inside->blocks.size(), far_m);
  inside->part_gap_m.assign(starts.size() / 1024 + 1, far_m);
  inside->draw(0, static_cast<std::uint32_t>(starts.size()));
  return Fleet{std::move(inside)};
}

void Fleet::step() {
  AloneWorker alone;
  in_->step(alone, 1);
}
void Fleet::step(Workers& workers, std::uint32_t steps) { in_->step(workers, steps); }
std::uint64_t Fleet::steps() const { return in_->step_number; }
SimDuration Fleet::time() const { return in_->options.step * in_->step_number; }

bool Fleet::send(Vehicle vehicle, std::span<const zone::SectionId> route, double goal_s_m) {
  return in_->send(vehicle, route, goal_s_m);
}
void Fleet::circulate(Vehicle vehicle) { in_->circulate(vehicle); }
std::span<const zone::SectionId> Fleet::committed(Vehicle vehicle) { return in_->committed(vehicle); }
void Fleet::set_priority(Vehicle vehicle, std::int32_t priority) {
  in_->prioritise(vehicle, static_cast<std::int16_t>(std::clamp(priority, 0, zone::priority_max)));
}
void Fleet::limit_speed(Vehicle vehicle, double speed_mps) {
  COSIVA_EXPECT(speed_mps > 0.0);
  in_->state.own[vehicle].own_mps = std::min(speed_mps, far_m);
  in_->numbers.has_caps |= speed_mps < far_m;
  if (!is_away(vehicle)) in_->survey(vehicle);
}
void Fleet::impose(Vehicle vehicle, std::optional<aiv::Profile> profile) {
  std::uint8_t& imposed = in_->state.imposed[vehicle];
  in_->told_vehicles -= imposed != no_profile ? 1 : 0;
  imposed = profile ? static_cast<std::uint8_t>(*profile) : no_profile;
  in_->told_vehicles += imposed != no_profile ? 1 : 0;
}

bool Fleet::take_away(Vehicle vehicle) { return in_->take_away(vehicle); }
bool Fleet::bring(Vehicle vehicle, zone::Place place, std::int32_t priority) {
  return in_->bring(vehicle, place, static_cast<std::int16_t>(std::clamp(priority, 0, zone::priority_max)));
}
bool Fleet::may_stand(zone::Place place) const {
  return place.section < zone().circuit.size() && in_->ground.may_stand(place);
}
bool Fleet::is_away(Vehicle vehicle) const { return (in_->state.mode[vehicle] & Mode::absent) != 0; }

std::size_t Fleet::size() const { return in_->state.s_m.size(); }
std::uint32_t Fleet::copies() const { return static_cast<std::uint32_t>(in_->copies.size() - 1); }
const zone::TrafficZone& Fleet::zone() const { return in_->ground.zone(); }
std::span<const Fleet::Vehicle> Fleet::arrived() const { return std::span(in_->arrived).first(in_->arrivals); }
bool Fleet::has_goal(Vehicle vehicle) const {
  return (in_->state.mode[vehicle] & (Mode::sent | Mode::absent)) == Mode::sent;
}
bool Fleet::is_at_goal(Vehicle vehicle) const {
  return (in_->state.mode[vehicle] & (Mode::at_goal | Mode::absent)) == Mode::at_goal;
}
std::uint32_t Fleet::copy_of(Vehicle vehicle) const { return in_->state.own[vehicle].copy; }
zone::Place Fleet::place(Vehicle vehicle) const { return {in_->state.section[vehicle], in_->state.s_m[vehicle]}; }
Pose2 Fleet::pose(Vehicle vehicle) const {
  return {in_->state.x_m[vehicle], in_->state.y_m[vehicle], in_->state.heading_rad[vehicle]};
}
std::span<const double> Fleet::x_m() const { return in_->state.x_m; }
std::span<const double> Fleet::y_m() const { return in_->state.y_m; }
std::span<const double> Fleet::heading_rad() const { return in_->state.heading_rad; }
std::span<const double> Fleet::speed_mps() const { return in_->state.v_mps; }
aiv::Profile Fleet::profile(Vehicle vehicle) const {
  return static_cast<aiv::Profile>(std::max<int>(0, in_->state.profile[vehicle]));
}
Fleet::Ahead Fleet::ahead(Vehicle vehicle) const {
  const State& state = in_->state;
  const std::uint32_t leader = state.leader[vehicle];
  if (leader == vehicle) return {};
  return {leader, state.offset_m[vehicle] + state.s_m[leader] - state.s_m[vehicle] - in_->numbers.length_m};
}
double Fleet::look_m() const { return in_->numbers.look_m; }
Fleet::Vehicle Fleet::holder(std::uint32_t copy, std::size_t crossing) const {
  return in_->crossings[std::size_t{copy} * zone().crossings.size() + crossing].holder;
}

double Fleet::distance_m(Vehicle vehicle) const { return in_->state.own[vehicle].gone_m + in_->state.s_m[vehicle]; }
SimDuration Fleet::waiting(Vehicle vehicle) const { return in_->options.step * in_->state.waited_steps[vehicle]; }
std::uint32_t Fleet::laps(Vehicle vehicle) const { return in_->state.own[vehicle].laps; }

Fleet::CrossingFigures Fleet::crossing(std::size_t crossing) const {
  CrossingFigures figures;
  std::uint64_t waited = 0;
  for (const Block& block : in_->blocks) {
    figures.grants += block.grants[crossing];
    waited += block.waited_steps[crossing];
  }
  figures.waiting = in_->options.step * static_cast<std::int64_t>(waited);
  return figures;
}

SimDuration Fleet::occupancy(zone::SectionId section) const {
  std::uint64_t steps = 0;
  for (const Block& block : in_->blocks) steps += block.occupied_steps[section];
  for (std::uint32_t copy = 0; copy < copies(); ++copy)
    for (std::uint32_t i = in_->front[in_->at(copy, section)]; i != none; i = in_->state.own[i].behind)
      steps += in_->step_number - in_->state.own[i].entered_step;
  return in_->options.step * static_cast<std::int64_t>(steps);
}

double Fleet::smallest_gap_m() const {
  const auto smallest = std::ranges::min_element(in_->smallest_gap_m);
  if (smallest == in_->smallest_gap_m.end() || *smallest >= far_m) return std::numeric_limits<double>::infinity();
  return *smallest;
}
std::uint64_t Fleet::collisions() const {
  std::uint64_t collisions = 0;
  for (const Block& block : in_->blocks) collisions += block.collisions;
  return collisions;
}
std::size_t Fleet::stuck() const { return in_->stuck(); }
std::uint64_t Fleet::digest() const { return in_->digest(); }
std::size_t Fleet::bytes() const { return in_->bytes(); }

}  // namespace cosiva::virtual_side
