#pragma once

#include <utility>

#include "cosiva/aiv/onboard/driving_context.h"
#include "cosiva/aiv/onboard/state_reporter.h"
#include "cosiva/aiv/order/order_actions.h"
#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/digest.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::aiv {

/// The actions of the order in the cycle of decisions: traversed nodes trigger them, and they keep the vehicle where it
/// has stopped for them.
///
/// Invariant: the vehicle holds for actions (Hold::action) exactly while a SOFT or HARD action is performed.
class ActionCycle {
 public:
  ActionCycle(ActionCatalogue catalogue, StateReporter& reporter)
      : actions_{std::move(catalogue)}, reporter_{reporter} {}

  /// Triggers the actions of the nodes traversed so far; also before an order is offered, which needs to know whether
  /// actions are left.
  void take_traversed(DrivingContext& context);
  void run(SimTime now, DrivingContext& context, wire::Effects& effects);
  void on_zone_switched() { actions_.cancel("the zone was switched"); }
  [[nodiscard]] OrderActions& actions() { return actions_; }
  [[nodiscard]] const OrderActions& actions() const { return actions_; }
  void fold(Digest& digest) const;  ///< nothing without actions, loads and charging
  void archive(Archive& archive);   ///< the state, for a snapshot

 private:
  OrderActions actions_;
  StateReporter& reporter_;
  bool traversed_{false};  ///< a node, since the last run(), which reports it
};

}  // namespace cosiva::aiv
