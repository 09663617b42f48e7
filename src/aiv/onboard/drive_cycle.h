#pragma once

#include "cosiva/aiv/onboard/boards_link.h"
#include "cosiva/aiv/onboard/driving_context.h"
#include "cosiva/aiv/onboard/supervision.h"
#include "cosiva/aiv/onboard/v2x_participant.h"
#include "cosiva/aiv/onboard/virtual_perception.h"
#include "cosiva/aiv/partners/server_proxy.h"

namespace cosiva::aiv {

/// One decision of the vehicle: what supervision, perception and V2X know goes to the agent, and the agent's command to
/// the motors.
///
/// Invariant: a command is given only to an agent that holds for each link which supervision reports as lost, except
/// for broker and server while the vehicle may finish its base (BaseWatch).
class DriveCycle {
 public:
  DriveCycle(const Supervision& supervision, VirtualPerception& perception, V2xParticipant& v2x, BoardsLink& boards,
             ServerProxy& server_proxy);

  void run(SimTime now, DrivingContext& context, wire::Effects& effects);

 private:
  [[nodiscard]] bool ranges_backwards(const zone::TrafficZone& zone) const;
  void supervise(SimTime now, DrivingContext& context) const;

  const Supervision& supervision_;
  VirtualPerception& perception_;
  V2xParticipant& v2x_;
  BoardsLink& boards_;
  ServerProxy& server_proxy_;
};

}  // namespace cosiva::aiv
