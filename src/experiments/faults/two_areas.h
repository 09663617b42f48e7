#pragma once

#include "cosiva/zone/layout/circuit_factory.h"

namespace cosiva::experiments {

/// The zones of two control areas on one floor, in the form of docs/guide/control_areas.md: two loops that are driven
/// side by side, and two lines that lead from one to the other, one for each direction. The straight part of each line
/// belongs to both control areas and has a transfer point, so that the vehicles of two control areas never merge
/// without a server that knows both.
///
/// ```
///      a_west ( a_far, rack_a  <- ) a_east
///               a_1  a_2     a_3 ->
///                 \          /
///               ab |        | ba
///                 \          /
///               b_1  b_2  b_3   ->
///      b_west ( b_far, rack_b  <- ) b_east
/// ```
struct TwoAreas {
  zone::ZoneConfiguration floor;  ///< all paths, with start positions for four vehicles
  zone::ZoneConfiguration a;      ///< with the stations "rack_a" and "to_b", the transfer point
  zone::ZoneConfiguration b;      ///< with the stations "rack_b" and "to_a"
};
[[nodiscard]] TwoAreas two_areas();

}  // namespace cosiva::experiments
