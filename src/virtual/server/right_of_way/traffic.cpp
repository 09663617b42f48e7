#include "cosiva/virtual/server/right_of_way/traffic.h"

#include <algorithm>
#include <utility>

#include "cosiva/aiv/decision/right_of_way.h"
#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/virtual/simulator/follow.h"

namespace cosiva::virtual_side {
namespace {

/// A base shorter than this is not measured.
constexpr double short_base_m = 8.0;
constexpr double base_slack_m = 0.5;
/// The end of a base that the vehicle has passed is no further ahead of the position that it reports.
constexpr double passed_base_m = 0.5;
/// The distance behind a vehicle within which a vehicle that only follows is searched for.
constexpr double behind_m_max = 8.0;
constexpr double past_m = 0.25;

/// A vehicle nearer to its stop line than this is stopped, or nearly so, and has to accelerate.
constexpr double stopped_before_m = 0.10;

}  // namespace

void Traffic::set_map(const WaypointGraph* map) {
  map_ = map;
  holders_.assign(map == nullptr ? 0 : map->crossing_count(), no_vehicle);
  queue_.clear();
  convoys_.clear();
  for (Vehicle& vehicle : vehicles_) {
    Vehicle fresh;
    fresh.priority = vehicle.priority;
    vehicle = std::move(fresh);
  }
  base_left_.assign(vehicles_.size(), std::nullopt);
  positions_dirty_ = true;
}

void Traffic::resize(std::size_t vehicles) {
  vehicles_.resize(vehicles);
  base_left_.resize(vehicles);
  positions_dirty_ = true;
}

void Traffic::set_position(VehicleIndex vehicle, std::optional<zone::TrackPosition> position) {
  if (vehicles_[vehicle].position == position) return;
  vehicles_[vehicle].position = position;
  if (position) follow(vehicle, *position);
  positions_dirty_ = true;
}

void Traffic::follow(VehicleIndex vehicle, zone::TrackPosition position) {
  Vehicle& self = vehicles_[vehicle];
  base_left_[vehicle].reset();
  const bool was_on =
      std::exchange(self.on_course, virtual_side::follow(self.course, map_->circuit(), position.section));
  if (was_on != self.on_course) check_again(vehicle);
}

void Traffic::check_again(VehicleIndex vehicle) {
  base_left_[vehicle].reset();
  holds_dirty_ = true;
  if (positions_dirty_ || map_ == nullptr) return;
  vehicles_[vehicle].ahead = vehicles_[vehicle].position ? ahead_within(vehicle, -1.0) : Leader{};
}

void Traffic::set_course(VehicleIndex vehicle, zone::Course course) {
  Vehicle& self = vehicles_[vehicle];
  self.course = std::move(course);
  self.on_course = !self.course.empty();
  if (self.position) follow(vehicle, *self.position);
  check_again(vehicle);
}

void Traffic::extend_course(VehicleIndex vehicle, Sections more) {
  vehicles_[vehicle].course.extend(more);
  check_again(vehicle);
}

void Traffic::cut_course(VehicleIndex vehicle, std::size_t keep) {
  vehicles_[vehicle].course.cut(keep);
  check_again(vehicle);
}

void Traffic::set_base_passed(VehicleIndex vehicle, bool passed) {
  if (vehicles_[vehicle].base_passed == passed) return;
  vehicles_[vehicle].base_passed = passed;
  measure_base(vehicle);
  holds_dirty_ = true;
}

void Traffic::set_base_end(VehicleIndex vehicle, WaypointIndex end) {
  set_base_passed(vehicle, false);
  if (vehicles_[vehicle].base_end == end) return;
  vehicles_[vehicle].base_end = end;
  measure_base(vehicle);
  holds_dirty_ = true;
}

void Traffic::reserve(VehicleIndex vehicle, std::vector<CrossingIndex> crossings) {
  Vehicle& self = vehicles_[vehicle];
  if (self.reserved == crossings) return;
  self.reserved = std::move(crossings);
  for (const CrossingIndex x : self.reserved) hold(x, vehicle);
  base_left_[vehicle].reset();
  holds_dirty_ = true;
}

void Traffic::hold(CrossingIndex crossing, VehicleIndex vehicle) {
  holds_ += holders_[crossing] == vehicle ? 0U : 1U;
  holders_[crossing] = vehicle;
}

void Traffic::measure_base(VehicleIndex vehicle) {
  Vehicle& self = vehicles_[vehicle];
  base_left_[vehicle].reset();
  self.base_m_max = self.base_passed ? passed_base_m : short_base_m;
  if (self.base_passed || self.base_end == no_waypoint || !self.position) return;
  const auto left_m =
      map_->base_left(*self.position, self.base_end, std::numeric_limits<double>::max(), remaining(vehicle), false);
  self.base_m_max = std::max(short_base_m, left_m.value_or(0.0) + base_slack_m);
}

std::optional<double> Traffic::base_left_m(VehicleIndex vehicle, zone::TrackPosition position) const {
  const Vehicle& self = vehicles_[vehicle];
  if (self.base_end == no_waypoint) return std::nullopt;
  std::optional<BaseLeft>& known = base_left_[vehicle];
  if (!known || known->position != position) {
    const Sections remaining =
        self.course.empty() || self.course.here() != position.section ? Sections{} : this->remaining(vehicle);
    known = {position, map_->base_left(position, self.base_end, self.base_m_max, remaining, self.base_passed)};
  }
  return known->left_m;
}

void Traffic::forget(VehicleIndex vehicle) {
  set_position(vehicle, std::nullopt);
  reserve(vehicle, {});
  set_base_end(vehicle, no_waypoint);
  vehicles_[vehicle].course.clear();
  vehicles_[vehicle].on_course = false;
  base_left_[vehicle].reset();
  withdraw(vehicle);
}

double Traffic::stopped_m() const { return map_->zone().vehicle.length_m + rules_.gap_m; }

void Traffic::update() {
  if (map_ == nullptr || !(positions_dirty_ || holds_dirty_)) return;
  if (std::exchange(positions_dirty_, false)) {
    sort_by_position();
    for (VehicleIndex i = 0; i < vehicles_.size(); ++i)
      vehicles_[i].ahead = vehicles_[i].position ? ahead_within(i, -1.0) : Leader{};
  }
  holds_dirty_ = false;
  update_holds();
}

void Traffic::sort_by_position() {
  by_section_.clear();
  for (VehicleIndex i = 0; i < vehicles_.size(); ++i)
    if (vehicles_[i].position) by_section_.emplace_back(vehicles_[i].position->section, i);
  std::ranges::sort(by_section_);
}

void Traffic::search_on(zone::SectionId section, double start_m, double from_s_m, double to_s_m, VehicleIndex self,
                        Leader& nearest) const {
  for (auto it = std::ranges::lower_bound(by_section_, std::pair{section, VehicleIndex{0}});
       it != by_section_.end() && it->first == section; ++it) {
    const VehicleIndex other = it->second;
    const double s_m = vehicles_[other].position->s_m;
    const double distance_m = start_m + (s_m - from_s_m);
    if (other == self || s_m < from_s_m || s_m > to_s_m || distance_m > nearest.distance_m) continue;
    // Of two vehicles at exactly the same position the lower number counts as the leader, so that it can leave.
    if (distance_m == 0.0 && other > self) continue;
    nearest = {other, distance_m};
  }
}

Traffic::Leader Traffic::ahead_within(VehicleIndex index, double limit_m) const {
  const Vehicle& self = vehicles_[index];
  if (limit_m >= 0.0 && (limit_m <= rules_.look_ahead_m || self.ahead.vehicle != no_vehicle)) return self.ahead;
  if (!self.position) return {};
  constexpr double everywhere = std::numeric_limits<double>::infinity();
  const zone::Circuit& circuit = map_->circuit();
  const Sections remaining = this->remaining(index);
  Leader nearest{no_vehicle, std::max(limit_m, rules_.look_ahead_m)};
  zone::SectionLookAhead path{circuit, self.position->section, remaining};
  search_on(path.section(), 0.0, self.position->s_m, everywhere, index, nearest);
  double travelled_m = circuit.section(path.section()).length_m() - self.position->s_m;
  for (std::size_t steps = 0; steps < remaining.size() + circuit.size() && travelled_m <= nearest.distance_m; ++steps) {
    const auto branches = circuit.next(path.section());
    if (!path.step()) break;
    // Vehicles on another branch obstruct the path as long as their bodies are not clear of it.
    for (const zone::SectionId branch : branches)
      if (branch != path.section()) search_on(branch, travelled_m, 0.0, map_->parted_m(branch), index, nearest);
    search_on(path.section(), travelled_m, 0.0, everywhere, index, nearest);
    travelled_m += circuit.section(path.section()).length_m();
  }
  if (nearest.vehicle == no_vehicle) return {};
  return nearest;
}

void Traffic::update_holds() {
  for (VehicleIndex v = 0; v < vehicles_.size(); ++v) {
    Vehicle& vehicle = vehicles_[v];
    if (!vehicle.position) {
      vehicle.needs = vehicle.reserved;
      continue;
    }
    const double base_m = base_left_m(v, *vehicle.position).value_or(0.0);
    std::optional<BaseLeft>& known = base_left_[v];
    if (known && known->needs_known) continue;
    vehicle.needs.clear();
    map_->crossings_on(*vehicle.position, base_m, vehicle.needs, remaining(v));
    for (const CrossingIndex x : vehicle.reserved)
      if (std::ranges::find(vehicle.needs, x) == vehicle.needs.end()) vehicle.needs.push_back(x);
    if (known) known->needs_known = true;
  }
  for (CrossingIndex x = 0; x < holders_.size(); ++x) {
    VehicleIndex& holder = holders_[x];
    if (holder == no_vehicle) continue;
    COSIVA_EXPECT(holder < vehicles_.size());
    const auto& needs = vehicles_[holder].needs;
    if (std::ranges::find(needs, x) == needs.end()) holder = no_vehicle;
  }
  for (VehicleIndex v = 0; v < vehicles_.size(); ++v)
    for (const CrossingIndex x : vehicles_[v].needs)
      if (holders_[x] == no_vehicle) hold(x, v);
}

double Traffic::reach_m(VehicleIndex vehicle, double wanted_m) const {
  return ahead_within(vehicle, wanted_m + stopped_m()).distance_m - stopped_m();
}

bool Traffic::holds_all(VehicleIndex vehicle, double distance_m) {
  const auto& position = vehicles_[vehicle].position;
  if (!position) return false;
  scratch_.clear();
  map_->crossings_on(*position, distance_m, scratch_, remaining(vehicle));
  return std::ranges::all_of(scratch_, [&](CrossingIndex x) { return holders_[x] == vehicle; });
}

bool Traffic::goes_before(const Request& a, const Request& b) const {
  const auto claim = [&](const Request& request) {
    return aiv::Claim{vehicles_[request.vehicle].priority, now_ - request.since};
  };
  // The queue is in the order of the requests.
  if (&a < &b) return aiv::keeps_its_turn(claim(a), claim(b), rules_.overtaken_at_most);
  return &a != &b && !aiv::keeps_its_turn(claim(b), claim(a), rules_.overtaken_at_most);
}

double Traffic::run_s(double stop_m, double length_m) const {
  const zone::SpeedProfile& pace = map_->zone().profiles.medium;
  const double speeding_up_s = stop_m < stopped_before_m ? 0.5 * pace.speed_mps / pace.acceleration_mps2 : 0.0;
  return length_m / pace.speed_mps + speeding_up_s;
}

std::optional<double> Traffic::loses_s(const Request& other, const Request& mine) const {
  const double pace_mps = map_->zone().profiles.medium.speed_mps;
  double begins_s = 0.0;
  for (const CrossingIndex x : other.crossings) {
    const VehicleIndex holder = holders_[x];
    if (holder == no_vehicle || holder == other.vehicle || holder == mine.vehicle) continue;
    const auto& at = vehicles_[holder].position;
    if (!at) return 0.0;  // when that vehicle will have left is not known
    const double base_m = base_left_m(holder, *at).value_or(0.0);
    begins_s = std::max(begins_s, map_->distance_to_exit_m(*at, x, base_m, remaining(holder)) / pace_mps);
  }
  if (begins_s == 0.0) return std::nullopt;
  double out_m = 0.0;
  for (const CrossingIndex x : mine.crossings)
    if (std::ranges::find(other.crossings, x) != other.crossings.end())
      out_m = std::max(
          out_m, map_->distance_to_exit_m(*vehicles_[mine.vehicle].position, x, mine.exit_m, remaining(mine.vehicle)));
  return std::max(0.0, latency_s + run_s(mine.stop_m, out_m) - begins_s);
}

bool Traffic::lets_by(const Request& other, const Request& mine) const {
  if (!rules_.convoys || has_waited(other) || vehicles_[other.vehicle].priority > vehicles_[mine.vehicle].priority)
    return false;
  const auto loses_s = this->loses_s(other, mine);
  return loses_s && other.lost_s + *loses_s <= rules_.lost_s_max;
}

bool Traffic::only_follows(VehicleIndex other, VehicleIndex self, const std::vector<CrossingIndex>& crossings) {
  const auto& from = vehicles_[other].position;
  if (!from) return false;
  const auto distance_m = map_->ahead(*from, *vehicles_[self].position, behind_m_max, remaining(other));
  if (!distance_m || *distance_m == 0.0) return false;
  // On a loop every vehicle follows every other; following counts only where none of the crossings lies between.
  between_.clear();
  map_->crossings_on(*from, *distance_m, between_, remaining(other));
  return !intersect(between_, crossings);
}

Traffic::Response Traffic::request(VehicleIndex vehicle, double exit_m, double stop_m) {
  const Vehicle& self = vehicles_[vehicle];
  if (!self.position) return {};
  auto mine = std::ranges::find(queue_, vehicle, &Request::vehicle);
  if (mine == queue_.end()) {
    queue_.push_back({vehicle, {}, now_, false});
    mine = queue_.end() - 1;
  }
  mine->stop_m = stop_m;
  mine->exit_m = exit_m;
  mine->crossings.clear();
  map_->crossings_on(*self.position, exit_m, mine->crossings, remaining(vehicle));
  const double room_m = exit_m + map_->zone().vehicle.length_m + rules_.room_m;
  const Leader ahead = ahead_within(vehicle, room_m);
  mine->has_room = ahead.distance_m >= room_m;

  const CrossingIndex first = mine->crossings.empty() ? 0 : mine->crossings.front();
  if (rules_.negotiated) {
    if (!mine->has_room) return {false, first, ahead.vehicle, WaitReason::ahead};
    queue_.erase(mine);
    return {true, first, no_vehicle, WaitReason::crossing};
  }
  for (const CrossingIndex x : mine->crossings) {
    const VehicleIndex holder = holders_[x];
    if (holder != no_vehicle && holder != vehicle && !only_follows(holder, vehicle, mine->crossings))
      return {false, x, holder, WaitReason::crossing};
  }
  // A vehicle may be stopped in a crossing that a third vehicle holds; it holds nothing, but occupies the crossing.
  for (VehicleIndex j = 0; j < vehicles_.size(); ++j) {
    if (j == vehicle || !intersect(vehicles_[j].needs, mine->crossings)) continue;
    const bool is_stopped_beside =
        is_in_others_crossing(*this, j) && std::ranges::all_of(vehicles_[j].needs, [&](CrossingIndex x) {
          return holders_[x] == vehicle || std::ranges::find(mine->crossings, x) == mine->crossings.end();
        });
    if (!is_stopped_beside && !only_follows(j, vehicle, mine->crossings))
      return {false, first, j, WaitReason::crossing};
  }
  if (!mine->has_room) return {false, first, ahead.vehicle, WaitReason::ahead};
  for (const Request& other : queue_) {
    // A vehicle without room beyond the crossing could not use its turn: it retains its turn, but lets others pass. A
    // vehicle that waits for a crossing that this vehicle is in cannot go before this one has left.
    const bool waits_for_this =
        std::ranges::any_of(other.crossings, [&](CrossingIndex x) { return holders_[x] == vehicle; });
    if (other.vehicle != vehicle && other.has_room && !waits_for_this && goes_before(other, *mine) &&
        intersect(other.crossings, mine->crossings) && !only_follows(other.vehicle, vehicle, mine->crossings) &&
        !lets_by(other, *mine))
      return {false, first, other.vehicle, WaitReason::turn};
  }
  for (Request& other : queue_)
    if (rules_.convoys && &other != &*mine && goes_before(other, *mine) && intersect(other.crossings, mine->crossings))
      other.lost_s += loses_s(other, *mine).value_or(0.0);
  for (const CrossingIndex x : mine->crossings) hold(x, vehicle);
  convoys_.record_pass(mine->vehicle, mine->crossings);
  queue_.erase(mine);
  holds_dirty_ = true;  // a grant that no base follows is revoked by the next update
  return {true, first, no_vehicle, WaitReason::crossing};
}

bool Traffic::may_join(VehicleIndex vehicle, double exit_m, double stop_m) {
  return convoys_.may_join(*this, vehicle, exit_m, stop_m);
}

Traffic::Convoy Traffic::join(VehicleIndex vehicle) {
  const Convoys::Pass& pass = convoys_.join(vehicles_[vehicle].ahead.vehicle, vehicle);
  for (Request& other : queue_)
    for (const auto& [loser, loses_s] : convoys_.losing())
      if (other.vehicle == loser) other.lost_s += loses_s;
  withdraw(vehicle);
  return {pass.row, pass.crossings};
}

void Traffic::withdraw(VehicleIndex vehicle) {
  std::erase_if(queue_, [vehicle](const Request& r) { return r.vehicle == vehicle; });
}

std::vector<VehicleIndex> Traffic::waiting(CrossingIndex crossing) const {
  std::vector<const Request*> requesting;
  for (const Request& request : queue_)
    if (std::ranges::find(request.crossings, crossing) != request.crossings.end()) requesting.push_back(&request);
  std::ranges::sort(requesting, [this](const Request* a, const Request* b) { return goes_before(*a, *b); });
  std::vector<VehicleIndex> vehicles;
  vehicles.reserve(requesting.size());
  for (const Request* request : requesting) vehicles.push_back(request->vehicle);
  return vehicles;
}

void Traffic::fold(Digest& digest) const {
  for (const VehicleIndex holder : holders_) digest.add(std::uint64_t{holder});
  for (const Request& request : queue_) {
    digest.add(std::uint64_t{request.vehicle});
    digest.add(request.since);
  }
  convoys_.fold(digest);
}

void Traffic::archive(Archive& archive) {
  archive(vehicles_, by_section_, holders_, holds_, queue_, convoys_, now_, positions_dirty_, holds_dirty_);
  if (archive.reads()) base_left_.assign(vehicles_.size(), std::nullopt);
}

bool is_in_others_crossing(const Traffic& traffic, VehicleIndex vehicle) {
  const auto& position = traffic.track_position(vehicle);
  if (!position || traffic.base_left_m(vehicle, *position).value_or(0.0) > 0.0) return false;
  return std::ranges::any_of(traffic.needs(vehicle), [&](CrossingIndex x) { return traffic.holder(x) != vehicle; });
}

bool requests(const Traffic& traffic, VehicleIndex vehicle, CrossingIndex crossing) {
  const auto request = std::ranges::find(traffic.requests(), vehicle, &Traffic::Request::vehicle);
  return request != traffic.requests().end() &&
         std::ranges::find(request->crossings, crossing) != request->crossings.end();
}

BeyondBase beyond_base(const Traffic& traffic, VehicleIndex vehicle, zone::TrackPosition position) {
  BeyondBase beyond{sections_of_base(traffic, vehicle, position), {}};
  list_beyond_base(traffic, vehicle, position, beyond.sections);
  return beyond;
}

std::size_t sections_of_base(const Traffic& traffic, VehicleIndex vehicle, zone::TrackPosition position) {
  const WaypointGraph& map = traffic.map();
  const zone::TrackPosition end = map.waypoint(traffic.base_end(vehicle)).position;
  if (traffic.base_passed(vehicle) && map.circuit().shortest_route(end, position, past_m)) return 0;
  if (end.section == position.section && end.s_m >= position.s_m) return 0;
  const Sections remaining = traffic.remaining(vehicle);
  if (!map.ahead(position, end, traffic.base_m_max(vehicle), remaining)) return 0;
  const auto found = std::ranges::find(remaining, end.section);
  return found == remaining.end() ? 0 : static_cast<std::size_t>(found - remaining.begin()) + 1;
}

void list_beyond_base(const Traffic& traffic, VehicleIndex vehicle, zone::TrackPosition position,
                      std::vector<zone::SectionId>& sections) {
  const Sections remaining = traffic.remaining(vehicle);
  const std::size_t keep = sections_of_base(traffic, vehicle, position);
  const zone::TrackPosition end = traffic.map().waypoint(traffic.base_end(vehicle)).position;
  const bool ends_here = end.section == position.section && end.s_m >= position.s_m;
  sections.clear();
  if (keep == 0 && (traffic.base_passed(vehicle) || !ends_here)) {
    const auto past = traffic.map().circuit().shortest_route(end, position, past_m);
    if (past) sections.assign(past->sections.begin() + 1, past->sections.end());
    if (!past && !ends_here) return;
  }
  sections.insert(sections.end(), remaining.begin() + static_cast<std::ptrdiff_t>(keep), remaining.end());
}

}  // namespace cosiva::virtual_side
