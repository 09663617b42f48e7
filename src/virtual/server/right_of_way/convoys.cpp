#include "cosiva/virtual/server/right_of_way/convoys.h"

#include <algorithm>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/virtual/server/right_of_way/traffic.h"

namespace cosiva::virtual_side {
namespace {

/// A vehicle that follows another with a smaller gap than this belongs to the same convoy.
constexpr double convoy_gap_m = 0.70;
/// The estimates are no more precise than this; below this gain the order of requests decides.
constexpr double gain_s_min = 0.1;

bool contains(const std::vector<VehicleIndex>& convoy, VehicleIndex vehicle) {
  return std::ranges::find(convoy, vehicle) != convoy.end();
}

std::vector<VehicleIndex> leaders_of(const Traffic& traffic, VehicleIndex vehicle, std::size_t row) {
  std::vector<VehicleIndex> convoy;
  for (VehicleIndex last = vehicle; convoy.size() < row; last = convoy.back()) {
    const VehicleIndex next = traffic.ahead(last).vehicle;
    if (next == no_vehicle || next == vehicle || contains(convoy, next)) break;
    convoy.push_back(next);
  }
  return convoy;
}

bool has_room_beyond(const Traffic& traffic, double leader_m, double exit_m, const std::vector<VehicleIndex>& convoy) {
  // From the front vehicle on: each vehicle finally stops at the end of its own base, or where its obstacle sensor
  // keeps it behind its leader.
  const double apart_m = traffic.map().zone().vehicle.length_m + traffic.rules().room_m;
  double at_m = leader_m;
  for (std::size_t i = 0; i + 1 < convoy.size(); ++i) at_m += traffic.ahead(convoy[i]).distance_m;
  double last_m = at_m + traffic.ahead(convoy.back()).distance_m;
  for (auto member = convoy.rbegin(); member != convoy.rend(); ++member) {
    const double base_m = traffic.base_left_m(*member, *traffic.track_position(*member)).value_or(0.0);
    last_m = std::min(at_m + base_m, last_m - apart_m);
    if (member + 1 != convoy.rend()) at_m -= traffic.ahead(*(member + 1)).distance_m;
  }
  return last_m - apart_m >= exit_m;
}

std::size_t members_from(const Traffic& traffic, VehicleIndex vehicle, std::size_t at_most) {
  std::size_t members = 1;
  for (VehicleIndex last = vehicle; members < at_most; ++members) {
    VehicleIndex behind = 0;
    const auto follows = [&](VehicleIndex other) {
      return traffic.track_position(other) && traffic.ahead(other).vehicle == last &&
             traffic.ahead(other).distance_m < convoy_gap_m;
    };
    while (behind < traffic.vehicle_count() && !follows(behind)) ++behind;
    if (behind == traffic.vehicle_count()) break;
    last = behind;
  }
  return members;
}

}  // namespace

bool intersect(const std::vector<std::uint32_t>& a, const std::vector<std::uint32_t>& b) {
  return std::ranges::any_of(a, [&](std::uint32_t x) { return std::ranges::find(b, x) != b.end(); });
}

void Convoys::record_pass(VehicleIndex vehicle, const std::vector<CrossingIndex>& crossings) {
  std::erase_if(passes_, [&](const Pass& pass) { return intersect(pass.crossings, crossings); });
  passes_.push_back({vehicle, crossings, 1});
}

const Convoys::Pass& Convoys::join(VehicleIndex leader, VehicleIndex vehicle) {
  const auto pass = std::ranges::find(passes_, leader, &Pass::last);
  COSIVA_EXPECT(pass != passes_.end());
  pass->last = vehicle;
  ++pass->row;
  ++count_;
  return *pass;
}

void Convoys::fold(Digest& digest) const {
  for (const Pass& pass : passes_) {
    digest.add(std::uint64_t{pass.last});
    digest.add(std::uint64_t{pass.row});
  }
}

bool Convoys::may_join(const Traffic& traffic, VehicleIndex vehicle, double exit_m, double stop_m) {
  const TrafficRules& rules = traffic.rules();
  const auto& position = traffic.track_position(vehicle);
  if (!rules.convoys || !position || stop_m > rules.request_within_m) return false;
  const auto leader = traffic.ahead(vehicle);
  const double room_m = traffic.map().zone().vehicle.length_m + rules.room_m;
  if (leader.vehicle == no_vehicle || leader.distance_m < stop_m || leader.distance_m > exit_m + room_m) return false;
  const auto pass = std::ranges::find(passes_, leader.vehicle, &Pass::last);
  if (pass == passes_.end() || pass->row >= rules.convoy_max) return false;
  chain_.clear();
  traffic.map().crossings_on(*position, exit_m, chain_, traffic.remaining(vehicle));
  if (chain_.empty() || chain_ != pass->crossings) return false;
  const auto convoy = leaders_of(traffic, vehicle, pass->row);
  const Joining joining{vehicle, std::max(0.0, stop_m), exit_m, leader.distance_m};
  return is_kept_by(traffic, convoy, vehicle) && has_room_beyond(traffic, joining.leader_m, exit_m, convoy) &&
         convoy_pays(traffic, joining, rules.convoy_max - pass->row);
}

bool Convoys::is_kept_by(const Traffic& traffic, const std::vector<VehicleIndex>& convoy, VehicleIndex joining) const {
  // The leader may have left the first crossing already: then another vehicle may be in that crossing.
  for (const CrossingIndex x : chain_)
    if (traffic.holder(x) != no_vehicle && traffic.holder(x) != joining && !contains(convoy, traffic.holder(x)))
      return false;
  for (VehicleIndex j = 0; j < traffic.vehicle_count(); ++j)
    if (j != joining && !contains(convoy, j) && intersect(traffic.needs(j), chain_)) return false;
  return true;
}

bool Convoys::convoy_pays(const Traffic& traffic, const Joining& joining, std::size_t at_most) {
  const TrafficRules& rules = traffic.rules();
  const zone::SpeedProfile& pace = traffic.map().zone().profiles.medium;
  const double clear_s = Traffic::latency_s + std::max(0.0, joining.exit_m - joining.leader_m) / pace.speed_mps;
  const double chain_s = traffic.run_s(joining.stop_m, joining.exit_m - joining.stop_m);
  const double ends_s = Traffic::latency_s + joining.stop_m / pace.speed_mps + chain_s;
  const double room_s = (traffic.map().zone().vehicle.length_m + rules.room_m) / pace.speed_mps;
  double turn_s = std::max(joining.stop_m / pace.speed_mps, clear_s + room_s);
  double lost_s = 0.0;
  losing_.clear();
  for (const Traffic::Request& other : traffic.requests()) {
    if (other.vehicle == joining.vehicle || !other.has_room || !intersect(other.crossings, chain_)) continue;
    if (traffic.has_waited(other) || traffic.priority(other.vehicle) > traffic.priority(joining.vehicle)) return false;
    const double begins_s = std::max(other.stop_m / pace.speed_mps, clear_s);
    const double loses_s = std::max(0.0, ends_s + Traffic::latency_s - begins_s);
    if (other.lost_s + loses_s > rules.lost_s_max) return false;
    losing_.emplace_back(other.vehicle, loses_s);
    lost_s += loses_s;
    turn_s = std::max(turn_s, begins_s + traffic.run_s(other.stop_m, other.exit_m - other.stop_m) + Traffic::latency_s);
  }
  const double saved_s = turn_s + chain_s - ends_s;
  return lost_s + gain_s_min < saved_s * static_cast<double>(members_from(traffic, joining.vehicle, at_most));
}

void Convoys::archive(Archive& archive) { archive(passes_, losing_, count_); }

}  // namespace cosiva::virtual_side
