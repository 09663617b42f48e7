#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "cosiva/base/pose.h"
#include "cosiva/base/time.h"

/// The neutral messages between master control and vehicles: VDA 5050's meaning (clauses of 2.1.0), no JSON. Codecs per
/// version live in vda5050/. Metres, radians in (−π, π], seconds, volts; percent where the standard uses percent.
namespace cosiva::wire {

struct Header {
  std::uint32_t header_id{};  ///< counts per topic, +1 per message sent, wraps (§6.4)
  SimTime timestamp{};
  std::string version;  ///< as the peer wrote it: "2.1.0", "2.0.0"
  std::string manufacturer;
  std::string serial_number;
  friend bool operator==(const Header&, const Header&) = default;
};

/// A parameter's value that is not a number, flag or text stays as its JSON.
struct RawJson {
  std::string text;
  friend bool operator==(const RawJson&, const RawJson&) = default;
};
using ParameterValue = std::variant<bool, double, std::string, RawJson>;

struct Parameter {
  std::string key;
  ParameterValue value;
  friend bool operator==(const Parameter&, const Parameter&) = default;
};

enum class BlockingType { none, soft, hard };

struct Action {
  std::string action_type;
  std::string action_id;
  std::string description;
  BlockingType blocking_type{BlockingType::none};
  std::vector<Parameter> parameters;
  friend bool operator==(const Action&, const Action&) = default;

  [[nodiscard]] const ParameterValue* find(std::string_view key) const;
  [[nodiscard]] std::optional<double> number(std::string_view key) const;
  [[nodiscard]] std::optional<std::string> text(std::string_view key) const;
};

struct NodePosition {
  double x_m{};
  double y_m{};
  std::optional<double> theta_rad;
  std::optional<double> allowed_deviation_xy_m;
  std::optional<double> allowed_deviation_theta_rad;
  std::string map_id;
  friend bool operator==(const NodePosition&, const NodePosition&) = default;
};

struct OrderNode {
  std::string node_id;
  std::uint32_t sequence_id{};
  bool released{};
  std::optional<NodePosition> position;
  std::vector<Action> actions;
  friend bool operator==(const OrderNode&, const OrderNode&) = default;
};

struct OrderEdge {
  std::string edge_id;
  std::uint32_t sequence_id{};
  bool released{};
  std::string start_node_id;
  std::string end_node_id;
  std::optional<double> max_speed_mps;
  std::optional<double> length_m;
  std::vector<Action> actions;
  /// Whether the vehicle drives backwards along the edge: an orientation of π, or of 0, tangential to the path.
  /// Nothing: the vehicle decides.
  std::optional<bool> backwards;
  /// Optional fields of the standard that were present and that CoSiVA does not honour (§6.1.1: reject, never ignore).
  std::vector<std::string> unsupported;
  friend bool operator==(const OrderEdge&, const OrderEdge&) = default;
};

/// Master control to vehicle (§6.6). Nodes and edges in sequence order.
struct Order {
  Header header;
  std::string order_id;
  std::uint32_t order_update_id{};
  std::string zone_set_id;
  std::vector<OrderNode> nodes;
  std::vector<OrderEdge> edges;
  friend bool operator==(const Order&, const Order&) = default;
};

/// Master control to vehicle (§6.9).
struct InstantActions {
  Header header;
  std::vector<Action> actions;
  friend bool operator==(const InstantActions&, const InstantActions&) = default;
};

enum class ActionStatus { waiting, initializing, running, paused, finished, failed };
struct ActionState {
  std::string action_id;
  std::string action_type;
  ActionStatus status{ActionStatus::waiting};
  std::string result_description;
  friend bool operator==(const ActionState&, const ActionState&) = default;
};

struct NodeState {
  std::string node_id;
  std::uint32_t sequence_id{};
  bool released{};
  std::optional<NodePosition> position;
  friend bool operator==(const NodeState&, const NodeState&) = default;
};
struct EdgeState {
  std::string edge_id;
  std::uint32_t sequence_id{};
  bool released{};
  friend bool operator==(const EdgeState&, const EdgeState&) = default;
};

struct AgvPosition {
  Pose2 pose;  ///< X_MB
  std::string map_id;
  bool position_initialized{};
  std::optional<double> localization_score;  ///< 0…1
  std::optional<double> deviation_range_m;
  friend bool operator==(const AgvPosition&, const AgvPosition&) = default;
};
struct Velocity {
  double vx_mps{};
  double vy_mps{};
  double omega_radps{};
  friend bool operator==(const Velocity&, const Velocity&) = default;
};
/// A load on the vehicle (2.1 §6.10.6, load). Texts that the vehicle does not know are empty.
struct Load {
  std::string load_id;
  std::string load_type;
  std::string load_position;  ///< the load handling device that carries the load
  std::optional<double> weight_kg{};
  friend bool operator==(const Load&, const Load&) = default;
};
struct BatteryState {
  double charge_percent{};
  std::optional<double> voltage_v;
  std::optional<double> reach_m;
  bool charging{};
  friend bool operator==(const BatteryState&, const BatteryState&) = default;
};

enum class ErrorLevel { warning, fatal };
struct Reference {
  std::string key;
  std::string value;
  friend bool operator==(const Reference&, const Reference&) = default;
};
struct VehicleError {
  std::string
      type;  ///< the standard's terms: orderError, orderUpdateError, noRouteError, validationError, noOrderToCancel…
  ErrorLevel level{ErrorLevel::warning};
  std::string description;
  std::vector<Reference> references;
  friend bool operator==(const VehicleError&, const VehicleError&) = default;
};
/// For display only, never for logic (§6.10.4).
struct Information {
  std::string type;
  std::string description;
  std::vector<Reference> references;
  friend bool operator==(const Information&, const Information&) = default;
};

enum class OperatingMode { automatic, semiautomatic, manual, service, teachin };
enum class EStop { none, autoack, manual, remote };

/// A map that the vehicle has (2.1 §6.10, maps).
struct MapInfo {
  std::string map_id;
  std::string map_version;
  std::string description;
  bool enabled{};
  friend bool operator==(const MapInfo&, const MapInfo&) = default;
};

/// Vehicle to master control (§6.10).
struct State {
  Header header;
  std::vector<MapInfo> maps;  ///< empty: the vehicle reports none
  std::string order_id;
  std::uint32_t order_update_id{};
  std::string zone_set_id;
  std::string last_node_id;
  std::uint32_t last_node_sequence_id{};
  bool driving{};
  bool paused{};
  bool new_base_request{};
  std::optional<double> distance_since_last_node_m;
  OperatingMode operating_mode{OperatingMode::automatic};
  std::vector<NodeState> node_states;
  std::vector<EdgeState> edge_states;
  std::optional<AgvPosition> position;
  std::optional<Velocity> velocity;
  std::vector<ActionState> action_states;
  /// Nothing: the vehicle cannot determine its loads. Empty: it is unloaded.
  std::optional<std::vector<Load>> loads;
  BatteryState battery;
  std::vector<VehicleError> errors;
  std::vector<Information> information;
  EStop e_stop{EStop::none};
  bool field_violation{};  ///< protective field: an obstacle is inside
  friend bool operator==(const State&, const State&) = default;
};

/// Vehicle to any client that displays it (§6.13).
struct Visualization {
  Header header;
  std::optional<AgvPosition> position;
  std::optional<Velocity> velocity;
  friend bool operator==(const Visualization&, const Visualization&) = default;
};

enum class ConnectionState { online, offline, connection_broken };
struct Connection {
  Header header;
  ConnectionState state{ConnectionState::offline};
  friend bool operator==(const Connection&, const Connection&) = default;
};

/// The vehicle's properties (§6.15). Only what CoSiVA uses; the codec fills in the rest of the required fields.
struct Factsheet {
  Header header;
  std::string series_name;
  std::string series_description;
  std::string agv_kinematic{"DIFF"};
  std::string agv_class{"CARRIER"};
  double speed_min_mps{};
  double speed_max_mps{};
  double acceleration_max_mps2{};
  double deceleration_max_mps2{};
  double height_m{};
  double width_m{};
  double length_m{};
  double min_order_interval_s{};
  double min_state_interval_s{};
  double default_state_interval_s{};
  double visualization_interval_s{};
  struct SupportedAction {
    std::string type;
    std::string description;
    bool instant{};
    bool node{};
    bool edge{};
    std::vector<Parameter> parameters;  ///< required: key, and its value's type as a text: "NUMBER", "STRING"
    std::vector<Parameter> optional_parameters{};
    std::vector<BlockingType> blocking_types{};  ///< that the action may have; empty: not declared
    friend bool operator==(const SupportedAction&, const SupportedAction&) = default;
  };
  std::vector<SupportedAction> actions;
  std::vector<std::string> load_positions;  ///< the load handling devices; empty: the vehicle carries no loads
  friend bool operator==(const Factsheet&, const Factsheet&) = default;
};

}  // namespace cosiva::wire
