#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/planning/window/itinerary.h"
#include "cosiva/planning/window/reservations.h"

namespace cosiva::planning {

/// A vehicle before a joint step.
struct StepVehicle {
  StateId at{};
  const Itinerary* itinerary{};
  Itinerary::Progress progress;
  std::uint32_t urgency{};  ///< vehicles with more of it decide first; then those nearer to their goal
};

/// Finds one step for all vehicles at once, such that the most urgent one comes nearer to its goal wherever the others
/// can give it room: priority inheritance with backtracking (Okumura et al. 2022) over operations of three steps
/// (Yukhnevich and Andreychuk 2025), so that a vehicle can turn around and drive away within one operation.
///
/// At first every vehicle waits, which is possible always. In the order of their urgency vehicles then take the best
/// operation for which the vehicles that it contradicts find other ones. A vehicle that could not make room by some
/// step is not displaced again by that step or an earlier one in favour of the same vehicle: thus the effort per
/// vehicle is bounded. A vehicle that stays at a stop is not displaced.
///
/// Invariant: whenever a function of the public interface returns, every vehicle has an operation, and no two of them
/// contradict each other.
class JointStep {
 public:
  static constexpr std::uint32_t operation_steps = 3;
  using Operation = std::array<StateId, operation_steps + 1>;

  /// @param floor  must outlive this object
  JointStep(const Floor& floor, bool cycles);

  /// Plans from states without common cells. Where every vehicle is where the operation before led it, and no vehicle
  /// leaves before the end of its stay, they go on with those operations as long as nothing better is found.
  void plan(std::span<const StepVehicle> fleet);

  [[nodiscard]] StateId next(Vehicle vehicle) const noexcept { return reservations_.path(vehicle)[1]; }
  /// Candidates examined since the object was made.
  [[nodiscard]] std::uint64_t expansions() const noexcept { return expansions_; }
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  struct Candidate {
    std::uint64_t cost{};
    Operation states{};
  };
  struct Change {
    Vehicle vehicle{};
    bool had_path{};
    Operation states{};
  };
  struct Permission {
    std::uint8_t decided{};      // its operation must not change any more in this plan
    std::uint8_t failed_step{};  // could not make room by this step
  };

  void begin(std::span<const StepVehicle> fleet);
  void decide(Vehicle vehicle);
  [[nodiscard]] bool find(Vehicle vehicle);
  [[nodiscard]] bool attempt(Vehicle vehicle, const Operation& operation);
  [[nodiscard]] bool displaceable(std::span<const Conflict> conflicts) const;
  void list_candidates(Vehicle vehicle, std::vector<Candidate>& candidates);
  void extend(Vehicle vehicle, std::uint32_t step, Itinerary::Progress progress, Candidate& candidate,
              std::vector<Candidate>& candidates);
  [[nodiscard]] std::uint64_t cost(Vehicle vehicle, const Operation& states) const;
  void remove(Vehicle vehicle);
  void undo(std::size_t changes, std::size_t decisions);

  const Floor* floor_;
  Reservations reservations_;
  std::span<const StepVehicle> fleet_;
  std::vector<Permission> permissions_;
  std::vector<Change> changes_;               // of the present decision, to take them back
  std::vector<Vehicle> decisions_;            // vehicles decided in the present decision
  std::vector<Vehicle> failed_;               // vehicles with a failed_step in the present decision
  std::vector<std::vector<Candidate>> pool_;  // lists not in use, to allocate them once
  std::uint32_t budget_{};                    // candidates that the present decision may examine
  std::uint64_t left_{};                      // candidates that the present plan may examine
  std::uint32_t rounds_{};
  std::uint64_t expansions_{0};
};

}  // namespace cosiva::planning
