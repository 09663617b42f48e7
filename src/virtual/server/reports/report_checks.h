#pragma once

#include <cstdint>
#include <string>

#include "cosiva/base/result.h"
#include "cosiva/virtual/server/context/server_context.h"

namespace cosiva::virtual_side {

/// The checks of every message of a vehicle: header, time stamp, readability. A message that fails is counted, and the
/// reason is logged once for each vehicle.
/// Invariant: a time on the server's clock that comes from a vehicle's time stamp is never later than now.
class ReportChecks {
 public:
  explicit ReportChecks(ServerContext& context) : context_{context} {}

  /// Bits of AivProxy::diagnostics: reasons that are logged once.
  enum Logged : std::uint32_t { identity = 1, version = 2, retained = 4, clock = 8, position = 16, unreadable = 32 };
  void log_once(AivProxy& proxy, std::uint32_t reason, char level, std::string text);
  void refuse(VehicleIndex vehicle, VehicleTopic topic, const wire::Input& input, const Error& error);
  /// Counts the message's header id. False: the message is not the vehicle's own, or of another major version.
  [[nodiscard]] bool take_header(VehicleIndex vehicle, VehicleTopic topic, const wire::Header& header);
  /// The time of a stamp on the server's clock; now where the vehicle's clock is off.
  [[nodiscard]] SimTime server_time(AivProxy& proxy, SimTime stamp);

 private:
  ServerContext& context_;
};

}  // namespace cosiva::virtual_side
