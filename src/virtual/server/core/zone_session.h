#pragma once

#include <memory>
#include <optional>
#include <string>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/digest.h"
#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/base/result.h"
#include "cosiva/virtual/server/commands/values/operator_command.h"
#include "cosiva/virtual/server/context/augmented_parts.h"
#include "cosiva/virtual/server/context/master_control.h"
#include "cosiva/virtual/server/context/server_context.h"
#include "cosiva/virtual/server/core/zone_change.h"
#include "cosiva/virtual/server/reports/twin_placement.h"
#include "cosiva/virtual/server/reports/vehicle_lifecycle.h"
#include "cosiva/virtual/server/right_of_way/waypoint_graph.h"
#include "cosiva/virtual/server/zones/zone_edits.h"

namespace cosiva::virtual_side {

/// The zone in force: which configurations of the broker, of an operator and of the state file replace it, its edits,
/// and the waypoint graph that all parts drive by.
/// Invariant: exactly one zone is in force after the first one has been taken, the waypoint graph is that zone's, and
/// every part has the same graph. A configuration that cannot be built changes nothing but the refusal that is shown.
class ZoneSession {
 public:
  ZoneSession(ServerContext& context, MasterControl& master, AugmentedParts& augmented, VehicleLifecycle& vehicles,
              TwinPlacement& twins)
      : context_{context},
        master_{master},
        augmented_{augmented},
        vehicles_{vehicles},
        twins_{twins},
        change_{context, master} {}

  /// The source of a configuration: from the options, published just now, or retained by the broker.
  enum class Source { given, published, retained };
  void receive(const zone::ZoneConfiguration& configuration, Source source);
  void link_went_down() { edits_.link_lost(); }
  void link_came_up();
  /// Publishes the zone where no other program serves it.
  void publish_own();
  /// In each cycle: takes a configuration that waits for the other retained ones when their time has elapsed.
  void take_waiting();

  /// Whether the zone of the command could be brought into force. Fails with a message that states what to do.
  [[nodiscard]] Result<void> check(const SwitchCommand& command) const;
  /// @param wanted  accepted by check()
  void switch_to(const zone::ZoneConfiguration& wanted);
  /// The refusal is shown until the next zone is taken.
  void refuse(const std::string& origin, const std::string& why);
  /// Executes "edit", "undo", "redo" or "saved".
  /// @param after  the result of edits().after() for the command
  void apply_edit(EditCommand::Kind kind, const zone::ZoneConfiguration& after);

  /// Takes the zone data of the state file as soon as a zone is in force.
  /// @param edited  the zone in force with its edits, as write_state() wrote it
  /// @param given   the zone of the options that another one had replaced
  void restore(std::optional<JsonValue> edited, std::optional<zone::ZoneConfiguration> given);
  /// The zone data of the state file have not been taken yet: a new state file would lose them.
  [[nodiscard]] bool awaits_zone_to_restore() const { return restored_zone_.has_value(); }
  /// The state file's "zone" and "given"; nothing where a new server would have the same zone.
  void write_state(JsonWriter& json) const;

  /// The waypoint graph of the zone in force; null before there is a zone.
  [[nodiscard]] const WaypointGraph* map() const { return map_ ? &*map_ : nullptr; }
  [[nodiscard]] ZoneChange& change() { return change_; }
  [[nodiscard]] const ZoneChange& change() const { return change_; }
  [[nodiscard]] const ZoneEdits& edits() const { return edits_; }
  /// The snapshot's "zone".
  void write(JsonWriter& json) const;
  /// The state, for a snapshot. Reading it makes the waypoint graph of the simulator's zone and gives it to all parts,
  /// which have to read their own state afterwards.
  void archive(Archive& archive);

 private:
  struct Refused {
    SimTime at{};
    std::string origin;
    std::string why;
  };
  [[nodiscard]] bool waits_for_others(const zone::ZoneConfiguration& configuration, Source source);
  bool take(const zone::ZoneConfiguration& configuration);
  void drive_on(const std::shared_ptr<const zone::TrafficZone>& zone);
  void start_over(const std::shared_ptr<const zone::TrafficZone>& zone);
  void notify_all(const WaypointGraph* map);
  void publish();
  void restore_now();

  ServerContext& context_;
  MasterControl& master_;
  AugmentedParts& augmented_;
  VehicleLifecycle& vehicles_;
  TwinPlacement& twins_;
  ZoneChange change_;
  ZoneEdits edits_;
  std::optional<WaypointGraph> map_;
  std::optional<Refused> refused_;
  bool switched_here_{false};  ///< the zone in force was set by a command: no other program serves it
  /// Retained configurations of a new connection: each waits until all of them have been received.
  std::optional<zone::ZoneConfiguration> waiting_;
  bool confirmed_{false};  ///< the zone in force is among the retained ones, or newer
  std::optional<JsonValue> restored_zone_;
  std::optional<zone::ZoneConfiguration> restored_given_;
};

}  // namespace cosiva::virtual_side
