#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "cosiva/base/json_value.h"
#include "cosiva/base/pose.h"
#include "cosiva/base/result.h"
#include "cosiva/zone/layout/circuit_factory.h"
#include "cosiva/zone/rtm/rtm.h"

/// Operator commands as values: what the texts of docs/protocols/hmi-api.md and of journals state, before any of it is
/// compared with the vehicles and the zone. DecodedCommand reads the texts.
namespace cosiva::virtual_side {

/// A number that a command may leave out. NaN: the field is there, but is no number; every check of a range refuses it.
using OptionalNumber = std::optional<double>;

/// What an operator can command a vehicle to do (A6).
enum class OperatorCommandKind : std::uint8_t {
  stop,
  slow,
  medium,
  fast,
  limit,
  restart,
  cancel,
  exclude,
  include,
  self_test
};
[[nodiscard]] std::string_view to_string(OperatorCommandKind kind);

/// A command to vehicles, or a text that is no command at all: Commands lists even those that it refuses.
struct VehicleCommand {
  std::string id;                          ///< empty: the server gives one
  std::string command_text;                ///< as requested, even when the command is unknown
  std::vector<std::string> vehicle_names;  ///< at least one; "*" alone: all
  std::optional<OperatorCommandKind> kind;
  double speed_mps{};   ///< of `limit`, above 0 and up to 5
  bool several{false};  ///< given as a list or as all: one entry for each vehicle
  /// Of a Stop that was published already: the id of its action. Empty: the server gives one.
  std::string action_id{};
  [[nodiscard]] bool all() const { return several && vehicle_names.front() == "*"; }
};

/// "retire": a vehicle that is absent has left the zone, and its twin leaves, too.
struct RetireCommand {
  std::string vehicle;
};

/// "go" and "circulate".
struct MissionCommand {
  bool goes{false};  ///< to a goal; false: circulates on a loop
  std::vector<std::string> vehicle_names;
  std::string name;  ///< of the goal or the loop; empty: none stated
};

/// "close" and "open".
struct SectionCommand {
  bool closes{false};
  std::string section;
};

/// The fields of a virtual object in "add" and "move".
struct VirtualObjectFields {
  std::optional<std::string> id;
  std::string kind;
  OptionalNumber x_m;
  OptionalNumber y_m;
  std::optional<std::string> section;
  bool section_is_text{true};
  OptionalNumber s_m;
  OptionalNumber radius_m;
  /// A point without a value is not written as a pair; a coordinate that is no number is NaN. Empty: no list.
  std::optional<std::vector<std::optional<Point2>>> path;
  OptionalNumber speed_mps;
  std::optional<std::string> repeat;
};
struct AddCommand {
  VirtualObjectFields object;
};
struct MoveCommand {
  VirtualObjectFields object;
};
struct RemoveCommand {
  std::string id;  ///< "*" means all
};

/// "edit", "undo", "redo", "saved".
struct EditCommand {
  enum class Kind : std::uint8_t { edit, undo, redo, saved };
  Kind kind{Kind::edit};
  JsonValue changes;  ///< of `edit`, as zone::zone_edit_from_json reads them together with the zone; null: none stated
};

struct SwitchCommand {
  zone::ZoneConfiguration zone;
  /// The RTM of this zone, or why it cannot be built, where the sender has built it; nothing: the core builds it.
  std::optional<Result<std::shared_ptr<const zone::Rtm>>> built{};
};

/// To the emulated world: adds or removes an obstacle, or injects a fault of a vehicle's modules.
struct PlantCommand {
  enum class Act : std::uint8_t { none, add, remove, fault, unit };
  Act act{Act::none};
  std::optional<std::string> id;
  OptionalNumber x_m;
  OptionalNumber y_m;
  OptionalNumber radius_m;
  struct Fault {
    std::string vehicle;
    std::string kind;
    OptionalNumber for_s;
    OptionalNumber sensor;
    OptionalNumber reading;
    std::optional<std::string> motor;
  };
  Fault fault{};
  /// Of a crossing unit.
  struct Unit {
    std::string crossing;
    std::optional<bool> on;
  };
  Unit unit{};
};

/// To the emulated world: a ratio of messages of a vehicle, or of all ("*"), is lost.
struct RadioCommand {
  std::string vehicle;
  double loss_ratio{-1.0};  ///< -1: none stated
};

/// To a battery test: a battery is in its vehicle.
struct BatteryReadyCommand {
  std::string vehicle;
  std::string battery;
  std::optional<std::string> type;
  bool type_is_text{true};
  OptionalNumber cycles;
  OptionalNumber rest_s;
  OptionalNumber temperature_c;
  OptionalNumber charge_percent;
};

using OperatorCommand =
    std::variant<VehicleCommand, MissionCommand, SectionCommand, AddCommand, MoveCommand, RemoveCommand, EditCommand,
                 SwitchCommand, PlantCommand, RadioCommand, BatteryReadyCommand, RetireCommand>;

}  // namespace cosiva::virtual_side
