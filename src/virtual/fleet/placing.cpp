// How a fleet begins: who stands where, and which copies go together.
#include <algorithm>
#include <string>

#include "cosiva/aiv/motion/formulas.h"
#include "cosiva/virtual/fleet/inside.h"
#include "cosiva/virtual/fleet/spacing.h"

namespace cosiva::virtual_side {
namespace {

/// Vehicles of whole copies that are stepped together: few enough that what a step needs of them stays in the
/// processor's second cache from one pass to the next.
constexpr std::uint32_t block_vehicles = 512;

/// Between two vehicles that are put down one behind the other.
constexpr double start_gap_m = aiv::stand_off_m + 0.01;

}  // namespace

void State::resize(std::size_t vehicles, bool limits, bool turns) {
  for (auto* numbers : {&s_m, &v_mps, &x_m, &y_m, &heading_rad}) numbers->assign(vehicles, 0.0);
  for (auto* places : {&offset_m, &halt_at, &line_at, &goal_at, &event_at, &cap_mps}) places->assign(vehicles, far_m);
  slow_at.assign(limits ? vehicles : 0, far_m);
  slow_mps.assign(limits ? vehicles : 0, 0.0);
  turn_left_rad.assign(turns ? vehicles : 0, 0.0);
  turn_radps.assign(turns ? vehicles : 0, 0.0);
  for (auto* counts : {&leader, &section, &waited_steps}) counts->assign(vehicles, 0);
  own.assign(vehicles, {});
  queue.assign(vehicles, {});
  profile.assign(vehicles, -1);
  imposed.assign(vehicles, no_profile);
  mode.assign(vehicles, 0);
  event.assign(vehicles, 0);
}

Result<void> Fleet::Inside::place(std::span<const FleetStart> starts) {
  state.resize(starts.size(), numbers.has_limits, numbers.has_turns);
  arrived.assign(starts.size(), 0);
  for (std::uint32_t i = 0; i < starts.size(); ++i) {
    const auto& [copy, place, priority] = starts[i];
    const auto refuse = [&](const char* why) {
      return fail("fleet.start", "vehicle " + std::to_string(i) + " cannot begin there: " + why, "starts");
    };
    const bool is_away = place.section == zone::no_section;
    if (i > 0 && copy < starts[i - 1].copy) return refuse("its copy comes before that of the vehicle before it");
    while (copies.size() <= copy) copies.push_back({i});
    state.own[i].copy = copy;
    state.own[i].priority = static_cast<std::int16_t>(std::clamp(priority, 0, zone::priority_max));
    if (is_away) {
      make_absent(i);
      ++told_vehicles;
      continue;
    }
    if (place.section >= ground.size() || !(place.s_m >= 0.0 && place.s_m <= ground.length_m(place.section)))
      return refuse("that is no place of the zone");
    if (!ground.may_stand(place)) return refuse("it would stand in a crossing, or between two close to each other");
    state.section[i] = place.section;
    state.own[i].began_on = place.section;
    state.s_m[i] = place.s_m;
    state.own[i].gone_m = -place.s_m;
  }
  copies.push_back({static_cast<std::uint32_t>(starts.size())});
  const std::size_t count = copies.size() - 1;
  front.assign(count * ground.size(), Fleet::none);
  rear.assign(count * ground.size(), Fleet::none);
  crossings.assign(count * ground.zone().crossings.size(), {});
  lay_blocks();
  return line_up();
}

void Fleet::Inside::lay_blocks() {
  const auto count = static_cast<std::uint32_t>(copies.size() - 1);
  for (std::uint32_t copy = 0; copy < count;) {
    Block block;
    block.first_copy = copy;
    block.first = copies[copy].first;
    do {
      ++copy;
    } while (copy < count && copies[copy].first - block.first < block_vehicles);
    block.last_copy = copy;
    block.last = copies[copy].first;
    block.occupied_steps.assign(ground.size(), 0);
    block.grants.assign(ground.zone().crossings.size(), 0);
    block.waited_steps.assign(ground.zone().crossings.size(), 0);
    block.seen_m.assign(ground.size(), 0.0);
    block.seen_search.assign(ground.size(), 0);
    // Each section is opened again only by a shorter way; on a real zone hardly ever.
    block.open.reserve(4 * ground.size());
    if (block.last - block.first > forgets_vehicles) state.next_mps.resize(state.s_m.size());
    blocks.push_back(std::move(block));
  }
}

Result<void> Fleet::Inside::line_up() {
  const auto count = static_cast<std::uint32_t>(state.s_m.size());
  std::vector<std::uint32_t> order(count);
  for (std::uint32_t i = 0; i < count; ++i) order[i] = i;
  std::ranges::sort(order, [&](std::uint32_t a, std::uint32_t b) {
    if (state.own[a].copy != state.own[b].copy) return state.own[a].copy < state.own[b].copy;
    if (state.section[a] != state.section[b]) return state.section[a] < state.section[b];
    return state.s_m[a] != state.s_m[b] ? state.s_m[a] > state.s_m[b] : a < b;
  });
  std::erase_if(order, [&](std::uint32_t i) { return (state.mode[i] & Mode::absent) != 0; });
  for (const std::uint32_t i : order) {
    const std::size_t here = at(state.own[i].copy, state.section[i]);
    const std::uint32_t last = rear[here];
    rear[here] = i;
    if (last == Fleet::none) {
      front[here] = i;
    } else {
      state.own[last].behind = i;
      state.leader[i] = last;
      state.offset_m[i] = 0.0;
    }
  }
  std::ranges::sort(order);
  for (const std::uint32_t i : order) {
    if (front[at(state.own[i].copy, state.section[i])] == i) look_ahead(i);
    survey(i);
    const double gap_m = state.offset_m[i] + state.s_m[state.leader[i]] - state.s_m[i] - numbers.length_m;
    if (gap_m < aiv::stand_off_m)
      return fail(
          "fleet.start",
          "vehicle " + std::to_string(i) + " begins too close behind vehicle " + std::to_string(state.leader[i]),
          "starts");
  }
  return {};
}

namespace {

/// Places that are taken one after the other, none nearer to another than a vehicle and its stand-off.
class Spread {
 public:
  Spread(const zone::TrafficZone& zone, const Ground& ground)
      : zone_{zone}, ground_{ground}, apart_m_{occupied_m(zone) + start_gap_m}, taken_(ground.size()) {}

  /// As many as there is room for, at most `count`, a new one after each `every_m` of way.
  [[nodiscard]] std::vector<zone::Place> take(std::size_t count, double every_m) {
    for (auto& places : taken_) places.clear();
    std::vector<zone::Place> found;
    const double pitch_m = std::min(0.25 * apart_m_, every_m);
    double since_m = every_m;
    for (zone::SectionId id = 0; id < ground_.size() && found.size() < count; ++id) {
      for (double s_m = 0.0; s_m < ground_.length_m(id) && found.size() < count; s_m += pitch_m, since_m += pitch_m) {
        if (since_m < every_m || !ground_.may_stand({id, s_m}) || !is_free(id, s_m)) continue;
        found.push_back({id, s_m});
        taken_[id].push_back(s_m);
        since_m = 0.0;
      }
    }
    return found;
  }

 private:
  [[nodiscard]] bool is_free(zone::SectionId id, double s_m) const {
    for (const double other : taken_[id])
      if (other > s_m - apart_m_ && other < s_m + apart_m_) return false;
    return is_free_ahead(id, ground_.length_m(id) - s_m, 0) && is_free_behind(id, s_m, 0);
  }
  [[nodiscard]] bool is_free_ahead(zone::SectionId id, double way_m, int depth) const {
    if (way_m >= apart_m_ || depth > 16) return true;
    return std::ranges::all_of(zone_.circuit.next(id), [&](zone::SectionId to) {
      return std::ranges::none_of(taken_[to], [&](double s_m) { return way_m + s_m < apart_m_; }) &&
             is_free_ahead(to, way_m + ground_.length_m(to), depth + 1);
    });
  }
  [[nodiscard]] bool is_free_behind(zone::SectionId id, double way_m, int depth) const {
    if (way_m >= apart_m_ || depth > 16) return true;
    return std::ranges::all_of(zone_.circuit.previous(id), [&](zone::SectionId from) {
      const double length_m = ground_.length_m(from);
      return std::ranges::none_of(taken_[from], [&](double s_m) { return way_m + length_m - s_m < apart_m_; }) &&
             is_free_behind(from, way_m + length_m, depth + 1);
    });
  }

  const zone::TrafficZone& zone_;
  const Ground& ground_;
  double apart_m_;
  std::vector<std::vector<double>> taken_;
};

}  // namespace

std::vector<FleetStart> Fleet::spread(const zone::TrafficZone& zone, std::size_t count, std::uint32_t copy) {
  auto ground = Ground::make(std::shared_ptr<const zone::TrafficZone>(std::shared_ptr<void>{}, &zone));
  if (!ground || count == 0) return {};
  Spread spread{zone, *ground};
  double every_m = zone.circuit.total_length_m() / static_cast<double>(count);
  std::vector<zone::Place> places;
  std::vector<zone::Place> best;
  // What lies in crossings is lost, so somewhat closer each time, until they fit or stand as close as may be.
  constexpr int tries = 60;
  for (int attempt = 0; attempt < tries; ++attempt) {
    places = spread.take(count, every_m);
    if (places.size() > best.size()) best = std::move(places);
    if (best.size() == count || every_m < 0.5 * zone.vehicle.length_m) break;
    every_m *= 0.93;
  }
  std::vector<FleetStart> starts;
  starts.reserve(best.size());
  for (const zone::Place& place : best) starts.push_back({copy, place, 0});
  return starts;
}

}  // namespace cosiva::virtual_side
