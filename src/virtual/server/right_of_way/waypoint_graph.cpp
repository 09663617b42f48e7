#include "cosiva/virtual/server/right_of_way/waypoint_graph.h"

#include <algorithm>
#include <utility>

#include "cosiva/base/expect.h"
#include "cosiva/zone/circuit/course.h"

namespace cosiva::virtual_side {
namespace {

constexpr double entered_m = 0.04;
constexpr double left_m = 0.01;
constexpr double late_m = 0.02;  ///< a vehicle this far into a span stopped late in front of the span
constexpr double overshoot_m = 0.25;
constexpr double at_node_m = 0.05;  ///< a vehicle nearer than this to a waypoint is on the waypoint
/// Limit of the sections without a waypoint that are searched; only a malicious file has more.
constexpr std::size_t searched_max = 4096;

void add_once(std::vector<CrossingIndex>& out, CrossingIndex crossing) {
  if (std::ranges::find(out, crossing) == out.end()) out.push_back(crossing);
}

void slower(std::optional<double>& limit, const std::optional<double>& other) {
  if (other) limit = limit ? std::min(*limit, *other) : *other;
}

}  // namespace

WaypointGraph::WaypointGraph(std::shared_ptr<const zone::TrafficZone> zone) : zone_{std::move(zone)} {
  spans_.resize(zone_->circuit.size());
  for (CrossingIndex i = 0; i < zone_->crossings.size(); ++i)
    for (const zone::CrossingSpan& span : zone_->crossings[i].spans)
      spans_[span.section].push_back({span.from_m, span.to_m, i});
  for (auto& spans : spans_) std::ranges::stable_sort(spans, {}, &Span::from_m);
  WaypointIndex at = 0;
  for (zone::SectionId section = 0; section <= zone_->circuit.size(); ++section) {
    while (at < zone_->waypoints.size() && zone_->waypoints[at].position.section < section) ++at;
    first_on_.push_back(at);
  }
  COSIVA_EXPECT(at == zone_->waypoints.size());
  lay_stretches();
}

bool WaypointGraph::take(std::shared_ptr<const zone::TrafficZone> zone) {
  const auto same_waypoint = [](const zone::Waypoint& a, const zone::Waypoint& b) {
    return a.id == b.id && a.position == b.position;
  };
  const auto same_crossing = [](const zone::Crossing& a, const zone::Crossing& b) {
    return a.name == b.name && std::ranges::equal(a.spans, b.spans, [](const auto& x, const auto& y) {
             return x.section == y.section && x.from_m == y.from_m && x.to_m == y.to_m;
           });
  };
  if (zone->name != zone_->name || !std::ranges::equal(zone->waypoints, zone_->waypoints, same_waypoint) ||
      !std::ranges::equal(zone->crossings, zone_->crossings, same_crossing))
    return false;
  zone_ = std::move(zone);
  COSIVA_EXPECT(points_.size() == zone_->waypoints.size());
  return true;
}

WaypointIndex WaypointGraph::first_on(zone::SectionId section) const {
  return first_on_[section] < first_on_[section + 1] ? first_on_[section] : no_waypoint;
}

void WaypointGraph::lay_stretches() {
  for (WaypointIndex i = 0; i < zone_->waypoints.size(); ++i) {
    const zone::Waypoint& from = zone_->waypoints[i];
    points_.push_back(position(zone_->circuit.pose_at(from.position)));
    by_id_[from.id].push_back(i);
    first_stretch_.push_back(stretches_.size());
    lay_stretches_from(i);
    for (std::size_t s = first_stretch_.back(); s < stretches_.size(); ++s) {
      finish(i, stretches_[s]);
      longest_m_ = std::max(longest_m_, stretches_[s].length_m);
    }
    const auto first = stretches_.begin() + static_cast<std::ptrdiff_t>(first_stretch_.back());
    const auto usual = std::find_if(first, stretches_.end(), [&](const Stretch& s) { return is_default(i, s); });
    if (usual != stretches_.end()) std::rotate(first, usual, usual + 1);
  }
  first_stretch_.push_back(stretches_.size());
}

void WaypointGraph::lay_stretches_from(WaypointIndex from) {
  const zone::Circuit& circuit = zone_->circuit;
  const zone::TrackPosition start = waypoint(from).position;
  if (from + 1 < first_on_[start.section + 1]) {
    stretches_.push_back({from + 1, waypoint(from + 1).position.s_m - start.s_m, {}, false, {}, {}});
    return;
  }
  // Each section is reached once, by the shortest route: an order names nodes, and the shortest route between two nodes
  // is the intended one.
  struct Reached {
    zone::SectionId section;
    double start_m;
    std::size_t via;
    bool done;
  };
  constexpr auto beginning = std::numeric_limits<std::size_t>::max();
  std::vector<Reached> reached;
  const auto reach = [&](zone::SectionId section, double start_m, std::size_t via) {
    const auto known = std::ranges::find(reached, section, &Reached::section);
    if (known == reached.end() && reached.size() < searched_max)
      reached.push_back({section, start_m, via, false});
    else if (known != reached.end() && !known->done && start_m < known->start_m)
      *known = {section, start_m, via, false};
  };
  for (const zone::SectionId after : circuit.next(start.section))
    reach(after, circuit.section(start.section).length_m() - start.s_m, beginning);
  for (;;) {
    std::size_t best = beginning;
    for (std::size_t i = 0; i < reached.size(); ++i)
      if (!reached[i].done && (best == beginning || reached[i].start_m < reached[best].start_m)) best = i;
    if (best == beginning) return;
    reached[best].done = true;
    const Reached here = reached[best];
    const WaypointIndex to = first_on(here.section);
    if (to == no_waypoint) {
      for (const zone::SectionId after : circuit.next(here.section))
        reach(after, here.start_m + circuit.section(here.section).length_m(), best);
      continue;
    }
    Stretch stretch{to, here.start_m + waypoint(to).position.s_m, {}, false, {}, {}};
    for (std::size_t at = best; at != beginning; at = reached[at].via) stretch.sections.push_back(reached[at].section);
    std::ranges::reverse(stretch.sections);
    stretches_.push_back(std::move(stretch));
  }
}

void WaypointGraph::finish(WaypointIndex from, Stretch& stretch) const {
  const zone::Circuit& circuit = zone_->circuit;
  const zone::Waypoint& start = waypoint(from);
  const zone::Waypoint& end = waypoint(stretch.to);
  stretch.speed_mps_max = circuit.part(start.position.section).speed_mps_max;
  for (const zone::SectionId section : stretch.sections)
    if (section != end.position.section || end.position.s_m > 0.0)
      slower(stretch.speed_mps_max, circuit.part(section).speed_mps_max);
  std::vector<CrossingIndex> met;
  crossings_on(start.position, stretch.length_m, met, stretch.sections);
  stretch.crosses = !met.empty();
  const double section_m = circuit.section(start.position.section).length_m();
  const double end_s_m = stretch.sections.empty() ? end.position.s_m : section_m;
  const bool whole = start.position.s_m == 0.0 && end_s_m == section_m &&
                     (stretch.sections.empty() || (stretch.sections.size() == 1 && end.position.s_m == 0.0));
  stretch.edge_id = zone_->edges_are_sections && whole ? circuit.part(start.position.section).name : start.id;
  if (!zone_->edges_are_sections || !whole) stretch.edge_id += "-" + end.id;
}

bool WaypointGraph::is_default(WaypointIndex from, const Stretch& stretch) const {
  zone::SectionLookAhead usual{zone_->circuit, waypoint(from).position.section, {}};
  return std::ranges::all_of(stretch.sections,
                             [&](zone::SectionId section) { return usual.step() && usual.section() == section; });
}

const WaypointGraph::Stretch* WaypointGraph::along(WaypointIndex from, Sections remaining) const {
  for (const Stretch& stretch : stretches(from)) {
    const std::size_t known = std::min(remaining.size(), stretch.sections.size());
    if (std::ranges::equal(remaining.first(known), Sections{stretch.sections}.first(known))) return &stretch;
  }
  return nullptr;
}

const WaypointGraph::Stretch& WaypointGraph::stretch(WaypointIndex from) const {
  static const Stretch none;
  const auto all = stretches(from);
  return all.empty() ? none : all.front();
}

WaypointGraph::Chain WaypointGraph::chain(WaypointIndex stop, Sections remaining, WaypointIndex goal) const {
  Chain chain;
  Chain first;
  WaypointIndex at = stop;
  std::size_t passed = 0;
  // Waypoints exist only where a vehicle may stop. Consecutive stretches without a free one between them are one chain.
  for (std::size_t steps = 0; steps < chain_max; ++steps) {
    const Stretch* next = along(at, remaining.subspan(std::min(passed, remaining.size())));
    if (next == nullptr || !next->crosses || (steps > 0 && next->to == stop)) return chain;
    chain.exit = next->to;
    chain.length_m += next->length_m;
    if (steps == 0) first = chain;
    passed += next->sections.size();
    at = next->to;
    if (at == goal && passed >= remaining.size()) return chain;
  }
  // Where every path crosses another there is no position to stop at; then vehicles drive from node to node.
  return first;
}

std::span<const WaypointIndex> WaypointGraph::find(std::string_view id) const {
  const auto it = by_id_.find(id);
  return it == by_id_.end() ? std::span<const WaypointIndex>{} : std::span{it->second};
}

std::optional<WaypointGraph::Behind> WaypointGraph::behind(zone::TrackPosition track_position,
                                                           Sections traversed) const {
  Behind found{no_waypoint, 0.0, {}};
  zone::SectionId section = track_position.section;
  double at_m = track_position.s_m;
  for (std::size_t steps = 0; steps <= zone_->circuit.size(); ++steps) {
    for (WaypointIndex i = first_on_[section + 1]; i > first_on_[section]; --i) {
      if (waypoint(i - 1).position.s_m > at_m + 1e-9) continue;
      found.waypoint = i - 1;
      found.since_m += at_m - waypoint(i - 1).position.s_m;
      std::ranges::reverse(found.sections);
      return found;
    }
    const auto previous = zone_->circuit.previous(section);
    if (traversed.empty() && previous.empty()) return std::nullopt;
    found.sections.push_back(section);
    found.since_m += at_m;
    section = traversed.empty() ? previous.front() : traversed.back();
    if (!traversed.empty()) traversed = traversed.first(traversed.size() - 1);
    at_m = zone_->circuit.section(section).length_m();
  }
  return std::nullopt;
}

std::optional<WaypointGraph::FirstAhead> WaypointGraph::first_ahead(zone::TrackPosition track_position,
                                                                    Sections remaining) const {
  for (WaypointIndex i = first_on_[track_position.section]; i < first_on_[track_position.section + 1]; ++i)
    if (waypoint(i).position.s_m >= track_position.s_m)
      return FirstAhead{i, waypoint(i).position.s_m - track_position.s_m, 0};
  double travelled_m = zone_->circuit.section(track_position.section).length_m() - track_position.s_m;
  for (std::size_t i = 0; i < remaining.size(); ++i) {
    if (const WaypointIndex first = first_on(remaining[i]); first != no_waypoint)
      return FirstAhead{first, travelled_m + waypoint(first).position.s_m, i + 1};
    travelled_m += zone_->circuit.section(remaining[i]).length_m();
  }
  return std::nullopt;
}

std::vector<zone::TrackPosition> WaypointGraph::starts(zone::TrackPosition track_position) const {
  std::vector<zone::TrackPosition> found{track_position};
  if (track_position.s_m > at_node_m) return found;
  const WaypointIndex here = first_on(track_position.section);
  if (here == no_waypoint || waypoint(here).position.s_m > 0.0) return found;
  const auto reached_by = zone_->circuit.previous(track_position.section);
  for (const WaypointIndex sibling : find(waypoint(here).id)) {
    const zone::TrackPosition start = waypoint(sibling).position;
    if (start.section == track_position.section || start.s_m > 0.0) continue;
    const auto ratios = [&](zone::SectionId before) {
      return std::ranges::find(reached_by, before) != reached_by.end();
    };
    const auto before = zone_->circuit.previous(start.section);
    if (std::ranges::any_of(before, ratios) || (before.empty() && reached_by.empty())) found.push_back(start);
  }
  return found;
}

WaypointIndex WaypointGraph::sibling_on(WaypointIndex of, zone::SectionId section) const {
  for (const WaypointIndex sibling : find(waypoint(of).id)) {
    const zone::TrackPosition& track_position = waypoint(sibling).position;
    if (track_position.section == section && track_position.s_m == 0.0) return sibling;
  }
  return no_waypoint;
}

std::optional<double> WaypointGraph::base_left(zone::TrackPosition track_position, WaypointIndex end, double limit_m,
                                               Sections remaining, bool passed) const {
  const zone::TrackPosition end_position = waypoint(end).position;
  if (!passed) {
    // On a short loop, a position just behind the vehicle may also be at the end of its path.
    if (const auto ahead_m = ahead(track_position, end_position, limit_m, remaining)) return ahead_m;
  }
  if (zone_->circuit.shortest_route(end_position, track_position, overshoot_m)) return 0.0;
  return passed ? ahead(track_position, end_position, limit_m, remaining) : std::nullopt;
}

std::optional<WaypointGraph::Through> WaypointGraph::through(zone::TrackPosition track_position,
                                                             std::span<const std::string_view> ids,
                                                             std::size_t released) const {
  // The next id determines which of an id's waypoints is meant: all of them are followed.
  struct Trail {
    WaypointIndex at;
    Through through;
  };
  constexpr std::size_t trails_max = 64;
  std::vector<Trail> trails;
  const auto record_end = [&](Trail& trail, std::size_t reached) {
    if (reached != released) return;
    trail.through.end = trail.at;
    trail.through.to_end = trail.through.sections.size();
  };
  for (std::size_t i = 0; i < ids.size(); ++i) {
    std::vector<Trail> on;
    if (i == 0) {
      for (const WaypointIndex first : find(ids[0])) {
        const zone::TrackPosition there = waypoint(first).position;
        if (zone_->circuit.shortest_route(there, track_position, overshoot_m))
          on.push_back({first, {{track_position.section}, no_waypoint, 0}});
        else if (auto start = zone_->circuit.shortest_route(track_position, there, longest_m_ + overshoot_m))
          on.push_back({first, {std::move(start->sections), no_waypoint, 0}});
      }
    }
    for (const Trail& trail : trails) {
      for (const Stretch& stretch : stretches(trail.at)) {
        if (waypoint(stretch.to).id != ids[i] || on.size() >= trails_max) continue;
        Trail further{stretch.to, trail.through};
        further.through.sections.insert(further.through.sections.end(), stretch.sections.begin(),
                                        stretch.sections.end());
        on.push_back(std::move(further));
      }
    }
    if (on.empty()) {
      // The horizon may lead to nodes unknown to this zone; the base must not.
      if (i < released) return std::nullopt;
      break;
    }
    for (Trail& trail : on) record_end(trail, i + 1);
    trails = std::move(on);
  }
  if (trails.empty()) return std::nullopt;
  return std::move(trails.front().through);
}

void WaypointGraph::spans_on(zone::SectionId section, double from_m, double to_m, bool stopped,
                             std::vector<CrossingIndex>& out) const {
  for (const Span& span : spans_[section]) {
    const bool met = span.from_m < to_m - 1e-6 && span.to_m > from_m;
    const bool in = stopped && span.from_m + entered_m < from_m + left_m && span.to_m > from_m;
    if (met || in) add_once(out, span.crossing);
  }
}

void WaypointGraph::crossings_on(zone::TrackPosition track_position, double distance_m, std::vector<CrossingIndex>& out,
                                 Sections remaining) const {
  const zone::Circuit& circuit = zone_->circuit;
  double from_m = track_position.s_m - left_m;
  double rest_m = distance_m;
  // A crossing that was left just behind the joint of two sections still counts for its 2 cm.
  if (from_m < 0.0) {
    for (const zone::SectionId before : circuit.previous(track_position.section)) {
      const double end_m = circuit.section(before).length_m();
      spans_on(before, end_m + from_m, end_m, true, out);
    }
  }
  double at_m = track_position.s_m;
  zone::SectionLookAhead ahead{circuit, track_position.section, remaining};
  for (std::size_t steps = 0; steps <= remaining.size() + circuit.size(); ++steps) {
    const bool first = steps == 0;
    const double end_m = circuit.section(ahead.section()).length_m();
    const double reach_m = std::min(end_m, at_m + rest_m);
    // Without a remaining distance, only the crossings that the vehicle is in count.
    spans_on(ahead.section(), first ? from_m : at_m, rest_m > 0.0 ? reach_m : at_m - late_m, first, out);
    rest_m -= end_m - at_m;
    if (rest_m <= 0.0 || !ahead.step()) return;
    at_m = 0.0;
  }
}

double WaypointGraph::distance_to_exit_m(zone::TrackPosition track_position, CrossingIndex crossing, double distance_m,
                                         Sections remaining) const {
  double out_m = 0.0;
  double start_m = -track_position.s_m;
  zone::SectionLookAhead ahead{zone_->circuit, track_position.section, remaining};
  for (std::size_t steps = 0; steps <= remaining.size() + zone_->circuit.size() && start_m < distance_m; ++steps) {
    for (const Span& span : spans_[ahead.section()])
      if (span.crossing == crossing && start_m + span.from_m < distance_m)
        out_m = std::max(out_m, start_m + span.to_m + left_m);
    start_m += zone_->circuit.section(ahead.section()).length_m();
    if (!ahead.step()) break;
  }
  return out_m;
}

double WaypointGraph::parted_m(zone::SectionId section) const {
  double parted = 0.5 * zone_->vehicle.length_m;
  for (const Span& span : spans_[section])
    if (span.from_m <= left_m) parted = std::max(parted, span.to_m + left_m);
  return parted;
}

}  // namespace cosiva::virtual_side
