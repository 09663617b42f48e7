// Vehicles that leave the zone, and that come into it.
#include <algorithm>
#include <utility>

#include "cosiva/aiv/motion/formulas.h"
#include "cosiva/virtual/fleet/inside.h"

namespace cosiva::virtual_side {
namespace {

/// Beyond what somebody behind is committed to: its stand-off, and what rounding may take.
constexpr double spare_m = aiv::stand_off_m + Ground::left_m + 0.01;

}  // namespace

Block& Fleet::Inside::block_of(std::uint32_t i) {
  const auto after = std::ranges::upper_bound(blocks, i, {}, &Block::first);
  return *(after - 1);
}

/// To every pass it looks like one that stands at its goal; it is on no list, so nobody sees it.
void Fleet::Inside::make_absent(std::uint32_t i) {
  state.mode[i] = Mode::sent | Mode::at_goal | Mode::absent;
  state.v_mps[i] = 0.0;
  state.leader[i] = i;
  for (auto* places : {&state.offset_m, &state.line_at, &state.event_at, &state.cap_mps}) (*places)[i] = far_m;
  state.halt_at[i] = state.s_m[i];
  state.goal_at[i] = state.s_m[i];
  state.event[i] = 0;
  if (numbers.has_limits) state.slow_at[i] = far_m;
}

void Fleet::Inside::unlink(std::uint32_t i) {
  const std::size_t here = at(state.own[i].copy, state.section[i]);
  const std::uint32_t behind = std::exchange(state.own[i].behind, Fleet::none);
  std::uint32_t before = Fleet::none;
  for (std::uint32_t other = front[here]; other != i; other = state.own[other].behind) before = other;
  (before == Fleet::none ? front[here] : state.own[before].behind) = behind;
  if (behind == Fleet::none) {
    rear[here] = before;
  } else if (before == Fleet::none) {
    look_ahead(behind);
  } else {
    state.leader[behind] = before;
    state.offset_m[behind] = 0.0;
  }
}

void Fleet::Inside::link(std::uint32_t i) {
  const std::size_t here = at(state.own[i].copy, state.section[i]);
  std::uint32_t before = Fleet::none;
  std::uint32_t behind = front[here];
  for (; behind != Fleet::none && state.s_m[behind] >= state.s_m[i]; behind = state.own[behind].behind) before = behind;
  (before == Fleet::none ? front[here] : state.own[before].behind) = i;
  state.own[i].behind = behind;
  if (behind == Fleet::none) {
    rear[here] = i;
  } else {
    state.leader[behind] = i;
    state.offset_m[behind] = 0.0;
  }
  if (before == Fleet::none) {
    look_ahead(i);
  } else {
    state.leader[i] = before;
    state.offset_m[i] = 0.0;
  }
}

bool Fleet::Inside::take_away(std::uint32_t i) {
  if ((state.mode[i] & Mode::at_goal) == 0 || (state.mode[i] & Mode::absent) != 0) return false;
  Block& block = block_of(i);
  Own& own = state.own[i];
  while (own.held_chain != no_chain) release(i);
  unlink(i);
  block.occupied_steps[state.section[i]] += step_number - own.entered_step;
  tell_behind(block, own.copy, state.section[i]);
  look_again(copies[own.copy]);
  own.own_mps = far_m;
  make_absent(i);
  return true;
}

/// Whether everybody who would come upon i next can still stop short of it, i already being on its list.
bool Fleet::Inside::leaves_room_behind(Block& block, std::uint32_t i) const {
  const std::uint32_t copy = state.own[i].copy;
  const auto can_stop = [&](std::uint32_t other, double way_m) {
    return way_m - numbers.length_m - spare_m >= committed_m(other) - state.s_m[other];
  };
  if (const std::uint32_t other = state.own[i].behind; other != Fleet::none)
    return can_stop(other, state.s_m[i] - state.s_m[other]);
  ++block.search;
  block.open.assign(1, state.section[i]);
  block.seen_m[state.section[i]] = state.s_m[i];
  for (std::size_t k = 0; k < block.open.size(); ++k) {
    const double way_m = block.seen_m[block.open[k]];
    for (const zone::SectionId from : ground.circuit().previous(block.open[k])) {
      const std::uint32_t first = front[at(copy, from)];
      const double length_m = ground.length_m(from);
      if (first != Fleet::none) {
        if (first != i && !can_stop(first, way_m + length_m - state.s_m[first])) return false;
        continue;
      }
      if (way_m + length_m > numbers.look_m) continue;
      if (block.seen_search[from] == block.search && block.seen_m[from] <= way_m + length_m) continue;
      block.seen_search[from] = block.search;
      block.seen_m[from] = way_m + length_m;
      block.open.push_back(from);
    }
  }
  return true;
}

bool Fleet::Inside::bring(std::uint32_t i, zone::Place place, std::int16_t priority) {
  if ((state.mode[i] & Mode::absent) == 0 || place.section >= ground.size()) return false;
  if (!(place.s_m >= 0.0 && place.s_m <= ground.length_m(place.section)) || !ground.may_stand(place)) return false;
  Block& block = block_of(i);
  Own& own = state.own[i];
  const double driven_m = own.gone_m + state.s_m[i];
  const zone::Place was{state.section[i], state.s_m[i]};
  if (own.route != Fleet::none) routes[own.route].sections.clear();
  own.route_step = 0;
  state.section[i] = place.section;
  state.s_m[i] = place.s_m;
  own.gone_m = driven_m - place.s_m;
  state.mode[i] = 0;
  link(i);
  const double gap_m = state.offset_m[i] + state.s_m[state.leader[i]] - state.s_m[i] - numbers.length_m;
  if (gap_m < spare_m || !leaves_room_behind(block, i)) {
    unlink(i);
    state.section[i] = was.section;
    state.s_m[i] = was.s_m;
    own.gone_m = driven_m - was.s_m;
    make_absent(i);
    return false;
  }
  --told_vehicles;
  state.profile[i] = -1;
  state.goal_at[i] = far_m;
  own.priority = priority;
  own.began_on = place.section;
  own.entered_step = step_number;
  survey(i);
  tell_behind(block, own.copy, place.section);
  look_again(copies[own.copy]);
  draw(i, i + 1);
  return true;
}

}  // namespace cosiva::virtual_side
