#include "cosiva/virtual/fleet/crossing_grants.h"

#include <algorithm>
#include <limits>

#include "cosiva/aiv/decision/right_of_way.h"
#include "cosiva/aiv/motion/formulas.h"
#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {

CrossingGrants::CrossingGrants(FleetTables& tables, Leaders& leaders, PathSurvey& survey)
    : ground_{tables.ground},
      options_{tables.options},
      numbers_{tables.numbers},
      state_{tables.state},
      copies_{tables.copies},
      crossings_{tables.crossings},
      leaders_{leaders},
      survey_{survey},
      overtaken_after_steps_{static_cast<std::uint32_t>(
          std::clamp<std::int64_t>((options_.overtaken_at_most + options_.step - SimDuration{1}) / options_.step, 0,
                                   std::numeric_limits<std::int32_t>::max()))} {}

void CrossingGrants::request(const Block& block, std::uint32_t i) {
  const Own& own = state_.own[i];
  if (own.held_chain != no_chain) return;  // one chain after the other
  // A vehicle with another vehicle between itself and the line is not the next one.
  if (state_.leader[i] != i && state_.offset_m[i] + state_.s_m[state_.leader[i]] < state_.line_at[i]) return;
  Copy& copy = copies_[own.copy];
  state_.queue[copy.first + copy.waiting++] = {i, block.now, own.line_chain, own.priority};
  recheck(copy);
  state_.mode[i] |= Mode::requesting;
}

void CrossingGrants::withdraw(std::uint32_t i) {
  if ((state_.mode[i] & Mode::requesting) == 0) return;
  Copy& copy = copies_[state_.own[i].copy];
  const auto all = waiting(state_.own[i].copy);
  const auto mine = std::ranges::find(all, i, &Waiting::vehicle);
  std::copy(mine + 1, all.end(), mine);
  --copy.waiting;
  recheck(copy);
  state_.mode[i] &= static_cast<std::uint8_t>(~Mode::requesting);
}

void CrossingGrants::release(std::uint32_t i) {
  const Ground::Chain& chain = ground_.chain(state_.own[i].held_chain);
  const auto leaves = ground_.leaves_of(chain);
  const std::size_t crossing = leaves[state_.own[i].held_next].crossing;
  CrossingState& left = crossings_[std::size_t{state_.own[i].copy} * ground_.zone().crossings.size() + crossing];
  left.holder = Fleet::none;
  copies_[state_.own[i].copy].due_step = 0;
  ++state_.own[i].held_next;
  if (state_.own[i].held_next < leaves.size()) {
    state_.own[i].release_at = state_.own[i].chain_at + leaves[state_.own[i].held_next].at_m + Ground::left_m;
    return;
  }
  clear_hold(i);
}

void CrossingGrants::clear_hold(std::uint32_t i) {
  state_.own[i].held_chain = no_chain;
  state_.own[i].release_at = far_m;
  state_.own[i].clear_at = far_m;
  state_.own[i].chain_at = far_m;
}

void CrossingGrants::grant_due(Block& block, std::uint32_t index) {
  Copy& copy = copies_[index];
  if (copy.sort_step <= block.now) sort_waiting(copy, waiting(index), block.now);
  const std::uint32_t sort_step = copy.sort_step;
  ++block.pass;
  CrossingState* const here = crossings_.data() + std::size_t{index} * ground_.zone().crossings.size();
  bool lacks_room = false;
  for (std::size_t k = 0; k < copy.waiting;) {
    const Waiting& one = waiting(index)[k];
    const Ground::Chain& chain = ground_.chain(one.chain);
    // A vehicle without room beyond the chain could not use its turn: the vehicle keeps the turn and lets others pass.
    if (!has_room(one.vehicle, chain)) {
      lacks_room = true;
      ++k;
      continue;
    }
    const auto leaves = ground_.leaves_of(chain);
    const bool is_open = std::ranges::all_of(leaves, [&](const Ground::Leave& leave) {
      const CrossingState& crossing = here[leave.crossing];
      return crossing.holder == Fleet::none && crossing.claimed_pass != block.pass;
    });
    if (is_open) {
      grant(block, one.vehicle, block.now - one.requested_step);  // the next request is at index k now
      continue;
    }
    for (const Ground::Leave& leave : leaves) here[leave.crossing].claimed_pass = block.pass;
    ++k;
  }
  // The leader of a vehicle that lacks room may move on at any time. The only other changes are a crossing left, a new
  // request, or a vehicle that has waited long enough.
  copy.due_step = lacks_room ? block.now : sort_step;
  copy.sort_step = sort_step;
}

void CrossingGrants::set_priority(std::uint32_t i, std::int16_t priority) {
  Own& own = state_.own[i];
  own.priority = priority;
  for (Waiting& one : waiting(own.copy))
    if (one.vehicle == i) one.priority = priority;
  recheck(copies_[own.copy]);
}

bool CrossingGrants::exchange_chain(std::uint32_t i, std::span<const zone::SectionId> route) {
  Own& own = state_.own[i];
  if (own.held_chain == no_chain) return true;
  const auto held = ground_.sections_of(ground_.chain(own.held_chain));
  double start_m = own.chain_at;
  std::vector<zone::SectionId> along;
  for (std::size_t k = 0; k < held.size() && start_m < -1e-6; start_m += ground_.length_m(held[k++]))
    along.push_back(held[k]);
  if (start_m > 1e-6) return true;  // the chain begins on a later section
  along.insert(along.end(), route.begin(), route.end());
  const auto lines = ground_.lines(along.front());
  const auto line = std::ranges::find_if(lines, [&](const Ground::Line& one) {
    return own.held_chain >= one.first_chain && own.held_chain < one.first_chain + one.chains;
  });
  const std::uint32_t wanted =
      line == lines.end() ? no_chain : survey_.find_chain(*line, {along.front(), 0, along, true});
  if (wanted == own.held_chain || wanted == no_chain) return wanted != no_chain;

  CrossingState* const here = crossings_.data() + std::size_t{own.copy} * ground_.zone().crossings.size();
  const auto leaves = ground_.leaves_of(ground_.chain(wanted));
  // Crossings behind the vehicle belong to others.
  std::uint16_t to_come = 0;
  while (to_come < leaves.size() && own.chain_at + leaves[to_come].at_m + Ground::left_m < state_.s_m[i]) ++to_come;
  for (const Ground::Leave& leave : leaves.subspan(to_come))
    if (here[leave.crossing].holder != Fleet::none && here[leave.crossing].holder != i) return false;
  for (const Ground::Leave& leave : ground_.leaves_of(ground_.chain(own.held_chain)).subspan(own.held_next))
    here[leave.crossing].holder = Fleet::none;
  own.held_next = to_come;
  if (to_come == leaves.size()) {  // on this route the vehicle has passed all of them
    clear_hold(i);
    recheck(copies_[own.copy]);
    return true;
  }
  for (const Ground::Leave& leave : leaves.subspan(own.held_next)) here[leave.crossing].holder = i;
  own.held_chain = wanted;
  own.release_at = own.chain_at + leaves[own.held_next].at_m + Ground::left_m;
  own.clear_at = own.chain_at + ground_.chain(wanted).exit_m;
  recheck(copies_[own.copy]);
  return true;
}

std::size_t CrossingGrants::stuck() const {
  const auto count = static_cast<std::uint32_t>(state_.s_m.size());
  // Each vehicle waits for at most one other: a walk along these that meets itself has found a cycle.
  std::vector<std::uint32_t> walk(count, 0);
  std::size_t in_circles = 0;
  for (std::uint32_t start = 0; start < count; ++start) {
    std::uint32_t i = start;
    while (walk[i] == 0) {
      walk[i] = start + 1;
      const std::uint32_t to = blocker_of(i);
      if (to == i) break;
      i = to;
      if (walk[i] != start + 1) continue;
      std::uint32_t round = i;
      do {
        ++in_circles;
        round = blocker_of(round);
      } while (round != i);
    }
  }
  return in_circles;
}

void CrossingGrants::recheck(Copy& copy) {
  copy.due_step = 0;
  copy.sort_step = 0;
}

std::span<Waiting> CrossingGrants::waiting(std::uint32_t copy) {
  return std::span(state_.queue).subspan(copies_[copy].first, copies_[copy].waiting);
}

void CrossingGrants::sort_waiting(Copy& copy, std::span<Waiting> all, std::uint32_t now) {
  // Insertion sort: the queue is nearly always in order.
  for (std::size_t k = 1; k < all.size(); ++k) {
    const Waiting self = all[k];
    std::size_t to = k;
    for (; to > 0 && !goes_before(all[to - 1], self, now); --to) all[to] = all[to - 1];
    all[to] = self;
  }
  copy.sort_step = std::numeric_limits<std::uint32_t>::max();
  for (const Waiting& one : all) {
    const std::uint32_t overtaken_no_more = one.requested_step + overtaken_after_steps_;
    if (overtaken_no_more > now) copy.sort_step = std::min(copy.sort_step, overtaken_no_more);
  }
}

bool CrossingGrants::goes_before(const Waiting& a, const Waiting& b, std::uint32_t now) const {
  const auto claim = [&](const Waiting& one) {
    return aiv::Claim{one.priority, options_.step * (now - one.requested_step)};
  };
  const bool a_came_first =
      a.requested_step != b.requested_step ? a.requested_step < b.requested_step : a.vehicle < b.vehicle;
  if (a_came_first) return aiv::keeps_its_turn(claim(a), claim(b), options_.overtaken_at_most);
  return !aiv::keeps_its_turn(claim(b), claim(a), options_.overtaken_at_most);
}

bool CrossingGrants::has_room(std::uint32_t i, const Ground::Chain& chain) const {
  const double exit_m = state_.line_at[i] - chain.entry_m + chain.exit_m;
  // A vehicle whose goal is in the crossing needs no room beyond.
  if ((state_.mode[i] & Mode::sent) != 0 && state_.goal_at[i] <= exit_m) return true;
  // The rear of the vehicle ahead must leave room to drive out of the crossing.
  const double need_m = exit_m + numbers_.length_m + gap_needed_m;
  Leaders::Found ahead{state_.leader[i], state_.offset_m[i]};
  const double own_m = ground_.length_m(state_.section[i]);
  if (ahead.vehicle == i && need_m > own_m + numbers_.sensed_m) ahead = leaders_.find_ahead(i, need_m - own_m);
  return ahead.vehicle == i || ahead.offset_m + state_.s_m[ahead.vehicle] >= need_m;
}

void CrossingGrants::grant(Block& block, std::uint32_t i, std::uint32_t waited) {
  const std::uint32_t index = state_.own[i].line_chain;
  const Ground::Chain& chain = ground_.chain(index);
  const auto leaves = ground_.leaves_of(chain);
  const std::size_t first = std::size_t{state_.own[i].copy} * ground_.zone().crossings.size();
  for (const Ground::Leave& leave : leaves) {
    COSIVA_EXPECT(crossings_[first + leave.crossing].holder == Fleet::none);
    crossings_[first + leave.crossing].holder = i;
    ++block.grants[leave.crossing];
    block.waited_steps[leave.crossing] += waited;
  }
  state_.own[i].held_chain = index;
  state_.own[i].held_next = 0;
  state_.own[i].chain_at = state_.line_at[i] - chain.entry_m;
  state_.own[i].release_at = state_.own[i].chain_at + leaves.front().at_m + Ground::left_m;
  state_.own[i].clear_at = state_.own[i].chain_at + chain.exit_m;
  withdraw(i);
  survey_.survey(i);
}

std::uint32_t CrossingGrants::blocker_of(std::uint32_t i) const {
  const bool is_stopped = state_.v_mps[i] < aiv::stopped_mps && (state_.mode[i] & (Mode::turning | Mode::at_goal)) == 0;
  if (!is_stopped) return i;
  const std::uint32_t leader = state_.leader[i];
  const double gap_m = leaders_.gap_m(i);
  constexpr double near_m = 0.05;
  if (leader != i && gap_m < aiv::clearance_m + near_m) return leader;
  if ((state_.mode[i] & Mode::requesting) == 0) return i;
  const Ground::Chain& chain = ground_.chain(state_.own[i].line_chain);
  const auto leaves = ground_.leaves_of(chain);
  const CrossingState* const here =
      crossings_.data() + std::size_t{state_.own[i].copy} * ground_.zone().crossings.size();
  for (const Ground::Leave& leave : leaves)
    if (here[leave.crossing].holder != Fleet::none) return here[leave.crossing].holder;
  return has_room(i, chain) ? i : leaders_.find_ahead(i, chain.exit_m + numbers_.sensed_m).vehicle;
}

}  // namespace cosiva::virtual_side
