#pragma once

#include "cosiva/aiv/onboard/driving_context.h"
#include "cosiva/aiv/onboard/error_log.h"
#include "cosiva/aiv/onboard/estimating.h"
#include "cosiva/aiv/partners/server_proxy.h"
#include "cosiva/base/archive_fwd.h"
#include "cosiva/wire/messages/board.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::aiv {

/// Joins the algorithms under qualification (figures 16 and 17) to the vehicle: requests from the broker, readings of
/// the boards, responses to the broker.
///
/// Invariant: the agent takes each odometry once, before the algorithms do, and no reading is dated after its arrival.
class EstimationService {
 public:
  void on_request(SimTime now, std::string_view payload, ServerProxy& server_proxy, wire::Effects& effects);
  /// Passes odometry to the agent and to the algorithms.
  void on_odometry(SimTime now, const wire::Odometry& odometry, DrivingContext& context);
  /// Before the agent takes the reading.
  void on_tag(SimTime now, const wire::TagRead& tag, const DrivingContext& context);
  void on_zone_switched() { estimating_.on_zone_switched(); }
  void publish(ServerProxy& server_proxy, wire::Effects& effects);
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  Estimating estimating_;
  BoardClock pils_clock_;
  ErrorLog errors_;
};

}  // namespace cosiva::aiv
