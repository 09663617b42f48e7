#pragma once

#include "cosiva/virtual/server/commands/command_ids.h"
#include "cosiva/virtual/server/commands/commands.h"
#include "cosiva/virtual/server/commands/intention_enforcer.h"
#include "cosiva/virtual/server/context/awaited_vehicles.h"
#include "cosiva/virtual/server/context/server_context.h"
#include "cosiva/virtual/server/deadlocks/deadlocks.h"
#include "cosiva/virtual/server/missions/mission_requests.h"
#include "cosiva/virtual/server/missions/missions.h"
#include "cosiva/virtual/server/missions/persisted_missions.h"
#include "cosiva/virtual/server/orders/order_manager.h"
#include "cosiva/virtual/server/right_of_way/traffic.h"
#include "cosiva/virtual/server/zones/map_deployment.h"

namespace cosiva::virtual_side {

/// The parts that make the server VDA 5050's master control: what each vehicle is to do, and the right of way. The
/// members refer to each other and to the context: a master control stays where it was made.
struct MasterControl {
  ServerContext& served;
  Traffic traffic{{.convoys = served.options.convoys && !served.options.negotiated_crossings,
                   .negotiated = served.options.negotiated_crossings}};
  InstantActionSender actions{served.publisher};
  Missions missions{served.registry, served.publisher};
  MissionRequests mission_requests{served.registry, served.publisher, missions};
  PersistedMissions persisted_missions{served.registry, missions};
  AwaitedVehicles awaited{served, traffic, missions};
  OrderManager orders{served.registry,
                      traffic,
                      served.publisher,
                      actions,
                      missions,
                      served.simulator,
                      OrderRules{.permitted_time = served.options.permitted_time}};
  Deadlocks deadlocks{served.registry, served.publisher, served.traces, orders};
  MapDeployment maps{served.registry, served.publisher, actions};
  Intentions intentions{};
  CommandIds command_ids{};
  Commands commands{served.registry, served.publisher, actions, orders, served.simulator, intentions, command_ids};
  IntentionEnforcer enforcer{served.registry, served.publisher, intentions, commands};
};

}  // namespace cosiva::virtual_side
