#include "cosiva/virtual/fleet/fleet_orders.h"

#include <algorithm>

#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {

FleetOrders::FleetOrders(FleetTables& tables, const Paths& paths, Leaders& leaders, PathSurvey& survey,
                         CrossingGrants& grants, SectionChanges& changes)
    : ground_{tables.ground},
      numbers_{tables.numbers},
      state_{tables.state},
      front_{tables.front},
      routes_{tables.routes},
      commanded_vehicles_{tables.commanded_vehicles},
      paths_{paths},
      leaders_{leaders},
      survey_{survey},
      grants_{grants},
      changes_{changes} {}

bool FleetOrders::send(std::uint32_t i, std::span<const zone::SectionId> route, double goal_s_m) {
  if ((state_.mode[i] & Mode::absent) != 0) return false;
  if (route.empty() || !std::ranges::all_of(route, [&](zone::SectionId id) { return id < ground_.size(); }))
    return false;
  if (!(goal_s_m >= 0.0 && goal_s_m <= ground_.length_m(route.back()))) return false;
  double goal_m = goal_s_m;
  for (std::size_t k = 0; k + 1 < route.size(); ++k) {
    const auto branches = ground_.circuit().next(route[k]);
    if (std::ranges::find(branches, route[k + 1]) == branches.end()) return false;
    goal_m += ground_.length_m(route[k]);
  }
  if (!survey_.has_chains(route, goal_s_m)) return false;
  const auto kept = committed(i);
  const std::size_t common = std::min(kept.size(), route.size());
  if (!std::equal(kept.begin(), kept.begin() + static_cast<std::ptrdiff_t>(common), route.begin())) return false;
  // The vehicle must not stop before the end of crossings that it holds: no other vehicle could pass.
  if (goal_m < committed_m(i) || (kept.size() > route.size() && (state_.mode[i] & Mode::turning) != 0)) return false;
  if (!grants_.exchange_chain(i, route)) return false;

  take_route(i, route);
  routes_[state_.own[i].route].goal_s_m = goal_s_m;
  state_.goal_at[i] = goal_m;
  if ((state_.mode[i] & Mode::sent) == 0) ++commanded_vehicles_;
  state_.mode[i] = static_cast<std::uint8_t>((state_.mode[i] | Mode::sent) & ~(Mode::at_goal | Mode::commanded));
  if (state_.v_mps[i] == 0.0 && goal_m == state_.s_m[i]) state_.mode[i] |= Mode::commanded;
  follow_anew(i);
  return true;
}

void FleetOrders::circulate(std::uint32_t i) {
  if ((state_.mode[i] & (Mode::sent | Mode::absent)) != Mode::sent) return;
  // The vehicle still drives the sections that it is committed to; from there the default successors lead on.
  committed(i);
  state_.goal_at[i] = far_m;
  --commanded_vehicles_;
  state_.mode[i] &= static_cast<std::uint8_t>(~(Mode::sent | Mode::at_goal | Mode::commanded));
  take_route(i, committed_sections_);
  follow_anew(i);
}

std::span<const zone::SectionId> FleetOrders::committed(std::uint32_t i) {
  committed_sections_.clear();
  Paths::Path path = paths_.path_of(i);
  committed_sections_.push_back(path.section);
  const double until_m = std::min(committed_m(i), state_.goal_at[i]);
  double end_m = ground_.length_m(path.section);
  // A vehicle that turns on the spot turns towards the next section.
  bool more = (state_.mode[i] & Mode::turning) != 0;
  while (more || end_m < until_m) {
    const zone::SectionId to = paths_.next(path);
    if (to == zone::no_section) break;
    committed_sections_.push_back(to);
    end_m += ground_.length_m(to);
    Paths::advance(path, to);
    more = false;
  }
  return committed_sections_;
}

double FleetOrders::committed_m(std::uint32_t i) const {
  const double v = state_.v_mps[i];
  double until_m = state_.s_m[i];
  // With the weakest brakes and a generous reaction time: a step is decided from the state before it.
  if (v > 0.0) until_m += v * v / (2.0 * numbers_.weakest_mps2) + v * (numbers_.late_s + 2.0 * numbers_.dt_s);
  if (state_.own[i].held_chain != no_chain) until_m = std::max(until_m, state_.own[i].clear_at);
  return until_m;
}

void FleetOrders::take_route(std::uint32_t i, std::span<const zone::SectionId> route) {
  COSIVA_EXPECT(!route.empty() && route.front() == state_.section[i]);
  if (state_.own[i].route == Fleet::none) {
    state_.own[i].route = static_cast<std::uint32_t>(routes_.size());
    routes_.emplace_back();
  }
  routes_[state_.own[i].route].sections.assign(route.begin(), route.end());
  state_.own[i].route_step = 0;
}

void FleetOrders::follow_anew(std::uint32_t i) {
  if (front_[list_index(ground_, state_.own[i].copy, state_.section[i])] == i) leaders_.look_ahead(i);
  const std::uint32_t requested_for = state_.own[i].line_chain;
  survey_.survey(i);
  // At a sharp bend a vehicle turns; a vehicle already stopped at the bend gets no further event for this.
  const bool is_at_end = state_.v_mps[i] == 0.0 && state_.s_m[i] == ground_.length_m(state_.section[i]);
  if (numbers_.has_turns && is_at_end && state_.goal_at[i] > state_.s_m[i] && (state_.mode[i] & Mode::turning) == 0)
    changes_.begin_turn(i);
  if ((state_.mode[i] & Mode::requesting) == 0 || state_.own[i].line_chain == requested_for) return;
  grants_.withdraw(i);
}

}  // namespace cosiva::virtual_side
