#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/pose.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::virtual_side {

using WaypointIndex = std::uint32_t;
inline constexpr WaypointIndex no_waypoint = std::numeric_limits<WaypointIndex>::max();
using CrossingIndex = std::uint32_t;
/// The sections after the present one, in driving order.
using Sections = std::span<const zone::SectionId>;

/// The zone as master control uses it: waypoints and the stretches between them, computed once per zone so that
/// extending orders compares no text. At a fork, `coming` determines the branch; beyond its end, and without it, routes
/// follow default successors.
///
/// Invariant: the waypoints of the zone are sorted by section, so that those of a section are consecutive, and each has
/// its point and its stretches here; a zone that take() accepts has the same waypoints.
class WaypointGraph {
 public:
  explicit WaypointGraph(std::shared_ptr<const zone::TrafficZone> zone);

  [[nodiscard]] const zone::TrafficZone& zone() const { return *zone_; }
  [[nodiscard]] const zone::Circuit& circuit() const { return zone_->circuit; }
  /// Replaces the zone by one with identical waypoints, crossings and stretches. False: the zones differ, and nothing
  /// is changed.
  bool take(std::shared_ptr<const zone::TrafficZone> zone);
  [[nodiscard]] std::size_t size() const { return points_.size(); }
  [[nodiscard]] std::size_t crossing_count() const { return zone_->crossings.size(); }

  /// From a waypoint to the next one.
  struct Stretch {
    WaypointIndex to{no_waypoint};  ///< no_waypoint where the circuit ends
    double length_m{};
    std::optional<double> speed_mps_max;
    bool crosses{false};  ///< contains a crossing's span: may be released only to the crossing's holder
    std::vector<zone::SectionId> sections;  ///< after the section of its start; the last contains its end
    std::string edge_id;                    ///< "<from>-<to>", or the section's name where the format names its edges
  };
  /// All stretches that start at a waypoint, one for each branch; the one along default successors first.
  [[nodiscard]] std::span<const Stretch> stretches(WaypointIndex from) const {
    return {stretches_.data() + first_stretch_[from], stretches_.data() + first_stretch_[from + 1]};
  }
  /// The stretch along `coming`; null: the circuit ends, or no stretch takes that branch.
  [[nodiscard]] const Stretch* along(WaypointIndex from, Sections remaining) const;
  /// The stretch along default successors; its `to` is no_waypoint where the circuit ends.
  [[nodiscard]] const Stretch& stretch(WaypointIndex from) const;

  /// The stretches from a stop line on that must be granted together, since a vehicle cannot stop between them.
  struct Chain {
    WaypointIndex exit{no_waypoint};
    double length_m{};
  };
  static constexpr std::size_t chain_max =
      16;  ///< stretches; where every path crosses another, one vehicle must go first
  /// @param goal  where `coming` ends and the vehicle will stop, even in a crossing; no_waypoint: none
  [[nodiscard]] Chain chain(WaypointIndex stop, Sections remaining = {}, WaypointIndex goal = no_waypoint) const;

  [[nodiscard]] const zone::Waypoint& waypoint(WaypointIndex index) const { return zone_->waypoints[index]; }
  [[nodiscard]] Point2 point(WaypointIndex index) const { return points_[index]; }
  /// The first waypoint of a section; no_waypoint: it has none.
  [[nodiscard]] WaypointIndex first_on(zone::SectionId section) const;
  /// All waypoints of an id, ascending: the same point on several sections.
  [[nodiscard]] std::span<const WaypointIndex> find(std::string_view id) const;

  /// The last waypoint at or before `place`, on its section or, back through `gone` and then `previous`, on an earlier
  /// section. Nothing: there is none.
  struct Behind {
    WaypointIndex waypoint;
    double since_m;                         ///< distance from the waypoint to `place`
    std::vector<zone::SectionId> sections;  ///< after the waypoint's own, up to `place`'s
  };
  [[nodiscard]] std::optional<Behind> behind(zone::TrackPosition position, Sections traversed = {}) const;
  /// The first waypoint at or after `place`.
  struct FirstAhead {
    WaypointIndex waypoint;
    double distance_m;
    std::size_t sections;  ///< of `coming`, up to the waypoint's own
  };
  [[nodiscard]] std::optional<FirstAhead> first_ahead(zone::TrackPosition position, Sections remaining) const;
  /// `place`, and the starts of all sections that begin at the waypoint at `place`: a vehicle that is stopped on a node
  /// may leave by any section that it could have reached there.
  [[nodiscard]] std::vector<zone::TrackPosition> starts(zone::TrackPosition position) const;
  /// The waypoint of the same id at which `section` begins; no_waypoint: there is none.
  [[nodiscard]] WaypointIndex sibling_on(WaypointIndex waypoint, zone::SectionId section) const;

  [[nodiscard]] std::optional<double> ahead(zone::TrackPosition from, zone::TrackPosition to, double limit_m,
                                            Sections remaining = {}) const {
    return zone_->circuit.distance_ahead(from, to, limit_m, remaining);
  }
  /// Distance from `place` to the end `end` of a base: 0 at the end or slightly beyond; nothing when the end is not
  /// within `limit_m` ahead.
  /// @param passed  the vehicle has reported that it passed the end: an end just behind `place` is then not one lap
  /// ahead
  [[nodiscard]] std::optional<double> base_left(zone::TrackPosition position, WaypointIndex end, double limit_m,
                                                Sections remaining = {}, bool passed = true) const;

  /// The route over the remaining nodes that a vehicle at `place` reports.
  struct Through {
    std::vector<zone::SectionId> sections;  ///< place.section first
    WaypointIndex end;                      ///< of ids[released - 1]
    std::size_t to_end;                     ///< sections up to `end`'s
  };
  /// @param released  number of released `ids`, at least one
  [[nodiscard]] std::optional<Through> through(zone::TrackPosition position, std::span<const std::string_view> ids,
                                               std::size_t released) const;

  /// Adds to `out`, once each and in driving order, the crossings with a span that a vehicle's body origin is in at
  /// `place` or reaches within the next `distance_m`. A span counts as entered 4 cm behind its start (the clearance
  /// that the span was computed with: a vehicle that stopped slightly late at its stop line is not in the span), and as
  /// left 1 cm behind its end (1 cm before its exit: a vehicle that stopped slightly early there has left it).
  void crossings_on(zone::TrackPosition position, double distance_m, std::vector<CrossingIndex>& out,
                    Sections remaining = {}) const;
  /// Distance from `place` to the end of the last span of that crossing within `distance_m`; 0: there is none.
  [[nodiscard]] double distance_to_exit_m(zone::TrackPosition position, CrossingIndex crossing, double distance_m,
                                          Sections remaining = {}) const;
  /// At a fork: the distance along `section` up to which a body obstructs vehicles on another branch.
  [[nodiscard]] double parted_m(zone::SectionId section) const;

 private:
  struct Span {
    double from_m;
    double to_m;
    CrossingIndex crossing;
  };
  void lay_stretches();
  void lay_stretches_from(WaypointIndex from);
  void finish(WaypointIndex from, Stretch& stretch) const;
  [[nodiscard]] bool is_default(WaypointIndex from, const Stretch& stretch) const;
  void spans_on(zone::SectionId section, double from_m, double to_m, bool stopped,
                std::vector<CrossingIndex>& out) const;

  std::shared_ptr<const zone::TrafficZone> zone_;
  std::vector<Stretch> stretches_;          ///< by start waypoint
  std::vector<std::size_t> first_stretch_;  ///< of each waypoint, plus one past the end
  std::vector<WaypointIndex> first_on_;     ///< of each section, plus one past the end
  std::vector<Point2> points_;
  std::vector<std::vector<Span>> spans_;  ///< by section, sorted
  std::map<std::string, std::vector<WaypointIndex>, std::less<>> by_id_;
  double longest_m_{0.0};  ///< of all stretches
};

}  // namespace cosiva::virtual_side
