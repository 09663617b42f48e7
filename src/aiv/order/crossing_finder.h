#pragma once

#include <cstddef>
#include <vector>

#include "cosiva/aiv/motion/outlook.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::aiv {

/// One crossing on the way ahead, with its zone's index. Distances from the vehicle's middle, along its way.
struct CrossingSpan {
  std::size_t crossing;
  double entry_m;         ///< 0 where it is inside
  double exit_m;          ///< > 0
  double chain_exit_m{};  ///< of the last crossing that follows too closely to stand before it
};

/// Which crossings a vehicle comes to, by name, where CrossingLookAhead tells only that there is one.
class CrossingFinder {
 public:
  explicit CrossingFinder(const zone::TrafficZone& zone);

  /// Those that the vehicle is in or enters within `reach_m`, and those chained to them, in the order of their entries;
  /// at most `count_max`. Replaces what was in `out`.
  void ahead(const Outlook& outlook, double reach_m, std::size_t count_max, std::vector<CrossingSpan>& out) const;

 private:
  struct Span {
    double from_m;
    double to_m;
    std::size_t crossing;
  };
  const zone::Circuit& circuit_;
  double gap_m_;                          ///< shorter gaps chain
  std::vector<std::vector<Span>> spans_;  ///< by section, in order of s
};

}  // namespace cosiva::aiv
