#pragma once

#include "cosiva/base/time.h"
#include "cosiva/virtual/server/messages/message_publisher.h"
#include "cosiva/virtual/server/missions/missions.h"
#include "cosiva/virtual/server/orders/order_rules.h"
#include "cosiva/virtual/server/registry/registry.h"
#include "cosiva/virtual/server/right_of_way/traffic.h"
#include "cosiva/virtual/server/right_of_way/waypoint_graph.h"
#include "cosiva/virtual/simulator/simulator.h"

namespace cosiva::virtual_side {

/// What all parts of OrderManager need: the services of the server, the parameters, and the zone in force, but no state
/// of a single vehicle. The parts refer to their context, so a context stays where it was made.
struct OrderContext {
  Registry& registry;
  Traffic& traffic;
  MessagePublisher& publisher;
  InstantActionSender& action_sender;
  Missions& missions;
  Simulator& simulator;
  OrderRules rules{};
  const WaypointGraph* map{nullptr};  ///< of the zone in force; null: none at present
  SimDuration lost_after{};           ///< of this tick: a vehicle that reports nothing for longer is lost
};

}  // namespace cosiva::virtual_side
