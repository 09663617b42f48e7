#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cosiva/experiments/faults/operator_state.h"
#include "cosiva/experiments/faults/violation.h"
#include "cosiva/experiments/runs/world/fault_injection.h"
#include "cosiva/experiments/runs/world/world.h"

namespace cosiva::experiments {

/// I6: a Stop outranks everything. A vehicle that has confirmed a Stop, or died after it, does not move on until the
/// Stop is lifted by a command, and the server sends no end of the pause before. A vehicle confirms by a state with
/// `paused` that lists an action of this Stop: it may be paused by an earlier one, which a delayed restart will end.
///
/// Invariant: a vehicle has a limit of its distance only while a Stop holds for it.
class StopMonitor {
 public:
  /// A confirmed Stop permits this distance: from the end of the deceleration, as the vehicle reports it, to rest.
  static constexpr double moves_m_max = 0.05;

  StopMonitor(const World& world, std::uint32_t aivs);

  void on_effect(Process aiv, const wire::Publish& message);
  /// A message leaves the server.
  [[nodiscard]] Finding on_server_message(const wire::Publish& message, const OperatorState& state);
  [[nodiscard]] Finding step(const OperatorState& state, const FaultInjection& faults);
  /// Without faults for some time: vehicles for which a Stop holds must be at rest.
  [[nodiscard]] Finding at_rest(const OperatorState& state) const;

 private:
  struct Vehicle {
    std::string name;
    bool paused{false};                ///< in its last state
    std::vector<std::string> stops{};  ///< the ids of the actions that were sent for the present Stop
    bool confirmed{false};             ///< by a state that lists one of them
    std::optional<double> distance_m_max;
  };

  /// What was confirmed was the Stop before.
  static void lift(Vehicle& vehicle);
  [[nodiscard]] Vehicle* find(const std::string& name);

  const World& world_;
  std::vector<Vehicle> vehicles_;
};

}  // namespace cosiva::experiments
