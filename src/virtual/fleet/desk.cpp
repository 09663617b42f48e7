// Who may enter which crossing.
#include <algorithm>
#include <limits>
#include <span>

#include "cosiva/aiv/decision/right_of_way.h"
#include "cosiva/aiv/motion/formulas.h"
#include "cosiva/virtual/fleet/inside.h"

namespace cosiva::virtual_side {
namespace {

/// From a crossing's exit to where the rear of the one ahead is at least: it must be able to leave the crossing behind.
constexpr double room_m = aiv::stand_off_m + Ground::left_m + 0.01;

}  // namespace

void Fleet::Inside::ask(const Block& block, std::uint32_t i) {
  const Own& own = state.own[i];
  if (own.held_chain != no_chain) return;  // one chain after the other
  // Whoever has somebody between itself and the line is not the next.
  if (state.leader[i] != i && state.offset_m[i] + state.s_m[state.leader[i]] < state.line_at[i]) return;
  Copy& copy = copies[own.copy];
  state.queue[copy.first + copy.waiting++] = {i, block.now, own.line_chain, own.priority};
  look_again(copy);
  state.mode[i] |= Mode::asks;
}

void Fleet::Inside::look_again(Copy& copy) {
  copy.due_step = 0;
  copy.sort_step = 0;
}

std::span<Waiting> Fleet::Inside::waiting(std::uint32_t copy) {
  return std::span(state.queue).subspan(copies[copy].first, copies[copy].waiting);
}

void Fleet::Inside::withdraw(std::uint32_t i) {
  if ((state.mode[i] & Mode::asks) == 0) return;
  Copy& copy = copies[state.own[i].copy];
  const auto all = waiting(state.own[i].copy);
  const auto mine = std::ranges::find(all, i, &Waiting::vehicle);
  std::copy(mine + 1, all.end(), mine);
  --copy.waiting;
  look_again(copy);
  state.mode[i] &= static_cast<std::uint8_t>(~Mode::asks);
}

void Fleet::Inside::prioritise(std::uint32_t i, std::int16_t priority) {
  Own& own = state.own[i];
  own.priority = priority;
  for (Waiting& one : waiting(own.copy))
    if (one.vehicle == i) one.priority = priority;
  look_again(copies[own.copy]);
}

void Fleet::Inside::release(std::uint32_t i) {
  const Ground::Chain& chain = ground.chain(state.own[i].held_chain);
  const auto leaves = ground.leaves_of(chain);
  const std::size_t crossing = leaves[state.own[i].held_next].crossing;
  CrossingState& left = crossings[std::size_t{state.own[i].copy} * ground.zone().crossings.size() + crossing];
  left.holder = Fleet::none;
  copies[state.own[i].copy].due_step = 0;
  ++state.own[i].held_next;
  if (state.own[i].held_next < leaves.size()) {
    state.own[i].release_at = state.own[i].chain_at + leaves[state.own[i].held_next].at_m + Ground::left_m;
    return;
  }
  hold_nothing(i);
}

void Fleet::Inside::hold_nothing(std::uint32_t i) {
  state.own[i].held_chain = no_chain;
  state.own[i].release_at = far_m;
  state.own[i].clear_at = far_m;
  state.own[i].chain_at = far_m;
}

bool Fleet::Inside::goes_before(const Waiting& a, const Waiting& b, std::uint32_t now) const {
  const auto claim = [&](const Waiting& one) {
    return aiv::Claim{one.priority, options.step * (now - one.asked_step)};
  };
  const bool a_came_first = a.asked_step != b.asked_step ? a.asked_step < b.asked_step : a.vehicle < b.vehicle;
  if (a_came_first) return aiv::keeps_its_turn(claim(a), claim(b), options.overtaken_at_most);
  return !aiv::keeps_its_turn(claim(b), claim(a), options.overtaken_at_most);
}

bool Fleet::Inside::has_room(std::uint32_t i, const Ground::Chain& chain) const {
  const double exit_m = state.line_at[i] - chain.entry_m + chain.exit_m;
  // Where it is to stay in the crossing it needs no room beyond.
  if ((state.mode[i] & Mode::sent) != 0 && state.goal_at[i] <= exit_m) return true;
  const double need_m = exit_m + numbers.length_m + room_m;
  Found ahead{state.leader[i], state.offset_m[i]};
  const double own_m = ground.length_m(state.section[i]);
  if (ahead.vehicle == i && need_m > own_m + numbers.look_m) ahead = find_ahead(i, need_m - own_m);
  return ahead.vehicle == i || ahead.offset_m + state.s_m[ahead.vehicle] >= need_m;
}

void Fleet::Inside::grant(Block& block, std::uint32_t i, std::uint32_t waited) {
  const std::uint32_t index = state.own[i].line_chain;
  const Ground::Chain& chain = ground.chain(index);
  const auto leaves = ground.leaves_of(chain);
  const std::size_t first = std::size_t{state.own[i].copy} * ground.zone().crossings.size();
  for (const Ground::Leave& leave : leaves) {
    crossings[first + leave.crossing].holder = i;
    ++block.grants[leave.crossing];
    block.waited_steps[leave.crossing] += waited;
  }
  state.own[i].held_chain = index;
  state.own[i].held_next = 0;
  state.own[i].chain_at = state.line_at[i] - chain.entry_m;
  state.own[i].release_at = state.own[i].chain_at + leaves.front().at_m + Ground::left_m;
  state.own[i].clear_at = state.own[i].chain_at + chain.exit_m;
  withdraw(i);
  survey(i);
}

void Fleet::Inside::sort_waiting(Copy& copy, std::span<Waiting> all, std::uint32_t now) {
  // Sorted by hand, because it nearly always is sorted.
  for (std::size_t k = 1; k < all.size(); ++k) {
    const Waiting self = all[k];
    std::size_t to = k;
    for (; to > 0 && !goes_before(all[to - 1], self, now); --to) all[to] = all[to - 1];
    all[to] = self;
  }
  copy.sort_step = std::numeric_limits<std::uint32_t>::max();
  for (const Waiting& one : all) {
    const std::uint32_t overtaken_no_more = one.asked_step + overtaken_after_steps;
    if (overtaken_no_more > now) copy.sort_step = std::min(copy.sort_step, overtaken_no_more);
  }
}

void Fleet::Inside::serve(Block& block, std::uint32_t index) {
  Copy& copy = copies[index];
  if (copy.sort_step <= block.now) sort_waiting(copy, waiting(index), block.now);
  const std::uint32_t sort_step = copy.sort_step;
  ++block.pass;
  CrossingState* const here = crossings.data() + std::size_t{index} * ground.zone().crossings.size();
  bool lacks_room = false;
  for (std::size_t k = 0; k < copy.waiting;) {
    const Waiting& one = waiting(index)[k];
    const Ground::Chain& chain = ground.chain(one.chain);
    // Who has no room beyond could not use its turn; it keeps it, but lets others by.
    if (!has_room(one.vehicle, chain)) {
      lacks_room = true;
      ++k;
      continue;
    }
    const auto leaves = ground.leaves_of(chain);
    const bool is_open = std::ranges::all_of(leaves, [&](const Ground::Leave& leave) {
      const CrossingState& crossing = here[leave.crossing];
      return crossing.holder == Fleet::none && crossing.claimed_pass != block.pass;
    });
    if (is_open) {
      grant(block, one.vehicle, block.now - one.asked_step);  // and the next one stands at k now
      continue;
    }
    for (const Ground::Leave& leave : leaves) here[leave.crossing].claimed_pass = block.pass;
    ++k;
  }
  // The one ahead of who lacks room may move on at any time; all else that could change is a crossing left, somebody
  // new, or one that has waited long enough.
  copy.due_step = lacks_room ? block.now : sort_step;
  copy.sort_step = sort_step;
}

std::uint32_t Fleet::Inside::waits_for(std::uint32_t i) const {
  const bool stands = state.v_mps[i] < aiv::standing_mps && (state.mode[i] & (Mode::turning | Mode::at_goal)) == 0;
  if (!stands) return i;
  const std::uint32_t leader = state.leader[i];
  const double gap_m = state.offset_m[i] + state.s_m[leader] - state.s_m[i] - numbers.length_m;
  constexpr double near_m = 0.05;
  if (leader != i && gap_m < aiv::stand_off_m + near_m) return leader;
  if ((state.mode[i] & Mode::asks) == 0) return i;
  const Ground::Chain& chain = ground.chain(state.own[i].line_chain);
  const auto leaves = ground.leaves_of(chain);
  const CrossingState* const here = crossings.data() + std::size_t{state.own[i].copy} * ground.zone().crossings.size();
  for (const Ground::Leave& leave : leaves)
    if (here[leave.crossing].holder != Fleet::none) return here[leave.crossing].holder;
  return has_room(i, chain) ? i : find_ahead(i, chain.exit_m + numbers.look_m).vehicle;
}

}  // namespace cosiva::virtual_side
