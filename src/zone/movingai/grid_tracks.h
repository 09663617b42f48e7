#pragma once

#include <string>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/zone/circuit/circuit.h"
#include "cosiva/zone/grid/grid.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::zone {

/// The tracks of a grid: from each free square's centre to those of its free neighbours, one section in each direction.
/// At the centres vehicles turn on the spot onto any track that leaves there: straight on by default, back as the last
/// choice.
struct GridTracks {
  std::vector<Circuit::Part> parts;
  std::vector<std::string> start_ids;  ///< by section: the node's id, "x3y7" in column 3 of row 7, both from 0
  std::vector<Station> stations;       ///< at the grid's stops, "S1", "S2", … in the order of the rows
  BeaconGrid beacons;                  ///< one in the centre of each square
  std::vector<Diagnostic> diagnostics;
};

/// The centre of the last row's first square is the origin of the map frame; rows lead east, and the first row is the
/// northernmost one.
/// Fails ("circuit.empty") where no two free squares are neighbours, ("zone.size") where there are too many of them.
/// @param pitch_m  of the squares
[[nodiscard]] Result<GridTracks> lay_grid_tracks(const Grid& grid, double pitch_m);

}  // namespace cosiva::zone
