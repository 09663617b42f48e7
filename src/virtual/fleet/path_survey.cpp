#include "cosiva/virtual/fleet/path_survey.h"

#include <algorithm>

#include "cosiva/aiv/motion/formulas.h"
#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {
namespace {

/// Rounding between a chain's exit and the next line.
constexpr double rounding_m = 1e-6;

}  // namespace

PathSurvey::PathSurvey(FleetTables& tables, const Paths& paths)
    : ground_{tables.ground}, numbers_{tables.numbers}, state_{tables.state}, paths_{paths} {}

void PathSurvey::survey(std::uint32_t i) {
  Paths::Path path = paths_.path_of(i);
  const double from_m =
      std::max(state_.s_m[i], state_.own[i].clear_at < 0.5 * far_m ? state_.own[i].clear_at - rounding_m : 0.0);
  const double own_length_m = ground_.length_m(path.section);
  double start_m = 0.0;
  double halt_m = state_.goal_at[i];
  double line_m = far_m;
  std::uint32_t chain = no_chain;
  double slow_key = 1e300;
  double slow_at = far_m;
  double slow_mps = 0.0;
  for (;;) {
    for (const Ground::Line& line : ground_.lines(path.section)) {
      if (start_m + line.at_m <= from_m || start_m + line.at_m > halt_m) continue;
      line_m = start_m + line.at_m;
      chain = match(line, path);
      break;
    }
    if (line_m < far_m) break;
    const double end_m = start_m + ground_.length_m(path.section);
    if (halt_m <= end_m || end_m - own_length_m > numbers_.sensed_m) break;
    const zone::SectionId to = paths_.next(path);
    if (to == zone::no_section || ground_.turn_rad(path.section, to) != 0.0) {
      halt_m = end_m;
      break;
    }
    start_m = end_m;
    Paths::advance(path, to);
    if (!numbers_.has_limits || ground_.limit_mps(to) >= far_m) continue;
    // The same one of two limits ahead governs up to the first: v² = l² + 2b·(d − l·t) for both.
    const double mps = ground_.limit_mps(to);
    const double key = mps * mps + 2.0 * numbers_.weakest_mps2 * (start_m - mps * aiv::reaction_s);
    if (key >= slow_key) continue;
    slow_key = key;
    slow_at = start_m;
    slow_mps = mps;
  }
  state_.line_at[i] = line_m;
  state_.own[i].line_chain = chain;
  state_.halt_at[i] = std::min(halt_m, line_m < far_m ? std::max(state_.s_m[i], line_m - aiv::stop_line_m) : far_m);
  state_.cap_mps[i] = state_.own[i].own_mps;
  if (numbers_.has_limits) {
    state_.cap_mps[i] = std::min(state_.own[i].own_mps, ground_.limit_mps(state_.section[i]));
    state_.slow_at[i] = slow_at;
    state_.slow_mps[i] = slow_mps;
  }
  set_event(i);
}

std::uint32_t PathSurvey::match(const Ground::Line& line, const Paths::Path& path) const {
  const std::uint32_t chain = find_chain(line, path);
  COSIVA_EXPECT(chain != no_chain);  // a vehicle is never sent along a route without a chain
  return chain;
}

std::uint32_t PathSurvey::find_chain(const Ground::Line& line, const Paths::Path& path) const {
  // The longest of several chains: if another crossing follows closely on one of two paths, its chain is longer. A
  // route that ends before the exit is continued by default successors: a vehicle that stayed there can continue along
  // them.
  std::uint32_t whole = no_chain;
  std::uint32_t part = no_chain;
  for (std::uint32_t c = line.first_chain; c < line.first_chain + line.chains; ++c) {
    Paths::Path on = path;
    bool same = true;
    bool ended = false;
    for (const zone::SectionId section : ground_.sections_of(ground_.chain(c)).subspan(1)) {
      zone::SectionId to = paths_.next(on);
      ended |= to == zone::no_section;
      if (ended) to = ground_.default_next(on.section);
      same = to == section;
      if (!same) break;
      Paths::advance(on, to);
    }
    std::uint32_t& best = ended ? part : whole;
    if (same && (best == no_chain || ground_.chain(c).exit_m > ground_.chain(best).exit_m)) best = c;
  }
  return whole != no_chain ? whole : part;
}

bool PathSurvey::has_chains(std::span<const zone::SectionId> route, double goal_s_m) const {
  if (!ground_.has_cuts()) return true;
  for (std::uint32_t k = 0; k < route.size(); ++k) {
    const double until_m = k + 1 == route.size() ? goal_s_m : ground_.length_m(route[k]);
    for (const Ground::Line& line : ground_.lines(route[k]))
      if (line.at_m <= until_m && find_chain(line, {route[k], k, route, true}) == no_chain) return false;
  }
  return true;
}

void PathSurvey::set_event(std::uint32_t i) {
  const zone::SectionId section = state_.section[i];
  double event_m = std::min(ground_.length_m(section), state_.own[i].release_at);
  const double parted_m = ground_.parted_m(section);
  if (state_.s_m[i] <= parted_m) event_m = std::min(event_m, parted_m);
  state_.event_at[i] = event_m;
}

}  // namespace cosiva::virtual_side
