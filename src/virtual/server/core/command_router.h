#pragma once

#include <string>
#include <string_view>
#include <variant>

#include "cosiva/base/json_value.h"
#include "cosiva/base/result.h"
#include "cosiva/virtual/server/context/augmented_parts.h"
#include "cosiva/virtual/server/context/instrument_parts.h"
#include "cosiva/virtual/server/context/master_control.h"
#include "cosiva/virtual/server/context/server_context.h"
#include "cosiva/virtual/server/core/virtual_world.h"
#include "cosiva/virtual/server/core/zone_session.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::virtual_side {

/// "edit", "undo", "redo", "saved": the configuration that the zone has afterwards.
struct EditCommand {
  std::string name;
  zone::ZoneConfiguration after;
};

/// "switch": the zone that replaces the one in force.
struct SwitchCommand {
  zone::ZoneConfiguration zone;
};

/// "plant", "radio", "batteryReady": the message that another program receives.
struct MessageCommand {
  std::string trace_to;
  std::string trace_kind;
  std::string trace_content;
  wire::Publish message;
};

/// "go", "circulate", "close", "open", checked by MissionRequests.
struct MissionCommand {
  JsonValue json;
};

/// A command of an operator, parsed and validated, ready to be executed. Commands to vehicles are none of these;
/// Commands lists even those that it refuses.
using OperatorCommand = std::variant<VirtualObjectCommand, EditCommand, SwitchCommand, MessageCommand, MissionCommand>;

/// Routes the commands of operators: each is parsed and validated once, then executed by the part that handles it.
/// Invariant: no part executes a command that was not validated, and a refused command changes nothing but the lists
/// that show the refusal.
class CommandRouter {
 public:
  CommandRouter(ServerContext& context, MasterControl& master, AugmentedParts& augmented,
                const InstrumentParts& instruments, ZoneSession& zones, VirtualWorld& world)
      : context_{context},
        master_{master},
        augmented_{augmented},
        instruments_{instruments},
        zones_{zones},
        world_{world} {}

  /// Whether run() would execute the command.
  [[nodiscard]] Result<void> check(std::string_view json) const;
  void run(std::string_view json);

 private:
  /// The part that executes a command.
  enum class Kind { object, edit, zone_switch, mission, world, battery, vehicles };
  /// A received command, parsed.
  struct Request {
    Result<JsonValue> json;
    std::string name;  ///< empty: the command has none
    Kind kind{Kind::vehicles};
  };
  [[nodiscard]] static Kind kind_of(std::string_view name);
  [[nodiscard]] static Request parse(std::string_view json);
  [[nodiscard]] Result<OperatorCommand> read(const Request& request) const;
  [[nodiscard]] Result<OperatorCommand> read_object(const Request& request) const;
  [[nodiscard]] Result<OperatorCommand> read_message(const Request& request) const;
  void refuse(const Request& request, const Error& error);

  void execute(const VirtualObjectCommand& command);
  void execute(const EditCommand& command);
  void execute(const SwitchCommand& command);
  void execute(MessageCommand& command);
  void execute(const MissionCommand& command);

  ServerContext& context_;
  MasterControl& master_;
  AugmentedParts& augmented_;
  const InstrumentParts& instruments_;
  ZoneSession& zones_;
  VirtualWorld& world_;
};

}  // namespace cosiva::virtual_side
