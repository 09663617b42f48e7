#include "cosiva/planning/track_fleet/track_fleet.h"

#include <algorithm>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::planning {
namespace {

/// Cells that a vehicle needs for these moves, in ascending order.
std::vector<CellId> cells_of(const Floor& floor, const GrantedMoves& granted) {
  const std::vector<StateId>& states = granted.states;
  std::vector<CellId> cells;
  const auto add = [&](std::span<const CellId> more) { cells.insert(cells.end(), more.begin(), more.end()); };
  for (std::size_t i = 0; i < states.size(); ++i) {
    if (i > 0 || !granted.clear) add(floor.footprint(states[i]));
    if (i > 0) add(floor.sweep_between(states[i - 1], states[i]));
  }
  std::ranges::sort(cells);
  cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
  return cells;
}

}  // namespace

TrackFleet::TrackFleet(const zone::TrafficZone& zone, const FleetPlanOptions& options, std::uint64_t seed)
    : track_{TrackFloor::make(zone)}, options_{options}, seed_{seed}, distances_{track_.floor()} {
  begin_again();
}

// --- which vehicles take part ---------------------------------------------------------------------------------------

GrantedMoves TrackFleet::granted(Vehicle vehicle) const {
  const auto& all = states(vehicle);
  const Member& member = members_[vehicle];
  const bool clear = is_in_plan(vehicle) ? plan_->order().is_clear(member.slot) : member.clear;
  return {{all.begin(), all.begin() + static_cast<std::ptrdiff_t>(granted_moves(vehicle) + 1)}, clear};
}

bool TrackFleet::join(Vehicle vehicle, std::span<const StateId> granted) {
  COSIVA_EXPECT(!takes_part(vehicle) && !granted.empty());
  const auto cells = cells_of(track_.floor(), {{granted.begin(), granted.end()}, false});
  for (Vehicle other = 0; other < members_.size(); ++other) {
    if (!takes_part(other)) continue;
    const auto needed = cells_of(track_.floor(), this->granted(other));
    const auto is_needed = [&](CellId cell) { return std::ranges::binary_search(needed, cell); };
    if (std::ranges::any_of(cells, is_needed)) return false;
  }
  members_[vehicle] = {};
  members_[vehicle].part = Part::planned;
  members_[vehicle].states.assign(granted.begin(), granted.end());
  changed_ = true;
  return true;
}

void TrackFleet::leave(Vehicle vehicle) {
  if (takes_part(vehicle)) changed_ = true;
  members_[vehicle] = {};
}

void TrackFleet::hold(Vehicle vehicle) {
  if (!is_in_plan(vehicle)) return;
  const GrantedMoves moves = granted(vehicle);
  members_[vehicle].states.assign(moves.states.begin(), moves.states.end());
  members_[vehicle].clear = moves.clear;
}

void TrackFleet::set_aside(Vehicle vehicle, bool aside) {
  COSIVA_EXPECT(takes_part(vehicle));
  if (aside == is_set_aside(vehicle)) return;
  hold(vehicle);
  members_[vehicle].part = aside ? Part::aside : Part::planned;
  changed_ = true;
}

void TrackFleet::obstruct(Obstruction obstruction) {
  if (obstruction == obstruction_) return;
  obstruction_ = std::move(obstruction);
  changed_ = true;
}

void TrackFleet::make_plan() {
  plan_.reset();  // refers to the floor of before
  open_ = std::make_unique<Floor>(track_.floor().without(closed_));
  plan_ = std::make_unique<FleetPlan>(track_.floor(), *open_, options_, seed_);
}

void TrackFleet::begin_again() {
  Obstruction closed = obstruction_;
  for (Vehicle vehicle = 0; vehicle < members_.size(); ++vehicle) {
    hold(vehicle);
    if (!is_set_aside(vehicle)) continue;
    const auto cells = cells_of(track_.floor(), granted(vehicle));
    closed.cells.insert(closed.cells.end(), cells.begin(), cells.end());
  }
  if (!open_ || closed != closed_) {
    closed_ = std::move(closed);
    make_plan();
  }
  slots_.clear();
  std::vector<GrantedMoves> granted;
  for (Vehicle vehicle = 0; vehicle < members_.size(); ++vehicle) {
    Member& member = members_[vehicle];
    if (member.part != Part::planned) continue;
    member.slot = static_cast<Vehicle>(slots_.size());
    slots_.push_back(vehicle);
    granted.push_back({{member.states.begin(), member.states.end()}, member.clear});
    member.states.clear();
  }
  plan_->begin(granted);
  for (const Vehicle vehicle : slots_)
    plan_->set_stops(members_[vehicle].slot, members_[vehicle].stops, members_[vehicle].urgency);
  changed_ = false;
  COSIVA_EXPECT(plan_->vehicles() == slots_.size());
}

// --- the plan -------------------------------------------------------------------------------------------------------

void TrackFleet::set_stops(Vehicle vehicle, std::span<const Stop> stops, std::uint32_t urgency) {
  Member& member = members_[vehicle];
  member.stops.assign(stops.begin(), stops.end());
  member.urgency = urgency;
  if (is_in_plan(vehicle)) plan_->set_stops(member.slot, stops, urgency);
}

bool TrackFleet::reachable(Vehicle vehicle) const {
  return !is_in_plan(vehicle) || plan_->reachable(members_[vehicle].slot);
}

void TrackFleet::plan() {
  if (changed_) begin_again();
  plan_->plan();
}

void TrackFleet::replan() {
  if (!changed_) plan_->replan();
}

// --- its execution --------------------------------------------------------------------------------------------------

const std::deque<StateId>& TrackFleet::states(Vehicle vehicle) const {
  COSIVA_EXPECT(takes_part(vehicle));
  const Member& member = members_[vehicle];
  return is_in_plan(vehicle) ? plan_->order().states(member.slot) : member.states;
}

std::size_t TrackFleet::granted_moves(Vehicle vehicle) const {
  const Member& member = members_[vehicle];
  return is_in_plan(vehicle) ? plan_->order().granted_moves(member.slot) : member.states.size() - 1;
}

void TrackFleet::clear(Vehicle vehicle) {
  Member& member = members_[vehicle];
  COSIVA_EXPECT(takes_part(vehicle) && granted_moves(vehicle) > 0);
  if (is_in_plan(vehicle)) {
    if (!plan_->order().is_clear(member.slot)) plan_->clear(member.slot);
    return;
  }
  changed_ = changed_ || !member.clear;
  member.clear = true;
}

void TrackFleet::arrive(Vehicle vehicle) {
  Member& member = members_[vehicle];
  COSIVA_EXPECT(takes_part(vehicle) && granted_moves(vehicle) > 0);
  if (is_in_plan(vehicle)) {
    plan_->arrive(member.slot);
    return;
  }
  member.states.pop_front();
  member.clear = false;
  changed_ = true;
}

bool TrackFleet::grant(Vehicle vehicle) {
  // After a change the plan of before may lead where something is now.
  return !changed_ && is_in_plan(vehicle) && plan_->grant(members_[vehicle].slot);
}

std::optional<Vehicle> TrackFleet::waits_for(Vehicle vehicle) const {
  if (!is_in_plan(vehicle) || changed_) return std::nullopt;
  const auto other = plan_->order().waits_for(members_[vehicle].slot);
  return other ? std::optional{slots_[*other]} : std::nullopt;
}

void TrackFleet::archive(Archive& archive) {
  archive(obstruction_, members_, slots_, changed_, closed_);
  if (archive.reads()) make_plan();
  archive(*plan_);
}

}  // namespace cosiva::planning
