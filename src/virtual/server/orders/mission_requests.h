#pragma once

#include <functional>
#include <string_view>
#include <utility>
#include <vector>

#include "cosiva/base/json_value.h"
#include "cosiva/base/result.h"
#include "cosiva/virtual/server/messages/message_publisher.h"
#include "cosiva/virtual/server/orders/missions.h"
#include "cosiva/virtual/server/registry/proxy.h"

namespace cosiva::virtual_side {

/// Checks and executes the commands that give missions and that close or open sections.
///
/// Invariant: only a command that check() accepts is executed.
class MissionRequests {
 public:
  MissionRequests(Registry& registry, MessagePublisher& publisher, Missions& missions)
      : registry_{registry}, publisher_{publisher}, missions_{missions} {}

  /// Returns the mission to a goal in another control area, "area/name", or an error.
  using Abroad = std::function<Result<Mission>(std::string_view to)>;
  void set_abroad(Abroad abroad) { abroad_ = std::move(abroad); }

  [[nodiscard]] static bool handles(std::string_view command);  ///< "go", "circulate", "close" or "open"
  /// Fails with a message that states what to do and lists the names most similar to the requested one.
  [[nodiscard]] Result<void> check(const JsonValue& command) const;
  /// Executes a command that check() accepts.
  void follow(const JsonValue& command);

 private:
  [[nodiscard]] Result<void> check_mission(const JsonValue& command, std::string_view verb) const;
  [[nodiscard]] Result<void> check_section(const JsonValue& command, std::string_view verb) const;
  [[nodiscard]] Result<std::vector<VehicleIndex>> addressed(const JsonValue& command) const;
  void close_or_open(const JsonValue& command, bool close);

  Registry& registry_;
  MessagePublisher& publisher_;
  Missions& missions_;
  Abroad abroad_;
};

}  // namespace cosiva::virtual_side
