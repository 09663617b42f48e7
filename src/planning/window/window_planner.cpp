#include "cosiva/planning/window/window_planner.h"

#include <algorithm>
#include <limits>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::planning {
namespace {

constexpr std::uint32_t no_limit = std::numeric_limits<std::uint32_t>::max();

// After so many attempts for each delayed vehicle without success, their delays are taken as unavoidable.
constexpr std::uint32_t rounds_max = 6;

}  // namespace

WindowPlanner::WindowPlanner(const Floor& floor, Distances& distances, const WindowOptions& options, std::uint64_t seed)
    : floor_{&floor},
      distances_{&distances},
      options_{options},
      random_{seed, "planner"},
      reservations_{floor, options.horizon, options.cycles},
      joint_{floor, options.cycles},
      search_{floor, options.horizon},
      found_(options.horizon + std::size_t{1}) {
  COSIVA_EXPECT(options.horizon >= 1 && options.horizon <= 255 && options.group >= 1);
}

void WindowPlanner::plan(std::span<const Traveller> fleet, std::uint64_t expansions_max) {
  if (!goes_on(fleet) || !go_on(fleet)) begin_anew(fleet);
  improve(expansions_max);
}

bool WindowPlanner::go_on(std::span<const Traveller> fleet) {
  std::vector<std::vector<StateId>> paths(fleet.size());
  std::vector<Vehicle> changed;
  for (Vehicle vehicle = 0; vehicle < fleet.size(); ++vehicle) {
    const auto before = path(vehicle).subspan(1);
    paths[vehicle].assign(before.begin(), before.end());
    if (fleet[vehicle].stops != fleet_[vehicle].stops) changed.push_back(vehicle);
  }
  accept(fleet);
  add_step(paths);
  reserve(paths);
  for (const Vehicle vehicle : changed) replan(vehicle, cost(vehicle) + 1);
  for (Vehicle vehicle = 0; vehicle < fleet.size(); ++vehicle) {
    if (stays(vehicle)) continue;
    replan(vehicle, no_limit);
    if (!stays(vehicle)) return false;
  }
  return true;
}

bool WindowPlanner::stays(Vehicle vehicle) const {
  const auto states = path(vehicle);
  return states[1] == states[0] || !Itinerary::staying(itineraries_[vehicle].start(states[0]));
}

void WindowPlanner::reserve(const std::vector<std::vector<StateId>>& paths) {
  std::vector<StateId> present(fleet_.size());
  std::ranges::transform(fleet_, present.begin(), &Traveller::at);
  reservations_.begin(present);
  for (Vehicle vehicle = 0; vehicle < fleet_.size(); ++vehicle) reservations_.add(vehicle, paths[vehicle]);
}

bool WindowPlanner::goes_on(std::span<const Traveller> fleet) const {
  if (fleet.size() != fleet_.size()) return false;
  for (Vehicle vehicle = 0; vehicle < fleet.size(); ++vehicle)
    if (fleet[vehicle].at != path(vehicle)[1]) return false;
  return true;
}

void WindowPlanner::accept(std::span<const Traveller> fleet) {
  fleet_.assign(fleet.begin(), fleet.end());
  itineraries_.clear();
  for (const Traveller& traveller : fleet_)
    itineraries_.emplace_back(traveller.at, traveller.stops, *floor_, *distances_);
}

void WindowPlanner::add_step(std::vector<std::vector<StateId>>& paths) {
  std::vector<StepVehicle> ends;
  for (Vehicle vehicle = 0; vehicle < paths.size(); ++vehicle) {
    const Itinerary& itinerary = itineraries_[vehicle];
    ends.push_back({paths[vehicle].back(), &itinerary, itinerary.end(paths[vehicle]), fleet_[vehicle].urgency});
  }
  joint_.plan(ends);
  for (Vehicle vehicle = 0; vehicle < paths.size(); ++vehicle) paths[vehicle].push_back(joint_.next(vehicle));
}

void WindowPlanner::begin_anew(std::span<const Traveller> fleet) {
  std::vector<std::vector<StateId>> paths;
  for (const Traveller& traveller : fleet) paths.push_back({traveller.at});
  accept(fleet);
  for (std::uint32_t step = 0; step < options_.horizon; ++step) add_step(paths);
  reserve(paths);
}

void WindowPlanner::replan(Vehicle vehicle, std::uint32_t limit) {
  reservations_.remove(vehicle);
  const auto before = path(vehicle);
  found_.assign(before.begin(), before.end());
  (void)search_.find(vehicle, fleet_[vehicle].at, itineraries_[vehicle], reservations_, limit, found_);
  reservations_.add(vehicle, found_);
}

void WindowPlanner::improve(std::uint64_t expansions_max) {
  const std::uint64_t end = search_.expansions() + expansions_max;
  std::uint64_t attempts = 0;
  std::uint32_t rounds = 0;  // since the last success
  do {
    list_delayed();
    for (std::size_t i = 0; i < delayed_.size(); ++i) {
      // An attempt without expansions costs time, too.
      if (search_.expansions() >= end || attempts++ >= expansions_max) return;
      std::swap(delayed_[i], delayed_[i + random_.below(delayed_.size() - i)]);
      if (!is_delayed(delayed_[i])) continue;
      choose_group(delayed_[i]);
      if (improve_group()) rounds = 0;
    }
  } while (!delayed_.empty() && ++rounds < rounds_max);
}

bool WindowPlanner::is_delayed(Vehicle vehicle) const {
  const Itinerary& itinerary = itineraries_[vehicle];
  const StateId at = fleet_[vehicle].at;
  return cost(vehicle) > itinerary.remaining(itinerary.start(at), at);
}

void WindowPlanner::list_delayed() {
  delayed_.clear();
  for (Vehicle vehicle = 0; vehicle < fleet_.size(); ++vehicle)
    if (is_delayed(vehicle)) delayed_.push_back(vehicle);
}

void WindowPlanner::choose_group(Vehicle vehicle) {
  group_.assign(1, vehicle);
  const Itinerary& itinerary = itineraries_[vehicle];
  StateId at = fleet_[vehicle].at;
  Itinerary::Progress progress = itinerary.start(at);
  // Those on the shortest path of the vehicle.
  for (std::uint32_t step = 1; step <= options_.horizon && !itinerary.done(progress); ++step) {
    StateId best = at;
    for (const StateId next : floor_->successors(at))
      if (itinerary.to_goal(progress, next) < itinerary.to_goal(progress, best)) best = next;
    for (const CellId cell : floor_->footprint(best)) {
      add_to_group(reservations_.owner(step, cell));
      add_to_group(reservations_.owner(step - 1, cell));
    }
    at = best;
    progress = itinerary.next(progress, at);
  }
}

void WindowPlanner::add_to_group(Vehicle vehicle) {
  if (vehicle == no_vehicle || group_.size() >= options_.group || std::ranges::find(group_, vehicle) != group_.end())
    return;
  group_.push_back(vehicle);
}

bool WindowPlanner::improve_group() {
  for (std::size_t i = group_.size() - 1; i > 0; --i) std::swap(group_[i], group_[random_.below(i + 1)]);
  std::uint32_t budget = 0;  // what the rest of the group may cost, to be better than before
  old_paths_.resize(std::max(old_paths_.size(), group_.size()));
  for (std::size_t i = 0; i < group_.size(); ++i) {
    const auto before = path(group_[i]);
    old_paths_[i].assign(before.begin(), before.end());
    budget += cost(group_[i]);
    reservations_.remove(group_[i]);
  }
  std::size_t added = 0;
  for (; added < group_.size(); ++added) {
    const Vehicle vehicle = group_[added];
    // The moves of a vehicle without stops, which only makes room, are no cost.
    const std::uint32_t limit = itineraries_[vehicle].idle() ? options_.horizon + 1 : budget;
    if (budget == 0 || !search_.find(vehicle, fleet_[vehicle].at, itineraries_[vehicle], reservations_, limit, found_))
      break;
    reservations_.add(vehicle, found_);
    budget -= std::min(budget, cost(vehicle));
  }
  if (added == group_.size() && budget > 0) return true;
  for (std::size_t i = 0; i < added; ++i) reservations_.remove(group_[i]);
  for (std::size_t i = 0; i < group_.size(); ++i) reservations_.add(group_[i], old_paths_[i]);
  return false;
}

void WindowPlanner::archive(Archive& archive) {
  archive(random_, reservations_, joint_, search_, fleet_);
  if (archive.reads()) accept(std::vector<Traveller>{fleet_});
}

}  // namespace cosiva::planning
