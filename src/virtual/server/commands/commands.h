#pragma once

#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/digest.h"
#include "cosiva/base/result.h"
#include "cosiva/virtual/server/commands/command_ids.h"
#include "cosiva/virtual/server/commands/intentions.h"
#include "cosiva/virtual/server/commands/values/operator_command.h"
#include "cosiva/virtual/server/messages/message_publisher.h"
#include "cosiva/virtual/server/orders/order_manager.h"
#include "cosiva/virtual/server/registry/registry.h"
#include "cosiva/virtual/simulator/simulator.h"

namespace cosiva::virtual_side {

enum class CommandState : std::uint8_t { issued, accepted, materialised, failed };
[[nodiscard]] std::string_view to_string(CommandState state);

struct Command {
  std::string id;
  VehicleIndex vehicle{no_vehicle};
  std::string vehicle_name;
  std::string command_text;  ///< as requested, even when the command is unknown
  std::optional<OperatorCommandKind> kind;
  double speed_mps{};       ///< of `limit`
  std::string action_id{};  ///< of a Stop that was published already
  CommandState state{CommandState::issued};
  SimTime at{};
  std::optional<SimTime> accepted_at;
  std::optional<SimTime> materialised_at;
  std::string reason;
  InstantActionSender::ActionHandle handle{0};
  [[nodiscard]] bool open() const { return state == CommandState::issued || state == CommandState::accepted; }
};

/// Tracks each command until its effect is observed on the vehicle: issued → accepted (the state lists its actions) →
/// materialised (the vehicle shows the effect), or failed with the reason. A Stop does not fail because time passes: it
/// is repeated, and listed as not confirmed, until the vehicle confirms it or an operator lifts it.
///
/// Invariant: a command changes its state only in this order and never after its end; a limited number of commands is
/// listed.
class Commands {
 public:
  static constexpr SimDuration timeout{std::chrono::seconds{5}};
  static constexpr std::size_t kept_max = 200;

  Commands(Registry& registry, MessagePublisher& publisher, InstantActionSender& action_sender, OrderManager& orders,
           Simulator& simulator, Intentions& intentions, CommandIds& ids)
      : registry_{registry},
        publisher_{publisher},
        action_sender_{action_sender},
        orders_{orders},
        simulator_{simulator},
        intentions_{intentions},
        ids_{ids} {}

  /// Whether issue() would execute the command.
  [[nodiscard]] Result<void> check(const VehicleCommand& command) const;
  /// @param command  or why its text is no command, which is listed as failed
  /// @param stored   the command was accepted and stored before: its intention holds for a vehicle that is not known
  ///                 yet, which an earlier process of the server knew
  void issue(const Result<VehicleCommand>& command, bool stored = false);
  /// Issues a command again whose intention a vehicle does not fulfil: it was not there, or has been restarted.
  void issue_again(VehicleIndex vehicle, OperatorCommandKind kind, double speed_mps);
  [[nodiscard]] bool any_open(VehicleIndex vehicle) const;
  /// Whether a Stop waits until the vehicle performs it. One that the vehicle has performed, and that is still open,
  /// may have been ended by an older restart that arrived later.
  [[nodiscard]] bool stop_unperformed(VehicleIndex vehicle) const;
  void on_state(VehicleIndex vehicle);
  void tick();
  /// The vehicle has been removed: its open commands fail.
  void forget(VehicleIndex vehicle, const std::string& reason);

  [[nodiscard]] const std::deque<Command>& list() const { return list_; }  ///< oldest first
  void fold(Digest& digest) const;
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  [[nodiscard]] std::vector<VehicleIndex> addressed(const VehicleCommand& requested) const;
  /// The monitor; null where the command is for a vehicle that the monitor does not count.
  [[nodiscard]] BijectionMonitor* monitor_of(const Command& command);
  [[nodiscard]] std::string id_for(const std::string& wanted);
  void begin(Command command);
  void refuse(Command command, const Error& error);
  /// Ends the open commands that this one reverts. @return  whether a restart was among them
  bool supersede(const Command& by);
  [[nodiscard]] std::optional<std::string> impossible(VehicleIndex vehicle, OperatorCommandKind kind) const;
  [[nodiscard]] bool effect_observed(const Command& command) const;
  void evaluate(Command& command);
  void accept(Command& command);
  void materialise(Command& command);
  void fail_command(Command& command, std::string reason);
  void keep(Command command);

  Registry& registry_;
  MessagePublisher& publisher_;
  InstantActionSender& action_sender_;
  OrderManager& orders_;
  Simulator& simulator_;
  Intentions& intentions_;
  CommandIds& ids_;
  std::deque<Command> list_;
};

}  // namespace cosiva::virtual_side
