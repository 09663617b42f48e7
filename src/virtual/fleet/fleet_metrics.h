#pragma once

#include <cstddef>
#include <cstdint>

#include "cosiva/virtual/fleet/fleet_tables.h"

namespace cosiva::virtual_side {

// Metrics of a fleet since its start, as documented at Fleet's functions of the same names.

[[nodiscard]] Fleet::CrossingMetrics crossing_metrics(const FleetTables& tables, std::size_t crossing);
[[nodiscard]] SimDuration occupancy(const FleetTables& tables, zone::SectionId section);
[[nodiscard]] double smallest_gap_m(const FleetTables& tables);
[[nodiscard]] std::uint64_t collisions(const FleetTables& tables);
[[nodiscard]] std::uint64_t fleet_digest(const FleetTables& tables);

}  // namespace cosiva::virtual_side
