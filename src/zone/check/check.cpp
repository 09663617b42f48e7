#include "cosiva/zone/check/check.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <span>
#include <tuple>

#include "cosiva/zone/check/deadlock.h"
#include "cosiva/zone/layout/beacon_free.h"
#include "cosiva/zone/layout/rounding.h"
#include "cosiva/zone/layout/waypoints.h"
#include "cosiva/zone/routing/route.h"

namespace cosiva::zone {
namespace {

// Stations times sections: the limit of the work for checking every station from every other.
constexpr std::size_t reaching_work_max = 20'000'000;

/// The positions that can be reached from these without entering a closed section; a closed section that a vehicle is
/// on may be left.
class Reachable {
 public:
  Reachable(const TrafficZone& zone, std::span<const TrackPosition> from)
      : from_{from}, entered_(zone.circuit.size(), false) {
    for (const SectionId id : zone.closed) entered_[id] = true;  // as if visited: no vehicle goes there
    std::vector<SectionId> open;
    const auto leave = [&](SectionId id) {
      for (const SectionId after : zone.circuit.next(id)) {
        if (entered_[after]) continue;
        entered_[after] = true;
        open.push_back(after);
      }
    };
    for (const TrackPosition& track_position : from) leave(track_position.section);
    while (!open.empty()) {
      const SectionId id = open.back();
      open.pop_back();
      leave(id);
    }
    for (const SectionId id : zone.closed) entered_[id] = false;
  }

  [[nodiscard]] bool reaches(TrackPosition goal) const {
    return entered_[goal.section] || std::any_of(from_.begin(), from_.end(), [&](const TrackPosition& from) {
             return from.section == goal.section && from.s_m <= goal.s_m;
           });
  }

 private:
  std::span<const TrackPosition> from_;
  std::vector<bool> entered_;
};

std::string metres(double value_m) { return metres_text(value_m) + " m"; }

class Checker {
 public:
  Checker(const TrafficZone& zone, const CheckLimits& limits) : zone_{zone}, circuit_{zone.circuit}, limits_{limits} {}

  std::vector<Problem> run() {
    joints();
    bends();
    ends();
    stations();
    starts();
    unread();
    single_tracks();
    count_those_left_out();
    std::stable_sort(found_.begin(), found_.end(), [](const Problem& a, const Problem& b) {
      return std::tuple(a.severity, std::string_view{a.code}) < std::tuple(b.severity, std::string_view{b.code});
    });
    return std::move(found_);
  }

 private:
  using Severity = Problem::Severity;

  void record(Severity severity, std::string code, TrackPosition track_position, std::string text) {
    auto& [count, last] = counts_[code];
    last = track_position;
    if (++count > listed_max(code)) return;
    found_.push_back(
        {severity, std::move(code), track_position, position(circuit_.pose_at(track_position)), std::move(text)});
  }

  [[nodiscard]] std::size_t listed_max(std::string_view code) const {
    return code == "zone.single_track" ? std::min(limits_.single_tracks, limits_.of_one_code) : limits_.of_one_code;
  }

  void count_those_left_out() {
    for (const auto& [code, counted] : counts_) {
      const auto& [count, last] = counted;
      if (count <= listed_max(code)) continue;
      found_.push_back({Severity::warning, code, last, position(circuit_.pose_at(last)),
                        "and " + std::to_string(count - listed_max(code)) + " more like those above, up to here"});
    }
  }

  [[nodiscard]] std::string name(SectionId id) const { return "'" + circuit_.part(id).name + "'"; }
  [[nodiscard]] TrackPosition end_of(SectionId id) const { return {id, circuit_.section(id).length_m()}; }

  void joints() {
    for (SectionId id = 0; id < circuit_.size(); ++id) {
      for (const SectionId after : circuit_.next(id)) {
        const Pose2& end = circuit_.section(id).end();
        const Pose2& start = circuit_.section(after).start();
        const double gap_m = distance(end, start);
        if (gap_m > limits_.gap_m)
          record(Severity::error, "circuit.gap", end_of(id),
                 name(id) + " ends " + metres(gap_m) + " from where " + name(after) + " starts; bring them together");
        const double kink_rad = std::fabs(wrap_angle(start.heading_rad - end.heading_rad));
        if (kink_rad > limits_.kink_rad && !circuit_.part(id).pivots)
          record(Severity::error, "circuit.kink", end_of(id),
                 "the path turns by " + metres_text(kink_rad / rad_per_deg) + "° at once from " + name(id) + " to " +
                     name(after) + "; round it, or let vehicles turn on the spot there");
      }
    }
  }

  void bends() {
    for (SectionId id = 0; id < circuit_.size(); ++id) {
      const Section& section = circuit_.section(id);
      const double bend = section.curvature_max_per_m();
      if (bend <= 0.0) continue;
      const bool at_start = std::fabs(section.curvature_at(0.0)) >= bend;
      const TrackPosition track_position = at_start ? TrackPosition{id, 0.0} : end_of(id);
      if (0.5 * zone_.vehicle.width_m * bend >= 1.0) {
        record(Severity::error, "zone.vehicle", track_position,
               name(id) + " bends with a radius of " + metres(1.0 / bend) + ", less than half the vehicle's width of " +
                   metres(zone_.vehicle.width_m) + "; widen the bend");
      }
      const double speed_mps = std::min(circuit_.part(id).speed_mps_max.value_or(zone_.profiles.fast.speed_mps),
                                        zone_.profiles.fast.speed_mps);
      const double lateral_mps2 = speed_mps * speed_mps * bend;
      if (lateral_mps2 > limits_.lateral_mps2) {
        record(Severity::warning, "zone.speed", track_position,
               "at " + metres_text(speed_mps) + " m/s vehicles are pushed outward with " + metres_text(lateral_mps2) +
                   " m/s² in " + name(id) + "; limit it to " +
                   metres_text(std::floor(100.0 * std::sqrt(limits_.lateral_mps2 / bend)) / 100.0) + " m/s");
      }
    }
  }

  void ends() {
    const auto goes_on = Router{zone_}.goes_on_for_ever();
    for (SectionId id = 0; id < circuit_.size(); ++id) {
      if (circuit_.next(id).empty())
        record(Severity::warning, "zone.dead_end", end_of(id),
               "nothing follows " + name(id) + "; a vehicle that drives to its end stays there");
      else if (!goes_on[id])
        record(Severity::warning, "zone.no_return", {id, 0.0},
               "all routes from " + name(id) + " end; a vehicle that drives in cannot return");
      if (circuit_.previous(id).empty())
        record(Severity::warning, "zone.no_entry", {id, 0.0},
               "no section leads to " + name(id) + "; only vehicles that start there drive on it");
    }
  }

  void stations() {
    const auto& all = zone_.stations;
    const Reachable reached{zone_, zone_.starts};
    for (const Station& station : all) {
      if (const Crossing* crossing = zone_.crossing_at(station.position))
        record(Severity::warning, "zone.station", station.position,
               "a vehicle at station '" + station.name + "' blocks all others at crossing " + crossing->name);
      if (!zone_.starts.empty() && !reached.reaches(station.position))
        record(Severity::error, "zone.unreachable", station.position,
               "station '" + station.name + "' cannot be reached from any of the starts");
    }
    // From every other station, as long as the search does not take minutes.
    const std::size_t requested = std::min(all.size(), reaching_work_max / (circuit_.size() + all.size()) + 1);
    // the number of stations, and the first of them
    std::vector<std::pair<std::size_t, std::size_t>> cut_off(all.size());
    for (std::size_t from = 0; from < requested; ++from) {
      const Reachable onward{zone_, std::span{&all[from].position, 1}};
      for (std::size_t to = 0; to < all.size(); ++to)
        if (to != from && !onward.reaches(all[to].position) && cut_off[to].first++ == 0) cut_off[to].second = from;
    }
    for (std::size_t to = 0; to < all.size(); ++to) {
      const auto [count, first] = cut_off[to];
      if (count == 0) continue;
      std::string from = "'" + all[first].name + "'";
      if (count > 1) from += " and " + std::to_string(count - 1) + " other" + (count > 2 ? "s" : "");
      record(Severity::warning, "zone.unreachable", all[to].position,
             "station '" + all[to].name + "' cannot be reached from station " + from);
    }
  }

  void starts() {
    const double room_m = stopping_room_m(zone_.vehicle);
    std::vector<Point2> taken;
    for (const TrackPosition& start : zone_.starts) {
      const Point2 p = position(circuit_.pose_at(start));
      const bool free = std::none_of(taken.begin(), taken.end(), [&](Point2 q) { return distance(p, q) < room_m; });
      const std::string which = "start " + std::to_string(taken.size() + 1);
      // At a node or a station of the file a vehicle begins even inside a crossing (TrafficZone::start_positions).
      if ((zone_.crossing_at(start) != nullptr || !zone_.may_stop(start)) && !is_at_waypoint(zone_, start))
        record(Severity::error, "zone.start", start, which + " lies where no vehicle may stop");
      else if (!free)
        record(Severity::warning, "zone.start", start,
               which + " is nearer than " + metres(room_m) + " to one before it; no vehicle begins here");
      if (std::binary_search(zone_.closed.begin(), zone_.closed.end(), start.section))
        record(Severity::warning, "zone.start", start, which + " lies on a closed section");
      taken.push_back(p);
    }
  }

  void unread() {
    const Stretch stretch = longest_unread(zone_);
    if (!stretch.endless && stretch.length_m <= limits_.unread_max_m) return;
    record(Severity::warning, "zone.unread", stretch.from,
           stretch.endless ? "a vehicle can circulate for ever without a tag or a beacon, " + metres(stretch.length_m) +
                                 " each time; lay a tag"
                           : "there is neither tag nor beacon for " + metres(stretch.length_m) + " from here to " +
                                 name(stretch.to.section) + "; expected one every " + metres(limits_.unread_max_m));
  }

  /// Two sections with the same path, driven in opposite directions.
  void single_tracks() {
    const std::vector<SectionId> other = opposites(zone_);
    for (SectionId id = 0; id < circuit_.size(); ++id) {
      if (other[id] == no_section || other[id] > id) continue;
      record(Severity::warning, "zone.single_track", {id, 0.0},
             name(id) + " and " + name(other[id]) + " are one track of " + metres(circuit_.section(id).length_m()) +
                 " driven both ways; only one vehicle at a time can use it");
    }
  }

  const TrafficZone& zone_;
  const Circuit& circuit_;
  const CheckLimits& limits_;
  std::vector<Problem> found_;
  std::map<std::string, std::pair<std::size_t, TrackPosition>> counts_;
};

}  // namespace

std::string_view to_string(Problem::Severity severity) {
  switch (severity) {
    case Problem::Severity::error: return "error";
    case Problem::Severity::warning: return "warning";
    case Problem::Severity::notice: return "notice";
  }
  return "?";
}

std::string to_string(const Problem& problem, const TrafficZone& zone) {
  std::string text{to_string(problem.severity)};
  text += " ";
  text += problem.code + " at '" + zone.circuit.part(problem.position.section).name + "' ";
  text += metres_text(problem.position.s_m) + " m (" + metres_text(problem.at.x_m) + ", " + metres_text(problem.at.y_m);
  return text + "): " + problem.text;
}

std::vector<Problem> problems(const TrafficZone& zone, const CheckLimits& limits) {
  return Checker{zone, limits}.run();
}

}  // namespace cosiva::zone
