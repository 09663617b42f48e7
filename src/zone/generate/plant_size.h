#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::zone {

/// A synthetic factory layout: rows of storage aisles, each row between a lane eastward and a lane westward that form a
/// loop with it. Along the aisles, which are one-way, alternately north and south, lie bays: lay-bys with a station
/// each. Chargers lie on the return lane at the east end of each row. Neighbouring rows lead to each other at both
/// ends.
struct PlantOptions {
  std::string name{"plant"};
  std::uint32_t rows{4};
  std::uint32_t aisles{8};         ///< per row
  std::uint32_t bays{6};           ///< per aisle, of which some are left out
  double bay_ratio{0.9};           ///< ratio of bays that exist, 0 to 1
  std::uint64_t seed{1};           ///< decides the bays' existence, side and length
  VehicleShape vehicle{1.2, 0.8};  ///< all dimensions are in proportion to it
  std::uint32_t starts{12};        ///< of an emulated fleet, in bays all over the layout; at most so many
};

/// The number of sections of such a layout when no bay is left out; with fewer bays it has fewer.
[[nodiscard]] std::size_t plant_sections_max(const PlantOptions& options);

/// Options of a layout of at least `sections` sections (up to 170 000) and not many more.
[[nodiscard]] PlantOptions plant_of_size(std::size_t sections);

}  // namespace cosiva::zone
