#include "cosiva/zone/routing/route.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <queue>
#include <string>
#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::zone {
namespace {

// Two positions this near on one section are the same position, whichever is ahead by rounding.
constexpr double same_position_m = 1e-6;
constexpr double infinity = std::numeric_limits<double>::infinity();

std::vector<bool> marked(const Circuit& circuit, std::span<const SectionId> sections) {
  std::vector<bool> flags(circuit.size(), false);
  for (const SectionId id : sections) {
    COSIVA_EXPECT(id < circuit.size());
    flags[id] = true;
  }
  return flags;
}

/// The quickest routes from the end of one section to the starts of others. Invariant: sections are done in the order
/// of their times.
class Search {
 public:
  Search(const Router& router, const Circuit& circuit, const std::vector<bool>& closed)
      : router_{router}, circuit_{circuit}, closed_{closed}, reached_(circuit.size()) {}

  /// Continues until a section of `wanted` is reached: that section, or no_section.
  SectionId run(SectionId from, const std::vector<bool>& wanted);
  /// The sections after the first one, up to `to`.
  [[nodiscard]] std::vector<SectionId> route_to(SectionId to) const;
  [[nodiscard]] std::size_t reached_count() const { return count_; }
  [[nodiscard]] SectionId farthest() const { return farthest_; }

 private:
  struct Reached {
    double time_s{infinity};  ///< when its start is reached
    SectionId via{no_section};
    bool done{false};
  };
  void leave(SectionId from, double time_s, bool begins);

  const Router& router_;
  const Circuit& circuit_;
  const std::vector<bool>& closed_;
  std::vector<Reached> reached_;
  using Entry = std::pair<double, SectionId>;  // the lower section first among equals
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue_;
  std::size_t count_{0};
  double last_done_s_{0.0};
  SectionId farthest_{no_section};
};

void Search::leave(SectionId from, double time_s, bool begins) {
  for (const SectionId to : circuit_.next(from)) {
    if (closed_[to]) continue;
    Reached& there = reached_[to];
    const double at_s = time_s + router_.turn_time_s(from, to);
    const SectionId via = begins ? no_section : from;
    if (there.done || at_s > there.time_s || (at_s == there.time_s && via >= there.via)) continue;
    there.via = via;
    if (at_s == there.time_s) continue;
    there.time_s = at_s;
    queue_.emplace(at_s, to);
  }
}

SectionId Search::run(SectionId from, const std::vector<bool>& wanted) {
  leave(from, 0.0, true);
  while (!queue_.empty()) {
    const auto [time_s, id] = queue_.top();
    queue_.pop();
    if (reached_[id].done) continue;
    COSIVA_EXPECT(reached_[id].time_s >= last_done_s_);
    last_done_s_ = reached_[id].time_s;
    reached_[id].done = true;
    ++count_;
    farthest_ = id;
    if (wanted[id]) return id;
    leave(id, time_s + router_.section_time_s(id), false);
  }
  return no_section;
}

std::vector<SectionId> Search::route_to(SectionId to) const {
  std::vector<SectionId> back;
  for (SectionId id = to; id != no_section; id = reached_[id].via) back.push_back(id);
  std::reverse(back.begin(), back.end());
  return back;
}

std::string in_quotes(const Circuit& circuit, SectionId id) {
  std::string text = "'";
  return text.append(circuit.part(id).name).append("'");
}

/// The reason why no wanted section can be reached. `what` names the goal ("'dock'", "the loop 'outer'").
Error no_route(const Router& router, const Circuit& circuit, SectionId from, const std::vector<bool>& wanted,
               const std::vector<bool>& closed, const std::string& what) {
  const std::string start = in_quotes(circuit, from);
  const std::vector<bool> open(circuit.size(), false);
  Search all{router, circuit, open};
  const SectionId found = all.run(from, wanted);
  if (found != no_section) {
    // With all sections open, the closed ones on the quickest route are the obstacles.
    std::string names;
    for (const SectionId id : all.route_to(found)) {
      if (closed[id]) names.append(names.empty() ? "" : ", ").append(in_quotes(circuit, id));
    }
    return {"route.none",
            "every route from " + start + " to " + what + " leads over closed sections; the quickest over " + names +
                "; open one of them",
            circuit.part(from).name};
  }
  std::string text = "no route leads from " + start + " to " + what;
  if (all.reached_count() == 0)
    text += ": nothing follows " + start;
  else
    text += ": the routes from there reach " + std::to_string(all.reached_count()) + " sections, the last of them " +
            in_quotes(circuit, all.farthest());
  return {"route.none", text, circuit.part(from).name};
}

}  // namespace

Router::Router(const TrafficZone& zone) : zone_{&zone} {}

double Router::section_time_s(SectionId section) const {
  const Circuit::Part& part = zone_->circuit.part(section);
  const double fastest_mps = zone_->profiles.fast.speed_mps;
  return part.section.length_m() / std::min(part.speed_mps_max.value_or(fastest_mps), fastest_mps);
}

double Router::turn_time_s(SectionId from, SectionId to) const {
  return std::fabs(zone_->circuit.turn_at(from, to)) / pivot_rate_radps;
}

namespace {

/// Length and time of a route that begins and ends somewhere on its first and last section.
Route measured(const Router& router, const Circuit& circuit, std::vector<SectionId> sections, double from_m,
               double to_m) {
  Route route{std::move(sections), 0.0, 0.0};
  const auto add = [&](SectionId id, double low_m, double high_m) {
    const double length_m = circuit.section(id).length_m();
    const double part_m = std::clamp(high_m - low_m, 0.0, length_m);
    route.length_m += part_m;
    route.time_s += router.section_time_s(id) * (part_m / length_m);
  };
  const std::size_t last = route.sections.size() - 1;
  for (std::size_t i = 0; i <= last; ++i) {
    const SectionId id = route.sections[i];
    if (i > 0) route.time_s += router.turn_time_s(route.sections[i - 1], id);
    add(id, i == 0 ? from_m : 0.0, i == last ? to_m : circuit.section(id).length_m());
  }
  return route;
}

}  // namespace

Result<Route> Router::plan(TrackPosition from, TrackPosition goal, std::span<const SectionId> closed) const {
  const Circuit& circuit = zone_->circuit;
  COSIVA_EXPECT(from.section < circuit.size() && goal.section < circuit.size());
  if (from.section == goal.section && goal.s_m >= from.s_m - same_position_m)
    return measured(*this, circuit, {from.section}, from.s_m, goal.s_m);

  const std::vector<bool> closed_flags = marked(circuit, closed);
  if (closed_flags[goal.section]) {
    return fail("route.none", in_quotes(circuit, goal.section) + ", where the goal lies, is closed",
                circuit.part(goal.section).name);
  }
  const std::vector<bool> wanted = marked(circuit, {&goal.section, 1});
  Search search{*this, circuit, closed_flags};
  if (search.run(from.section, wanted) == no_section) {
    return tl::unexpected(
        no_route(*this, circuit, from.section, wanted, closed_flags, in_quotes(circuit, goal.section)));
  }
  std::vector<SectionId> sections = search.route_to(goal.section);
  sections.insert(sections.begin(), from.section);
  return measured(*this, circuit, std::move(sections), from.s_m, goal.s_m);
}

Result<Route> Router::plan(TrackPosition from, const Loop& loop, std::span<const SectionId> closed) const {
  const Circuit& circuit = zone_->circuit;
  COSIVA_EXPECT(from.section < circuit.size() && !loop.sections.empty());
  const std::vector<bool> closed_flags = marked(circuit, closed);
  const std::string what = "the loop '" + loop.name + "'";

  const auto index_of = [&](SectionId id) {
    return static_cast<std::size_t>(std::find(loop.sections.begin(), loop.sections.end(), id) - loop.sections.begin());
  };
  std::vector<SectionId> sections{from.section};
  /// On to the quickest of the wanted sections.
  const auto go_on = [&](const std::vector<bool>& wanted) -> Result<SectionId> {
    Search search{*this, circuit, closed_flags};
    const SectionId at = search.run(sections.back(), wanted);
    if (at == no_section) return tl::unexpected(no_route(*this, circuit, sections.back(), wanted, closed_flags, what));
    const auto found = search.route_to(at);
    sections.insert(sections.end(), found.begin(), found.end());
    return at;
  };

  std::size_t first = index_of(from.section);
  if (first == loop.sections.size()) {
    const auto joined = go_on(marked(circuit, loop.sections));
    if (!joined) return tl::unexpected(joined.error());
    first = index_of(*joined);
  }
  for (std::size_t i = 1; i < loop.sections.size(); ++i) {
    const SectionId id = loop.sections[(first + i) % loop.sections.size()];
    if (closed_flags[id]) continue;
    const auto next = circuit.next(sections.back());
    if (std::find(next.begin(), next.end(), id) != next.end()) {
      sections.push_back(id);
    } else if (const auto went = go_on(marked(circuit, {&id, 1})); !went) {
      return tl::unexpected(went.error());
    }
  }
  const double end_m = circuit.section(sections.back()).length_m();
  return measured(*this, circuit, std::move(sections), from.s_m, end_m);
}

/// A section that leads only to dead ends is one itself: such sections are removed, one after the other, until none is
/// left.
std::vector<bool> Router::goes_on_for_ever(std::span<const SectionId> closed) const {
  const Circuit& circuit = zone_->circuit;
  const std::vector<bool> closed_flags = marked(circuit, closed);
  std::vector<bool> alive(circuit.size(), true);
  std::vector<std::size_t> branches(circuit.size(), 0);
  std::vector<SectionId> dead;
  for (SectionId id = 0; id < circuit.size(); ++id) {
    for (const SectionId after : circuit.next(id)) branches[id] += closed_flags[after] ? 0U : 1U;
    if (branches[id] == 0) dead.push_back(id);
  }
  while (!dead.empty()) {
    const SectionId id = dead.back();
    dead.pop_back();
    alive[id] = false;
    if (closed_flags[id]) continue;  // no predecessor depends on entering it
    for (const SectionId before : circuit.previous(id)) {
      if (--branches[before] == 0) dead.push_back(before);
    }
  }
  return alive;
}

}  // namespace cosiva::zone
