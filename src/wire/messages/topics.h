#pragma once

#include <optional>
#include <string>
#include <string_view>

/// Topics of the messages. VDA 5050's own layout (§6.3): interface/majorVersion/manufacturer/serialNumber/topic.
/// CoSiVA's own messages, for which the standard has no term, are below cosiva/v1 and never carry a vehicle's order.
namespace cosiva::wire {

inline constexpr std::string_view default_interface = "uagv";
inline constexpr std::string_view our_manufacturer = "CoSiVA";

/// Retained: the zone's configuration file, from the physical side; the last level is its format.
inline constexpr std::string_view zone_topic_prefix = "cosiva/v1/zone/";
/// Retained with a last will: {"connectionState":"ONLINE"|"OFFLINE"|"CONNECTIONBROKEN","timestamp":…} of CoSiVA's
/// server.
inline constexpr std::string_view server_connection_topic = "cosiva/v1/server/connection";
/// Every 100 ms, QoS 0: {"headerId":…,"timestamp":…}. A vehicle that has received one stops 500 ms after the last.
inline constexpr std::string_view server_heartbeat_topic = "cosiva/v1/server/heartbeat";
/// The plant's ground truth, 10 Hz, for instruments and tests only; no on-board program and no twin subscribes to it.
inline constexpr std::string_view ground_truth_topic = "cosiva/v1/plant/ground_truth";
/// Commands to the emulated world: {"addObstacle":{"id","x","y","radius"}} or {"removeObstacle":"id"}.
inline constexpr std::string_view plant_command_topic = "cosiva/v1/plant/command";
/// The emulated radio: {"vehicle":"CoSiVA/AIV2"|"*","loss":0.3}: an *emulated* vehicle's program then loses this ratio
/// of its messages, in both directions. Physical vehicles do not subscribe.
inline constexpr std::string_view plant_radio_topic = "cosiva/v1/plant/radio";

/// The emulated units: {"crossing":"X1","on":false}: the *emulated* unit of this crossing then neither sends nor
/// receives anything. Physical units do not subscribe.
inline constexpr std::string_view plant_unit_topic = "cosiva/v1/plant/unit";

/// Server → one vehicle: the virtual objects near its route (wire::VirtualObstacles).
inline constexpr std::string_view virtual_obstacles_topic_prefix = "cosiva/v1/virtual_obstacles/";
/// Vehicle → server: the vehicle has taken a VirtualObstacles message into account (wire::VirtualObstaclesAck).
inline constexpr std::string_view virtual_obstacles_ack_topic_prefix = "cosiva/v1/virtual_obstacles_ack/";
/// Vehicle → server: the obstacle that its DOBS detects in its path, or that there is none any more
/// (wire::DetectedObstacleReport).
inline constexpr std::string_view detected_obstacle_topic_prefix = "cosiva/v1/detected_obstacle/";
/// Vehicle → server, twice a second: the condition of its boards (wire::BoardsReport, A18).
inline constexpr std::string_view boards_topic_prefix = "cosiva/v1/boards/";

/// Crossing unit → all, five times a second (wire::CrossingStatus).
inline constexpr std::string_view unit_topic_prefix = "cosiva/v1/unit/";
/// The manufacturer in the identity of crossing units; their serial number is the crossing's name: "CoSiVA.unit/X1".
inline constexpr std::string_view unit_manufacturer = "CoSiVA.unit";

/// The manufacturer of vehicles that are added only virtually (A3): "CoSiVA.virtual/V1".
inline constexpr std::string_view virtual_manufacturer = "CoSiVA.virtual";

/// A vehicle's identity on the wire. Both are case-sensitive; serial numbers use A-Z a-z 0-9 _ . : - only.
struct VehicleId {
  std::string manufacturer;
  std::string serial_number;
  friend auto operator<=>(const VehicleId&, const VehicleId&) = default;
};
/// "manufacturer/serial", for display.
[[nodiscard]] std::string to_string(const VehicleId& id);

/// The MQTT filter for all topics that many levels below a prefix: ("a/", 2) is "a/+/+".
[[nodiscard]] std::string topics_below(std::string_view prefix, int levels);

struct VdaTopic {
  std::string interface_name;
  std::string major_version;  ///< "v2"
  VehicleId vehicle;
  std::string name;  ///< order, instantActions, state, visualization, connection, factsheet
};
[[nodiscard]] std::string to_string(const VdaTopic& topic);
/// Nothing where the text has not exactly five non-empty levels.
[[nodiscard]] std::optional<VdaTopic> parse_vda_topic(std::string_view topic);
[[nodiscard]] std::string vda_topic(const VehicleId& vehicle, std::string_view name,
                                    std::string_view interface_name = default_interface);
/// "<prefix><manufacturer>/<serial>", and back; nothing where the rest is not two non-empty levels.
[[nodiscard]] std::string own_topic(std::string_view prefix, const VehicleId& vehicle);
[[nodiscard]] std::optional<VehicleId> parse_own_topic(std::string_view prefix, std::string_view topic);
[[nodiscard]] bool valid_serial_number(std::string_view serial);

}  // namespace cosiva::wire
