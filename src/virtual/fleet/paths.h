#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "cosiva/virtual/fleet/fleet_tables.h"

namespace cosiva::virtual_side {

/// Follows vehicles' paths from section to section.
class Paths {
 public:
  /// Goes from section to section along a vehicle's path.
  struct Path {
    zone::SectionId section;
    std::uint32_t step;                      ///< in the route
    std::span<const zone::SectionId> route;  ///< beyond its end the vehicle circulates
    bool ends;                               ///< with the route
  };
  explicit Paths(const FleetTables& tables);

  /// The path of vehicle i from its present section.
  [[nodiscard]] Path path_of(std::uint32_t i) const;
  /// The next section; no_section: the route ends there, or the path does.
  [[nodiscard]] zone::SectionId next(const Path& path) const;
  /// The next section, as if a route did not end with its goal: bodies beyond the goal count.
  [[nodiscard]] zone::SectionId beyond(const Path& path) const;
  /// Advances to `section`, which must follow.
  static void advance(Path& path, zone::SectionId section);

 private:
  const Ground& ground_;
  const State& state_;
  const std::vector<FleetTables::Route>& routes_;
};

}  // namespace cosiva::virtual_side
