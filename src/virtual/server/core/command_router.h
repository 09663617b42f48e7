#pragma once

#include <string>
#include <variant>

#include "cosiva/base/result.h"
#include "cosiva/virtual/server/commands/values/decoded_command.h"
#include "cosiva/virtual/server/commands/values/operator_command.h"
#include "cosiva/virtual/server/context/augmented_parts.h"
#include "cosiva/virtual/server/context/instrument_parts.h"
#include "cosiva/virtual/server/context/master_control.h"
#include "cosiva/virtual/server/context/server_context.h"
#include "cosiva/virtual/server/core/virtual_world.h"
#include "cosiva/virtual/server/core/zone_session.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::virtual_side {

/// "edit", "undo", "redo", "saved": the configuration that the zone has afterwards.
struct CheckedEdit {
  EditCommand::Kind kind;
  zone::ZoneConfiguration after;
};

/// "plant", "radio", "batteryReady": the message that another program receives.
struct MessageCommand {
  AgentProxy RemoteAgents::*receiver;
  std::string_view kind;  ///< this and the summary are for the trace
  std::string summary;
  wire::Publish message;
};

/// A command that was compared with the vehicles and the zone, ready to be executed. Commands to vehicles are none of
/// these; Commands lists even those that it refuses.
using CheckedCommand = std::variant<VirtualObjectCommand, CheckedEdit, SwitchCommand, MessageCommand, MissionCommand,
                                    SectionCommand, Departure>;

/// Routes the decoded commands of operators: each is checked, then executed by the part that handles it.
/// Invariant: no part executes a command that was not validated, and a refused command changes nothing but the lists
/// that show the refusal.
class CommandRouter {
 public:
  CommandRouter(ServerContext& context, MasterControl& master, AugmentedParts& augmented,
                const InstrumentParts& instruments, VehicleLifecycle& vehicles, ZoneSession& zones, VirtualWorld& world)
      : context_{context},
        master_{master},
        augmented_{augmented},
        instruments_{instruments},
        vehicles_{vehicles},
        zones_{zones},
        world_{world} {}

  /// Whether run() would execute the command.
  [[nodiscard]] Result<void> check(const DecodedCommand& decoded) const;
  void run(const DecodedCommand& decoded, bool stored = false);

 private:
  [[nodiscard]] Result<CheckedCommand> checked(const OperatorCommand& command) const;
  [[nodiscard]] Result<CheckedCommand> checked(const AddCommand& command) const;
  [[nodiscard]] Result<CheckedCommand> checked(const PlantCommand& command) const;
  [[nodiscard]] Result<CheckedCommand> checked(const RadioCommand& command) const;
  [[nodiscard]] Result<CheckedCommand> checked(const BatteryReadyCommand& command) const;
  void refuse(const DecodedCommand::Fault& fault);
  void refuse(const OperatorCommand& command, const Error& error);

  void execute(const VirtualObjectCommand& command);
  void execute(const CheckedEdit& command);
  void execute(const SwitchCommand& command);
  void execute(MessageCommand& command);
  void execute(const MissionCommand& command);
  void execute(const SectionCommand& command);
  void execute(const Departure& command);

  ServerContext& context_;
  MasterControl& master_;
  AugmentedParts& augmented_;
  const InstrumentParts& instruments_;
  VehicleLifecycle& vehicles_;
  ZoneSession& zones_;
  VirtualWorld& world_;
};

}  // namespace cosiva::virtual_side
