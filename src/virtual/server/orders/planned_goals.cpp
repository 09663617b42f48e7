#include "cosiva/virtual/server/orders/planned_goals.h"

#include <algorithm>
#include <chrono>
#include <set>
#include <string>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {
namespace {

constexpr SimDuration other_goal_after = std::chrono::seconds{5};  // where the present one cannot be reached
constexpr planning::Distances::Steps aside_moves = 2;              // of a vehicle that lets others go to the stations
constexpr SimDuration urgent_after = std::chrono::seconds{10};

}  // namespace

void PlannedGoals::set_map(const WaypointGraph* map) {
  for (Vehicle& vehicle : vehicles_) vehicle = {};
  stations_.clear();
  waypoints_.clear();
  if (!fleet_.in_force()) return;
  const planning::TrackFloor& track = fleet_.plan().track();
  std::set<planning::CellId> points;  // a goal has several names where stations and waypoints are at one point
  const auto add = [&](std::vector<planning::GoalId>& goals, const std::string& name) {
    const auto goal = track.goal(name);
    if (goal && points.insert(track.floor().footprint(track.floor().goal(*goal)[0])[0]).second) goals.push_back(*goal);
  };
  for (const zone::Station& station : map->zone().stations) add(stations_, station.name);
  for (const zone::Waypoint& waypoint : map->zone().waypoints) add(waypoints_, waypoint.id);
  COSIVA_EXPECT(points.size() == stations_.size() + waypoints_.size());
}

bool PlannedGoals::choose(VehicleIndex vehicle, SimDuration waited) {
  Vehicle& known = vehicles_[vehicle];
  const std::uint64_t revision = context_.missions.revision(vehicle);
  if (known.revision != revision) {
    known = {revision, std::nullopt, false, vehicle, context_.publisher.now(), context_.publisher.now()};
    fleet_.begin_move(vehicle);
  }
  const Mission& mission = context_.missions.mission(vehicle);
  const bool arrived = mission.kind == Mission::Kind::go ? go(vehicle, mission) : go_round(vehicle, mission);
  set_stops(vehicle, waited);
  return arrived;
}

bool PlannedGoals::go(VehicleIndex vehicle, const Mission& mission) {
  Vehicle& known = vehicles_[vehicle];
  planning::TrackFleet& plan = fleet_.plan();
  known.goal = plan.track().goal(mission.name);
  const bool is_there = has_arrived(vehicle);
  const bool was_arrived = context_.missions.state(vehicle) == Missions::State::arrived;
  if (is_there && !was_arrived)
    (void)context_.missions.is_stopped_at(vehicle, position(fleet_.pose(vehicle)), context_.rules.deviation_m);
  if (context_.missions.state(vehicle) != Missions::State::arrived) {
    std::optional<std::string> why;
    if (!plan.reachable(vehicle))
      why = "no path to " + mission.name + " is free: closed sections, or vehicles that do not drive, obstruct all";
    context_.missions.set_no_route(vehicle, why);
    return false;
  }
  if (is_there || (known.goal && is_goal_of_others(*known.goal, vehicle))) {
    known.goal.reset();  // makes room for others
  } else if (known.goal && fleet_.waits_at_state(vehicle) &&
             context_.publisher.now() - known.chosen_at >= other_goal_after) {
    known.chosen_at = context_.publisher.now();
    plan.set_stops(vehicle, {}, 0);  // has made room, and returns
  }
  return !was_arrived;
}

bool PlannedGoals::go_round(VehicleIndex vehicle, const Mission& mission) {
  Vehicle& known = vehicles_[vehicle];
  const SimTime now = context_.publisher.now();
  const bool obstructed = !fleet_.plan().reachable(vehicle) && now - known.chosen_at >= other_goal_after;
  const bool arrived = has_arrived(vehicle);
  if (waits_for_station(vehicle) && is_next_for_station(vehicle)) {
    if (const auto station = nearest_free(vehicle, stations_, 1)) {
      known.goal = station;
      known.to_station = true;
      known.chosen_at = now;
      return false;
    }
  }
  if (known.goal && !obstructed && !arrived) return false;
  const bool counts = arrived && (stations_.empty() || is_station(*known.goal));
  if (counts) known.at_station_at = now;
  const bool was_station = std::exchange(known.to_station, true);
  const auto before = std::exchange(known.goal, std::nullopt);
  known.chosen_at = now;
  if (const zone::Loop* const loop = loop_of(*context_.map, mission)) {
    if (const auto round = round_of(*loop); !round.empty()) known.goal = round[++known.round % round.size()];
    return counts;
  }
  // Steps of different lengths, so that vehicles do not follow one another from station to station.
  known.round += 1 + vehicle % 3;
  const bool crowded = others_wait_for_station(vehicle);
  if (!crowded)
    known.goal = next_free(vehicle, known.round, before);
  else if (!arrived || !was_station)
    known.goal = nearest_free(vehicle, stations_, 1);
  known.to_station = known.goal.has_value();
  if (!known.goal) known.goal = nearest_free(vehicle, waypoints_, aside_moves);
  return counts;
}

std::optional<planning::GoalId> PlannedGoals::next_free(VehicleIndex vehicle, std::size_t first,
                                                        std::optional<planning::GoalId> but) const {
  for (std::size_t i = 0; i < stations_.size(); ++i) {
    const planning::GoalId goal = stations_[(first + i) % stations_.size()];
    if (goal != but && !is_goal_of_others(goal, vehicle)) return goal;
  }
  return std::nullopt;
}

std::optional<planning::GoalId> PlannedGoals::nearest_free(VehicleIndex vehicle,
                                                           std::span<const planning::GoalId> goals,
                                                           planning::Distances::Steps moves_min) {
  std::optional<planning::GoalId> nearest;
  planning::Distances::Steps moves = planning::Distances::unreachable;
  for (const planning::GoalId goal : goals) {
    const auto here = fleet_.plan().moves_to(goal, fleet_.plan().states(vehicle)[0]);
    if (here < moves_min || here >= moves || is_goal_of_others(goal, vehicle)) continue;
    nearest = goal;
    moves = here;
  }
  return nearest;
}

bool PlannedGoals::is_station(planning::GoalId goal) const {
  const planning::Floor& floor = fleet_.plan().track().floor();
  return std::ranges::any_of(
      stations_, [&](planning::GoalId station) { return floor.goal(station).front() == floor.goal(goal).front(); });
}

bool PlannedGoals::waits_for_station(VehicleIndex vehicle) const {
  return fleet_.plan().takes_part(vehicle) && vehicles_[vehicle].goal && !vehicles_[vehicle].to_station &&
         context_.missions.mission(vehicle).kind == Mission::Kind::circulate;
}

bool PlannedGoals::others_wait_for_station(VehicleIndex vehicle) const {
  for (VehicleIndex other = 0; other < vehicles_.size(); ++other)
    if (other != vehicle && waits_for_station(other)) return true;
  return false;
}

bool PlannedGoals::is_next_for_station(VehicleIndex vehicle) const {
  for (VehicleIndex other = 0; other < vehicles_.size(); ++other)
    if (waits_for_station(other) && vehicles_[other].at_station_at < vehicles_[vehicle].at_station_at) return false;
  return true;
}

std::vector<planning::GoalId> PlannedGoals::round_of(const zone::Loop& loop) const {
  std::vector<planning::GoalId> goals;
  for (const zone::SectionId section : loop.sections) {
    const WaypointIndex first = context_.map->first_on(section);
    if (first == no_waypoint) continue;
    if (const auto goal = fleet_.plan().track().goal(context_.map->waypoint(first).id)) goals.push_back(*goal);
  }
  return goals;
}

bool PlannedGoals::is_goal_of_others(planning::GoalId goal, VehicleIndex vehicle) const {
  for (VehicleIndex other = 0; other < vehicles_.size(); ++other)
    if (other != vehicle && fleet_.plan().takes_part(other) && vehicles_[other].goal == goal) return true;
  return false;
}

bool PlannedGoals::has_arrived(VehicleIndex vehicle) const {
  const auto& goal = vehicles_[vehicle].goal;
  return goal && fleet_.waits_at_state(vehicle) && fleet_.plan().moves_to(*goal, fleet_.plan().states(vehicle)[0]) == 0;
}

void PlannedGoals::set_stops(VehicleIndex vehicle, SimDuration waited) {
  const auto& goal = vehicles_[vehicle].goal;
  std::vector<planning::Stop> stops;
  if (goal) stops.push_back({*goal, 1});
  fleet_.plan().set_stops(vehicle, stops, static_cast<std::uint32_t>(waited / urgent_after));
}

void PlannedGoals::archive(Archive& archive) { archive(vehicles_); }

}  // namespace cosiva::virtual_side
