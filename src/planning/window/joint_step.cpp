#include "cosiva/planning/window/joint_step.h"

#include <algorithm>
#include <numeric>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::planning {
namespace {

// A decision that has examined so many candidates is given up: the vehicle goes on as before.
constexpr std::uint32_t candidates_max = 100'000;
// All decisions of a plan may examine so many, and so many more for each vehicle; from then on each one is left the
// least number. In crowds a few vehicles would take most of the time without success.
constexpr std::uint32_t plan_candidates = 100'000;
constexpr std::uint32_t vehicle_candidates = 50;
constexpr std::uint32_t candidates_min = 200;
constexpr std::size_t displaced_max = 2;

// Ties between equal operations are broken differently for each vehicle, state and plan, but equally on every machine:
// vehicles that always choose the same of two paths meet on it.
std::uint64_t tie_break(std::uint64_t round, Vehicle vehicle, const JointStep::Operation& states) {
  std::uint64_t hash = round ^ (vehicle * 0x9E3779B97F4A7C15ULL);
  for (const StateId state : states) hash = (hash ^ state) * 0xFF51AFD7ED558CCDULL;
  return (hash >> 33U) & 0xFFU;
}

// Moves of an operation that serve nothing, because the vehicle has done all it has to.
std::uint64_t moves_after(const JointStep::Operation& states, std::uint32_t step) {
  std::uint64_t moves = 0;
  for (++step; step < states.size(); ++step) moves += states[step] != states[step - 1] ? 1U : 0U;
  return moves;
}

}  // namespace

JointStep::JointStep(const Floor& floor, bool cycles) : floor_{&floor}, reservations_{floor, operation_steps, cycles} {}

void JointStep::plan(std::span<const StepVehicle> fleet) {
  begin(fleet);
  std::vector<Vehicle> order(fleet.size());
  std::iota(order.begin(), order.end(), 0U);
  const auto left = [&](Vehicle vehicle) {
    return fleet[vehicle].itinerary->remaining(fleet[vehicle].progress, fleet[vehicle].at);
  };
  std::ranges::stable_sort(order, [&](Vehicle a, Vehicle b) {
    if (fleet[a].urgency != fleet[b].urgency) return fleet[a].urgency > fleet[b].urgency;
    const bool a_done = fleet[a].itinerary->done(fleet[a].progress);
    const bool b_done = fleet[b].itinerary->done(fleet[b].progress);
    return a_done != b_done ? b_done : left(a) < left(b);
  });
  left_ = plan_candidates + std::uint64_t{vehicle_candidates} * fleet.size();
  for (const Vehicle vehicle : order) decide(vehicle);
}

void JointStep::begin(std::span<const StepVehicle> fleet) {
  bool goes_on = fleet.size() == reservations_.vehicles();
  for (Vehicle vehicle = 0; goes_on && vehicle < fleet.size(); ++vehicle) {
    const auto before = reservations_.path(vehicle);
    // Where stops have changed, a vehicle may have to stay where it was to pass.
    goes_on =
        fleet[vehicle].at == before[1] && (before[2] == before[1] || !Itinerary::staying(fleet[vehicle].progress));
  }
  std::vector<Operation> operations(fleet.size());
  for (Vehicle vehicle = 0; vehicle < fleet.size(); ++vehicle) {
    operations[vehicle].fill(fleet[vehicle].at);
    if (!goes_on) continue;
    const auto before = reservations_.path(vehicle);
    for (std::uint32_t step = 1; step <= operation_steps; ++step)
      operations[vehicle][step] = before[std::min(step + 1, operation_steps)];
  }
  std::vector<StateId> present(fleet.size());
  std::ranges::transform(fleet, present.begin(), &StepVehicle::at);
  reservations_.begin(present);
  for (Vehicle vehicle = 0; vehicle < fleet.size(); ++vehicle) reservations_.add(vehicle, operations[vehicle]);
  fleet_ = fleet;
  permissions_.assign(fleet.size(), {});
  for (Vehicle vehicle = 0; vehicle < fleet.size(); ++vehicle)
    if (Itinerary::staying(fleet[vehicle].progress)) permissions_[vehicle].decided = 1;
  ++rounds_;
}

void JointStep::decide(Vehicle vehicle) {
  if (permissions_[vehicle].decided != 0) return;
  changes_.clear();
  decisions_.clear();
  for (const Vehicle other : failed_) permissions_[other].failed_step = 0;
  failed_.clear();
  const std::uint64_t before = expansions_;
  budget_ = static_cast<std::uint32_t>(std::clamp<std::uint64_t>(left_, candidates_min, candidates_max));
  remove(vehicle);
  if (!find(vehicle)) undo(0, 0);
  left_ -= std::min(left_, expansions_ - before);
  COSIVA_EXPECT(reservations_.has_path(vehicle));
  permissions_[vehicle].decided = 1;
}

bool JointStep::find(Vehicle vehicle) {
  std::vector<Candidate> candidates;
  if (!pool_.empty()) {
    candidates.swap(pool_.back());
    pool_.pop_back();
  }
  candidates.clear();
  list_candidates(vehicle, candidates);
  // During this search no other vehicle may displace it.
  permissions_[vehicle].decided = 1;
  bool found = false;
  for (const Candidate& candidate : candidates) {
    if (budget_ == 0) break;
    --budget_;
    ++expansions_;
    if ((found = attempt(vehicle, candidate.states))) break;
  }
  if (found)
    decisions_.push_back(vehicle);
  else
    permissions_[vehicle].decided = 0;
  pool_.push_back(std::move(candidates));
  return found;
}

bool JointStep::attempt(Vehicle vehicle, const Operation& operation) {
  std::vector<Conflict> conflicts;
  reservations_.conflicts(vehicle, operation, displaced_max, conflicts);
  if (!displaceable(conflicts)) return false;
  const std::size_t changes = changes_.size();
  const std::size_t decisions = decisions_.size();
  for (const Conflict& conflict : conflicts) remove(conflict.vehicle);
  changes_.push_back({vehicle, false, {}});
  reservations_.add(vehicle, operation);
  for (const Conflict& conflict : conflicts) {
    if (reservations_.has_path(conflict.vehicle) || find(conflict.vehicle)) continue;
    Permission& permission = permissions_[conflict.vehicle];
    if (permission.failed_step == 0) failed_.push_back(conflict.vehicle);
    permission.failed_step = std::max(permission.failed_step, static_cast<std::uint8_t>(conflict.step));
    undo(changes, decisions);
    return false;
  }
  return true;
}

bool JointStep::displaceable(std::span<const Conflict> conflicts) const {
  return conflicts.size() <= displaced_max && std::ranges::all_of(conflicts, [&](const Conflict& conflict) {
           const Permission& permission = permissions_[conflict.vehicle];
           return reservations_.has_path(conflict.vehicle) && permission.decided == 0 &&
                  conflict.step > permission.failed_step;
         });
}

void JointStep::list_candidates(Vehicle vehicle, std::vector<Candidate>& candidates) {
  Candidate candidate;
  candidate.states[0] = fleet_[vehicle].at;
  extend(vehicle, 1, fleet_[vehicle].progress, candidate, candidates);
  std::ranges::sort(candidates, {}, &Candidate::cost);
}

void JointStep::extend(Vehicle vehicle, std::uint32_t step, Itinerary::Progress progress, Candidate& candidate,
                       std::vector<Candidate>& candidates) {
  if (step > operation_steps) {
    candidate.cost = cost(vehicle, candidate.states) * 0x100 + tie_break(rounds_, vehicle, candidate.states);
    candidates.push_back(candidate);
    return;
  }
  const Itinerary& itinerary = *fleet_[vehicle].itinerary;
  const auto go = [&](StateId to) {
    candidate.states[step] = to;
    extend(vehicle, step + 1, itinerary.next(progress, to), candidate, candidates);
  };
  const StateId from = candidate.states[step - 1];
  go(from);
  if (Itinerary::staying(progress)) return;
  // No vehicle makes room by a move after which it could never reach its goal.
  for (const StateId to : floor_->successors(from))
    if (itinerary.to_goal(progress, to) != Distances::unreachable) go(to);
}

std::uint64_t JointStep::cost(Vehicle vehicle, const Operation& states) const {
  const StepVehicle& traveller = fleet_[vehicle];
  const Itinerary& itinerary = *traveller.itinerary;
  if (itinerary.done(traveller.progress)) return moves_after(states, 0);
  // Among operations that end equally near, the one that comes nearer earlier: each step's detour counts.
  Itinerary::Progress progress = traveller.progress;
  const std::uint32_t least = itinerary.remaining(progress, traveller.at);
  std::uint64_t detours = 0;
  std::uint32_t step = 0;
  while (step < operation_steps && !itinerary.done(progress)) {
    ++step;
    progress = itinerary.next(progress, states[step]);
    detours += step + itinerary.remaining(progress, states[step]) - least;
  }
  return (step + itinerary.remaining(progress, states[step])) * std::uint64_t{0x100} + detours +
         moves_after(states, step);
}

void JointStep::remove(Vehicle vehicle) {
  Change change{vehicle, true, {}};
  std::ranges::copy(reservations_.path(vehicle), change.states.begin());
  changes_.push_back(change);
  reservations_.remove(vehicle);
}

void JointStep::undo(std::size_t changes, std::size_t decisions) {
  for (std::size_t i = changes_.size(); i-- > changes;)
    if (reservations_.has_path(changes_[i].vehicle)) reservations_.remove(changes_[i].vehicle);
  // The first change of a vehicle holds what it had before.
  for (std::size_t i = changes; i < changes_.size(); ++i)
    if (changes_[i].had_path && !reservations_.has_path(changes_[i].vehicle))
      reservations_.add(changes_[i].vehicle, changes_[i].states);
  changes_.resize(changes);
  for (std::size_t i = decisions_.size(); i-- > decisions;) permissions_[decisions_[i]].decided = 0;
  decisions_.resize(decisions);
}

void JointStep::archive(Archive& archive) { archive(reservations_, rounds_, expansions_); }

}  // namespace cosiva::planning
