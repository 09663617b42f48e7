#pragma once

#include <span>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::zone {

/// A route through the graph of sections.
struct Route {
  std::vector<SectionId> sections;  ///< the starting section first, the goal's last
  double length_m{};
  double time_s{};  ///< at each section's limit or the fast profile, turns on the spot included
};

/// The assumed speed of turns on the spot.
inline constexpr double pivot_rate_radps = 1.0;

/// Plans routes by travel time (Dijkstra). The closed sections are given with each call: they are never entered; a
/// vehicle on one may leave it. Equal times are decided by the lower section number, so that a plan is the same on
/// every machine.
class Router {
 public:
  /// @param zone  must outlive the router
  explicit Router(const TrafficZone& zone);

  /// To a position. Fails ("route.none") with a sentence: whether there is no route at all, or which closed section is
  /// on it.
  [[nodiscard]] Result<Route> plan(TrackPosition from, TrackPosition goal,
                                   std::span<const SectionId> closed = {}) const;
  /// To the first section of a loop that is reached, and from there one lap: up to the end of the section before it in
  /// the loop. Around a closed section of the loop the quickest detour is taken. Where the route begins on the loop,
  /// the lap begins there.
  [[nodiscard]] Result<Route> plan(TrackPosition from, const Loop& loop, std::span<const SectionId> closed = {}) const;

  /// Sections from which a vehicle can drive on for ever without entering a closed one; the others lead into dead ends
  /// only.
  [[nodiscard]] std::vector<bool> goes_on_for_ever(std::span<const SectionId> closed = {}) const;

  /// Travel time of a whole section, the turn before it not included.
  [[nodiscard]] double section_time_s(SectionId section) const;
  /// Of a turn on the spot between two sections; 0 where there is none.
  [[nodiscard]] double turn_time_s(SectionId from, SectionId to) const;

 private:
  const TrafficZone* zone_;
};

}  // namespace cosiva::zone
