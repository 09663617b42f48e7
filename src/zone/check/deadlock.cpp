#include "cosiva/zone/check/deadlock.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <span>
#include <string>
#include <utility>

#include "cosiva/base/components.h"
#include "cosiva/base/expect.h"
#include "cosiva/zone/layout/rounding.h"

namespace cosiva::zone {
namespace {

/// The number of similar findings that are named.
constexpr std::size_t named_max = 5;

/// Whether positions keep `room_m` from each other all the way round `round_m`, taking as many as that allows from
/// `first`.
std::size_t packed_from(std::span<const double> positions_m, std::size_t first, double round_m, double room_m) {
  std::size_t count = 1;
  double last_m = positions_m[first];
  for (std::size_t i = 1; i < positions_m.size(); ++i) {
    const std::size_t at = (first + i) % positions_m.size();
    const double position_m = positions_m[at] + (at < first ? round_m : 0.0);
    if (position_m - last_m < room_m || positions_m[first] + round_m - position_m < room_m) continue;
    last_m = position_m;
    ++count;
  }
  return count;
}

/// Finds one kind of position after the other. Invariant: no section has more waiting positions than waypoints.
class Spots {
 public:
  explicit Spots(const TrafficZone& zone) : zone_{zone}, circuit_{zone.circuit}, opposite_{opposites(zone)} {
    rests_.assign(circuit_.size(), 0);
    stretches_.assign(circuit_.size(), 0);
    for (const Waypoint& waypoint : zone.waypoints) {
      ++stretches_[waypoint.position.section];
      if (zone.crossing_at(waypoint.position) == nullptr) ++rests_[waypoint.position.section];
      COSIVA_EXPECT(rests_[waypoint.position.section] <= stretches_[waypoint.position.section]);
    }
  }

  std::vector<Problem> run() {
    loops();
    rows_without_room();
    single_tracks();
    dead_ends();
    return std::move(found_);
  }

 private:
  [[nodiscard]] std::string name(SectionId id) const { return "'" + circuit_.part(id).name + "'"; }

  void record(std::string code, TrackPosition track_position, std::string text) {
    found_.push_back({Problem::Severity::notice, std::move(code), track_position,
                      position(circuit_.pose_at(track_position)), std::move(text)});
  }

  // --- how many vehicles fit on a loop ---

  void loops() {
    for (const Loop& loop : zone_.loops) one_loop("loop '" + loop.name + "'", loop.sections);
    if (!zone_.loops.empty()) return;
    const auto next = [this](SectionId id) { return circuit_.next(id); };
    components_.find(circuit_.size(), next);
    for (std::size_t c = 0; c < components_.size(); ++c) {
      const auto members = components_.members(c);
      const auto itself = circuit_.next(members.front());
      if (members.size() == 1 && std::find(itself.begin(), itself.end(), members.front()) == itself.end()) continue;
      one_part(members);
    }
  }

  void one_loop(const std::string& what, const std::vector<SectionId>& sections) {
    const std::size_t most = vehicles_going_round(zone_, sections);
    record("deadlock.loop", {sections.front(), 0.0},
           what + (most == 0 ? " has no position where a vehicle can wait outside crossings"
                             : " has room for " + vehicles(most) + " to circulate; with " + std::to_string(most + 1) +
                                   " no vehicle in it can move"));
  }

  /// A loop is followed all round; elsewhere a vehicle that is blocked on one branch may take another.
  void one_part(std::span<const std::uint32_t> members) {
    std::vector<SectionId> cycle;
    for (SectionId at = members.front(); cycle.empty() || at != members.front();) {
      cycle.push_back(at);
      SectionId onward = no_section;
      for (const SectionId after : circuit_.next(at)) {
        if (components_.component_of(after) != components_.component_of(at)) continue;
        if (onward != no_section) return whole_part(members);
        onward = after;
      }
      at = onward;
    }
    one_loop("the loop from " + name(members.front()), cycle);
  }

  void whole_part(std::span<const std::uint32_t> members) {
    std::size_t positions = 0;
    for (const SectionId id : members) {
      const double length_m = circuit_.section(id).length_m();
      const auto fit = static_cast<std::size_t>(length_m / stopping_room_m(zone_.vehicle)) + 1;
      positions += std::min(rests_[id], fit);
    }
    const std::size_t most = positions > 0 ? positions - 1 : 0;
    record("deadlock.loop", {members.front(), 0.0},
           "the " + std::to_string(members.size()) + " sections that lead round from " + name(members.front()) +
               " have waiting positions for at most " + vehicles(positions) + "; with more than " +
               std::to_string(most) + " no vehicle in them can move");
  }

  static std::string vehicles(std::size_t count) {
    return std::to_string(count) + (count == 1 ? " vehicle" : " vehicles");
  }

  // --- crossings without room between them ---

  [[nodiscard]] bool without_room(SectionId id) const { return rests_[id] == 0; }

  void rows_without_room() {
    // Of the successors of a section only those count that have no room either. A vehicle that turns round in a dead
    // end returns over sections that it holds already.
    std::vector<SectionId> onward;
    std::vector<std::size_t> first(circuit_.size() + 1, 0);
    for (SectionId id = 0; id < circuit_.size(); ++id) {
      if (without_room(id))
        for (const SectionId after : circuit_.next(id))
          if (without_room(after) && after != opposite_[id]) onward.push_back(after);
      first[id + 1] = onward.size();
    }
    const auto next = [&](SectionId id) {
      return std::span<const SectionId>{onward}.subspan(first[id], first[id + 1] - first[id]);
    };
    components_.find(circuit_.size(), next);
    // Predecessors come first: the longest row from each is known when it is needed.
    std::vector<std::size_t> row(circuit_.size(), 0);
    for (std::size_t c = 0; c < components_.size(); ++c) {
      const auto members = components_.members(c);
      const SectionId id = members.front();
      if (!without_room(id)) continue;
      const auto branches = next(id);
      if (members.size() > 1 || std::find(branches.begin(), branches.end(), id) != branches.end()) {
        record("deadlock.no_room", {id, 0.0},
               "a vehicle can go round from " + name(id) + " over " + std::to_string(members.size()) +
                   " sections without a waiting position between crossings; vehicles stop in crossings there, and each "
                   "may hold what the next one needs: leave more room between two of them");
        for (const SectionId member : members) row[member] = 0;
        continue;
      }
      for (const SectionId after : branches) row[id] = std::max(row[id], row[after]);
      row[id] += std::max<std::size_t>(1, stretches_[id]);
    }
    long_rows(row);
  }

  /// Reported once for each row, where the row begins.
  void long_rows(const std::vector<std::size_t>& row) {
    for (SectionId id = 0; id < circuit_.size(); ++id) {
      if (row[id] <= reserved_at_once_max) continue;
      const auto before = circuit_.previous(id);
      if (std::any_of(before.begin(), before.end(), [&](SectionId b) { return row[b] > row[id]; })) continue;
      record("deadlock.no_room", {id, 0.0},
             "from " + name(id) + " on crossings follow each other over " + std::to_string(row[id]) +
                 " stretches without a waiting position; more than " + std::to_string(reserved_at_once_max) +
                 " are not reserved at once, so vehicles stop in crossings there");
    }
  }

  // --- there and back on one track ---

  /// The successor of a section without a turn at its end; no_section at a fork, or where the section ends.
  [[nodiscard]] SectionId straight_on(SectionId id) const {
    SectionId found = no_section;
    for (const SectionId after : circuit_.next(id)) {
      if (after == opposite_[id]) continue;
      if (found != no_section) return no_section;
      found = after;
    }
    return found;
  }

  /// The next section of the same track driven both ways; no_section where a vehicle may leave the track, or where it
  /// ends.
  [[nodiscard]] SectionId along_track(SectionId id) const {
    const SectionId after = straight_on(id);
    if (after == no_section || opposite_[after] == no_section) return no_section;
    return straight_on(opposite_[after]) == opposite_[id] ? after : no_section;
  }

  void single_tracks() {
    std::vector<bool> done(circuit_.size(), false);
    for (SectionId id = 0; id < circuit_.size(); ++id) {
      if (done[id] || opposite_[id] == no_section) continue;
      // Its beginning: as far back as the track goes, in the opposite direction.
      SectionId at = id;
      for (SectionId back = along_track(opposite_[at]); back != no_section && opposite_[back] != id;
           back = along_track(opposite_[at]))
        at = opposite_[back];
      one_track(at, done);
    }
  }

  void one_track(SectionId first, std::vector<bool>& done) {
    SectionId last = first;
    SectionId waits_on = no_section;
    double length_m = 0.0;
    for (SectionId at = first; at != no_section && !done[at]; at = along_track(at)) {
      done[at] = done[opposite_[at]] = true;
      length_m += circuit_.section(at).length_m();
      last = at;
      if (waits_on == no_section && rests_[at] + rests_[opposite_[at]] > 0)
        waits_on = rests_[at] > 0 ? at : opposite_[at];
    }
    if (waits_on == no_section) return;  // reserved whole, from end to end
    record("deadlock.single_track", {waits_on, 0.0},
           (first == last ? name(first) + " is" : name(first) + " to " + name(last) + " are") + " one track of " +
               metres_text(length_m) + " m driven both ways, and a vehicle may stop on " + name(waits_on) +
               " while another comes from the other direction; there is no room to pass");
  }

  void dead_ends() {
    std::vector<SectionId> ends;
    for (SectionId id = 0; id < circuit_.size(); ++id) {
      const auto next = circuit_.next(id);
      if (opposite_[id] != no_section && next.size() == 1 && next.front() == opposite_[id]) ends.push_back(id);
    }
    if (ends.empty()) return;
    std::string names;
    for (std::size_t i = 0; i < std::min(named_max, ends.size()); ++i) names += (i > 0 ? ", " : "") + name(ends[i]);
    if (ends.size() > named_max) names += " and " + std::to_string(ends.size() - named_max) + " more";
    record(
        "deadlock.dead_end", {ends.front(), 0.0},
        names + " can only be left in the direction of entry; a vehicle that waits to enter must leave the exit free");
  }

  const TrafficZone& zone_;
  const Circuit& circuit_;
  std::vector<SectionId> opposite_;
  std::vector<std::size_t> rests_;      ///< on each section: waypoints where a vehicle may wait
  std::vector<std::size_t> stretches_;  ///< waypoints of any kind
  StrongComponents components_;
  std::vector<Problem> found_;
};

}  // namespace

std::vector<SectionId> opposites(const TrafficZone& zone) {
  using Key = std::array<double, 4>;
  const auto key = [](Point2 a, Point2 b) {
    const auto cell = [](double value_m) { return std::nearbyint(value_m * 100.0); };
    return Key{cell(a.x_m), cell(a.y_m), cell(b.x_m), cell(b.y_m)};
  };
  const Circuit& circuit = zone.circuit;
  std::vector<SectionId> found(circuit.size(), no_section);
  std::map<Key, SectionId> by_ends;
  for (SectionId id = 0; id < circuit.size(); ++id) {
    const Section& section = circuit.section(id);
    const Point2 start = position(section.start());
    const Point2 end = position(section.end());
    const auto other = by_ends.find(key(end, start));
    by_ends.emplace(key(start, end), id);
    if (other == by_ends.end()) continue;
    const Section& back = circuit.section(other->second);
    const double apart_m = distance(section.pose_at(0.5 * section.length_m()), back.pose_at(0.5 * back.length_m()));
    if (apart_m >= 0.5 * zone.vehicle.width_m) continue;
    found[id] = other->second;
    found[other->second] = id;
  }
  return found;
}

std::size_t vehicles_going_round(const TrafficZone& zone, const std::vector<SectionId>& sections) {
  const auto before = [](const Waypoint& waypoint, SectionId id) { return waypoint.position.section < id; };
  std::vector<double> positions_m;
  double round_m = 0.0;
  for (const SectionId id : sections) {
    auto at = std::lower_bound(zone.waypoints.begin(), zone.waypoints.end(), id, before);
    for (; at != zone.waypoints.end() && at->position.section == id; ++at)
      if (zone.crossing_at(at->position) == nullptr) positions_m.push_back(round_m + at->position.s_m);
    round_m += zone.circuit.section(id).length_m();
  }
  if (positions_m.empty()) return 0;
  const double room_m = stopping_room_m(zone.vehicle);
  // The tightest row begins at one of the first positions that a vehicle takes away from each other.
  std::size_t most = 0;
  for (std::size_t first = 0; first < positions_m.size() && positions_m[first] < positions_m.front() + room_m; ++first)
    most = std::max(most, packed_from(positions_m, first, round_m, room_m));
  return most - 1;
}

std::vector<Problem> deadlock_spots(const TrafficZone& zone) { return Spots{zone}.run(); }

}  // namespace cosiva::zone
