#pragma once

#include "cosiva/aiv/onboard/action_cycle.h"
#include "cosiva/aiv/onboard/action_executor.h"
#include "cosiva/aiv/onboard/drive_cycle.h"
#include "cosiva/aiv/onboard/driving_context.h"
#include "cosiva/aiv/onboard/state_reporter.h"
#include "cosiva/aiv/onboard/zone_selection.h"
#include "cosiva/aiv/partners/server_proxy.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::aiv {

/// Checks orders and passes them to the agent.
///
/// Invariant: an order that is accepted is the agent's order, and the next state acknowledges it by its orderUpdateId.
class OrderReceiver {
 public:
  /// The other parts of the vehicle. All outlive the receiver.
  struct Parts {
    ServerProxy& server_proxy;
    StateReporter& reporter;
    ActionExecutor& actions;
    DriveCycle& drive_cycle;
    const ZoneSelection& zones;
    ActionCycle& action_cycle;
  };
  /// @param cycle  of the vehicle's decisions; where it is long, a new order is decided on at once
  OrderReceiver(const Parts& parts, SimDuration cycle) : parts_{parts}, cycle_{cycle} {}

  /// @param context  none before a zone is known
  void on_order(const wire::Input& input, DrivingContext* context, wire::Effects& effects);

 private:
  void accept(const wire::Order& order, OrderBook::Verdict verdict, SimTime now, DrivingContext& context,
              wire::Effects& effects);

  Parts parts_;
  SimDuration cycle_;
};

}  // namespace cosiva::aiv
