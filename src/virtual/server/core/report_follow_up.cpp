#include "cosiva/virtual/server/core/report_follow_up.h"

#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {
namespace {

constexpr SimDuration position_lost_max{std::chrono::seconds{1}};
constexpr SimDuration init_again{std::chrono::seconds{5}};
constexpr SimDuration factsheet_timeout{std::chrono::seconds{1}};

}  // namespace

void ReportFollowUp::request_missing() {
  COSIVA_EXPECT(context_.link.synchronised());
  for (VehicleIndex v = 0; v < context_.registry.size(); ++v) {
    initialise_position(v);
    request_factsheet(v);
  }
}

void ReportFollowUp::initialise_position(VehicleIndex vehicle) {
  AivProxy& proxy = context_.registry[vehicle];
  if (!proxy.position.lost_for_longer_than(position_lost_max, context_.now)) return;
  if (!proxy.position.pose() || !zones_.map() || !proxy.online() ||
      proxy.lost(context_.now, context_.options.lost_after))
    return;
  if (proxy.position.initialised_within(init_again, context_.now)) return;
  if (proxy.supports("initPosition") == std::optional{false}) return;
  // A vehicle that is off-route knows its position; there is nothing to initialise.
  if (!zones_.change().off_route(vehicle).empty()) return;
  proxy.position.on_initialisation_sent(context_.now);
  wire::Action action{"initPosition", {}, {}, wire::BlockingType::hard, {}};
  action.parameters = {{"x", proxy.position.pose()->x_m},
                       {"y", proxy.position.pose()->y_m},
                       {"theta", proxy.position.pose()->heading_rad},
                       {"mapId", context_.simulator.zone()->name}};
  const Twin& twin = context_.simulator.twin(*proxy.twin());
  if (twin.on_circuit()) {
    if (const auto behind = zones_.map()->behind(twin.reported_position(), master_.traffic.traversed(vehicle)))
      action.parameters.push_back({"lastNodeId", zones_.map()->waypoint(behind->waypoint).id});
  }
  context_.publisher.log('i', proxy.name() + ": has lost its position; sent its last known position");
  master_.actions.send(proxy, vehicle, {std::move(action)}, std::chrono::seconds{2}, false);
}

void ReportFollowUp::request_factsheet(VehicleIndex vehicle) {
  AivProxy& proxy = context_.registry[vehicle];
  if (!proxy.factsheet.missing() || !proxy.twin_link.present() || !proxy.online()) return;
  if (context_.now - proxy.membership.first_received() < factsheet_timeout) return;
  proxy.factsheet.on_requested();
  master_.actions.send(proxy, vehicle, {{"factsheetRequest", {}, {}, wire::BlockingType::none, {}}},
                       SimDuration::zero(), false);
}

}  // namespace cosiva::virtual_side
