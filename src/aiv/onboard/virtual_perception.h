#pragma once

#include "cosiva/aiv/onboard/driving_context.h"
#include "cosiva/aiv/onboard/error_log.h"
#include "cosiva/aiv/partners/server_proxy.h"
#include "cosiva/base/archive_fwd.h"
#include "cosiva/wire/own/own_messages.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::aiv {

/// Perception of virtual bodies: takes the server's list of them (wire::VirtualObstacles), finds the first one in the
/// corridor for each decision, and responds to the server (wire::VirtualObstaclesAck).
///
/// Invariant: a response names a body and its distance exactly when the vehicle brakes for this body.
class VirtualPerception {
 public:
  /// True: the list is accepted, and the vehicle has to decide and then to acknowledge().
  [[nodiscard]] bool on_bodies(SimTime now, const wire::Input& input, DrivingContext& context, wire::Effects& effects);
  /// Responds to the list that was accepted last, unless nothing has changed.
  void acknowledge(SimTime now, const DrivingContext& context, ServerProxy& server_proxy, wire::Effects& effects);

  /// Before a decision: which body is the first in the corridor.
  /// @param server_lost  no news can arrive: the list does not expire
  void update(SimTime now, bool server_lost, DrivingContext& context);
  /// After a decision: responds where braking for a virtual body has begun or ended.
  void publish_change(SimTime now, const DrivingContext& context, ServerProxy& server_proxy, wire::Effects& effects);

  /// The server is new or has lost its state: the next list is acknowledged in any case.
  void request_response() { ack_due_ = true; }
  void on_zone_switched();
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  void respond(SimTime now, const DrivingContext& context, ServerProxy& server_proxy, wire::Effects& effects);

  PerceivedWorld::Contact contact_;     ///< at the last decision
  wire::VirtualObstaclesAck response_;  ///< the last one
  bool ack_due_{true};                  ///< the server does not know yet that this vehicle perceives virtual bodies
  ErrorLog errors_;
};

}  // namespace cosiva::aiv
