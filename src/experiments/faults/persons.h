#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cosiva/base/pose.h"
#include "cosiva/base/time.h"
#include "cosiva/experiments/faults/violation.h"
#include "cosiva/experiments/runs/world/world.h"

namespace cosiva::experiments {

/// Persons that step into the paths of vehicles, where the vehicles detect them in time and can still stop, and the
/// check that no vehicle touches a person or another vehicle.
///
/// Invariant: a person is in a path from stepping in until leaving, once at a time.
class Persons {
 public:
  /// A person closer to a vehicle could not be avoided: braking from the fast profile, half a vehicle, a board's
  /// and a cycle's delay [m].
  static constexpr double clear_m = 0.55;
  static constexpr double radius_m = 0.06;

  explicit Persons(World& world) : world_{world} {}

  /// A person steps in front of a vehicle, at a point that follows from `draw`; no person does where one could not be
  /// avoided. The plant is running.
  void step_in(std::uint32_t vehicle, std::uint64_t draw, SimTime until);
  /// Those whose time is over leave, once the plant is running; all of them at `SimTime::max()`.
  void leave(SimTime now);
  /// Bodies have touched since the last check.
  [[nodiscard]] Finding check();

  /// A point in the path of a vehicle at which a person can be avoided; it follows from `draw`. Nothing: the vehicle is
  /// on no path, in a tight bend, or too close to others.
  [[nodiscard]] std::optional<Point2> point_in_path(std::uint32_t vehicle, std::uint64_t draw) const;
  /// The vehicle that touches a virtual person at this point, "AIV1"; empty: none does.
  [[nodiscard]] std::string touching(Point2 person) const;

 private:
  struct Person {
    std::string id;
    SimTime until;
  };
  World& world_;
  std::vector<Person> persons_;
  std::uint64_t count_{0};
  std::size_t collisions_{0};  ///< until the last check
};

}  // namespace cosiva::experiments
