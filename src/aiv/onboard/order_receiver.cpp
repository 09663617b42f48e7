#include "cosiva/aiv/onboard/order_receiver.h"

#include <string>
#include <utility>
#include <vector>

#include "cosiva/base/expect.h"
#include "cosiva/wire/vda5050/typed_messages.h"

namespace cosiva::aiv {
namespace {

constexpr SimDuration usual_cycle = std::chrono::milliseconds{20};

}  // namespace

void OrderReceiver::on_order(const wire::Input& input, DrivingContext* context, wire::Effects& effects) {
  StateReporter& reporter = parts_.reporter;
  const auto received = wire::vda5050::order_from(input);
  if (!received) return reporter.refuse("validationError", "order", to_string(received.error()), {}, effects);
  const wire::Order& order = **received;
  std::vector<wire::Reference> references{{"topic", "order"},
                                          {"headerId", std::to_string(order.header.header_id)},
                                          {"orderId", order.order_id},
                                          {"orderUpdateId", std::to_string(order.order_update_id)}};
  const auto refuse = [&](std::string type, std::string why) {
    reporter.refuse(std::move(type), "order", std::move(why), std::move(references), effects);
  };
  if (auto accepted = parts_.server_proxy.accepts(order.header); !accepted)
    return refuse("validationError", to_string(accepted.error()));
  if (context == nullptr) return refuse("noRouteError", "no zone is known yet");
  VehicleState& vehicle = context->vehicle();
  const bool repeated = order.order_id == vehicle.order().ids().order_id &&
                        order.order_update_id == vehicle.order().ids().order_update_id;
  if (const auto& pending = parts_.zones.pending(); pending && !repeated)
    return refuse("noRouteError", "zone '" + pending->zone().name + "' follows as soon as the vehicle has stopped");

  parts_.action_cycle.take_traversed(*context);
  const auto verdict = vehicle.take_order(order, parts_.action_cycle.actions().left());
  reporter.request_report();  // its orderUpdateId is the only acknowledgement, also of a repetition
  if (!verdict) return refuse(verdict.error().code, to_string(verdict.error()));
  accept(order, *verdict, input.at, *context, effects);
}

void OrderReceiver::accept(const wire::Order& order, OrderBook::Verdict verdict, SimTime now, DrivingContext& context,
                           wire::Effects& effects) {
  COSIVA_EXPECT(context.vehicle().order().ids().order_id == order.order_id);
  if (verdict == OrderBook::Verdict::accepted_new) {
    parts_.reporter.on_new_order();
    parts_.actions.on_new_order();
    parts_.action_cycle.actions().on_new_order(order);
    effects.emplace_back(wire::Log{'i', "order " + order.order_id + " from " + order.nodes.front().node_id});
  } else if (verdict == OrderBook::Verdict::accepted_update) {
    parts_.reporter.on_order_update();
    parts_.action_cycle.actions().on_update(order);
  }
  // With a long cycle the next tick is far away, and other vehicles may wait for this one to drive.
  if (cycle_ > usual_cycle && verdict != OrderBook::Verdict::ignored_same)
    parts_.drive_cycle.run(now, context, effects);
}

}  // namespace cosiva::aiv
