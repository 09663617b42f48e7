// The longest distance without a beacon, and better positions for the beacons.
#include "cosiva/zone/layout/beacon_free.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "cosiva/zone/layout/rounding.h"

namespace cosiva::zone {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr double sagitta_max_m = 1e-4;
/// A beacon just at a joint belongs to both of its sides, whatever the rounding.
constexpr double same_position_m = 1e-9;
/// Chords examined in a whole search, about a second's work.
constexpr double work_max = 2e7;
constexpr std::size_t searched_chords_max = 200'000;

/// The tags or beacons read on one section, in the order of driving.
struct Reads {
  std::vector<double> s_m;
};

/// The longest distance between reads over all branches.
class DistanceToReads {
 public:
  DistanceToReads(const Circuit& circuit, const std::vector<Reads>& reads)
      : circuit_{circuit},
        reads_{reads},
        ahead_m_(circuit.size(), unknown),
        begin_m_(circuit.size()),
        via_(circuit.size(), no_section) {}

  Stretch longest() {
    for (SectionId id = 0; id < circuit_.size(); ++id) look_ahead(id);
    if (longest_.endless) return longest_;
    for (SectionId id = 0; id < circuit_.size(); ++id) {
      const auto& s = reads_[id].s_m;
      for (std::size_t i = 1; i < s.size(); ++i) record(s[i] - s[i - 1], {id, s[i - 1]}, {id, s[i]});
      if (circuit_.previous(id).empty()) record(ahead_m_[id], {id, 0.0}, end_of_path(id));
      if (s.empty()) continue;
      const double left_m = circuit_.section(id).length_m() - s.back();
      const SectionId worst = worst_after(id);
      if (worst == no_section)
        record(left_m, {id, s.back()}, {id, circuit_.section(id).length_m()});
      else
        record(left_m + ahead_m_[worst], {id, s.back()}, end_of_path(worst));
    }
    return longest_;
  }

 private:
  static constexpr double unknown = -1.0;
  static constexpr double open = -2.0;  // on the path that is being followed

  void record(double length_m, TrackPosition from, TrackPosition to) {
    if (length_m > longest_.length_m) longest_ = {length_m, from, to, false};
  }

  [[nodiscard]] SectionId worst_after(SectionId id) const {
    SectionId worst = no_section;
    for (const SectionId after : circuit_.next(id))
      if (worst == no_section || ahead_m_[after] > ahead_m_[worst]) worst = after;
    return worst;
  }

  using Stack = std::vector<std::pair<SectionId, std::size_t>>;  // a section, and which of its branches comes next

  /// Known at once where a tag or beacon is read on it, otherwise to be followed.
  void enter(SectionId id, Stack& stack) {
    if (!reads_[id].s_m.empty()) {
      ahead_m_[id] = reads_[id].s_m.front();
      return;
    }
    ahead_m_[id] = open;
    begin_m_[id] = stack.empty() ? 0.0 : end_m(stack.back().first);
    stack.emplace_back(id, 0);
  }

  [[nodiscard]] double end_m(SectionId id) const { return begin_m_[id] + circuit_.section(id).length_m(); }

  /// From the start of each section to the next read, by the worst branch; depth first, on an explicit stack.
  void look_ahead(SectionId first) {
    if (ahead_m_[first] != unknown) return;
    Stack stack;
    enter(first, stack);
    while (!stack.empty()) {
      const SectionId id = stack.back().first;
      const auto next = circuit_.next(id);
      if (stack.back().second < next.size()) {
        const SectionId after = next[stack.back().second++];
        if (ahead_m_[after] == unknown)
          enter(after, stack);
        else if (ahead_m_[after] == open)
          record_round(stack, after);
        continue;
      }
      via_[id] = worst_after(id);
      const double beyond_m = via_[id] == no_section ? 0.0 : std::max(ahead_m_[via_[id]], 0.0);
      ahead_m_[id] = circuit_.section(id).length_m() + beyond_m;
      stack.pop_back();
    }
  }

  /// From the start of an open section to the end of the last one, and round again.
  void record_round(const Stack& stack, SectionId first) {
    const SectionId last = stack.back().first;
    const double length_m = end_m(last) - begin_m_[first];
    if (longest_.endless && length_m <= longest_.length_m) return;
    longest_ = {length_m, {first, 0.0}, {last, circuit_.section(last).length_m()}, true};
  }

  [[nodiscard]] TrackPosition end_of_path(SectionId id) const {
    while (reads_[id].s_m.empty()) {
      if (via_[id] == no_section) return {id, circuit_.section(id).length_m()};
      id = via_[id];
    }
    return {id, reads_[id].s_m.front()};
  }

  const Circuit& circuit_;
  const std::vector<Reads>& reads_;
  std::vector<double> ahead_m_;
  std::vector<double> begin_m_;  ///< of open sections: from the begin of the path that is being followed
  std::vector<SectionId> via_;
  Stretch longest_;
};

/// All sections as short straight pieces in the frame of a matrix, to compute where beacons are read for one origin or
/// another.
class Chords {
 public:
  Chords(const TrafficZone& zone, double reach_m)
      : circuit_{zone.circuit},
        grid_{*zone.beacons},
        reach_m_{std::min(reach_m, grid_.pitch_m)},
        turn_{sincos(grid_.rotation_rad)} {
    begin_.reserve(circuit_.size() + 1);
    for (SectionId id = 0; id < circuit_.size(); ++id) {
      begin_.push_back(chords_.size());
      cut(circuit_.section(id));
    }
    begin_.push_back(chords_.size());
  }

  [[nodiscard]] std::size_t size() const { return chords_.size(); }
  [[nodiscard]] const SinCos& turn() const { return turn_; }

  /// The positions where beacons are read when the matrix is shifted by `offset` along its own axes.
  void read(Point2 offset, std::vector<Reads>& reads) const {
    reads.resize(circuit_.size());
    for (SectionId id = 0; id < circuit_.size(); ++id) {
      reads[id].s_m.clear();
      for (std::size_t i = begin_[id]; i < begin_[id + 1]; ++i) read_chord(id, i, offset, reads[id].s_m);
      std::sort(reads[id].s_m.begin(), reads[id].s_m.end());
    }
  }

 private:
  struct Chord {
    Point2 from;
    Point2 along;  // unit
    double length_m;
    double s_m;
  };

  void cut(const Section& section) {
    const double bend = section.curvature_max_per_m();
    // No longer than a pitch, so that few beacons are near each.
    double part_m = grid_.pitch_m;
    if (bend > 0.0) part_m = std::min({part_m, std::sqrt(8.0 * sagitta_max_m / bend), 0.5 / bend});
    const double parts = std::max(1.0, std::ceil(section.length_m() / part_m));
    Point2 from = in_matrix(position(section.pose_at(0.0)));
    for (double i = 0.0; i < parts; i += 1.0) {
      const double s_m = section.length_m() * (i / parts);
      const Point2 to = in_matrix(position(section.pose_at(section.length_m() * ((i + 1.0) / parts))));
      const double length_m = distance(from, to);
      if (length_m > 0.0)
        chords_.push_back({from, {(to.x_m - from.x_m) / length_m, (to.y_m - from.y_m) / length_m}, length_m, s_m});
      from = to;
    }
  }

  [[nodiscard]] Point2 in_matrix(Point2 p) const {
    const double x_m = p.x_m - grid_.origin.x_m;
    const double y_m = p.y_m - grid_.origin.y_m;
    return {x_m * turn_.cos + y_m * turn_.sin, y_m * turn_.cos - x_m * turn_.sin};
  }

  [[nodiscard]] double along_m(const Chord& chord, Point2 p) const {
    return (p.x_m - chord.from.x_m) * chord.along.x_m + (p.y_m - chord.from.y_m) * chord.along.y_m;
  }

  void read_chord(SectionId id, std::size_t index, Point2 offset, std::vector<double>& s_m) const {
    const Chord& chord = chords_[index];
    const Point2 to{chord.from.x_m + chord.along.x_m * chord.length_m,
                    chord.from.y_m + chord.along.y_m * chord.length_m};
    const double pitch_m = grid_.pitch_m;
    const auto first = [&](double a, double b, double shift) {
      return std::ceil((std::min(a, b) - reach_m_ - shift) / pitch_m);
    };
    const auto last = [&](double a, double b, double shift) {
      return std::floor((std::max(a, b) + reach_m_ - shift) / pitch_m);
    };
    // A matrix that covers the zone would do so from any origin.
    const bool covers = grid_.covers_through.has_value();
    const double i0 = first(chord.from.x_m, to.x_m, offset.x_m);
    const double i1 = last(chord.from.x_m, to.x_m, offset.x_m);
    const double j0 = first(chord.from.y_m, to.y_m, offset.y_m);
    const double j1 = last(chord.from.y_m, to.y_m, offset.y_m);
    for (double i = covers ? i0 : std::max(i0, 0.0); i <= (covers ? i1 : std::min(i1, grid_.columns - 1.0)); i += 1.0)
      for (double j = covers ? j0 : std::max(j0, 0.0); j <= (covers ? j1 : std::min(j1, grid_.rows - 1.0)); j += 1.0)
        read_beacon(id, index, {offset.x_m + i * pitch_m, offset.y_m + j * pitch_m}, s_m);
  }

  /// A beacon is read once, where the path is nearest to it: on a chord, or where two meet at an angle.
  void read_beacon(SectionId id, std::size_t index, Point2 beacon, std::vector<double>& s_m) const {
    const Chord& chord = chords_[index];
    double at_m = along_m(chord, beacon);
    if (at_m < -same_position_m) {
      const bool turns_here = index > begin_[id] && along_m(chords_[index - 1], beacon) > chords_[index - 1].length_m;
      const bool begins_here = index == begin_[id] && circuit_.previous(id).empty();
      if (!turns_here && !begins_here) return;
    } else if (at_m > chord.length_m + same_position_m) {
      const bool ends_here = index + 1 == begin_[id + 1] && (circuit_.next(id).empty() || circuit_.part(id).pivots);
      if (!ends_here) return;
    }
    at_m = std::clamp(at_m, 0.0, chord.length_m);
    const Point2 nearest{chord.from.x_m + chord.along.x_m * at_m, chord.from.y_m + chord.along.y_m * at_m};
    if (distance(nearest, beacon) <= reach_m_) s_m.push_back(chord.s_m + at_m);
  }

  const Circuit& circuit_;
  const BeaconGrid& grid_;
  double reach_m_;
  SinCos turn_;
  std::vector<Chord> chords_;
  std::vector<std::size_t> begin_;  ///< of each section's chords
};

/// A suggestion must hold although beacons are laid, and paths driven, with a small lateral offset: only beacons within
/// this ratio of the reach count while origins are compared.
constexpr double surely_read = 0.9;

/// Tries origins and keeps the best; of equal ones the first.
class Search {
 public:
  Search(const TrafficZone& zone, double reach_m)
      : zone_{zone}, chords_{zone, reach_m}, sure_{zone, surely_read * reach_m}, reach_m_{reach_m} {}

  std::optional<OriginSuggestion> run() {
    if (chords_.size() > searched_chords_max) return std::nullopt;
    best_m_ = longest_m(sure_, {0.0, 0.0});
    const double pitch_m = zone_.beacons->pitch_m;
    const double tries_max = work_max / static_cast<double>(std::max<std::size_t>(chords_.size(), 1));
    const double finest = std::clamp(std::ceil(pitch_m / reach_m_), 8.0, 32.0);
    const double parts = std::max(4.0, std::min(finest, std::floor(std::sqrt(0.5 * tries_max))));
    double step_m = pitch_m / parts;
    for (double i = 0.0; i < parts; i += 1.0)
      for (double j = 0.0; j < parts; j += 1.0) consider({i * step_m, j * step_m});
    for (int round = 0; round < 6; ++round) {
      step_m *= 0.5;
      const Point2 centre = best_;
      for (const double x : {-1.0, 0.0, 1.0})
        for (const double y : {-1.0, 0.0, 1.0}) consider({centre.x_m + x * step_m, centre.y_m + y * step_m});
    }
    return suggestion(longest_m(chords_, {0.0, 0.0}));
  }

 private:
  double longest_m(const Chords& chords, Point2 offset) {
    chords.read(offset, reads_);
    const Stretch longest = DistanceToReads{zone_.circuit, reads_}.longest();
    return longest.endless ? infinite : longest.length_m;
  }

  void consider(Point2 offset) {
    const double length_m = longest_m(sure_, offset);
    // A gain of less than a micrometre is no reason to move beacons.
    if (length_m < best_m_ - 1e-6) {
      best_m_ = length_m;
      best_ = offset;
    }
  }

  /// On the map, rounded as it will be written, and measured as rounded.
  OriginSuggestion suggestion(double before_m) {
    const BeaconGrid& grid = *zone_.beacons;
    const Point2 origin = grid.covers_through.value_or(grid.origin);
    const SinCos& turn = chords_.turn();
    const Point2 rounded{rounded_m(origin.x_m + best_.x_m * turn.cos - best_.y_m * turn.sin),
                         rounded_m(origin.y_m + best_.x_m * turn.sin + best_.y_m * turn.cos)};
    const double x_m = rounded.x_m - origin.x_m;
    const double y_m = rounded.y_m - origin.y_m;
    const double after_m = longest_m(chords_, {x_m * turn.cos + y_m * turn.sin, y_m * turn.cos - x_m * turn.sin});
    if (!(after_m < before_m)) return {origin, before_m, before_m};
    return {rounded, before_m, after_m};
  }

  const TrafficZone& zone_;
  Chords chords_;
  Chords sure_;  ///< with the counting part of the reach
  double reach_m_;
  std::vector<Reads> reads_;
  Point2 best_{};
  double best_m_{infinite};
};

/// Adds the reads of tags to the present ones of beacons.
void read_tags(const TrafficZone& zone, std::vector<Reads>& reads) {
  for (const Tag& tag : zone.tags) reads[tag.position.section].s_m.push_back(tag.position.s_m);
  for (Reads& one : reads) std::sort(one.s_m.begin(), one.s_m.end());
}

}  // namespace

Stretch longest_beacon_free(const TrafficZone& zone, double reach_m) {
  std::vector<Reads> reads(zone.circuit.size());
  if (zone.beacons) Chords{zone, reach_m}.read({0.0, 0.0}, reads);
  return DistanceToReads{zone.circuit, reads}.longest();
}

Stretch longest_tag_free(const TrafficZone& zone) {
  std::vector<Reads> reads(zone.circuit.size());
  read_tags(zone, reads);
  return DistanceToReads{zone.circuit, reads}.longest();
}

Stretch longest_unread(const TrafficZone& zone, double reach_m) {
  std::vector<Reads> reads(zone.circuit.size());
  if (zone.beacons) Chords{zone, reach_m}.read({0.0, 0.0}, reads);
  read_tags(zone, reads);
  return DistanceToReads{zone.circuit, reads}.longest();
}

std::optional<OriginSuggestion> suggest_origin(const TrafficZone& zone, double reach_m) {
  if (!zone.beacons) return std::nullopt;
  return Search{zone, reach_m}.run();
}

}  // namespace cosiva::zone
