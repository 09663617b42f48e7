// lay_waypoints: where an order may start, turn, or end.
#include "cosiva/zone/layout/waypoints.h"

#include <algorithm>
#include <cmath>
#include <queue>
#include <string_view>
#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::zone {
namespace {

/// Between a stop line and the span it guards, and between a span and its exit.
constexpr double margin_m = 0.02;
/// Two nodes nearer than this are one: a vehicle's position is not known better.
constexpr double merge_m = 0.02;

struct Stretch {
  double from_m;
  double to_m;
};

/// Sorted, disjoint; stretches that touch become one.
void unite(std::vector<Stretch>& stretches) {
  std::sort(stretches.begin(), stretches.end(), [](const Stretch& a, const Stretch& b) {
    return a.from_m != b.from_m ? a.from_m < b.from_m : a.to_m < b.to_m;
  });
  std::vector<Stretch> united;
  for (const Stretch& stretch : stretches) {
    if (!united.empty() && stretch.from_m <= united.back().to_m)
      united.back().to_m = std::max(united.back().to_m, stretch.to_m);
    else
      united.push_back(stretch);
  }
  stretches = std::move(united);
}

enum class Side { ahead, behind };

/// Lets each of `left_m` run out along the circuit: the rest of it where each section begins in that direction (its
/// start when going ahead, its end when going behind), −1 where it is not reached. Runs on through sections that
/// `passes`.
template <typename Passes>
std::vector<double> run_out(const Circuit& circuit, Side side, const std::vector<std::pair<double, SectionId>>& left_m,
                            const Passes& passes) {
  // Largest first, so that each section is expanded once however many paths lead to it.
  std::vector<double> left_at(circuit.size(), -1.0);
  std::priority_queue<std::pair<double, SectionId>> queue(left_m.begin(), left_m.end());
  while (!queue.empty()) {
    const auto [left, id] = queue.top();
    queue.pop();
    if (left <= left_at[id]) continue;
    left_at[id] = left;
    const double beyond_m = left - circuit.section(id).length_m();
    if (beyond_m < 0.0 || !passes(id)) continue;
    for (const SectionId neighbour : side == Side::ahead ? circuit.next(id) : circuit.previous(id))
      queue.emplace(beyond_m, neighbour);
  }
  return left_at;
}

/// The stretches without waypoints, section by section: the spans with their margins, and the stretches between two
/// spans too close together to stop between, also across joints.
class Blocked {
 public:
  Blocked(const Circuit& circuit, const std::vector<Crossing>& crossings, double room_m)
      : circuit_{circuit}, stretches_(circuit.size()) {
    for (const Crossing& crossing : crossings) {
      for (const CrossingSpan& span : crossing.spans) {
        COSIVA_EXPECT(span.section < circuit.size());
        stretches_[span.section].push_back({span.from_m - margin_m, span.to_m + margin_m});
      }
    }
    for (auto& stretches : stretches_) unite(stretches);
    spill_over_joints();
    bridge_gaps(std::max(room_m - 2.0 * margin_m, 0.0));
  }

  [[nodiscard]] const std::vector<Stretch>& of(SectionId id) const { return stretches_[id]; }

 private:
  [[nodiscard]] double length_m(SectionId id) const { return circuit_.section(id).length_m(); }

  /// A margin that reaches beyond its section's end belongs to the neighbours, however short they are.
  void spill_over_joints() {
    std::vector<std::pair<double, SectionId>> ahead;
    std::vector<std::pair<double, SectionId>> behind;
    for (SectionId id = 0; id < stretches_.size(); ++id) {
      for (Stretch& stretch : stretches_[id]) {
        if (stretch.to_m >= length_m(id)) {
          for (const SectionId after : circuit_.next(id)) ahead.emplace_back(stretch.to_m - length_m(id), after);
        }
        if (stretch.from_m <= 0.0) {
          for (const SectionId before : circuit_.previous(id)) behind.emplace_back(-stretch.from_m, before);
        }
        stretch = {std::max(stretch.from_m, 0.0), std::min(stretch.to_m, length_m(id))};
      }
    }
    const auto always = [](SectionId) { return true; };
    const auto over_start = run_out(circuit_, Side::ahead, ahead, always);
    const auto over_end = run_out(circuit_, Side::behind, behind, always);
    for (SectionId id = 0; id < stretches_.size(); ++id) {
      const double length = length_m(id);
      if (over_start[id] >= 0.0) stretches_[id].push_back({0.0, std::min(over_start[id], length)});
      if (over_end[id] >= 0.0) stretches_[id].push_back({std::max(length - over_end[id], 0.0), length});
      unite(stretches_[id]);
    }
  }

  void bridge_gaps(double gap_m) {
    // The rest of the gap where each section begins, from the nearest blocked stretch on either side.
    std::vector<std::pair<double, SectionId>> ahead;
    std::vector<std::pair<double, SectionId>> behind;
    for (SectionId id = 0; id < stretches_.size(); ++id) {
      if (stretches_[id].empty()) continue;
      const double left_ahead = gap_m - (length_m(id) - stretches_[id].back().to_m);
      const double left_behind = gap_m - stretches_[id].front().from_m;
      for (const SectionId after : circuit_.next(id)) ahead.emplace_back(left_ahead, after);
      for (const SectionId before : circuit_.previous(id)) behind.emplace_back(left_behind, before);
    }
    const auto free = [this](SectionId id) { return stretches_[id].empty(); };
    const auto from_behind = run_out(circuit_, Side::ahead, ahead, free);
    const auto from_ahead = run_out(circuit_, Side::behind, behind, free);

    for (SectionId id = 0; id < stretches_.size(); ++id) {
      auto& here = stretches_[id];
      const double length = length_m(id);
      if (here.empty()) {
        // free behind + length + free ahead < gap
        if (from_behind[id] >= 0.0 && from_ahead[id] >= 0.0 && from_behind[id] + from_ahead[id] > gap_m + length)
          here.push_back({0.0, length});
        continue;
      }
      std::vector<Stretch> bridges;
      for (std::size_t i = 0; i + 1 < here.size(); ++i) {
        if (here[i + 1].from_m - here[i].to_m < gap_m) bridges.push_back({here[i].to_m, here[i + 1].from_m});
      }
      if (from_behind[id] > here.front().from_m) bridges.push_back({0.0, here.front().from_m});
      if (from_ahead[id] > length - here.back().to_m) bridges.push_back({here.back().to_m, length});
      here.insert(here.end(), bridges.begin(), bridges.end());
      unite(here);
    }
  }

  const Circuit& circuit_;
  std::vector<std::vector<Stretch>> stretches_;
};

/// Waypoints over a free stretch of one section: its ends, and between them as few as keep to the spacing.
void lay(std::vector<double>& positions, double from_m, double to_m, double spacing_m) {
  positions.push_back(from_m);
  const double length_m = to_m - from_m;
  if (length_m < merge_m) return;
  // The small margin keeps 1.5 m at 0.3 m in five parts when rounding makes the quotient 5.000000001.
  const double parts = std::max(1.0, std::ceil(length_m / spacing_m - 1e-9));
  for (double i = 1.0; i < parts; i += 1.0) positions.push_back(from_m + length_m * (i / parts));
  positions.push_back(to_m);
}

/// A waypoint of one section, before its id is assigned.
struct Laid {
  double s_m;
  const std::string* id{nullptr};  ///< of its own, if any
};

const std::string* own_id(const std::vector<std::string>& ids, SectionId section) {
  return section < ids.size() && !ids[section].empty() ? &ids[section] : nullptr;
}

/// Lays the waypoints section by section. Invariant: those of the present section are sorted by arc length.
class Layer {
 public:
  Layer(const Circuit& circuit, const std::vector<Crossing>& crossings, const WaypointRules& rules);
  std::vector<Waypoint> lay_all();

 private:
  void lay_free(SectionId id);
  void lay_requested(SectionId id);
  void name(double s_m, const std::string* id);
  [[nodiscard]] std::string id_at(SectionId id, double s_m) const;

  const Circuit& circuit_;
  const WaypointRules& rules_;
  Blocked blocked_;
  std::vector<TrackPosition> at_;        ///< sorted
  std::vector<std::string_view> taken_;  ///< ids of the rules, sorted
  std::vector<double> free_;             ///< of the present section
  std::vector<Laid> laid_;               ///< likewise, sorted
};

Layer::Layer(const Circuit& circuit, const std::vector<Crossing>& crossings, const WaypointRules& rules)
    : circuit_{circuit}, rules_{rules}, blocked_{circuit, crossings, rules.room_m}, at_{rules.at} {
  std::sort(at_.begin(), at_.end(), [](const TrackPosition& a, const TrackPosition& b) {
    return a.section != b.section ? a.section < b.section : a.s_m < b.s_m;
  });
  for (const auto* ids : {&rules.start_ids, &rules.end_ids}) taken_.insert(taken_.end(), ids->begin(), ids->end());
  std::sort(taken_.begin(), taken_.end());
}

void Layer::lay_free(SectionId id) {
  free_.clear();
  const double length_m = circuit_.section(id).length_m();
  const double spacing_m = rules_.nodes_only ? length_m : rules_.spacing_m;
  double from_m = 0.0;
  for (const Stretch& stretch : blocked_.of(id)) {
    if (stretch.from_m > from_m) lay(free_, from_m, stretch.from_m, spacing_m);
    from_m = stretch.to_m;
  }
  // The waypoint at a section's end is the one at the start of its successors, which create it; a dead end has no
  // successors.
  const bool followed = !circuit_.next(id).empty();
  if (from_m < length_m && !(followed && from_m > 0.0 && length_m - from_m < merge_m)) {
    lay(free_, from_m, length_m, spacing_m);
    if (followed && free_.back() == length_m) free_.pop_back();
  }
  laid_.clear();
  for (const double s : free_) laid_.push_back({s});
}

/// A waypoint too near to a position with an id of its own is dropped.
void Layer::name(double s_m, const std::string* id) {
  if (id == nullptr) return;
  std::erase_if(laid_, [&](const Laid& laid) { return laid.id == nullptr && std::fabs(laid.s_m - s_m) < merge_m; });
  const auto after = std::find_if(laid_.begin(), laid_.end(), [&](const Laid& laid) { return laid.s_m > s_m; });
  laid_.insert(after, {s_m, id});
}

/// Both lists are sorted: one pass, however many are requested.
void Layer::lay_requested(SectionId id) {
  const double length_m = circuit_.section(id).length_m();
  std::vector<Laid> all;
  auto old = laid_.begin();
  const auto first =
      std::partition_point(at_.begin(), at_.end(), [id](const TrackPosition& at) { return at.section < id; });
  for (auto at = first; at != at_.end() && at->section == id; ++at) {
    const double s_m = std::clamp(at->s_m, 0.0, length_m);
    while (old != laid_.end() && old->s_m <= s_m) all.push_back(*old++);
    const bool behind = !all.empty() && s_m - all.back().s_m < merge_m;
    const bool ahead = old != laid_.end() && old->s_m - s_m < merge_m;
    if (!behind && !ahead) all.push_back({s_m});
  }
  all.insert(all.end(), old, laid_.end());
  laid_ = std::move(all);
}

std::string Layer::id_at(SectionId id, double s_m) const {
  const auto millimetres = static_cast<long long>(std::floor(s_m * 1000.0 + 0.5));
  std::string name = circuit_.part(id).name + "@" + std::to_string(millimetres);
  // A format's own ids may look like generated ones, and mean another point.
  while (std::binary_search(taken_.begin(), taken_.end(), std::string_view{name})) name += '+';
  return name;
}

std::vector<Waypoint> Layer::lay_all() {
  std::vector<Waypoint> waypoints;
  for (SectionId id = 0; id < circuit_.size(); ++id) {
    lay_free(id);
    name(0.0, own_id(rules_.start_ids, id));
    if (circuit_.next(id).empty()) name(circuit_.section(id).length_m(), own_id(rules_.end_ids, id));
    lay_requested(id);
    COSIVA_EXPECT(
        std::is_sorted(laid_.begin(), laid_.end(), [](const Laid& a, const Laid& b) { return a.s_m < b.s_m; }));
    for (const Laid& laid : laid_)
      waypoints.push_back({laid.id != nullptr ? *laid.id : id_at(id, laid.s_m), {id, laid.s_m}});
  }
  return waypoints;
}

}  // namespace

std::vector<Waypoint> lay_waypoints(const Circuit& circuit, const std::vector<Crossing>& crossings, double spacing_m,
                                    double room_m) {
  WaypointRules rules;
  rules.spacing_m = spacing_m;
  rules.room_m = room_m;
  return lay_waypoints(circuit, crossings, rules);
}

std::vector<Waypoint> lay_waypoints(const Circuit& circuit, const std::vector<Crossing>& crossings,
                                    const WaypointRules& rules) {
  COSIVA_EXPECT(rules.spacing_m >= merge_m && rules.room_m >= 0.0);
  return Layer{circuit, crossings, rules}.lay_all();
}

bool is_at_waypoint(const TrafficZone& zone, TrackPosition position) {
  constexpr double near_m = 0.02;
  const std::size_t at = zone.waypoint_behind({position.section, position.s_m + near_m});
  if (at == zone.waypoints.size()) return false;
  const TrackPosition& waypoint = zone.waypoints[at].position;
  return waypoint.section == position.section && std::fabs(waypoint.s_m - position.s_m) <= near_m;
}

}  // namespace cosiva::zone
