#include "cosiva/virtual/fleet/fleet_tables.h"

#include <utility>

namespace cosiva::virtual_side {

FleetTables::FleetTables(Ground fleet_ground, const FleetOptions& fleet_options)
    : ground{std::move(fleet_ground)}, options{fleet_options}, numbers{numbers_of(ground.zone(), options)} {
  numbers.has_limits = ground.has_limits();
  numbers.has_turns = ground.has_turns();
}

std::size_t FleetTables::bytes() const {
  std::size_t bytes = sizeof(FleetTables) + ground.bytes() + state.bytes() + allocated_bytes(copies) +
                      allocated_bytes(front) + allocated_bytes(rear) + allocated_bytes(crossings) +
                      allocated_bytes(blocks) + allocated_bytes(routes) + allocated_bytes(arrived);
  for (const Block& block : blocks)
    bytes += allocated_bytes(block.occupied_steps) + allocated_bytes(block.grants) +
             allocated_bytes(block.waited_steps) + allocated_bytes(block.detected_m) +
             allocated_bytes(block.detection_search) + allocated_bytes(block.open);
  for (const Route& route : routes) bytes += allocated_bytes(route.sections);
  return bytes;
}

}  // namespace cosiva::virtual_side
