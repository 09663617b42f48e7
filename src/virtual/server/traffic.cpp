#include "virtual/server/traffic.h"

#include <algorithm>
#include <utility>

namespace cosiva::virtual_side {
namespace {

/// No base is longer than this; a base that seems to be has been driven to its end.
constexpr double base_m_max = 8.0;

bool shares(const std::vector<CrossingIndex>& a, const std::vector<CrossingIndex>& b) {
  return std::ranges::any_of(a, [&](CrossingIndex x) { return std::ranges::find(b, x) != b.end(); });
}

}  // namespace

void Traffic::set_map(const WayMap* map) {
  map_ = map;
  holders_.assign(map == nullptr ? 0 : map->crossing_count(), no_vehicle);
  queue_.clear();
  for (Vehicle& vehicle : vehicles_) {
    Vehicle fresh;
    fresh.priority = vehicle.priority;
    vehicle = std::move(fresh);
  }
  dirty_ = true;
}

void Traffic::resize(std::size_t vehicles) {
  vehicles_.resize(vehicles);
  dirty_ = true;
}

void Traffic::set_place(VehicleIndex vehicle, std::optional<zone::Place> place) {
  if (vehicles_[vehicle].place == place) return;
  vehicles_[vehicle].place = place;
  dirty_ = true;
}

void Traffic::set_base_end(VehicleIndex vehicle, WaypointIndex end) {
  if (vehicles_[vehicle].base_end == end) return;
  vehicles_[vehicle].base_end = end;
  dirty_ = true;
}

void Traffic::forget(VehicleIndex vehicle) {
  set_place(vehicle, std::nullopt);
  set_base_end(vehicle, no_waypoint);
  withdraw(vehicle);
}

double Traffic::standing_m() const { return map_->zone().vehicle.length_m + rules_.gap_m; }

void Traffic::update() {
  if (map_ == nullptr || !dirty_) return;
  dirty_ = false;
  for (VehicleIndex i = 0; i < vehicles_.size(); ++i) find_ahead(i);
  settle_holds();
}

void Traffic::find_ahead(VehicleIndex index) {
  Vehicle& self = vehicles_[index];
  self.ahead = {};
  if (!self.place) return;
  double limit_m = rules_.look_ahead_m;
  for (VehicleIndex j = 0; j < vehicles_.size(); ++j) {
    if (j == index || !vehicles_[j].place) continue;
    const auto distance_m = map_->ahead(*self.place, *vehicles_[j].place, limit_m);
    // Two at the very same place: the lower number is taken to be the one in front, so that one of them can leave.
    if (!distance_m || (*distance_m == 0.0 && j > index)) continue;
    self.ahead = {j, *distance_m};
    limit_m = *distance_m;
  }
}

void Traffic::settle_holds() {
  for (Vehicle& vehicle : vehicles_) {
    vehicle.needs.clear();
    if (!vehicle.place) continue;
    double base_m = 0.0;
    if (vehicle.base_end != no_waypoint)
      base_m = map_->base_left(*vehicle.place, vehicle.base_end, base_m_max).value_or(0.0);
    map_->crossings_on(*vehicle.place, base_m, vehicle.needs);
  }
  for (CrossingIndex x = 0; x < holders_.size(); ++x) {
    VehicleIndex& holder = holders_[x];
    const auto needs = [&](VehicleIndex v) {
      return std::ranges::find(vehicles_[v].needs, x) != vehicles_[v].needs.end();
    };
    if (holder != no_vehicle && needs(holder)) continue;
    holder = no_vehicle;
    for (VehicleIndex v = 0; v < vehicles_.size() && holder == no_vehicle; ++v)
      if (needs(v)) holder = v;
  }
}

double Traffic::reach_m(VehicleIndex vehicle) const { return vehicles_[vehicle].ahead.distance_m - standing_m(); }

bool Traffic::holds_all(VehicleIndex vehicle, double distance_m) {
  const auto& place = vehicles_[vehicle].place;
  if (!place) return false;
  scratch_.clear();
  map_->crossings_on(*place, distance_m, scratch_);
  return std::ranges::all_of(scratch_, [&](CrossingIndex x) { return holders_[x] == vehicle; });
}

bool Traffic::goes_before(const Request& a, const Request& b) const {
  const bool a_waited = now_ - a.since >= rules_.overtaken_at_most;
  const bool b_waited = now_ - b.since >= rules_.overtaken_at_most;
  if (a_waited != b_waited) return a_waited;
  const std::int32_t a_priority = vehicles_[a.vehicle].priority;
  const std::int32_t b_priority = vehicles_[b.vehicle].priority;
  if (!a_waited && a_priority != b_priority) return a_priority > b_priority;
  return &a < &b;  // the queue is in the order of asking
}

bool Traffic::only_follows(VehicleIndex other, VehicleIndex self, const std::vector<CrossingIndex>& crossings) {
  const auto& from = vehicles_[other].place;
  if (!from) return false;
  const auto distance_m = map_->ahead(*from, *vehicles_[self].place, base_m_max);
  if (!distance_m || *distance_m == 0.0) return false;
  // On a ring everybody follows everybody; it counts only where none of the crossings comes first.
  between_.clear();
  map_->crossings_on(*from, *distance_m, between_);
  return !shares(between_, crossings);
}

Traffic::Answer Traffic::request(VehicleIndex vehicle, WaypointIndex stop, double distance_m) {
  const Vehicle& self = vehicles_[vehicle];
  if (!self.place) return {};
  auto mine = std::ranges::find(queue_, vehicle, &Request::vehicle);
  if (mine == queue_.end()) {
    queue_.push_back({vehicle, {}, now_, false});
    mine = queue_.end() - 1;
  }
  const double exit_m = distance_m + map_->stretch(stop).chain_m;
  mine->crossings.clear();
  map_->crossings_on(*self.place, exit_m, mine->crossings);
  mine->has_room = self.ahead.distance_m >= exit_m + map_->zone().vehicle.length_m + rules_.room_m;

  const CrossingIndex first = mine->crossings.empty() ? 0 : mine->crossings.front();
  for (const CrossingIndex x : mine->crossings) {
    const VehicleIndex holder = holders_[x];
    if (holder != no_vehicle && holder != vehicle && !only_follows(holder, vehicle, mine->crossings))
      return {false, x, holder};
  }
  // Somebody may stand in a crossing that a third one holds; it holds nothing, but it is there.
  for (VehicleIndex j = 0; j < vehicles_.size(); ++j) {
    if (j != vehicle && shares(vehicles_[j].needs, mine->crossings) && !only_follows(j, vehicle, mine->crossings))
      return {false, first, j};
  }
  if (!mine->has_room) return {false, first, self.ahead.vehicle};
  for (const Request& other : queue_) {
    // Who has no room beyond could not use its turn; it keeps it, but lets others by.
    if (other.vehicle != vehicle && other.has_room && goes_before(other, *mine) &&
        shares(other.crossings, mine->crossings) && !only_follows(other.vehicle, vehicle, mine->crossings))
      return {false, first, other.vehicle};
  }
  for (const CrossingIndex x : mine->crossings) holders_[x] = vehicle;
  queue_.erase(mine);
  dirty_ = true;  // a grant that no base follows is taken back by the next update
  return {true, first, no_vehicle};
}

void Traffic::withdraw(VehicleIndex vehicle) {
  std::erase_if(queue_, [vehicle](const Request& r) { return r.vehicle == vehicle; });
}

std::vector<VehicleIndex> Traffic::waiting(CrossingIndex crossing) const {
  std::vector<const Request*> asking;
  for (const Request& request : queue_)
    if (std::ranges::find(request.crossings, crossing) != request.crossings.end()) asking.push_back(&request);
  std::ranges::sort(asking, [this](const Request* a, const Request* b) { return goes_before(*a, *b); });
  std::vector<VehicleIndex> vehicles;
  vehicles.reserve(asking.size());
  for (const Request* request : asking) vehicles.push_back(request->vehicle);
  return vehicles;
}

void Traffic::fold(Digest& digest) const {
  for (const VehicleIndex holder : holders_) digest.add(std::uint64_t{holder});
  for (const Request& request : queue_) {
    digest.add(std::uint64_t{request.vehicle});
    digest.add(request.since);
  }
}

}  // namespace cosiva::virtual_side
