#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "cosiva/base/pose.h"

namespace cosiva::experiments {

/// Reach of the direct link of a world.
struct RadioReach {
  double vehicles_m{};  ///< between two vehicles
  double units_m{};     ///< between a crossing unit, whose antenna is above the floor, and a vehicle or another unit
};

/// The positions of the antennas of a direct link, and which of them reach each other.
///
/// Invariant: reach is symmetric.
class Antennas {
 public:
  using Participant = std::size_t;
  enum class Kind : std::uint8_t { vehicle, unit };

  /// Both distances are positive (checked).
  explicit Antennas(RadioReach reach);

  void position_at(Participant participant, Kind kind, Point2 at);
  /// False where the position of one is not known.
  [[nodiscard]] bool reach(Participant a, Participant b) const;

 private:
  struct Antenna {
    Kind kind{};
    Point2 at;
  };
  RadioReach reach_;
  std::vector<std::optional<Antenna>> antennas_;  ///< by participant
};

}  // namespace cosiva::experiments
