#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::zone {

/// A synthetic plant: rows of storage aisles, each row between a lane eastward and a lane westward that make a ring
/// with it. Along the aisles, which are one-way, now north, now south, lie bays: lay-bys with a station each. Chargers
/// lie on the way back at the east end of each row. Neighbouring rows lead to each other at both ends.
struct PlantOptions {
  std::string name{"plant"};
  std::uint32_t rows{4};
  std::uint32_t aisles{8};         ///< per row
  std::uint32_t bays{6};           ///< per aisle, of which some are left out
  double bay_ratio{0.9};           ///< how many of them there are, 0 to 1
  std::uint64_t seed{1};           ///< decides which bays there are, on which side, and how long they are
  VehicleShape vehicle{1.2, 0.8};  ///< everything is laid out to its scale
  std::uint32_t starts{12};        ///< of an emulated fleet, in bays all over the plant; at most so many
};

/// How many sections such a plant has when no bay is left out; with fewer bays it has fewer.
[[nodiscard]] std::size_t plant_sections_max(const PlantOptions& options);

/// Options of a plant of at least `sections` sections (up to 170 000) and not many more.
[[nodiscard]] PlantOptions plant_of_size(std::size_t sections);

}  // namespace cosiva::zone
