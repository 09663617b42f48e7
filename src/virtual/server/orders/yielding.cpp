#include "cosiva/virtual/server/orders/yielding.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "cosiva/aiv/decision/envelope.h"
#include "cosiva/aiv/decision/line_entry.h"
#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/base/math.h"
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

bool Yielding::has_what_to_give_back(VehicleIndex vehicle) const {
  const auto& track_position = positions_.reported(vehicle).position;
  const bool is_running = sessions_[vehicle].is_running();
  if (!track_position) return false;
  if (positions_.goes_onto_line(vehicle)) return is_running || waits_[vehicle].since.has_value();
  return is_running && context_.traffic.base_left_m(vehicle, *track_position).value_or(0.0) > base_left_m_min;
}

bool Yielding::keeps_off(const Wait& wait, zone::TrackPosition track_position) const {
  const zone::Circuit& circuit = context_.map->circuit();
  const zone::VehicleShape& shape = context_.map->zone().vehicle;
  const Pose2 X_MV =
      positions_.is_off_path(wait.blocker) ? positions_.body(wait.blocker) : circuit.pose_at(track_position);
  switch (wait.why) {
    case WaitReason::turn:
    case WaitReason::plan: return false;
    case WaitReason::ahead: return true;
    case WaitReason::crossing: {
      std::vector<CrossingIndex> occupied_crossings;
      context_.map->crossings_on(track_position, 0.0, occupied_crossings, context_.traffic.remaining(wait.blocker));
      return std::ranges::any_of(occupied_crossings,
                                 [&](CrossingIndex x) { return requests(context_.traffic, wait.waiter, x); });
    }
    case WaitReason::off_path:
    case WaitReason::sensors: break;
  }
  const ReportedPose& theirs = positions_.reported(wait.waiter);
  if (positions_.is_off_path(wait.waiter)) {
    const auto& sent_to = positions_.entry_point(wait.waiter);
    const auto nearest = zone::snap_to_path(circuit, theirs.X_MB);
    if (!sent_to && !nearest) return true;
    aiv::EntrySweep sweep{shape};
    sweep.take({positions_.body(wait.waiter), circuit.pose_at(sent_to ? *sent_to : nearest->position)});
    return sweep.near_body(X_MV, path_clear_m);
  }
  if (!theirs.position) return true;
  const double far_m = context_.traffic.base_left_m(wait.waiter, *theirs.position).value_or(0.0) + distance_before_m;
  for (double ahead_m = 0.0; ahead_m < far_m; ahead_m += distance_step_m) {
    const Pose2 X_MW =
        circuit.pose_at(circuit.advance(*theirs.position, ahead_m, context_.traffic.remaining(wait.waiter)));
    if (aiv::near_bodies(shape, X_MW, X_MV, path_clear_m)) return true;
  }
  return false;
}

std::optional<double> Yielding::can_yield(VehicleIndex vehicle, Means means, std::span<const Wait> waits) const {
  const auto& track_position = positions_.reported(vehicle).position;
  const OrderSession& session = sessions_[vehicle];
  if (context_.map == nullptr || !context_.registry[vehicle].here() || !track_position || yields(vehicle))
    return std::nullopt;
  switch (means) {
    case Means::move_up: return makes_room_by_moving_up(vehicle, waits) ? std::optional{0.0} : std::nullopt;
    case Means::wait: {
      const bool gives_back = has_what_to_give_back(vehicle);
      const bool frees = std::ranges::all_of(waits, [&](const Wait& wait) {
        return !keeps_off(wait, *track_position) && (gives_back || wait.why == WaitReason::turn);
      });
      return frees ? std::optional{0.0} : std::nullopt;
    }
    case Means::detour: {
      if (positions_.is_off_path(vehicle)) return std::nullopt;
      const auto around = contested(vehicle);
      const zone::TrackPosition from =
          session.is_running() ? context_.map->waypoint(session.base_end()).position : *track_position;
      return !around.empty() && context_.missions.has_detour(vehicle, from, around) ? std::optional{0.0} : std::nullopt;
    }
    case Means::other_position:
      return session.stage() == OrderSession::Stage::none && !joins_.is_pending(vehicle) &&
                     positions_.goes_onto_line(vehicle)
                 ? std::optional{0.0}
                 : std::nullopt;
    case Means::back_up: return distance_back_m(vehicle, waits);
  }
  return std::nullopt;
}

bool Yielding::yield(VehicleIndex vehicle, Means means, std::span<const Wait> waits) {
  COSIVA_EXPECT(!waits.empty());
  if (means == Means::move_up) {
    vehicles_[vehicle].moves_up = true;
    return true;
  }
  if (means == Means::detour) {
    context_.missions.avoid(vehicle, contested(vehicle));
    return true;
  }
  if (means == Means::other_position) return joins_.join_elsewhere(vehicle, false, elsewhere_within_m);
  Stop stop;
  stop.until = context_.publisher.now() + context_.rules.yield_time_max;
  for (const Wait& wait : waits) stop.others.emplace_back(wait.waiter, position(positions_.body(wait.waiter)));
  stop.drops_order = means == Means::back_up || has_what_to_give_back(vehicle);
  if (means == Means::back_up) {
    const auto back_m = distance_back_m(vehicle, waits);
    if (!back_m) return false;
    stop.back_m = *back_m;
    stop.until += back_up_timeout;
  }
  vehicles_[vehicle].stop = std::move(stop);
  context_.traffic.withdraw(vehicle);
  return true;
}

// --- closer to the leader -------------------------------------------------------------------------------------------

bool Yielding::makes_room_by_moving_up(VehicleIndex vehicle, std::span<const Wait> waits) const {
  const WaitRecord& record = waits_[vehicle];
  const Traffic::Leader& ahead = context_.traffic.ahead(vehicle);
  if (positions_.is_off_path(vehicle) || record.crossing || record.why != WaitReason::ahead ||
      record.blocker != ahead.vehicle || !detects(context_.registry, vehicle, ahead.vehicle))
    return false;
  const double up_m =
      ahead.distance_m - context_.map->zone().vehicle.length_m - aiv::clearance_m - detected_too_early_m;
  return up_m > 0.0 && std::ranges::any_of(waits, [&](const Wait& wait) {
           const auto& track_position = context_.traffic.track_position(wait.waiter);
           const Traffic::Leader& before = context_.traffic.ahead(wait.waiter);
           if (wait.why != WaitReason::ahead || !track_position || before.vehicle != vehicle) return false;
           const Sections remaining = context_.traffic.remaining(wait.waiter);
           const auto is_in_crossing = [&](double ahead_m) {
             std::vector<CrossingIndex> crossings;
             context_.map->crossings_on(context_.map->circuit().advance(*track_position, ahead_m, remaining), 0.0,
                                        crossings, remaining);
             return !crossings.empty();
           };
           return is_in_crossing(0.0) &&
                  !is_in_crossing(std::max(0.0, before.distance_m + up_m - context_.traffic.stopped_m()));
         });
}

// --- another route --------------------------------------------------------------------------------------------------

std::vector<zone::SectionId> Yielding::contested(VehicleIndex vehicle) const {
  const WaitRecord& record = waits_[vehicle];
  const zone::TrackPosition here = *positions_.reported(vehicle).position;
  const bool running = sessions_[vehicle].is_running();
  const zone::TrackPosition from = running ? context_.map->waypoint(sessions_[vehicle].base_end()).position : here;
  const auto route = running ? beyond_base(context_.traffic, vehicle, here).sections
                             : std::vector<zone::SectionId>(context_.traffic.remaining(vehicle).begin(),
                                                            context_.traffic.remaining(vehicle).end());
  // The first section of its route that it need not enter and that contains what it waits for.
  const auto& blocker = record.blocker == no_vehicle ? std::nullopt : context_.traffic.track_position(record.blocker);
  for (const zone::SectionId section : route) {
    if (section == from.section) break;
    if (blocker && blocker->section == section) return {section};
    if (!record.crossing) continue;
    const auto& spans = context_.map->zone().crossings[*record.crossing].spans;
    if (std::ranges::find(spans, section, &zone::CrossingSpan::section) != spans.end()) return {section};
  }
  return {};
}

// --- backwards ------------------------------------------------------------------------------------------------------

std::optional<double> Yielding::distance_back_m(VehicleIndex vehicle, std::span<const Wait> waits) const {
  const AivProxy& proxy = context_.registry[vehicle];
  if (positions_.is_off_path(vehicle) || !proxy.supports("backUp").value_or(proxy.is_cosiva()) ||
      !positions_.is_stopped(vehicle))
    return std::nullopt;
  const zone::Circuit& circuit = context_.map->circuit();
  const zone::TrackPosition here = *positions_.reported(vehicle).position;
  const Sections traversed = context_.traffic.traversed(vehicle);
  // Over a joint only where the section that it came from is known, and where the path does not bend sharply.
  double far_m = here.s_m;
  const auto before = circuit.previous(here.section);
  const zone::SectionId came_from = !traversed.empty()   ? traversed.back()
                                    : before.size() == 1 ? before.front()
                                                         : zone::no_section;
  if (came_from != zone::no_section && circuit.turn_at(came_from, here.section) == 0.0)
    far_m += circuit.section(came_from).length_m();
  far_m = std::min(far_m, context_.rules.back_up_m_max);

  std::vector<CrossingIndex> occupied_crossings;
  context_.map->crossings_on(here, 0.0, occupied_crossings, context_.traffic.remaining(vehicle));
  for (double back_m = back_step_m; back_m + back_slack_m <= far_m + 1e-9; back_m += back_step_m) {
    const zone::TrackPosition there = circuit.advance(here, -back_m, {}, traversed);
    if (std::ranges::any_of(waits, [&](const Wait& wait) { return keeps_off(wait, there); })) continue;
    // In a crossing that the vehicle was not in, it would obstruct other vehicles.
    std::vector<CrossingIndex> crossings_there;
    context_.map->crossings_on(there, 0.0, crossings_there, context_.traffic.remaining(vehicle));
    const bool another = std::ranges::any_of(crossings_there, [&](CrossingIndex x) {
      return std::ranges::find(occupied_crossings, x) == occupied_crossings.end();
    });
    if (another) continue;
    const double rolls_m = back_m + back_slack_m;
    return is_free_behind(vehicle, rolls_m) ? std::optional{rolls_m} : std::nullopt;
  }
  return std::nullopt;
}

bool Yielding::is_free_behind(VehicleIndex vehicle, double back_m) const {
  const zone::Circuit& circuit = context_.map->circuit();
  const zone::TrackPosition here = *positions_.reported(vehicle).position;
  // The vehicle may move away from a body that is already close at the present clearance.
  double clear_m = behind_clear_m;
  while (clear_m > 0.0 && near_anything(vehicle, positions_.body(vehicle), clear_m)) clear_m -= 0.01;
  if (clear_m <= 0.0) clear_m = 0.002;
  const double end_m = back_m + behind_beyond_m;
  for (double at_m = behind_every_m; at_m < end_m + behind_every_m; at_m += behind_every_m) {
    const zone::TrackPosition track_position =
        circuit.advance(here, -std::min(at_m, end_m), {}, context_.traffic.traversed(vehicle));
    if (near_anything(vehicle, circuit.pose_at(track_position), clear_m)) return false;
  }
  return true;
}

bool Yielding::near_anything(VehicleIndex vehicle, const Pose2& X_MB, double clear_m) const {
  const zone::VehicleShape& shape = context_.map->zone().vehicle;
  const zone::Circuit& circuit = context_.map->circuit();
  for (VehicleIndex other = 0; other < context_.registry.size(); ++other) {
    if (other == vehicle || !context_.registry[other].here()) continue;
    if (aiv::near_bodies(shape, X_MB, positions_.body(other), clear_m)) return true;
    const auto& track_position = context_.traffic.track_position(other);
    const double base_m = track_position ? context_.traffic.base_left_m(other, *track_position).value_or(0.0) : 0.0;
    for (double ahead_m = behind_every_m; ahead_m < base_m + behind_every_m; ahead_m += behind_every_m) {
      const zone::TrackPosition on =
          circuit.advance(*track_position, std::min(ahead_m, base_m), context_.traffic.remaining(other));
      if (aiv::near_bodies(shape, X_MB, circuit.pose_at(on), clear_m)) return true;
    }
  }
  const auto near_disc = [&](Point2 at, double radius_m) { return to_body_m(shape, X_MB, at) < radius_m + clear_m; };
  const auto& virtual_objects = context_.simulator.augmented().virtual_objects();
  const auto& detected = context_.simulator.detected().obstacles();
  return std::ranges::any_of(virtual_objects,
                             [&](const VirtualObject& virtual_object) {
                               return near_disc(virtual_object.at(context_.publisher.now()).at,
                                                virtual_object.radius_m);
                             }) ||
         std::ranges::any_of(detected, [&](const DetectedObstacle& one) { return near_disc(one.at, one.radius_m); });
}

// --- until the others have left -------------------------------------------------------------------------------------

bool Yielding::continue_yielding(VehicleIndex vehicle) {
  if (!yields(vehicle)) return false;
  OrderSession& session = sessions_[vehicle];
  Stop& stop = *vehicles_[vehicle].stop;
  const bool others_have_left = std::ranges::all_of(stop.others, [&](const auto& other) {
    return !context_.registry[other.first].here() ||
           distance(position(positions_.body(other.first)), other.second) > context_.rules.others_left_m;
  });
  const bool backs_up = stop.back_m > 0.0 || stop.handle != 0;
  if (context_.publisher.now() >= stop.until || (others_have_left && !backs_up)) {
    end(vehicle);
    return false;
  }
  if (stop.drops_order && session.is_running()) session.cancel();
  if (backs_up && session.stage() == OrderSession::Stage::none) follow_back_up(vehicle, stop);
  return true;
}

void Yielding::follow_back_up(VehicleIndex vehicle, Stop& stop) {
  COSIVA_EXPECT(stop.drops_order);
  if (stop.handle == 0) {
    if (!positions_.is_stopped(vehicle)) return;
    if (!is_free_behind(vehicle, stop.back_m)) return;  // a vehicle there may leave again before the timeout
    // The vehicle may move away from a body that is already close at the present clearance.
    stop.clear_m = back_clear_m;
    while (stop.clear_m > back_clear_m_min && near_anything(vehicle, positions_.body(vehicle), stop.clear_m))
      stop.clear_m -= 0.001;
    stop.handle = send_back_up(vehicle, stop.back_m);
    return;
  }
  const InstantActionSender::PendingAction* pending_action = context_.action_sender.find(stop.handle);
  const wire::ActionStatus status =
      pending_action == nullptr ? wire::ActionStatus::failed : pending_action->actions.front().status;
  const bool over = status == wire::ActionStatus::finished || status == wire::ActionStatus::failed;
  if (!over && !stop.stopped && near_anything(vehicle, positions_.body(vehicle), stop.clear_m)) {
    context_.action_sender.drop(stop.handle);
    stop.stopped = true;
    stop.handle = send_back_up(vehicle, 0.0);
    return;
  }
  if (!over) return;
  if (status == wire::ActionStatus::failed && pending_action != nullptr)
    context_.publisher.log(
        'w', context_.registry[vehicle].name() + ": did not back up: " + pending_action->actions.front().result);
  context_.action_sender.drop(stop.handle);
  stop.handle = 0;
  stop.back_m = 0.0;
  stop.until = std::min(stop.until, context_.publisher.now() + context_.rules.yield_time_max);
}

InstantActionSender::ActionHandle Yielding::send_back_up(VehicleIndex vehicle, double distance_m) {
  return context_.action_sender.send(context_.registry[vehicle], vehicle,
                                     {{"backUp", {}, {}, wire::BlockingType::hard, {{"distance", distance_m}}}},
                                     std::chrono::seconds{3}, true);
}

void Yielding::end(VehicleIndex vehicle) {
  auto& stop = vehicles_[vehicle].stop;
  if (stop && stop->handle != 0) context_.action_sender.drop(stop->handle);
  stop.reset();
}

void Yielding::archive(Archive& archive) { archive(vehicles_); }

}  // namespace cosiva::virtual_side
