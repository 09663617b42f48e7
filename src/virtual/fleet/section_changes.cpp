#include "cosiva/virtual/fleet/section_changes.h"

#include "cosiva/aiv/motion/formulas.h"
#include "cosiva/aiv/motion/manoeuvre.h"
#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {
namespace {

/// A position relative to the start of the next section; far_m stays far.
double shifted(double at_m, double length_m) { return at_m < 0.5 * far_m ? at_m - length_m : far_m; }

}  // namespace

SectionChanges::SectionChanges(FleetTables& tables, const Paths& paths, Leaders& leaders, PathSurvey& survey,
                               CrossingGrants& grants)
    : ground_{tables.ground},
      numbers_{tables.numbers},
      state_{tables.state},
      front_{tables.front},
      rear_{tables.rear},
      routes_{tables.routes},
      arrived_{tables.arrived},
      paths_{paths},
      leaders_{leaders},
      survey_{survey},
      grants_{grants} {}

void SectionChanges::handle_events(Block& block, std::uint32_t i) {
  const std::uint8_t event = state_.event[i];
  if ((event & Event::passed) != 0) {
    if (state_.s_m[i] > state_.line_at[i])
      ++block.collisions;  // in a crossing that it does not hold: must never
                           // happen
    if (state_.s_m[i] > ground_.length_m(state_.section[i])) move_across(block, i);
    while (state_.s_m[i] > state_.own[i].release_at) grants_.release(i);
    if (state_.s_m[i] > ground_.parted_m(state_.section[i]) && ground_.parted_m(state_.section[i]) > 0.0)
      leaders_.update_followers(block, state_.own[i].copy, state_.section[i]);
    survey_.set_event(i);
  }
  const bool at_goal =
      (state_.mode[i] & Mode::sent) != 0 && state_.s_m[i] == state_.goal_at[i] && state_.v_mps[i] == 0.0;
  if ((event & (Event::halted | Event::goes_on)) != 0 && at_goal && (state_.mode[i] & Mode::at_goal) == 0) {
    state_.mode[i] = static_cast<std::uint8_t>((state_.mode[i] | Mode::at_goal) & ~Mode::commanded);
    arrived_[block.first + block.arrivals++] = i;
  }
  if ((state_.mode[i] & Mode::turning) != 0) {
    turn_on(i);
    if (state_.turn_left_rad[i] == 0.0) {
      state_.mode[i] &= static_cast<std::uint8_t>(~Mode::turning);
      switch_section(block, i);
      survey_.survey(i);
    }
  } else if ((event & Event::halted) != 0 && state_.s_m[i] == ground_.length_m(state_.section[i]) && !at_goal) {
    if (numbers_.has_turns) begin_turn(i);
  }
  if ((event & Event::nears) != 0 && state_.line_at[i] < far_m && (state_.mode[i] & Mode::requesting) == 0)
    grants_.request(block, i);
}

void SectionChanges::switch_section(Block& block, std::uint32_t i) {
  const std::uint32_t copy = state_.own[i].copy;
  const zone::SectionId from = state_.section[i];
  const Paths::Path path = paths_.path_of(i);
  const zone::SectionId to = paths_.next(path);
  COSIVA_EXPECT(to != zone::no_section);
  // Vehicles ahead on this section leave it first.
  while (front_[list_index(ground_, copy, from)] != i) move_across(block, front_[list_index(ground_, copy, from)]);

  const std::uint32_t behind = state_.own[i].behind;
  front_[list_index(ground_, copy, from)] = behind;
  if (behind == Fleet::none) rear_[list_index(ground_, copy, from)] = Fleet::none;
  state_.own[i].behind = Fleet::none;
  block.occupied_steps[from] += block.now - state_.own[i].entered_step;
  state_.own[i].entered_step = block.now;

  const double length_m = ground_.length_m(from);
  state_.s_m[i] -= length_m;
  state_.own[i].traversed_m += length_m;
  for (auto* position : {&state_.halt_at, &state_.line_at, &state_.goal_at})
    (*position)[i] = shifted((*position)[i], length_m);
  Own& own = state_.own[i];
  for (double* position : {&own.release_at, &own.clear_at, &own.chain_at}) *position = shifted(*position, length_m);
  state_.section[i] = to;
  if (!path.route.empty()) ++state_.own[i].route_step;
  // The goal exactly as sent, without the rounding of the sections before it.
  if (path.ends && path.step + 2 == path.route.size()) state_.goal_at[i] = routes_[state_.own[i].route].goal_s_m;
  if (to == state_.own[i].began_on) ++state_.own[i].laps;

  const std::uint32_t last = rear_[list_index(ground_, copy, to)];
  rear_[list_index(ground_, copy, to)] = i;
  if (last == Fleet::none) {
    front_[list_index(ground_, copy, to)] = i;
    leaders_.look_ahead(i);
  } else {
    state_.own[last].behind = i;
    state_.leader[i] = last;
    state_.offset_m[i] = 0.0;
  }
  leaders_.update_followers(block, copy, to, behind == Fleet::none ? from : zone::no_section);
}

void SectionChanges::move_across(Block& block, std::uint32_t i) {
  // The article's loop (A30): over as many sections as necessary.
  while (state_.s_m[i] > ground_.length_m(state_.section[i])) switch_section(block, i);
  survey_.survey(i);
}

void SectionChanges::begin_turn(std::uint32_t i) {
  const zone::SectionId from = state_.section[i];
  const zone::SectionId to = paths_.next(paths_.path_of(i));
  if (to == zone::no_section) return;  // a dead end: the vehicle stays
  const double turn_rad = ground_.turn_rad(from, to);
  if (turn_rad == 0.0) return;
  state_.mode[i] |= Mode::turning;
  state_.turn_left_rad[i] = turn_rad;
  state_.turn_radps[i] = 0.0;
}

void SectionChanges::turn_on(std::uint32_t i) {
  constexpr aiv::ManoeuvreRates rates;
  const double sign = state_.turn_left_rad[i] < 0.0 ? -1.0 : 1.0;
  const double left_rad = sign * state_.turn_left_rad[i];
  const double rate =
      aiv::plain::manoeuvre_rate(state_.turn_radps[i], rates.turn_radps, left_rad, rates.turn_radps2, numbers_.dt_s);
  constexpr double close_rad = 1e-6;
  const double moved_rad = left_rad - rate * numbers_.dt_s < close_rad ? left_rad : rate * numbers_.dt_s;
  state_.turn_radps[i] = rate;
  state_.turn_left_rad[i] = sign * (left_rad - moved_rad);
}

}  // namespace cosiva::virtual_side
