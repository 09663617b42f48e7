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
/// Sections in the order of driving: those that come after the present one.
using Sections = std::span<const zone::SectionId>;

/// The zone as master control drives it: waypoints and the stretches between them, worked out once per zone so that
/// rolling orders compares no text. Where ways part, `coming` says which is meant; from its end, and without it, ways
/// follow default successors.
class WaypointGraph {
 public:
  explicit WaypointGraph(std::shared_ptr<const zone::TrafficZone> zone);

  [[nodiscard]] const zone::TrafficZone& zone() const { return *zone_; }
  [[nodiscard]] const zone::Circuit& circuit() const { return zone_->circuit; }
  /// Goes on with another zone that has the very same waypoints, crossings and ways. False: it has not, nothing is
  /// done.
  bool take(std::shared_ptr<const zone::TrafficZone> zone);
  [[nodiscard]] std::size_t size() const { return points_.size(); }
  [[nodiscard]] std::size_t crossing_count() const { return zone_->crossings.size(); }

  /// From a waypoint to the next one.
  struct Stretch {
    WaypointIndex to{no_waypoint};  ///< no_waypoint where the way ends
    double length_m{};
    std::optional<double> speed_mps_max;
    bool crosses{false};                    ///< a crossing's span lies on it: it may be released only to who holds it
    std::vector<zone::SectionId> sections;  ///< after the one it starts on; the last is where it ends
    std::string edge_id;                    ///< "<from>-<to>", or the section's name where the format names its edges
  };
  /// All that leave a waypoint, one for each way; that of default successors first.
  [[nodiscard]] std::span<const Stretch> stretches(WaypointIndex from) const {
    return {stretches_.data() + first_stretch_[from], stretches_.data() + first_stretch_[from + 1]};
  }
  /// The one along `coming`; null: the way ends, or no stretch goes that way.
  [[nodiscard]] const Stretch* along(WaypointIndex from, Sections remaining) const;
  /// That of default successors; its `to` is no_waypoint where the way ends.
  [[nodiscard]] const Stretch& stretch(WaypointIndex from) const;

  /// The stretches from a stop line on that must be taken all at once, since one cannot stand between them.
  struct Chain {
    WaypointIndex exit{no_waypoint};
    double length_m{};
  };
  static constexpr std::size_t chain_max = 16;  ///< stretches; where every way crosses another, somebody must begin
  /// @param goal  where `coming` ends and the vehicle will stay, whatever it stands in; no_waypoint: nowhere
  [[nodiscard]] Chain chain(WaypointIndex stop, Sections remaining = {}, WaypointIndex goal = no_waypoint) const;

  [[nodiscard]] const zone::Waypoint& waypoint(WaypointIndex index) const { return zone_->waypoints[index]; }
  [[nodiscard]] Point2 point(WaypointIndex index) const { return points_[index]; }
  /// All waypoints of an id, ascending: the same point, on several sections.
  [[nodiscard]] std::span<const WaypointIndex> find(std::string_view id) const;

  /// The last waypoint at or before `place`, on its section or, going back through `gone` and then `previous`, on one
  /// before it. Nothing: there is none.
  struct Behind {
    WaypointIndex waypoint;
    double since_m;                         ///< way from it to `place`
    std::vector<zone::SectionId> sections;  ///< after its own, up to `place`'s
  };
  [[nodiscard]] std::optional<Behind> behind(zone::TrackPosition position, Sections traversed = {}) const;
  /// The first waypoint at or after `place`.
  struct FirstAhead {
    WaypointIndex waypoint;
    double distance_m;
    std::size_t sections;  ///< of `coming`, up to its own
  };
  [[nodiscard]] std::optional<FirstAhead> first_ahead(zone::TrackPosition position, Sections remaining) const;
  /// `place`, and the starts of all sections that begin at the waypoint it stands on: where ways meet at a node, a
  /// vehicle that stands on it may leave by any of those it could have come to.
  [[nodiscard]] std::vector<zone::TrackPosition> starts(zone::TrackPosition position) const;
  /// Of the waypoint's id, the one where `section` begins; no_waypoint: there is none.
  [[nodiscard]] WaypointIndex sibling_on(WaypointIndex waypoint, zone::SectionId section) const;

  [[nodiscard]] std::optional<double> ahead(zone::TrackPosition from, zone::TrackPosition to, double limit_m,
                                            Sections remaining = {}) const {
    return zone_->circuit.distance_ahead(from, to, limit_m, remaining);
  }
  /// Way from `place` to a base that ends at `end`: 0 when it stands there or a little beyond; nothing when the end is
  /// not within `limit_m` ahead.
  /// @param passed  it has said that it passed the end, so that what is just behind is not one lap ahead
  [[nodiscard]] std::optional<double> base_left(zone::TrackPosition position, WaypointIndex end, double limit_m,
                                                Sections remaining = {}, bool passed = true) const;

  /// The way over nodes that a vehicle at `place` reports as left to drive.
  struct Through {
    std::vector<zone::SectionId> sections;  ///< place.section first
    WaypointIndex end;                      ///< of ids[released - 1]
    std::size_t to_end;                     ///< sections up to `end`'s
  };
  /// @param released  so many of `ids` are released, at least one
  [[nodiscard]] std::optional<Through> through(zone::TrackPosition position, std::span<const std::string_view> ids,
                                               std::size_t released) const;

  /// Adds to `out`, once each and in order of the way, the crossings with a span that a vehicle's middle is in at
  /// `place` or meets over the next `distance_m`. A span counts as entered 4 cm behind its start (the clearance it was
  /// found with: a vehicle that stopped a little late at its stop line is not in it) and as left 1 cm behind its end (1
  /// cm before its exit: so is one that stopped a little early there).
  void crossings_on(zone::TrackPosition position, double distance_m, std::vector<CrossingIndex>& out,
                    Sections remaining = {}) const;
  /// From `place` to where the last span of that crossing within `distance_m` is left; 0: there is none.
  [[nodiscard]] double distance_to_exit_m(zone::TrackPosition position, CrossingIndex crossing, double distance_m,
                                          Sections remaining = {}) const;
  /// Where ways part: so far along `section` a body still is in the way of those who take another branch.
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
  [[nodiscard]] WaypointIndex first_on(zone::SectionId section) const;

  std::shared_ptr<const zone::TrafficZone> zone_;
  std::vector<Stretch> stretches_;          ///< by the waypoint they start at
  std::vector<std::size_t> first_stretch_;  ///< of each waypoint, and one behind the last
  std::vector<WaypointIndex> first_on_;     ///< of each section, and one behind the last
  std::vector<Point2> points_;
  std::vector<std::vector<Span>> spans_;  ///< by section, sorted
  std::map<std::string, std::vector<WaypointIndex>, std::less<>> by_id_;
  double longest_m_{0.0};  ///< of all stretches
};

}  // namespace cosiva::virtual_side
