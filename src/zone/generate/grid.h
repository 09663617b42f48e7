#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "cosiva/base/result.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::zone {

/// A floor of columns and rows of nodes, `pitch_m` apart, joined by tracks. Nodes are named as the cells of a
/// spreadsheet, from A1 in the south-west. Bays are dead ends one vehicle deep outside the border, each with a station;
/// without bays every second node of the border is a station.
struct GridOptions {
  std::string name{"grid"};
  std::uint32_t columns{6};
  std::uint32_t rows{5};
  double pitch_m{3.0};
  std::uint32_t bays{0};
  /// Each track has a section in each direction. Otherwise rows and columns lead alternately one way and the other, and
  /// those at the border round the floor, so that every node reaches every other one.
  bool two_way{false};
  std::uint64_t seed{1};  ///< decides where the first bay and the first start are
  VehicleShape vehicle{1.2, 0.8};
  std::uint32_t starts{24};  ///< of an emulated fleet, at nodes all over the floor; at most so many
};

/// A loop of nodes, `pitch_m` apart along it, joined by tracks driven both ways. Bays lie outside it, at different
/// nodes; without bays every second node is a station.
struct LoopOptions {
  std::string name{"loop"};
  std::uint32_t nodes{12};
  double pitch_m{3.0};
  std::uint32_t bays{0};
  std::uint64_t seed{1};  ///< decides where the first bay and the first start are
  VehicleShape vehicle{1.2, 0.8};
  std::uint32_t starts{24};
};

/// The native file (TOML) of such a floor; the same options always give the same text. Fails ("generate.options") when
/// they make no floor.
[[nodiscard]] Result<std::string> generate_grid(const GridOptions& options);
[[nodiscard]] Result<std::string> generate_loop(const LoopOptions& options);

}  // namespace cosiva::zone
