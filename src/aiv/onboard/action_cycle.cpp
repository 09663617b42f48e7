#include "cosiva/aiv/onboard/action_cycle.h"

#include <cstdint>
#include <string_view>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::aiv {

void ActionCycle::take_traversed(DrivingContext& context) {
  for (const wire::OrderNode& node : context.vehicle().progress().take_traversed()) {
    actions_.on_traversed(node.sequence_id);
    traversed_ = true;
  }
}

void ActionCycle::run(SimTime now, DrivingContext& context, wire::Effects& effects) {
  VehicleState& vehicle = context.vehicle();
  take_traversed(context);
  if (std::exchange(traversed_, false)) reporter_.request_report();
  if (vehicle.progress().take_lost()) {
    actions_.cancel("the order was dropped");
    reporter_.refuse("orderError", "order", "the vehicle was found off its order's route and dropped the order",
                     {{"orderId", vehicle.order().ids().order_id}}, effects);
  }
  actions_.update(
      {now, vehicle.motion().stopped(), vehicle.holds().has(Hold::paused), vehicle.position().travelled_m()});
  vehicle.hold(Hold::action, actions_.holds_vehicle());
  if (!actions_.keep_here()) vehicle.progress().end_stop();
  for (OrderActions::Failure& failure : actions_.take_failures()) {
    reporter_.refuse("orderActionError", "order", std::move(failure.why),
                     {{"actionId", failure.action.action_id},
                      {"actionType", failure.action.action_type},
                      {failure.on_edge ? "edgeId" : "nodeId", failure.node_or_edge_id}},
                     effects);
  }
  if (actions_.take_changed()) reporter_.request_report();
  COSIVA_EXPECT(vehicle.holds().has(Hold::action) == actions_.holds_vehicle());
}

void ActionCycle::fold(Digest& digest) const {
  for (const wire::ActionState& state : actions_.states()) {
    digest.add(std::string_view{state.action_id});
    digest.add(static_cast<std::uint64_t>(state.status));
  }
  for (const wire::Load& load : actions_.loads().loads()) {
    digest.add(std::string_view{load.load_id});
    digest.add(std::string_view{load.load_position});
  }
  if (actions_.charging()) digest.add(std::uint64_t{1});
}

void ActionCycle::archive(Archive& archive) { archive(actions_, traversed_); }

}  // namespace cosiva::aiv
