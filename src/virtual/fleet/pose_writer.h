#pragma once

#include <cstdint>

#include "cosiva/virtual/fleet/fleet_tables.h"
#include "cosiva/virtual/fleet/paths.h"
#include "cosiva/zone/circuit/pose_table.h"

namespace cosiva::virtual_side {

/// Computes poses from track positions. Invariant: vehicles first…last of a call exist; only their poses are written.
class PoseWriter {
 public:
  PoseWriter(FleetTables& tables, const Paths& paths);

  /// Writes the poses of vehicles first…last.
  void write(std::uint32_t first, std::uint32_t last);
  [[nodiscard]] std::size_t bytes() const { return table_.bytes(); }

 private:
  const Ground& ground_;
  const Numbers& numbers_;
  State& state_;
  const Paths& paths_;
  zone::PoseTable table_;
};

}  // namespace cosiva::virtual_side
