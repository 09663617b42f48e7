#include "cosiva/aiv/onboard/virtual_perception.h"

#include <string>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::aiv {
namespace {

/// While the server sends lists, a response follows at least this often.
constexpr SimDuration response_period_max = std::chrono::seconds{1};

}  // namespace

bool VirtualPerception::on_bodies(SimTime now, const wire::Input& input, DrivingContext& context,
                                  wire::Effects& effects) {
  if (input.flag) return false;  // a retained list is of unknown age
  const auto refuse = [&](std::string kind, const std::string& why) {
    errors_.report(std::move(kind), "virtual obstacles not used: " + why, effects);
    return false;
  };
  auto list = wire::virtual_obstacles_from_json(input.payload);
  if (!list) return refuse(list.error().code + " " + list.error().location, to_string(list.error()));
  const std::string& map_id = context.zone().name;
  if (list->map_id != map_id)
    return refuse("map", "the list is of map '" + list->map_id + "', this is '" + map_id + "'");
  // A decreasing number is another server's, which does not know yet that this vehicle perceives virtual bodies. And
  // any response may have been lost in transit.
  PerceivedWorld& bodies = context.virtual_bodies();
  const bool first = !bodies.informed() || list->header_id < bodies.header_id();
  const bool expired = now - response_.decided >= response_period_max || now < response_.decided;
  const bool changed = bodies.receive(now, std::move(*list));
  ack_due_ = ack_due_ || first || expired || changed;
  return true;
}

void VirtualPerception::acknowledge(SimTime now, const DrivingContext& context, ServerProxy& server_proxy,
                                    wire::Effects& effects) {
  const bool responded =
      response_.decided == now && response_.virtual_obstacles_header_id == context.virtual_bodies().header_id();
  const bool other_body = context.agent().decision().braking_for_virtual && contact_.body != response_.body;
  const bool due = std::exchange(ack_due_, false) || other_body;
  if (due && !responded) respond(now, context, server_proxy, effects);
}

void VirtualPerception::update(SimTime now, bool server_lost, DrivingContext& context) {
  PerceivedWorld& bodies = context.virtual_bodies();
  // A vehicle without its server cannot learn that a body has disappeared; the vehicle is stopped.
  if (server_lost)
    bodies.excuse_silence(now);
  else
    bodies.age(now);
  const PositionEstimator& position = context.vehicle().position();
  contact_ = position.known() ? bodies.first(now, position.outlook()) : PerceivedWorld::Contact{};
  context.agent().perceive(contact_.gap_m);
}

void VirtualPerception::publish_change(SimTime now, const DrivingContext& context, ServerProxy& server_proxy,
                                       wire::Effects& effects) {
  if (context.agent().decision().braking_for_virtual != response_.braking) respond(now, context, server_proxy, effects);
}

void VirtualPerception::respond(SimTime now, const DrivingContext& context, ServerProxy& server_proxy,
                                wire::Effects& effects) {
  response_ = {
      context.virtual_bodies().header_id(), now, context.agent().decision().braking_for_virtual, {}, std::nullopt};
  if (response_.braking) {
    response_.body = std::string(contact_.body);
    response_.distance_m = contact_.gap_m;
  }
  COSIVA_EXPECT(response_.braking == response_.distance_m.has_value());
  server_proxy.publish(response_, effects);
}

void VirtualPerception::on_zone_switched() {
  contact_ = {};
  ack_due_ = true;
  errors_.clear();
}

void VirtualPerception::archive(Archive& archive) {
  archive(response_, ack_due_, errors_);  // the contact is found anew before each decision
}

}  // namespace cosiva::aiv
