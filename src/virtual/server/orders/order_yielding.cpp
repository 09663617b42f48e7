// OrderManager: one vehicle lets others out of a deadlock. The vehicle moves up, releases what it holds ahead, takes
// another route, joins the path at another position, or backs up.
#include <algorithm>
#include <cmath>

#include "cosiva/aiv/decision/envelope.h"
#include "cosiva/aiv/decision/line_entry.h"
#include "cosiva/base/math.h"
#include "cosiva/virtual/server/orders/order_manager.h"
#include "cosiva/zone/circuit/path_snap.h"

namespace cosiva::virtual_side {
namespace {

/// A shorter base than this is not worth releasing.
constexpr double base_left_m_min = 0.02;
/// Distance within which a vehicle that joins the path searches for a position: the limit of its own joinLine.
constexpr double elsewhere_within_m = 0.60;
/// The distance to back up is searched in steps, with a small margin, and the space behind is checked slightly further.
constexpr double back_step_m = 0.025;
constexpr double back_slack_m = 0.02;
constexpr double behind_every_m = 0.02;
constexpr double behind_beyond_m = 0.04;
/// Clearance around a body that backs up without a rear sensor.
constexpr double behind_clear_m = 0.03;
/// A vehicle that backs up stops when any body is nearer than this, or nearer than at the start; by reports, which may
/// be inaccurate.
constexpr double back_clear_m = 0.005;
constexpr double back_clear_m_min = -0.02;
/// Distance along another vehicle's path within which obstructing bodies are searched: the next stretch or chain, and
/// the stopping distance.
constexpr double distance_before_m = 0.70 + aiv::clearance_m;
constexpr double distance_step_m = 0.03;
constexpr double path_clear_m = 0.04;
/// The obstacle sensor may stop a vehicle this much too early behind its leader.
constexpr double detected_too_early_m = 0.03;
constexpr SimDuration back_up_timeout{std::chrono::seconds{10}};

/// Distance from a point to the edge of a body; 0 inside.
double to_body_m(const zone::VehicleShape& shape, const Pose2& X_MB, Point2 p_M) {
  const Pose2 X_BM = inverse(X_MB);
  const Point2 p_B = X_BM * p_M;
  return norm(std::max(0.0, std::fabs(p_B.x_m) - 0.5 * shape.length_m),
              std::max(0.0, std::fabs(p_B.y_m) - 0.5 * shape.width_m));
}

}  // namespace

bool OrderManager::has_what_to_give_back(VehicleIndex vehicle) const {
  const Plan& plan = plans_[vehicle];
  if (!plan.reported.position) return false;
  if (goes_onto_line(vehicle)) return plan.stage == Plan::Stage::running || plan.waits_since.has_value();
  return plan.stage == Plan::Stage::running &&
         traffic_.base_left_m(vehicle, *plan.reported.position).value_or(0.0) > base_left_m_min;
}

bool OrderManager::keeps_off(const Wait& wait, zone::TrackPosition track_position) const {
  const zone::Circuit& circuit = map_->circuit();
  const zone::VehicleShape& shape = map_->zone().vehicle;
  const Pose2 X_MV = off_path(wait.blocker) ? body(wait.blocker) : circuit.pose_at(track_position);
  switch (wait.why) {
    case WaitReason::turn: return false;
    case WaitReason::ahead: return true;
    case WaitReason::crossing: {
      std::vector<CrossingIndex> occupied_crossings;
      map_->crossings_on(track_position, 0.0, occupied_crossings, traffic_.remaining(wait.blocker));
      return std::ranges::any_of(occupied_crossings,
                                 [&](CrossingIndex x) { return traffic_.requests(wait.waiter, x); });
    }
    case WaitReason::off_path:
    case WaitReason::sensors: break;
  }
  const Plan& theirs = plans_[wait.waiter];
  if (off_path(wait.waiter)) {
    const auto entry_point = zone::snap_to_path(circuit, theirs.reported.X_MB);
    if (!theirs.entry_point && !entry_point) return true;
    aiv::EntrySweep sweep{shape};
    sweep.take({body(wait.waiter), circuit.pose_at(theirs.entry_point ? *theirs.entry_point : entry_point->position)});
    return sweep.near_body(X_MV, path_clear_m);
  }
  if (!theirs.reported.position) return true;
  const double far_m = traffic_.base_left_m(wait.waiter, *theirs.reported.position).value_or(0.0) + distance_before_m;
  for (double ahead_m = 0.0; ahead_m < far_m; ahead_m += distance_step_m) {
    const Pose2 X_MW =
        circuit.pose_at(circuit.advance(*theirs.reported.position, ahead_m, traffic_.remaining(wait.waiter)));
    if (aiv::near_bodies(shape, X_MW, X_MV, path_clear_m)) return true;
  }
  return false;
}

std::optional<double> OrderManager::can_yield(VehicleIndex vehicle, Means means, std::span<const Wait> waits) {
  Plan& plan = plans_[vehicle];
  if (map_ == nullptr || !registry_[vehicle].here() || !plan.reported.position || plan.yielding) return std::nullopt;
  switch (means) {
    case Means::move_up: return makes_room_by_moving_up(vehicle, waits) ? std::optional{0.0} : std::nullopt;
    case Means::wait: {
      const bool gives_back = has_what_to_give_back(vehicle);
      const bool frees = std::ranges::all_of(waits, [&](const Wait& wait) {
        return !keeps_off(wait, *plan.reported.position) && (gives_back || wait.why == WaitReason::turn);
      });
      return frees ? std::optional{0.0} : std::nullopt;
    }
    case Means::detour: {
      if (off_path(vehicle)) return std::nullopt;
      const auto around = contested(vehicle);
      const zone::TrackPosition from =
          plan.stage == Plan::Stage::running ? map_->waypoint(plan.base_end).position : *plan.reported.position;
      return !around.empty() && missions_.has_detour(vehicle, from, around) ? std::optional{0.0} : std::nullopt;
    }
    case Means::other_position:
      return plan.stage == Plan::Stage::none && plan.join_handle == 0 && goes_onto_line(vehicle) ? std::optional{0.0}
                                                                                                 : std::nullopt;
    case Means::back_up: return distance_back_m(vehicle, waits);
  }
  return std::nullopt;
}

bool OrderManager::yield(VehicleIndex vehicle, Means means, std::span<const Wait> waits) {
  Plan& plan = plans_[vehicle];
  if (means == Means::move_up) {
    plan.moves_up = true;
    return true;
  }
  if (means == Means::detour) {
    missions_.avoid(vehicle, contested(vehicle));
    return true;
  }
  if (means == Means::other_position) return join_elsewhere(vehicle, false, elsewhere_within_m);
  Plan::Yielding yielding;
  yielding.until = publisher_.now() + rules_.yield_time_max;
  for (const Wait& wait : waits) yielding.others.emplace_back(wait.waiter, position(body(wait.waiter)));
  yielding.drops_order = means == Means::back_up || has_what_to_give_back(vehicle);
  if (means == Means::back_up) {
    const auto back_m = distance_back_m(vehicle, waits);
    if (!back_m) return false;
    yielding.back_m = *back_m;
    yielding.until += back_up_timeout;
  }
  plan.yielding = std::move(yielding);
  traffic_.withdraw(vehicle);
  return true;
}

// --- closer to the leader -------------------------------------------------------------------------------------------

bool OrderManager::makes_room_by_moving_up(VehicleIndex vehicle, std::span<const Wait> waits) const {
  const Plan& plan = plans_[vehicle];
  const Traffic::Leader& ahead = traffic_.ahead(vehicle);
  if (off_path(vehicle) || plan.waits_for_crossing || plan.waits_why != WaitReason::ahead ||
      plan.waits_for_vehicle != ahead.vehicle || !detects_leader(vehicle, ahead.vehicle))
    return false;
  const double up_m = ahead.distance_m - map_->zone().vehicle.length_m - aiv::clearance_m - detected_too_early_m;
  return up_m > 0.0 && std::ranges::any_of(waits, [&](const Wait& wait) {
           const auto& track_position = traffic_.track_position(wait.waiter);
           const Traffic::Leader& before = traffic_.ahead(wait.waiter);
           if (wait.why != WaitReason::ahead || !track_position || before.vehicle != vehicle) return false;
           const Sections remaining = traffic_.remaining(wait.waiter);
           const auto is_in_crossing = [&](double ahead_m) {
             std::vector<CrossingIndex> crossings;
             map_->crossings_on(map_->circuit().advance(*track_position, ahead_m, remaining), 0.0, crossings,
                                remaining);
             return !crossings.empty();
           };
           return is_in_crossing(0.0) &&
                  !is_in_crossing(std::max(0.0, before.distance_m + up_m - traffic_.stopped_m()));
         });
}

// --- another route --------------------------------------------------------------------------------------------------

std::vector<zone::SectionId> OrderManager::contested(VehicleIndex vehicle) const {
  const Plan& plan = plans_[vehicle];
  const bool running = plan.stage == Plan::Stage::running;
  const zone::TrackPosition from = running ? map_->waypoint(plan.base_end).position : *plan.reported.position;
  const auto route =
      running ? traffic_.beyond_base(vehicle, *plan.reported.position).sections
              : std::vector<zone::SectionId>(traffic_.remaining(vehicle).begin(), traffic_.remaining(vehicle).end());
  // The first section of its route that it need not enter and that contains what it waits for.
  const auto& blocker =
      plan.waits_for_vehicle == no_vehicle ? std::nullopt : traffic_.track_position(plan.waits_for_vehicle);
  for (const zone::SectionId section : route) {
    if (section == from.section) break;
    if (blocker && blocker->section == section) return {section};
    if (!plan.waits_for_crossing) continue;
    const auto& spans = map_->zone().crossings[*plan.waits_for_crossing].spans;
    if (std::ranges::find(spans, section, &zone::CrossingSpan::section) != spans.end()) return {section};
  }
  return {};
}

// --- backwards ------------------------------------------------------------------------------------------------------

std::optional<double> OrderManager::distance_back_m(VehicleIndex vehicle, std::span<const Wait> waits) const {
  const Plan& plan = plans_[vehicle];
  const AivProxy& proxy = registry_[vehicle];
  if (off_path(vehicle) || !proxy.supports("backUp").value_or(proxy.is_cosiva()) || !is_stopped(vehicle))
    return std::nullopt;
  const zone::Circuit& circuit = map_->circuit();
  const zone::TrackPosition here = *plan.reported.position;
  const Sections traversed = traffic_.traversed(vehicle);
  // Over a joint only where the section that it came from is known, and where the path does not bend sharply.
  double far_m = here.s_m;
  const auto before = circuit.previous(here.section);
  const zone::SectionId came_from = !traversed.empty()   ? traversed.back()
                                    : before.size() == 1 ? before.front()
                                                         : zone::no_section;
  if (came_from != zone::no_section && circuit.turn_at(came_from, here.section) == 0.0)
    far_m += circuit.section(came_from).length_m();
  far_m = std::min(far_m, rules_.back_up_m_max);

  std::vector<CrossingIndex> occupied_crossings;
  map_->crossings_on(here, 0.0, occupied_crossings, traffic_.remaining(vehicle));
  for (double back_m = back_step_m; back_m + back_slack_m <= far_m + 1e-9; back_m += back_step_m) {
    const zone::TrackPosition there = circuit.advance(here, -back_m, {}, traversed);
    if (std::ranges::any_of(waits, [&](const Wait& wait) { return keeps_off(wait, there); })) continue;
    // In a crossing that the vehicle was not in, it would obstruct other vehicles.
    std::vector<CrossingIndex> crossings_there;
    map_->crossings_on(there, 0.0, crossings_there, traffic_.remaining(vehicle));
    const bool another = std::ranges::any_of(crossings_there, [&](CrossingIndex x) {
      return std::ranges::find(occupied_crossings, x) == occupied_crossings.end();
    });
    if (another) continue;
    const double rolls_m = back_m + back_slack_m;
    return is_free_behind(vehicle, rolls_m) ? std::optional{rolls_m} : std::nullopt;
  }
  return std::nullopt;
}

bool OrderManager::is_free_behind(VehicleIndex vehicle, double back_m) const {
  const zone::Circuit& circuit = map_->circuit();
  const zone::TrackPosition here = *plans_[vehicle].reported.position;
  // The vehicle may move away from a body that is already close at the present clearance.
  double clear_m = behind_clear_m;
  while (clear_m > 0.0 && near_anything(vehicle, body(vehicle), clear_m)) clear_m -= 0.01;
  if (clear_m <= 0.0) clear_m = 0.002;
  const double end_m = back_m + behind_beyond_m;
  for (double at_m = behind_every_m; at_m < end_m + behind_every_m; at_m += behind_every_m) {
    const zone::TrackPosition track_position =
        circuit.advance(here, -std::min(at_m, end_m), {}, traffic_.traversed(vehicle));
    if (near_anything(vehicle, circuit.pose_at(track_position), clear_m)) return false;
  }
  return true;
}

bool OrderManager::near_anything(VehicleIndex vehicle, const Pose2& X_MB, double clear_m) const {
  const zone::VehicleShape& shape = map_->zone().vehicle;
  const zone::Circuit& circuit = map_->circuit();
  for (VehicleIndex other = 0; other < registry_.size(); ++other) {
    if (other == vehicle || !registry_[other].here()) continue;
    if (aiv::near_bodies(shape, X_MB, body(other), clear_m)) return true;
    const auto& track_position = traffic_.track_position(other);
    const double base_m = track_position ? traffic_.base_left_m(other, *track_position).value_or(0.0) : 0.0;
    for (double ahead_m = behind_every_m; ahead_m < base_m + behind_every_m; ahead_m += behind_every_m) {
      const zone::TrackPosition on =
          circuit.advance(*track_position, std::min(ahead_m, base_m), traffic_.remaining(other));
      if (aiv::near_bodies(shape, X_MB, circuit.pose_at(on), clear_m)) return true;
    }
  }
  const auto near_disc = [&](Point2 at, double radius_m) { return to_body_m(shape, X_MB, at) < radius_m + clear_m; };
  const auto& virtual_objects = simulator_.augmented().virtual_objects();
  const auto& detected = simulator_.detected().obstacles();
  return std::ranges::any_of(virtual_objects,
                             [&](const VirtualObject& virtual_object) {
                               return near_disc(virtual_object.at(publisher_.now()).at, virtual_object.radius_m);
                             }) ||
         std::ranges::any_of(detected, [&](const DetectedObstacle& one) { return near_disc(one.at, one.radius_m); });
}

// --- until the others have left -------------------------------------------------------------------------------------

bool OrderManager::continue_yielding(VehicleIndex vehicle) {
  Plan& plan = plans_[vehicle];
  if (!plan.yielding) return false;
  Plan::Yielding& yielding = *plan.yielding;
  const bool others_have_left = std::ranges::all_of(yielding.others, [&](const auto& other) {
    return !registry_[other.first].here() || distance(position(body(other.first)), other.second) > rules_.others_left_m;
  });
  const bool backs_up = yielding.back_m > 0.0 || yielding.handle != 0;
  if (publisher_.now() >= yielding.until || (others_have_left && !backs_up)) {
    end_yielding(vehicle);
    return false;
  }
  if (yielding.drops_order && plan.stage == Plan::Stage::running) cancel(vehicle);
  if (backs_up && plan.stage == Plan::Stage::none) follow_back_up(vehicle, yielding);
  return true;
}

void OrderManager::follow_back_up(VehicleIndex vehicle, Plan::Yielding& yielding) {
  const auto notify = [&](double distance_m) {
    return action_sender_.send(registry_[vehicle], vehicle,
                               {{"backUp", {}, {}, wire::BlockingType::hard, {{"distance", distance_m}}}},
                               std::chrono::seconds{3}, true);
  };
  if (yielding.handle == 0) {
    if (!is_stopped(vehicle)) return;
    if (!is_free_behind(vehicle, yielding.back_m)) return;  // a vehicle there may leave again before the timeout
    // The vehicle may move away from a body that is already close at the present clearance.
    yielding.clear_m = back_clear_m;
    while (yielding.clear_m > back_clear_m_min && near_anything(vehicle, body(vehicle), yielding.clear_m))
      yielding.clear_m -= 0.001;
    yielding.handle = notify(yielding.back_m);
    return;
  }
  const InstantActionSender::PendingAction* pending_action = action_sender_.find(yielding.handle);
  const wire::ActionStatus status =
      pending_action == nullptr ? wire::ActionStatus::failed : pending_action->actions.front().status;
  const bool over = status == wire::ActionStatus::finished || status == wire::ActionStatus::failed;
  if (!over && !yielding.stopped && near_anything(vehicle, body(vehicle), yielding.clear_m)) {
    action_sender_.drop(yielding.handle);
    yielding.stopped = true;
    yielding.handle = notify(0.0);
    return;
  }
  if (!over) return;
  if (status == wire::ActionStatus::failed && pending_action != nullptr)
    publisher_.log('w', registry_[vehicle].name + ": did not back up: " + pending_action->actions.front().result);
  action_sender_.drop(yielding.handle);
  yielding.handle = 0;
  yielding.back_m = 0.0;
  yielding.until = std::min(yielding.until, publisher_.now() + rules_.yield_time_max);
}

void OrderManager::end_yielding(VehicleIndex vehicle) {
  auto& yielding = plans_[vehicle].yielding;
  if (yielding && yielding->handle != 0) action_sender_.drop(yielding->handle);
  yielding.reset();
}

}  // namespace cosiva::virtual_side
