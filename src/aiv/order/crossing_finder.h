#pragma once

#include <cstddef>
#include <vector>

#include "cosiva/aiv/motion/outlook.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::aiv {

/// One crossing on the path ahead, with its index in the zone. Distances from the body origin, along the path.
struct CrossingSpan {
  std::size_t crossing;
  double entry_m;         ///< 0 where the vehicle is inside
  double exit_m;          ///< > 0
  double chain_exit_m{};  ///< of the last crossing that follows too closely to stop before it
};

/// Which crossings a vehicle approaches, by name, where CrossingLookAhead finds only that there is one.
class CrossingFinder {
 public:
  explicit CrossingFinder(const zone::TrafficZone& zone);

  /// The crossings that the vehicle is in or enters within `reach_m`, and those chained to them, in the order of their
  /// entries; at most `count_max`. Replaces the contents of `out`.
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
