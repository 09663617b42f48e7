#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/pose.h"
#include "zone/traffic_zone.h"

namespace cosiva::virtual_side {

using WaypointIndex = std::uint32_t;
inline constexpr WaypointIndex no_waypoint = std::numeric_limits<WaypointIndex>::max();
using CrossingIndex = std::uint32_t;

/// The zone as master control drives it: waypoints and the stretches between them, worked out once per zone so that
/// rolling orders compares no text. Ways follow default successors.
class WayMap {
 public:
  explicit WayMap(std::shared_ptr<const zone::TrafficZone> zone);

  [[nodiscard]] const zone::TrafficZone& zone() const { return *zone_; }
  /// Goes on with another zone that has the very same waypoints, crossings and ways. False: it has not, nothing is
  /// done.
  bool take(std::shared_ptr<const zone::TrafficZone> zone);
  [[nodiscard]] std::size_t size() const { return stretches_.size(); }
  [[nodiscard]] std::size_t crossing_count() const { return zone_->crossings.size(); }

  /// From a waypoint to the next one.
  struct Stretch {
    WaypointIndex to{no_waypoint};  ///< no_waypoint where the way ends
    double length_m{};
    std::optional<double> speed_mps_max;
    bool crosses{false};                    ///< a crossing's span lies on it: it may be released only to who holds it
    WaypointIndex chain_exit{no_waypoint};  ///< where one may stand again, after all crossings without room between
    double chain_m{};                       ///< way to chain_exit
    std::string edge_id;                    ///< "<from>-<to>"
  };
  [[nodiscard]] const Stretch& stretch(WaypointIndex from) const { return stretches_[from]; }
  [[nodiscard]] const zone::Waypoint& waypoint(WaypointIndex index) const { return zone_->waypoints[index]; }
  [[nodiscard]] Point2 point(WaypointIndex index) const { return points_[index]; }

  [[nodiscard]] std::optional<WaypointIndex> find(std::string_view id) const;
  /// The last waypoint at or before `place`; no_waypoint when there is none.
  [[nodiscard]] WaypointIndex behind(zone::Place place) const;
  [[nodiscard]] std::optional<double> ahead(zone::Place from, zone::Place to, double limit_m) const {
    return zone_->circuit.distance_ahead(from, to, limit_m);
  }
  /// Way from `place` to a base that ends at `end`: 0 when it stands there or a little beyond; nothing when the end is
  /// not within `limit_m` ahead.
  [[nodiscard]] std::optional<double> base_left(zone::Place place, WaypointIndex end, double limit_m) const;

  /// Adds to `out`, once each and in order of the way, the crossings with a span that a vehicle's middle is in at
  /// `place` or meets over the next `distance_m`. A span counts as entered 4 cm behind its start (the clearance it was
  /// found with: a vehicle that stopped a little late at its stop line is not in it) and as left 2 cm behind its end.
  void crossings_on(zone::Place place, double distance_m, std::vector<CrossingIndex>& out) const;

 private:
  struct Span {
    double from_m;
    double to_m;
    CrossingIndex crossing;
  };
  void lay_stretches();
  void lay_chains();
  void spans_on(zone::SectionId section, double from_m, double to_m, bool standing,
                std::vector<CrossingIndex>& out) const;

  std::shared_ptr<const zone::TrafficZone> zone_;
  std::vector<Stretch> stretches_;  ///< by the waypoint it starts at
  std::vector<Point2> points_;
  std::vector<std::vector<Span>> spans_;  ///< by section, sorted
  std::map<std::string, WaypointIndex, std::less<>> by_id_;
};

}  // namespace cosiva::virtual_side
