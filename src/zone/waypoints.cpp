// lay_waypoints: where an order may start, turn, or end.
#include <algorithm>
#include <cmath>
#include <queue>
#include <utility>

#include "base/expect.h"
#include "zone/traffic_zone.h"

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

enum class Way { ahead, behind };

/// Lets each of `left_m` run out along the circuit: what is left of it where each section begins in that way (its start
/// when going ahead, its end when going behind), −1 where it does not come. Runs on through sections that `passes`.
template <typename Passes>
std::vector<double> run_out(const Circuit& circuit, Way way, const std::vector<std::pair<double, SectionId>>& left_m,
                            const Passes& passes) {
  // Largest first, so that each section is expanded once however many ways lead to it.
  std::vector<double> left_at(circuit.size(), -1.0);
  std::priority_queue<std::pair<double, SectionId>> queue(left_m.begin(), left_m.end());
  while (!queue.empty()) {
    const auto [left, id] = queue.top();
    queue.pop();
    if (left <= left_at[id]) continue;
    left_at[id] = left;
    const double beyond_m = left - circuit.section(id).length_m();
    if (beyond_m < 0.0 || !passes(id)) continue;
    for (const SectionId neighbour : way == Way::ahead ? circuit.next(id) : circuit.previous(id))
      queue.emplace(beyond_m, neighbour);
  }
  return left_at;
}

/// Where no waypoint may lie, section by section: the spans with their margins, and what lies between two spans too
/// close together to stand between, also across joints.
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
    const auto over_start = run_out(circuit_, Way::ahead, ahead, always);
    const auto over_end = run_out(circuit_, Way::behind, behind, always);
    for (SectionId id = 0; id < stretches_.size(); ++id) {
      const double length = length_m(id);
      if (over_start[id] >= 0.0) stretches_[id].push_back({0.0, std::min(over_start[id], length)});
      if (over_end[id] >= 0.0) stretches_[id].push_back({std::max(length - over_end[id], 0.0), length});
      unite(stretches_[id]);
    }
  }

  void bridge_gaps(double gap_m) {
    // What is left of the gap where each section begins, coming from the nearest blocked stretch on either side.
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
    const auto from_behind = run_out(circuit_, Way::ahead, ahead, free);
    const auto from_ahead = run_out(circuit_, Way::behind, behind, free);

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
void lay(std::vector<double>& places, double from_m, double to_m, double spacing_m) {
  places.push_back(from_m);
  const double length_m = to_m - from_m;
  if (length_m < merge_m) return;
  // The small grace keeps 1.5 m at 0.3 m in five parts when rounding makes the quotient 5.000000001.
  const double parts = std::max(1.0, std::ceil(length_m / spacing_m - 1e-9));
  for (double i = 1.0; i < parts; i += 1.0) places.push_back(from_m + length_m * (i / parts));
  places.push_back(to_m);
}

}  // namespace

std::vector<Waypoint> lay_waypoints(const Circuit& circuit, const std::vector<Crossing>& crossings, double spacing_m,
                                    double room_m) {
  COSIVA_EXPECT(spacing_m >= merge_m && room_m >= 0.0);
  const Blocked blocked{circuit, crossings, room_m};
  std::vector<Waypoint> waypoints;
  std::vector<double> places;
  for (SectionId id = 0; id < circuit.size(); ++id) {
    places.clear();
    const double length_m = circuit.section(id).length_m();
    double from_m = 0.0;
    for (const Stretch& stretch : blocked.of(id)) {
      if (stretch.from_m > from_m) lay(places, from_m, stretch.from_m, spacing_m);
      from_m = stretch.to_m;
    }
    // The end of a section is the start of those that follow, and theirs to mark; a dead end has nobody else.
    const bool followed = !circuit.next(id).empty();
    if (from_m < length_m && !(followed && from_m > 0.0 && length_m - from_m < merge_m)) {
      lay(places, from_m, length_m, spacing_m);
      if (followed && places.back() == length_m) places.pop_back();
    }
    for (const double s : places) {
      const auto millimetres = static_cast<long long>(std::floor(s * 1000.0 + 0.5));
      waypoints.push_back({circuit.part(id).name + "@" + std::to_string(millimetres), {id, s}});
    }
  }
  return waypoints;
}

}  // namespace cosiva::zone
