#include "cosiva/virtual/fleet/presence.h"

#include <algorithm>
#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {

Presence::Presence(FleetTables& tables, Leaders& leaders, PathSurvey& survey, CrossingGrants& grants,
                   FleetOrders& orders, PoseWriter& poses)
    : ground_{tables.ground},
      numbers_{tables.numbers},
      state_{tables.state},
      copies_{tables.copies},
      front_{tables.front},
      blocks_{tables.blocks},
      routes_{tables.routes},
      step_number_{tables.step_number},
      commanded_vehicles_{tables.commanded_vehicles},
      leaders_{leaders},
      survey_{survey},
      grants_{grants},
      orders_{orders},
      poses_{poses} {}

bool Presence::take_away(std::uint32_t i) {
  if ((state_.mode[i] & Mode::at_goal) == 0 || (state_.mode[i] & Mode::absent) != 0) return false;
  Block& block = block_of(i);
  Own& own = state_.own[i];
  while (own.held_chain != no_chain) grants_.release(i);
  leaders_.unlink(i);
  block.occupied_steps[state_.section[i]] += step_number_ - own.entered_step;
  leaders_.update_followers(block, own.copy, state_.section[i]);
  CrossingGrants::recheck(copies_[own.copy]);
  own.own_mps = far_m;
  make_absent(i);
  return true;
}

bool Presence::bring(std::uint32_t i, zone::TrackPosition position, std::int16_t priority) {
  if ((state_.mode[i] & Mode::absent) == 0 || position.section >= ground_.size()) return false;
  if (!(position.s_m >= 0.0 && position.s_m <= ground_.length_m(position.section)) || !ground_.may_stop(position))
    return false;
  Block& block = block_of(i);
  Own& own = state_.own[i];
  const double driven_m = own.traversed_m + state_.s_m[i];
  const zone::TrackPosition was{state_.section[i], state_.s_m[i]};
  if (own.route != Fleet::none) routes_[own.route].sections.clear();
  own.route_step = 0;
  state_.section[i] = position.section;
  state_.s_m[i] = position.s_m;
  own.traversed_m = driven_m - position.s_m;
  state_.mode[i] = 0;
  leaders_.link(i);
  const double gap_m = leaders_.gap_m(i);
  if (gap_m < gap_needed_m || !leaves_room_behind(block, i)) {
    leaders_.unlink(i);
    state_.section[i] = was.section;
    state_.s_m[i] = was.s_m;
    own.traversed_m = driven_m - was.s_m;
    make_absent(i);
    return false;
  }
  --commanded_vehicles_;
  state_.profile[i] = -1;
  state_.goal_at[i] = far_m;
  own.priority = priority;
  own.began_on = position.section;
  own.entered_step = step_number_;
  survey_.survey(i);
  leaders_.update_followers(block, own.copy, position.section);
  CrossingGrants::recheck(copies_[own.copy]);
  poses_.write(i, i + 1);
  return true;
}

void Presence::make_absent(std::uint32_t i) {
  COSIVA_EXPECT(state_.own[i].held_chain == no_chain);
  state_.mode[i] = Mode::sent | Mode::at_goal | Mode::absent;
  state_.v_mps[i] = 0.0;
  state_.leader[i] = i;
  for (auto* positions : {&state_.offset_m, &state_.line_at, &state_.event_at, &state_.cap_mps})
    (*positions)[i] = far_m;
  state_.halt_at[i] = state_.s_m[i];
  state_.goal_at[i] = state_.s_m[i];
  state_.event[i] = 0;
  if (numbers_.has_limits) state_.slow_at[i] = far_m;
}

bool Presence::leaves_room_behind(Block& block, std::uint32_t i) const {
  const std::uint32_t copy = state_.own[i].copy;
  const auto can_stop = [&](std::uint32_t other, double path_distance_m) {
    return path_distance_m - numbers_.length_m - gap_needed_m >= orders_.committed_m(other) - state_.s_m[other];
  };
  if (const std::uint32_t other = state_.own[i].behind; other != Fleet::none)
    return can_stop(other, state_.s_m[i] - state_.s_m[other]);
  ++block.search;
  block.open.assign(1, state_.section[i]);
  block.detected_m[state_.section[i]] = state_.s_m[i];
  for (std::size_t k = 0; k < block.open.size(); ++k) {
    const double path_distance_m = block.detected_m[block.open[k]];
    for (const zone::SectionId from : ground_.circuit().previous(block.open[k])) {
      const std::uint32_t first = front_[list_index(ground_, copy, from)];
      const double length_m = ground_.length_m(from);
      if (first != Fleet::none) {
        if (first != i && !can_stop(first, path_distance_m + length_m - state_.s_m[first])) return false;
        continue;
      }
      if (path_distance_m + length_m > numbers_.sensed_m) continue;
      if (block.detection_search[from] == block.search && block.detected_m[from] <= path_distance_m + length_m)
        continue;
      block.detection_search[from] = block.search;
      block.detected_m[from] = path_distance_m + length_m;
      block.open.push_back(from);
    }
  }
  return true;
}

Block& Presence::block_of(std::uint32_t i) {
  const auto after = std::ranges::upper_bound(blocks_, i, {}, &Block::first);
  return *(after - 1);
}

}  // namespace cosiva::virtual_side
