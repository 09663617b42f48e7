// Who is ahead of whom, what lies ahead of whom, and what happens at the ends of sections.
#include <algorithm>

#include "cosiva/aiv/motion/formulas.h"
#include "cosiva/aiv/motion/manoeuvre.h"
#include "cosiva/base/expect.h"
#include "cosiva/virtual/fleet/inside.h"

namespace cosiva::virtual_side {
namespace {

/// Rounding between a chain's exit and the next line.
constexpr double rounding_m = 1e-6;

/// A place as seen from the start of the next section; far away stays far away.
double shifted(double at_m, double length_m) { return at_m < 0.5 * far_m ? at_m - length_m : far_m; }

}  // namespace

Fleet::Inside::Way Fleet::Inside::way_of(std::uint32_t i) const {
  const std::uint32_t route = state.own[i].route;
  if (route == Fleet::none) return {state.section[i], 0, {}, false};
  return {state.section[i], state.own[i].route_step, routes[route].sections, (state.mode[i] & Mode::sent) != 0};
}

zone::SectionId Fleet::Inside::next(const Way& way) const {
  if (way.ends && way.step + 1 >= way.route.size()) return zone::no_section;
  return beyond(way);
}

zone::SectionId Fleet::Inside::beyond(const Way& way) const {
  return way.step + 1 < way.route.size() ? way.route[way.step + 1] : ground.default_next(way.section);
}

void Fleet::Inside::step_to(Way& way, zone::SectionId section) {
  way.section = section;
  ++way.step;
}

Fleet::Inside::Found Fleet::Inside::find_ahead(std::uint32_t i, double look_m) const {
  const std::uint32_t copy = state.own[i].copy;
  const zone::Circuit& circuit = ground.circuit();
  Way way = way_of(i);
  double start_m = ground.length_m(way.section);
  const double end_m = start_m + look_m;
  for (std::size_t steps = 0; start_m <= end_m && steps <= ground.size(); ++steps) {
    const zone::SectionId to = beyond(way);
    if (to == zone::no_section) break;
    Found found{rear[at(copy, to)], start_m};
    const auto ways = circuit.next(way.section);
    if (ways.size() > 1) {
      // Who has taken another branch is in the way until its body has parted.
      for (const zone::SectionId branch : ways) {
        const std::uint32_t other = rear[at(copy, branch)];
        if (branch == to || other == Fleet::none || !(state.s_m[other] < ground.parted_m(branch))) continue;
        if (found.vehicle == Fleet::none || state.s_m[other] < state.s_m[found.vehicle]) found.vehicle = other;
      }
    }
    if (found.vehicle == i) return {i, far_m};  // all the way round, and nobody else
    if (found.vehicle != Fleet::none) return found;
    start_m += ground.length_m(to);
    step_to(way, to);
  }
  return {i, far_m};
}

void Fleet::Inside::look_ahead(std::uint32_t i) {
  const auto [vehicle, offset_m] = find_ahead(i, numbers.look_m);
  state.leader[i] = vehicle;
  state.offset_m[i] = offset_m;
}

/// Somebody has come onto `section`, or is in nobody's way there any more; `left`, where it was, may be empty now.
/// Whoever is first on the sections before these looks again.
void Fleet::Inside::tell_behind(Block& block, std::uint32_t copy, zone::SectionId section, zone::SectionId left) {
  const zone::Circuit& circuit = ground.circuit();
  ++block.search;
  block.open.clear();
  for (const zone::SectionId changed : {left, section}) {
    if (changed == zone::no_section) continue;
    block.open.push_back(changed);
    block.seen_m[changed] = 0.0;
    block.seen_search[changed] = block.search;
  }
  for (std::size_t k = 0; k < block.open.size(); ++k) {
    const zone::SectionId to = block.open[k];
    const double way_m = block.seen_m[to];
    for (const zone::SectionId from : circuit.previous(to)) {
      const std::uint32_t first = front[at(copy, from)];
      if (first != Fleet::none) {
        look_ahead(first);
        continue;
      }
      const double on_m = way_m + ground.length_m(from);
      if (on_m > numbers.look_m) continue;
      // Found again by a shorter way it is looked through again: what lies behind it may only now be near enough.
      if (block.seen_search[from] == block.search && block.seen_m[from] <= on_m) continue;
      block.seen_search[from] = block.search;
      block.seen_m[from] = on_m;
      block.open.push_back(from);
    }
  }
}

void Fleet::Inside::switch_section(Block& block, std::uint32_t i) {
  const std::uint32_t copy = state.own[i].copy;
  const zone::SectionId from = state.section[i];
  const Way way = way_of(i);
  const zone::SectionId to = next(way);
  COSIVA_EXPECT(to != zone::no_section);
  // Whoever is before it on this section leaves it first.
  while (front[at(copy, from)] != i) move_across(block, front[at(copy, from)]);

  const std::uint32_t behind = state.own[i].behind;
  front[at(copy, from)] = behind;
  if (behind == Fleet::none) rear[at(copy, from)] = Fleet::none;
  state.own[i].behind = Fleet::none;
  block.occupied_steps[from] += block.now - state.own[i].entered_step;
  state.own[i].entered_step = block.now;

  const double length_m = ground.length_m(from);
  state.s_m[i] -= length_m;
  state.own[i].gone_m += length_m;
  for (auto* place : {&state.halt_at, &state.line_at, &state.goal_at}) (*place)[i] = shifted((*place)[i], length_m);
  Own& own = state.own[i];
  for (double* place : {&own.release_at, &own.clear_at, &own.chain_at}) *place = shifted(*place, length_m);
  state.section[i] = to;
  if (!way.route.empty()) ++state.own[i].route_step;
  // Exactly where it was sent, whatever rounding the way there has left.
  if (way.ends && way.step + 2 == way.route.size()) state.goal_at[i] = routes[state.own[i].route].goal_s_m;
  if (to == state.own[i].began_on) ++state.own[i].laps;

  const std::uint32_t last = rear[at(copy, to)];
  rear[at(copy, to)] = i;
  if (last == Fleet::none) {
    front[at(copy, to)] = i;
    look_ahead(i);
  } else {
    state.own[last].behind = i;
    state.leader[i] = last;
    state.offset_m[i] = 0.0;
  }
  tell_behind(block, copy, to, behind == Fleet::none ? from : zone::no_section);
}

void Fleet::Inside::move_across(Block& block, std::uint32_t i) {
  // The article's loop (A30): as many sections as it takes.
  while (state.s_m[i] > ground.length_m(state.section[i])) switch_section(block, i);
  survey(i);
}

std::uint32_t Fleet::Inside::match(const Ground::Line& line, const Way& way) const {
  const std::uint32_t chain = find_chain(line, way);
  COSIVA_EXPECT(chain != no_chain);  // whoever has none is not sent that way
  return chain;
}

std::uint32_t Fleet::Inside::find_chain(const Ground::Line& line, const Way& way) const {
  // Of several the longest: where another crossing follows closely on only one of two ways, that one's chain is longer.
  // A way that ends before the exit goes on by default, so that whoever has stayed there can always go on so.
  std::uint32_t whole = no_chain;
  std::uint32_t part = no_chain;
  for (std::uint32_t c = line.first_chain; c < line.first_chain + line.chains; ++c) {
    Way on = way;
    bool same = true;
    bool ended = false;
    for (const zone::SectionId section : ground.sections_of(ground.chain(c)).subspan(1)) {
      zone::SectionId to = next(on);
      ended |= to == zone::no_section;
      if (ended) to = ground.default_next(on.section);
      same = to == section;
      if (!same) break;
      step_to(on, to);
    }
    std::uint32_t& best = ended ? part : whole;
    if (same && (best == no_chain || ground.chain(c).exit_m > ground.chain(best).exit_m)) best = c;
  }
  return whole != no_chain ? whole : part;
}

void Fleet::Inside::survey(std::uint32_t i) {
  Way way = way_of(i);
  const double from_m =
      std::max(state.s_m[i], state.own[i].clear_at < 0.5 * far_m ? state.own[i].clear_at - rounding_m : 0.0);
  const double own_length_m = ground.length_m(way.section);
  double start_m = 0.0;
  double halt_m = state.goal_at[i];
  double line_m = far_m;
  std::uint32_t chain = no_chain;
  double slow_key = 1e300;
  double slow_at = far_m;
  double slow_mps = 0.0;
  for (;;) {
    for (const Ground::Line& line : ground.lines(way.section)) {
      if (start_m + line.at_m <= from_m || start_m + line.at_m > halt_m) continue;
      line_m = start_m + line.at_m;
      chain = match(line, way);
      break;
    }
    if (line_m < far_m) break;
    const double end_m = start_m + ground.length_m(way.section);
    if (halt_m <= end_m || end_m - own_length_m > numbers.look_m) break;
    const zone::SectionId to = next(way);
    if (to == zone::no_section || ground.turn_rad(way.section, to) != 0.0) {
      halt_m = end_m;
      break;
    }
    start_m = end_m;
    step_to(way, to);
    if (!numbers.has_limits || ground.limit_mps(to) >= far_m) continue;
    // Of two limits ahead the same one counts all the way to the first: v² = l² + 2b·(d − l·t) for both.
    const double mps = ground.limit_mps(to);
    const double key = mps * mps + 2.0 * numbers.weakest_mps2 * (start_m - mps * aiv::reaction_s);
    if (key >= slow_key) continue;
    slow_key = key;
    slow_at = start_m;
    slow_mps = mps;
  }
  state.line_at[i] = line_m;
  state.own[i].line_chain = chain;
  state.halt_at[i] = std::min(halt_m, line_m < far_m ? std::max(state.s_m[i], line_m - aiv::stop_line_m) : far_m);
  state.cap_mps[i] = state.own[i].own_mps;
  if (numbers.has_limits) {
    state.cap_mps[i] = std::min(state.own[i].own_mps, ground.limit_mps(state.section[i]));
    state.slow_at[i] = slow_at;
    state.slow_mps[i] = slow_mps;
  }
  set_event(i);
}

void Fleet::Inside::set_event(std::uint32_t i) {
  const zone::SectionId section = state.section[i];
  double event_m = std::min(ground.length_m(section), state.own[i].release_at);
  const double parted_m = ground.parted_m(section);
  if (state.s_m[i] <= parted_m) event_m = std::min(event_m, parted_m);
  state.event_at[i] = event_m;
}

void Fleet::Inside::begin_turn(std::uint32_t i) {
  const zone::SectionId from = state.section[i];
  const zone::SectionId to = next(way_of(i));
  if (to == zone::no_section) return;  // a dead end: it stays
  const double turn_rad = ground.turn_rad(from, to);
  if (turn_rad == 0.0) return;
  state.mode[i] |= Mode::turning;
  state.turn_left_rad[i] = turn_rad;
  state.turn_radps[i] = 0.0;
}

void Fleet::Inside::turn_on(std::uint32_t i) {
  constexpr aiv::ManoeuvreRates rates;
  const double sign = state.turn_left_rad[i] < 0.0 ? -1.0 : 1.0;
  const double left_rad = sign * state.turn_left_rad[i];
  const double rate =
      aiv::plain::manoeuvre_rate(state.turn_radps[i], rates.turn_radps, left_rad, rates.turn_radps2, numbers.dt_s);
  constexpr double close_rad = 1e-6;
  const double moved_rad = left_rad - rate * numbers.dt_s < close_rad ? left_rad : rate * numbers.dt_s;
  state.turn_radps[i] = rate;
  state.turn_left_rad[i] = sign * (left_rad - moved_rad);
}

void Fleet::Inside::see_to(Block& block, std::uint32_t i) {
  const std::uint8_t event = state.event[i];
  if ((event & Event::passed) != 0) {
    if (state.s_m[i] > state.line_at[i]) ++block.collisions;  // in a crossing that it does not hold: never
    if (state.s_m[i] > ground.length_m(state.section[i])) move_across(block, i);
    while (state.s_m[i] > state.own[i].release_at) release(i);
    if (state.s_m[i] > ground.parted_m(state.section[i]) && ground.parted_m(state.section[i]) > 0.0)
      tell_behind(block, state.own[i].copy, state.section[i]);
    set_event(i);
  }
  const bool at_goal = (state.mode[i] & Mode::sent) != 0 && state.s_m[i] == state.goal_at[i] && state.v_mps[i] == 0.0;
  if ((event & (Event::halted | Event::goes_on)) != 0 && at_goal && (state.mode[i] & Mode::at_goal) == 0) {
    state.mode[i] = static_cast<std::uint8_t>((state.mode[i] | Mode::at_goal) & ~Mode::told);
    arrived[block.first + block.arrivals++] = i;
  }
  if ((state.mode[i] & Mode::turning) != 0) {
    turn_on(i);
    if (state.turn_left_rad[i] == 0.0) {
      state.mode[i] &= static_cast<std::uint8_t>(~Mode::turning);
      switch_section(block, i);
      survey(i);
    }
  } else if ((event & Event::halted) != 0 && state.s_m[i] == ground.length_m(state.section[i]) && !at_goal) {
    if (numbers.has_turns) begin_turn(i);
  }
  if ((event & Event::nears) != 0 && state.line_at[i] < far_m && (state.mode[i] & Mode::asks) == 0) ask(block, i);
}

}  // namespace cosiva::virtual_side
