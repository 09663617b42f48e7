#include "virtual/server/way_map.h"

#include <algorithm>
#include <utility>

namespace cosiva::virtual_side {
namespace {

constexpr double entered_m = 0.04;
constexpr double left_m = 0.02;
constexpr double overshoot_m = 0.25;

void add_once(std::vector<CrossingIndex>& out, CrossingIndex crossing) {
  if (std::ranges::find(out, crossing) == out.end()) out.push_back(crossing);
}

}  // namespace

WayMap::WayMap(std::shared_ptr<const zone::TrafficZone> zone) : zone_{std::move(zone)} {
  spans_.resize(zone_->circuit.size());
  for (CrossingIndex i = 0; i < zone_->crossings.size(); ++i)
    for (const zone::CrossingSpan& span : zone_->crossings[i].spans)
      spans_[span.section].push_back({span.from_m, span.to_m, i});
  for (auto& spans : spans_) std::ranges::stable_sort(spans, {}, &Span::from_m);
  lay_stretches();
  lay_chains();
}

bool WayMap::take(std::shared_ptr<const zone::TrafficZone> zone) {
  const auto same_waypoint = [](const zone::Waypoint& a, const zone::Waypoint& b) {
    return a.id == b.id && a.place == b.place;
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
  return true;
}

void WayMap::lay_stretches() {
  const zone::Circuit& circuit = zone_->circuit;
  std::vector<CrossingIndex> met;
  for (WaypointIndex i = 0; i < zone_->waypoints.size(); ++i) {
    const zone::Waypoint& from = zone_->waypoints[i];
    points_.push_back(position(circuit.pose_at(from.place)));
    by_id_.emplace(from.id, i);
    Stretch stretch;
    stretch.speed_mps_max = circuit.part(from.place.section).speed_mps_max;
    const std::size_t next = zone_->next_waypoint(i);
    if (next < zone_->waypoints.size()) {
      const zone::Waypoint& to = zone_->waypoints[next];
      // A ring with a single waypoint leads back to itself, the long way.
      const double length_m =
          next == i ? circuit.total_length_m()
                    : circuit.distance_ahead(from.place, to.place, circuit.total_length_m() + 1.0).value_or(0.0);
      stretch.to = static_cast<WaypointIndex>(next);
      stretch.length_m = length_m;
      stretch.edge_id = from.id + "-" + to.id;
      if (const auto& limit = circuit.part(to.place.section).speed_mps_max; limit && to.place.s_m > 0.0)
        stretch.speed_mps_max = stretch.speed_mps_max ? std::min(*stretch.speed_mps_max, *limit) : *limit;
      met.clear();
      crossings_on(from.place, length_m, met);
      stretch.crosses = !met.empty();
    }
    stretches_.push_back(std::move(stretch));
  }
}

void WayMap::lay_chains() {
  for (WaypointIndex i = 0; i < stretches_.size(); ++i) {
    Stretch& first = stretches_[i];
    if (!first.crosses) continue;
    first.chain_exit = first.to;
    first.chain_m = first.length_m;
    // Waypoints are laid only where one may stand. Stretches that follow without a free one between them are one chain.
    for (std::size_t steps = 0; steps < stretches_.size(); ++steps) {
      const Stretch& following = stretches_[first.chain_exit];
      if (!following.crosses || following.to == no_waypoint || following.to == i) break;
      first.chain_exit = following.to;
      first.chain_m += following.length_m;
    }
  }
}

std::optional<WaypointIndex> WayMap::find(std::string_view id) const {
  const auto it = by_id_.find(id);
  if (it == by_id_.end()) return std::nullopt;
  return it->second;
}

WaypointIndex WayMap::behind(zone::Place place) const {
  const std::size_t index = zone_->waypoint_behind(place);
  return index < zone_->waypoints.size() ? static_cast<WaypointIndex>(index) : no_waypoint;
}

std::optional<double> WayMap::base_left(zone::Place place, WaypointIndex end, double limit_m) const {
  const zone::Place end_place = waypoint(end).place;
  if (ahead(end_place, place, overshoot_m)) return 0.0;
  return ahead(place, end_place, limit_m);
}

void WayMap::spans_on(zone::SectionId section, double from_m, double to_m, bool standing,
                      std::vector<CrossingIndex>& out) const {
  for (const Span& span : spans_[section]) {
    const bool met = span.from_m < to_m - 1e-6 && span.to_m > from_m;
    const bool in = standing && span.from_m + entered_m < from_m + left_m && span.to_m > from_m;
    if (met || in) add_once(out, span.crossing);
  }
}

void WayMap::crossings_on(zone::Place place, double distance_m, std::vector<CrossingIndex>& out) const {
  const zone::Circuit& circuit = zone_->circuit;
  zone::SectionId section = place.section;
  double from_m = place.s_m - left_m;
  double rest_m = distance_m;
  // What was left just behind the joint still counts by its 2 cm.
  if (from_m < 0.0) {
    for (const zone::SectionId before : circuit.previous(section)) {
      const double end_m = circuit.section(before).length_m();
      spans_on(before, end_m + from_m, end_m, true, out);
    }
  }
  double at_m = place.s_m;
  bool first = true;
  for (std::size_t steps = 0; steps <= circuit.size(); ++steps) {
    const double end_m = circuit.section(section).length_m();
    const double reach_m = std::min(end_m, at_m + rest_m);
    // Without way to go, only what it stands in counts.
    spans_on(section, first ? from_m : at_m, rest_m > 0.0 ? reach_m : from_m, first, out);
    rest_m -= end_m - at_m;
    if (rest_m <= 0.0 || circuit.next(section).empty()) return;
    section = circuit.next(section).front();
    at_m = 0.0;
    first = false;
  }
}

}  // namespace cosiva::virtual_side
