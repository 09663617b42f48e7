#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/base/time.h"
#include "cosiva/virtual/server/context/server_context.h"

namespace cosiva::virtual_side {

/// The vehicles that a server before a restart controlled, and that have not reported since. Each may still have a base
/// that leads through a crossing, which no other vehicle may be sent through: until all of them have reported, no order
/// is extended. A server that continues from a snapshot knows the bases and awaits no vehicle.
///
/// Invariant: a vehicle is awaited until it reports, and no longer than `wait_max` after the broker's messages are
/// known.
class AwaitedVehicles {
 public:
  /// A vehicle reports once a second at least. One without a report for so long has stopped by its own watchdog, or its
  /// messages do not reach the broker.
  static constexpr SimDuration wait_max = std::chrono::seconds{10};

  explicit AwaitedVehicles(ServerContext& context) : context_{context} {}

  /// Adds "vehicles":["CoSiVA/AIV1"…]: those that report to this server, unless they have signed off, and those
  /// awaited; no field without any.
  void write(JsonWriter& json) const;
  /// Restores what write() wrote; items that are no names are skipped.
  void restore(const JsonValue& names);
  /// In each tick with the broker's messages known: whether orders may be extended.
  [[nodiscard]] bool have_reported();
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  ServerContext& context_;
  std::vector<std::string> names_;
  std::optional<SimTime> until_;
};

}  // namespace cosiva::virtual_side
