#pragma once

#include <span>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::zone {

/// A way through the graph of sections.
struct Route {
  std::vector<SectionId> sections;  ///< the one it begins on first, the goal's last
  double length_m{};
  double time_s{};  ///< at each section's limit or the fast profile, turns on the spot included
};

/// How fast vehicles are taken to turn on the spot.
inline constexpr double pivot_rate_radps = 1.0;

/// Plans ways by travel time (Dijkstra). Which sections are closed is said each time: they are never entered; one that
/// a vehicle stands on it may leave. Equal times are decided by the lower section number, so that a plan is the same
/// everywhere.
class Router {
 public:
  /// @param zone  must outlive the router
  explicit Router(const TrafficZone& zone);

  /// To a place. Fails ("route.none") with a sentence: whether there is no way at all, or which closed section is in
  /// it.
  [[nodiscard]] Result<Route> plan(TrackPosition from, TrackPosition goal,
                                   std::span<const SectionId> closed = {}) const;
  /// To the first section of a loop that is reached, and from there once round: up to the end of the section before it
  /// in the loop. Round a closed section of the loop the quickest detour is taken. Where the way begins on the loop,
  /// it begins there.
  [[nodiscard]] Result<Route> plan(TrackPosition from, const Loop& loop, std::span<const SectionId> closed = {}) const;

  /// Sections from which one can drive on for ever without entering a closed one; the others lead into dead ends only.
  [[nodiscard]] std::vector<bool> goes_on_for_ever(std::span<const SectionId> closed = {}) const;

  /// Travel time of a whole section, the turn before it not included.
  [[nodiscard]] double section_time_s(SectionId section) const;
  /// Of a turn on the spot between two sections; 0 where there is none.
  [[nodiscard]] double turn_time_s(SectionId from, SectionId to) const;

 private:
  const TrafficZone* zone_;
};

}  // namespace cosiva::zone
