#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "cosiva/virtual/fleet/fleet_tables.h"
#include "cosiva/virtual/fleet/paths.h"

namespace cosiva::virtual_side {

/// Finds what lies ahead of a vehicle on its path: stop lines, limits and the next event.
/// Invariant: a vehicle with a stop line ahead knows the chain of crossings that begins there.
class PathSurvey {
 public:
  PathSurvey(FleetTables& tables, const Paths& paths);

  /// Finds line_at, halt_at and the limits on the path ahead of vehicle i.
  void survey(std::uint32_t i);
  /// The chain that begins at `line` and follows `path`; no_chain if there is none.
  [[nodiscard]] std::uint32_t find_chain(const Ground::Line& line, const Paths::Path& path) const;
  /// Whether each line on `route` up to `goal_s_m` on its last section has a chain that follows the route.
  [[nodiscard]] bool has_chains(std::span<const zone::SectionId> route, double goal_s_m) const;
  /// Finds the next position where vehicle i needs more than a plain move.
  void set_event(std::uint32_t i);

 private:
  [[nodiscard]] std::uint32_t match(const Ground::Line& line, const Paths::Path& path) const;

  const Ground& ground_;
  const Numbers& numbers_;
  State& state_;
  const Paths& paths_;
};

}  // namespace cosiva::virtual_side
