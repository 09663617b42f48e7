#include "cosiva/wire/vda5050/decode.h"

#include <cmath>

#include "cosiva/wire/vda5050/codec.h"
#include "cosiva/wire/vda5050/json_in.h"
#include "cosiva/wire/vda5050/terms.h"

namespace cosiva::wire::vda5050 {
namespace {

void read_action(Fields& fields, Action& action) {
  // The 2.0.0 schema of instantActions has no actionType and names the field actionName.
  const std::string_view type_key = !fields.has("actionType") && fields.has("actionName") ? "actionName" : "actionType";
  fields.text(type_key, action.action_type, Need::required);
  fields.text("actionId", action.action_id, Need::required);
  fields.description("actionDescription", action.description);
  fields.word("blockingType", blocking_types, action.blocking_type, Need::optional);
  fields.each("actionParameters", Need::optional, action.parameters, [](Fields& item, Parameter& parameter) {
    item.text("key", parameter.key, Need::required);
    item.parameter_value("value", parameter.value);
  });
}

void read_node_position(Fields& fields, std::optional<NodePosition>& out) {
  fields.object("nodePosition", Need::optional, [&](Fields& inner) {
    NodePosition position;
    inner.number("x", position.x_m, Need::required);
    inner.number("y", position.y_m, Need::required);
    inner.angle("theta", position.theta_rad);
    inner.number("allowedDeviationXY", position.allowed_deviation_xy_m, 0.0);
    if (!position.allowed_deviation_xy_m) inner.number("allowedDeviationXy", position.allowed_deviation_xy_m, 0.0);
    inner.number("allowedDeviationTheta", position.allowed_deviation_theta_rad);
    inner.text("mapId", position.map_id, Need::required);
    out = std::move(position);
  });
}

/// Requirements of an edge that this line-guided fleet cannot fulfil (§6.1.1: reject, never ignore). The line gives the
/// path, so `trajectory` would be another path; heights are for lifts; a corridor requires path planning. A body that
/// is always tangential to the line fulfils the fields about turning (rotationAllowed, maxRotationSpeed), and the
/// order's next node already determines what `direction` would.
void read_unsupported(Fields& fields, std::vector<std::string>& unsupported) {
  for (const std::string_view key : {"trajectory", "corridor", "maxHeight", "minHeight"}) {
    if (fields.has(key)) unsupported.emplace_back(key);
  }
}

/// Along the line a body points forwards or backwards: orientations of 0 and π, tangential to the path.
void read_orientation(Fields& fields, OrderEdge& edge) {
  std::optional<double> orientation_rad;
  std::string orientation_type{"TANGENTIAL"};
  fields.angle("orientation", orientation_rad);
  fields.text("orientationType", orientation_type, Need::optional);
  // A hundredth of a degree: a peer's arithmetic may leave this much of a zero.
  constexpr double negligible_rad = 1.7e-4;
  if (!orientation_rad) return;
  const double turn_rad = std::fabs(wrap_angle(*orientation_rad));
  const bool backwards = turn_rad > 0.5 * pi;
  if (orientation_type != "TANGENTIAL" || (backwards ? pi - turn_rad : turn_rad) > negligible_rad)
    edge.unsupported.emplace_back("orientation");
  else
    edge.backwards = backwards;
}

void read_order_node(Fields& fields, OrderNode& node) {
  fields.text("nodeId", node.node_id, Need::required);
  fields.count("sequenceId", node.sequence_id, Need::required);
  fields.flag("released", node.released, Need::required);
  read_node_position(fields, node.position);
  fields.each("actions", Need::optional, node.actions, read_action);
}

void read_order_edge(Fields& fields, OrderEdge& edge) {
  fields.text("edgeId", edge.edge_id, Need::required);
  fields.count("sequenceId", edge.sequence_id, Need::required);
  fields.flag("released", edge.released, Need::required);
  fields.text("startNodeId", edge.start_node_id, Need::required);
  fields.text("endNodeId", edge.end_node_id, Need::required);
  fields.number("maxSpeed", edge.max_speed_mps, 0.0);
  fields.number("length", edge.length_m, 0.0);
  read_unsupported(fields, edge.unsupported);
  read_orientation(fields, edge);
  fields.each("actions", Need::optional, edge.actions, read_action);
}

void read_agv_position(Fields& fields, std::optional<AgvPosition>& out) {
  fields.object("agvPosition", Need::optional, [&](Fields& inner) {
    AgvPosition position;
    inner.number("x", position.pose.x_m, Need::required);
    inner.number("y", position.pose.y_m, Need::required);
    inner.angle("theta", position.pose.heading_rad, Need::required);
    inner.text("mapId", position.map_id, Need::required);
    inner.flag("positionInitialized", position.position_initialized, Need::required);
    inner.number("localizationScore", position.localization_score, 0.0, 1.0);
    inner.number("deviationRange", position.deviation_range_m);
    out = std::move(position);
  });
}

void read_velocity(Fields& fields, std::optional<Velocity>& out) {
  fields.object("velocity", Need::optional, [&](Fields& inner) {
    Velocity velocity;
    inner.number("vx", velocity.vx_mps, Need::optional);
    inner.number("vy", velocity.vy_mps, Need::optional);
    inner.number("omega", velocity.omega_radps, Need::optional);
    out = velocity;
  });
}

void read_reference(Fields& fields, Reference& reference) {
  fields.text("referenceKey", reference.key, Need::required);
  fields.text("referenceValue", reference.value, Need::required);
}

void read_progress(Fields& fields, State& state) {
  fields.each("nodeStates", Need::required, state.node_states, [](Fields& item, NodeState& node) {
    item.text("nodeId", node.node_id, Need::required);
    item.count("sequenceId", node.sequence_id, Need::required);
    item.flag("released", node.released, Need::required);
    read_node_position(item, node.position);
  });
  fields.each("edgeStates", Need::required, state.edge_states, [](Fields& item, EdgeState& edge) {
    item.text("edgeId", edge.edge_id, Need::required);
    item.count("sequenceId", edge.sequence_id, Need::required);
    item.flag("released", edge.released, Need::required);
  });
  fields.each("actionStates", Need::required, state.action_states, [](Fields& item, ActionState& action) {
    item.text("actionId", action.action_id, Need::required);
    item.text("actionType", action.action_type, Need::optional);
    item.word("actionStatus", action_statuses, action.status, Need::required);
    item.description("resultDescription", action.result_description);
  });
}

void read_loads(Fields& fields, State& state) {
  if (!fields.has("loads")) return;
  fields.each("loads", Need::optional, state.loads.emplace(), [](Fields& item, Load& load) {
    item.text("loadId", load.load_id, Need::optional);
    item.text("loadType", load.load_type, Need::optional);
    item.text("loadPosition", load.load_position, Need::optional);
    item.number("weight", load.weight_kg, 0.0);
  });
}

void read_condition(Fields& fields, State& state) {
  fields.object("batteryState", Need::required, [&](Fields& battery) {
    battery.number("batteryCharge", state.battery.charge_percent, Need::required);
    battery.number("batteryVoltage", state.battery.voltage_v);
    battery.number("reach", state.battery.reach_m);
    battery.flag("charging", state.battery.charging, Need::required);
  });
  fields.each("errors", Need::required, state.errors, [](Fields& item, VehicleError& error) {
    item.text("errorType", error.type, Need::required);
    item.word("errorLevel", error_levels, error.level, Need::required);
    item.description("errorDescription", error.description);
    item.each("errorReferences", Need::optional, error.references, read_reference);
  });
  fields.each("information", Need::optional, state.information, [](Fields& item, Information& information) {
    item.text("infoType", information.type, Need::required);
    item.description("infoDescription", information.description);
    item.each("infoReferences", Need::optional, information.references, read_reference);
  });
  fields.object("safetyState", Need::required, [&](Fields& safety) {
    safety.word("eStop", e_stops, state.e_stop, Need::required);
    safety.flag("fieldViolation", state.field_violation, Need::required);
  });
}

}  // namespace

Result<Order> decode_order(std::string_view json) {
  return decode_message<Order>(json, "order", [](Fields& fields, Order& order) {
    read_header(fields, order.header, Need::required);
    fields.text("orderId", order.order_id, Need::required);
    fields.count("orderUpdateId", order.order_update_id, Need::required);
    fields.text("zoneSetId", order.zone_set_id, Need::optional);
    fields.each("nodes", Need::required, order.nodes, read_order_node);
    fields.each("edges", Need::required, order.edges, read_order_edge);
  });
}

Result<InstantActions> decode_instant_actions(std::string_view json) {
  return decode_message<InstantActions>(json, "instantActions", [](Fields& fields, InstantActions& message) {
    read_header(fields, message.header, Need::required);
    // Some 2.0 peers name the array after its topic.
    const std::string_view key = !fields.has("actions") && fields.has("instantActions") ? "instantActions" : "actions";
    fields.each(key, Need::required, message.actions, read_action);
  });
}

Result<State> decode_state(std::string_view json) {
  return decode_message<State>(json, "state", [](Fields& fields, State& state) {
    read_header(fields, state.header, Need::required);
    fields.each("maps", Need::optional, state.maps, [](Fields& item, MapInfo& map) {
      item.text("mapId", map.map_id, Need::required);
      item.text("mapVersion", map.map_version, Need::required);
      item.description("mapDescription", map.description);
      item.word("mapStatus", map_statuses, map.enabled, Need::required);
    });
    fields.text("orderId", state.order_id, Need::required);
    fields.count("orderUpdateId", state.order_update_id, Need::required);
    fields.text("zoneSetId", state.zone_set_id, Need::optional);
    fields.text("lastNodeId", state.last_node_id, Need::required);
    fields.count("lastNodeSequenceId", state.last_node_sequence_id, Need::required);
    fields.flag("driving", state.driving, Need::required);
    fields.flag("paused", state.paused, Need::optional);
    fields.flag("newBaseRequest", state.new_base_request, Need::optional);
    fields.number("distanceSinceLastNode", state.distance_since_last_node_m);
    fields.word("operatingMode", operating_modes, state.operating_mode, Need::required);
    read_agv_position(fields, state.position);
    read_velocity(fields, state.velocity);
    read_progress(fields, state);
    read_loads(fields, state);
    read_condition(fields, state);
  });
}

Result<Visualization> decode_visualization(std::string_view json) {
  return decode_message<Visualization>(json, "visualization", [](Fields& fields, Visualization& message) {
    read_header(fields, message.header, Need::optional);
    read_agv_position(fields, message.position);
    read_velocity(fields, message.velocity);
  });
}

Result<Connection> decode_connection(std::string_view json) {
  return decode_message<Connection>(json, "connection", [](Fields& fields, Connection& message) {
    read_header(fields, message.header, Need::required);
    fields.word("connectionState", connection_states, message.state, Need::required);
  });
}

}  // namespace cosiva::wire::vda5050
