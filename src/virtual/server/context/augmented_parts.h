#pragma once

#include "cosiva/virtual/server/augmented/restored_aivs.h"
#include "cosiva/virtual/server/augmented/virtual_fleet.h"
#include "cosiva/virtual/server/augmented/virtual_object_commands.h"
#include "cosiva/virtual/server/augmented/virtual_obstacle_publisher.h"
#include "cosiva/virtual/server/context/master_control.h"
#include "cosiva/virtual/server/context/server_context.h"

namespace cosiva::virtual_side {

/// The parts of what is added only virtually (A3). The members refer to each other, to the context and to the master
/// control: they stay where they were made.
struct AugmentedParts {
  ServerContext& server;
  MasterControl& master;
  VirtualFleet hosted{server.registry, server.publisher, server.options.virtual_rules, server.options.v2x,
                      !server.options.negotiated_crossings};
  RestoredAivs restored{};
  ThirdPartyPause pauses{server.registry, master.traffic, server.publisher, master.actions, server.simulator};
  VirtualObstaclePublisher virtual_obstacles{server.registry,  server.publisher, server.traces,
                                             server.simulator, hosted,           pauses};
  VirtualObjectCommands objects{server.registry, server.simulator, hosted, restored, server.publisher};
};

}  // namespace cosiva::virtual_side
