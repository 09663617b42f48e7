#include "virtual/server/traffic.h"

#include <algorithm>

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
  for (Vehicle& vehicle : vehicles_) vehicle = {};
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

Traffic::Answer Traffic::request(VehicleIndex vehicle, WaypointIndex stop, double distance_m) {
  const Vehicle& self = vehicles_[vehicle];
  if (!self.place) return {};
  auto mine = std::ranges::find(queue_, vehicle, &Request::vehicle);
  if (mine == queue_.end()) {
    queue_.push_back({vehicle, {}, false});
    mine = queue_.end() - 1;
  }
  const double exit_m = distance_m + map_->stretch(stop).chain_m;
  mine->crossings.clear();
  map_->crossings_on(*self.place, exit_m, mine->crossings);
  mine->has_room = self.ahead.distance_m >= exit_m + map_->zone().vehicle.length_m + rules_.room_m;

  const CrossingIndex first = mine->crossings.empty() ? 0 : mine->crossings.front();
  for (const CrossingIndex x : mine->crossings)
    if (holders_[x] != no_vehicle && holders_[x] != vehicle) return {false, x, holders_[x]};
  // Somebody may stand in a crossing that a third one holds; it holds nothing, but it is there.
  for (VehicleIndex j = 0; j < vehicles_.size(); ++j)
    if (j != vehicle && shares(vehicles_[j].needs, mine->crossings)) return {false, first, j};
  if (!mine->has_room) return {false, first, self.ahead.vehicle};
  for (auto older = queue_.begin(); older != mine; ++older) {
    // Who has no room beyond could not use its turn; it keeps it, but lets others by.
    if (older->has_room && shares(older->crossings, mine->crossings)) return {false, first, older->vehicle};
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
  std::vector<VehicleIndex> names;
  for (const Request& request : queue_)
    if (std::ranges::find(request.crossings, crossing) != request.crossings.end()) names.push_back(request.vehicle);
  return names;
}

void Traffic::fold(Digest& digest) const {
  for (const VehicleIndex holder : holders_) digest.add(std::uint64_t{holder});
  for (const Request& request : queue_) digest.add(std::uint64_t{request.vehicle});
}

}  // namespace cosiva::virtual_side
