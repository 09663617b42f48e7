#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "cosiva/planning/track/track_floor.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::planning {

struct WellFormedLimits {
  std::size_t work_max{100'000'000};  ///< moves that the searches may examine; about two seconds
};

/// What a fleet can do at the stations of a zone, by searches on the floor of its tracks with the bodies' exact
/// geometry. A layout is well-formed when every station can be reached and left while vehicles are stopped at all other
/// stations: then a plan exists for as many vehicles as there are stations, whatever their order (Ma et al. 2017,
/// "Lifelong Multi-Agent Path Finding for Online Pickup and Delivery Tasks").
///
/// Invariant: there is one finding for each station of the zone.
class WellFormed {
 public:
  struct Finding {
    bool is_entered{false};  ///< a move leads there
    bool is_left{false};     ///< a vehicle that has arrived there can go on for ever, or to another station's point
    bool reaches_another{false};  ///< it can go on to another station, if only one at the same point
    /// Stations that cannot be reached from most others, or not left for them, while a vehicle is stopped here.
    std::vector<std::size_t> cut_off{};
  };

  [[nodiscard]] static WellFormed examine(const zone::TrafficZone& zone, const WellFormedLimits& limits = {});

  [[nodiscard]] const std::vector<Finding>& stations() const noexcept { return stations_; }
  /// The first stations, whose `cut_off` was searched before the work reached its limit.
  [[nodiscard]] std::size_t examined() const noexcept { return examined_; }
  /// The first station that cannot be reached and left while vehicles are stopped at all others; none: the layout is
  /// well-formed.
  [[nodiscard]] std::optional<std::size_t> obstructed() const noexcept { return obstructed_; }

 private:
  class Search;
  explicit WellFormed(std::size_t stations) : stations_(stations) {}

  std::vector<Finding> stations_;
  std::size_t examined_{0};
  std::optional<std::size_t> obstructed_;
};

}  // namespace cosiva::planning
