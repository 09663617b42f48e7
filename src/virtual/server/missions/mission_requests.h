#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/virtual/server/commands/values/operator_command.h"
#include "cosiva/virtual/server/messages/message_publisher.h"
#include "cosiva/virtual/server/missions/missions.h"
#include "cosiva/virtual/server/registry/registry.h"

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

  /// Fails with a message that states what to do and lists the names most similar to the requested one.
  [[nodiscard]] Result<void> check(const MissionCommand& command) const;
  [[nodiscard]] Result<void> check(const SectionCommand& command) const;
  /// Executes a command that check() accepts.
  void follow(const MissionCommand& command);
  void follow(const SectionCommand& command);

 private:
  [[nodiscard]] Result<void> check_map() const;
  [[nodiscard]] Result<std::vector<VehicleIndex>> addressed(const std::vector<std::string>& names) const;

  Registry& registry_;
  MessagePublisher& publisher_;
  Missions& missions_;
  Abroad abroad_;
};

}  // namespace cosiva::virtual_side
