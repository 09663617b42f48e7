#include "cosiva/virtual/fleet/fleet_tables.h"

#include <utility>

namespace cosiva::virtual_side {
namespace {

template <typename T>
std::size_t size_of(const std::vector<T>& values) {
  return values.capacity() * sizeof(T);
}

}  // namespace

FleetTables::FleetTables(Ground fleet_ground, const FleetOptions& fleet_options)
    : ground{std::move(fleet_ground)}, options{fleet_options}, numbers{numbers_of(ground.zone(), options)} {
  numbers.has_limits = ground.has_limits();
  numbers.has_turns = ground.has_turns();
}

std::size_t FleetTables::bytes() const {
  std::size_t bytes = sizeof(FleetTables) + ground.bytes() + state.bytes() + size_of(copies) + size_of(front) +
                      size_of(rear) + size_of(crossings) + size_of(blocks) + size_of(routes) + size_of(arrived);
  for (const Block& block : blocks)
    bytes += size_of(block.occupied_steps) + size_of(block.grants) + size_of(block.waited_steps) +
             size_of(block.seen_m) + size_of(block.seen_search) + size_of(block.open);
  for (const Route& route : routes) bytes += size_of(route.sections);
  return bytes;
}

}  // namespace cosiva::virtual_side
