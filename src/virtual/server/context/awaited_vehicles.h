#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/base/time.h"
#include "cosiva/virtual/server/context/server_context.h"
#include "cosiva/virtual/server/missions/missions.h"
#include "cosiva/virtual/server/right_of_way/traffic.h"

namespace cosiva::virtual_side {

/// The vehicles that a server before a restart controlled, and that have not reported since. Each may still have a base
/// that leads through crossings: it holds the crossings that it held when the state was persisted, until it reports,
/// signs off or is retired, however long that takes. What else its base leads to is not known: until all vehicles have
/// reported, no order is extended, but only for `wait_max`, because a vehicle detects another one ahead by itself. A
/// server that continues from a snapshot knows the bases and awaits no vehicle.
///
/// Invariant: a vehicle is awaited until it reports, signs off or is retired; one that holds no crossing no longer than
/// `wait_max` after the broker's messages are known.
class AwaitedVehicles {
 public:
  /// A vehicle reports once a second at least. One without a report for so long has stopped by its own watchdog, or its
  /// messages do not reach the broker.
  static constexpr SimDuration wait_max = std::chrono::seconds{10};

  AwaitedVehicles(ServerContext& context, Traffic& traffic, const Missions& missions)
      : context_{context}, traffic_{traffic}, missions_{missions} {}

  /// Adds "vehicles":["CoSiVA/AIV1"…]: those that report to this server, unless they have signed off, and those
  /// awaited; and "held":{"zone":…,"crossings":{"X1":"CoSiVA/AIV1"…}}, the crossings that they hold. No field
  /// without any.
  void write(JsonWriter& json) const;
  /// Restores what write() wrote; items that are no names are skipped.
  /// @param held  null: no crossings
  void restore(const JsonValue& names, const JsonValue* held);
  /// The awaited vehicles that hold crossings: they have to be registered, although nothing of them has been received.
  [[nodiscard]] std::vector<std::string> holders() const;
  /// In each tick with the broker's messages known: whether orders may be extended.
  [[nodiscard]] bool have_reported();
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  struct Awaited {
    std::string name;
    std::vector<std::string> crossings;  ///< that it holds in `zone_`
  };
  [[nodiscard]] bool is_awaited(const Awaited& awaited) const;
  /// The zone in force is the one that the crossings belong to, or none is in force yet.
  [[nodiscard]] bool may_hold() const;
  void write_held(JsonWriter& json) const;
  void end_those_that_reported();
  void reserve_crossings();
  void give_up();

  ServerContext& context_;
  Traffic& traffic_;
  const Missions& missions_;  ///< knows the zone in force
  std::vector<Awaited> awaited_;
  std::string zone_;
  std::optional<SimTime> until_;
  bool given_up_{false};
};

}  // namespace cosiva::virtual_side
