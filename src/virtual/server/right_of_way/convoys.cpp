// Traffic's convoys: who passes a crossing together with the vehicle ahead of it, although the turn is somebody else's.
#include <algorithm>

#include "cosiva/base/expect.h"
#include "cosiva/virtual/server/right_of_way/traffic.h"

namespace cosiva::virtual_side {
namespace {

/// One behind the other with less between them than this is of the same convoy.
constexpr double convoy_gap_m = 0.70;
/// These guesses are no finer; where it makes no difference, turns count.
constexpr double gain_s_min = 0.1;

bool shares(const std::vector<CrossingIndex>& a, const std::vector<CrossingIndex>& b) {
  return std::ranges::any_of(a, [&](CrossingIndex x) { return std::ranges::find(b, x) != b.end(); });
}

bool contains(const std::vector<VehicleIndex>& convoy, VehicleIndex vehicle) {
  return std::ranges::find(convoy, vehicle) != convoy.end();
}

}  // namespace

void Traffic::note_pass(const Request& granted) {
  std::erase_if(passes_, [&](const Pass& pass) { return shares(pass.crossings, granted.crossings); });
  passes_.push_back({granted.vehicle, granted.crossings, 1});
}

bool Traffic::may_join(VehicleIndex vehicle, double exit_m, double stop_m) {
  const Vehicle& self = vehicles_[vehicle];
  if (!rules_.convoys || !self.place || stop_m > rules_.request_within_m) return false;
  const Ahead ahead = self.ahead;
  const double room_m = map_->zone().vehicle.length_m + rules_.room_m;
  if (ahead.vehicle == no_vehicle || ahead.distance_m < stop_m || ahead.distance_m > exit_m + room_m) return false;
  const auto pass = std::ranges::find(passes_, ahead.vehicle, &Pass::last);
  if (pass == passes_.end() || pass->row >= rules_.convoy_max) return false;
  scratch_.clear();
  map_->crossings_on(*self.place, exit_m, scratch_, coming(vehicle));
  if (scratch_.empty() || scratch_ != pass->crossings) return false;
  const auto convoy = convoy_ahead(vehicle, pass->row);
  const Joining joining{vehicle, std::max(0.0, stop_m), exit_m, ahead.distance_m};
  return is_kept_by(convoy, vehicle) && has_room_beyond(joining, convoy) &&
         convoy_pays(joining, rules_.convoy_max - pass->row);
}

Traffic::Convoy Traffic::join(VehicleIndex vehicle) {
  const auto pass = std::ranges::find(passes_, vehicles_[vehicle].ahead.vehicle, &Pass::last);
  COSIVA_EXPECT(pass != passes_.end());
  pass->last = vehicle;
  ++pass->row;
  ++convoys_;
  for (Request& other : queue_)
    for (const auto& [loser, loses_s] : losing_)
      if (other.vehicle == loser) other.lost_s += loses_s;
  withdraw(vehicle);
  return {pass->row, pass->crossings};
}

std::vector<VehicleIndex> Traffic::convoy_ahead(VehicleIndex vehicle, std::size_t row) const {
  std::vector<VehicleIndex> convoy;
  for (VehicleIndex last = vehicle; convoy.size() < row; last = convoy.back()) {
    const VehicleIndex next = vehicles_[last].ahead.vehicle;
    if (next == no_vehicle || next == vehicle || contains(convoy, next)) break;
    convoy.push_back(next);
  }
  return convoy;
}

bool Traffic::is_kept_by(const std::vector<VehicleIndex>& convoy, VehicleIndex joining) {
  // The one ahead may have left the first crossing already: then somebody else may be in it.
  for (const CrossingIndex x : scratch_)
    if (holders_[x] != no_vehicle && holders_[x] != joining && !contains(convoy, holders_[x])) return false;
  for (VehicleIndex j = 0; j < vehicles_.size(); ++j)
    if (j != joining && !contains(convoy, j) && shares(vehicles_[j].needs, scratch_)) return false;
  return true;
}

bool Traffic::has_room_beyond(const Joining& joining, const std::vector<VehicleIndex>& convoy) const {
  // From the front on: for good each stands at the end of its own base, or where its eyes keep it behind the one ahead.
  const double apart_m = map_->zone().vehicle.length_m + rules_.room_m;
  double at_m = joining.ahead_m;
  for (std::size_t i = 0; i + 1 < convoy.size(); ++i) at_m += vehicles_[convoy[i]].ahead.distance_m;
  double stands_m = at_m + vehicles_[convoy.back()].ahead.distance_m;
  for (auto member = convoy.rbegin(); member != convoy.rend(); ++member) {
    const double base_m = base_left_m(*member, *vehicles_[*member].place).value_or(0.0);
    stands_m = std::min(at_m + base_m, stands_m - apart_m);
    if (member + 1 != convoy.rend()) at_m -= vehicles_[*(member + 1)].ahead.distance_m;
  }
  return stands_m - apart_m >= joining.exit_m;
}

bool Traffic::convoy_pays(const Joining& joining, std::size_t at_most) {
  const zone::SpeedProfile& pace = map_->zone().profiles.medium;
  const double clear_s = latency_s + std::max(0.0, joining.exit_m - joining.ahead_m) / pace.speed_mps;
  const double chain_s = run_s(joining.stop_m, joining.exit_m - joining.stop_m);
  const double ends_s = latency_s + joining.stop_m / pace.speed_mps + chain_s;
  const double room_s = (map_->zone().vehicle.length_m + rules_.room_m) / pace.speed_mps;
  double turn_s = std::max(joining.stop_m / pace.speed_mps, clear_s + room_s);
  double lost_s = 0.0;
  losing_.clear();
  for (const Request& other : queue_) {
    if (other.vehicle == joining.vehicle || !other.has_room || !shares(other.crossings, scratch_)) continue;
    if (has_waited(other) || vehicles_[other.vehicle].priority > vehicles_[joining.vehicle].priority) return false;
    const double begins_s = std::max(other.stop_m / pace.speed_mps, clear_s);
    const double loses_s = std::max(0.0, ends_s + latency_s - begins_s);
    if (other.lost_s + loses_s > rules_.lost_s_max) return false;
    losing_.emplace_back(other.vehicle, loses_s);
    lost_s += loses_s;
    turn_s = std::max(turn_s, begins_s + run_s(other.stop_m, other.exit_m - other.stop_m) + latency_s);
  }
  const double saved_s = turn_s + chain_s - ends_s;
  return lost_s + gain_s_min < saved_s * static_cast<double>(members_from(joining.vehicle, at_most));
}

std::size_t Traffic::members_from(VehicleIndex vehicle, std::size_t at_most) const {
  std::size_t members = 1;
  for (VehicleIndex last = vehicle; members < at_most; ++members) {
    const auto behind = std::ranges::find_if(vehicles_, [&](const Vehicle& other) {
      return other.place && other.ahead.vehicle == last && other.ahead.distance_m < convoy_gap_m;
    });
    if (behind == vehicles_.end()) break;
    last = static_cast<VehicleIndex>(behind - vehicles_.begin());
  }
  return members;
}

}  // namespace cosiva::virtual_side
