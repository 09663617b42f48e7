// What vehicles can be told while they drive.
#include <algorithm>

#include "cosiva/virtual/fleet/inside.h"

namespace cosiva::virtual_side {

double Fleet::Inside::committed_m(std::uint32_t i) const {
  const double v = state.v_mps[i];
  double until_m = state.s_m[i];
  // By the weakest brakes, and the reactions generously: a step is decided upon what was seen before it.
  if (v > 0.0) until_m += v * v / (2.0 * numbers.weakest_mps2) + v * (numbers.late_s + 2.0 * numbers.dt_s);
  if (state.own[i].held_chain != no_chain) until_m = std::max(until_m, state.own[i].clear_at);
  return until_m;
}

std::span<const zone::SectionId> Fleet::Inside::committed(std::uint32_t i) {
  committed_sections.clear();
  Way way = way_of(i);
  committed_sections.push_back(way.section);
  const double until_m = std::min(committed_m(i), state.goal_at[i]);
  double end_m = ground.length_m(way.section);
  // Whoever turns on the spot does so towards the next one.
  bool more = (state.mode[i] & Mode::turning) != 0;
  while (more || end_m < until_m) {
    const zone::SectionId to = next(way);
    if (to == zone::no_section) break;
    committed_sections.push_back(to);
    end_m += ground.length_m(to);
    step_to(way, to);
    more = false;
  }
  return committed_sections;
}

void Fleet::Inside::take_route(std::uint32_t i, std::span<const zone::SectionId> route) {
  if (state.own[i].route == Fleet::none) {
    state.own[i].route = static_cast<std::uint32_t>(routes.size());
    routes.emplace_back();
  }
  routes[state.own[i].route].sections.assign(route.begin(), route.end());
  state.own[i].route_step = 0;
}

void Fleet::Inside::follow_anew(std::uint32_t i) {
  if (front[at(state.own[i].copy, state.section[i])] == i) look_ahead(i);
  const std::uint32_t asked_for = state.own[i].line_chain;
  survey(i);
  // Who comes to a sharp bend turns there; who stands there already has no more to come.
  const bool stands_at_end = state.v_mps[i] == 0.0 && state.s_m[i] == ground.length_m(state.section[i]);
  if (numbers.has_turns && stands_at_end && state.goal_at[i] > state.s_m[i] && (state.mode[i] & Mode::turning) == 0)
    begin_turn(i);
  if ((state.mode[i] & Mode::asks) == 0 || state.own[i].line_chain == asked_for) return;
  withdraw(i);
}

bool Fleet::Inside::has_chains(std::span<const zone::SectionId> route, double goal_s_m) const {
  if (!ground.has_cuts()) return true;
  for (std::uint32_t k = 0; k < route.size(); ++k) {
    const double until_m = k + 1 == route.size() ? goal_s_m : ground.length_m(route[k]);
    for (const Ground::Line& line : ground.lines(route[k]))
      if (line.at_m <= until_m && find_chain(line, {route[k], k, route, true}) == no_chain) return false;
  }
  return true;
}

/// Who stays in crossings holds what leads on from there by default. Along another way it needs others with them, and
/// takes those only all at once. False: they are not free, or there is no such way.
bool Fleet::Inside::exchange_chain(std::uint32_t i, std::span<const zone::SectionId> route) {
  Own& own = state.own[i];
  if (own.held_chain == no_chain) return true;
  const auto held = ground.sections_of(ground.chain(own.held_chain));
  double start_m = own.chain_at;
  std::vector<zone::SectionId> along;
  for (std::size_t k = 0; k < held.size() && start_m < -1e-6; start_m += ground.length_m(held[k++]))
    along.push_back(held[k]);
  if (start_m > 1e-6) return true;  // the chain begins on a later section
  along.insert(along.end(), route.begin(), route.end());
  const auto lines = ground.lines(along.front());
  const auto line = std::ranges::find_if(lines, [&](const Ground::Line& one) {
    return own.held_chain >= one.first_chain && own.held_chain < one.first_chain + one.chains;
  });
  const std::uint32_t wanted = line == lines.end() ? no_chain : find_chain(*line, {along.front(), 0, along, true});
  if (wanted == own.held_chain || wanted == no_chain) return wanted != no_chain;

  CrossingState* const here = crossings.data() + std::size_t{own.copy} * ground.zone().crossings.size();
  const auto leaves = ground.leaves_of(ground.chain(wanted));
  // What lies behind it is others' business.
  std::uint16_t to_come = 0;
  while (to_come < leaves.size() && own.chain_at + leaves[to_come].at_m + Ground::left_m < state.s_m[i]) ++to_come;
  for (const Ground::Leave& leave : leaves.subspan(to_come))
    if (here[leave.crossing].holder != Fleet::none && here[leave.crossing].holder != i) return false;
  for (const Ground::Leave& leave : ground.leaves_of(ground.chain(own.held_chain)).subspan(own.held_next))
    here[leave.crossing].holder = Fleet::none;
  own.held_next = to_come;
  if (to_come == leaves.size()) {  // this way it is through already
    hold_nothing(i);
    look_again(copies[own.copy]);
    return true;
  }
  for (const Ground::Leave& leave : leaves.subspan(own.held_next)) here[leave.crossing].holder = i;
  own.held_chain = wanted;
  own.release_at = own.chain_at + leaves[own.held_next].at_m + Ground::left_m;
  own.clear_at = own.chain_at + ground.chain(wanted).exit_m;
  look_again(copies[own.copy]);
  return true;
}

bool Fleet::Inside::send(std::uint32_t i, std::span<const zone::SectionId> route, double goal_s_m) {
  if ((state.mode[i] & Mode::absent) != 0) return false;
  if (route.empty() || !std::ranges::all_of(route, [&](zone::SectionId id) { return id < ground.size(); }))
    return false;
  if (!(goal_s_m >= 0.0 && goal_s_m <= ground.length_m(route.back()))) return false;
  double goal_m = goal_s_m;
  for (std::size_t k = 0; k + 1 < route.size(); ++k) {
    const auto ways = ground.circuit().next(route[k]);
    if (std::ranges::find(ways, route[k + 1]) == ways.end()) return false;
    goal_m += ground.length_m(route[k]);
  }
  if (!has_chains(route, goal_s_m)) return false;
  const auto kept = committed(i);
  const std::size_t common = std::min(kept.size(), route.size());
  if (!std::equal(kept.begin(), kept.begin() + static_cast<std::ptrdiff_t>(common), route.begin())) return false;
  // Nor may it stay short of the end of crossings that it holds: nobody else could pass.
  if (goal_m < committed_m(i) || (kept.size() > route.size() && (state.mode[i] & Mode::turning) != 0)) return false;
  if (!exchange_chain(i, route)) return false;

  take_route(i, route);
  routes[state.own[i].route].goal_s_m = goal_s_m;
  state.goal_at[i] = goal_m;
  if ((state.mode[i] & Mode::sent) == 0) ++told_vehicles;
  state.mode[i] = static_cast<std::uint8_t>((state.mode[i] | Mode::sent) & ~(Mode::at_goal | Mode::told));
  if (state.v_mps[i] == 0.0 && goal_m == state.s_m[i]) state.mode[i] |= Mode::told;
  follow_anew(i);
  return true;
}

void Fleet::Inside::circulate(std::uint32_t i) {
  if ((state.mode[i] & (Mode::sent | Mode::absent)) != Mode::sent) return;
  // What it is committed to stays its way; from there the defaults lead on.
  committed(i);
  state.goal_at[i] = far_m;
  --told_vehicles;
  state.mode[i] &= static_cast<std::uint8_t>(~(Mode::sent | Mode::at_goal | Mode::told));
  take_route(i, committed_sections);
  follow_anew(i);
}

}  // namespace cosiva::virtual_side
