#include "cosiva/wire/vda5050/encode.h"

#include <algorithm>

#include "cosiva/base/math.h"
#include "cosiva/base/time.h"
#include "cosiva/wire/vda5050/codec.h"
#include "cosiva/wire/vda5050/json_out.h"
#include "cosiva/wire/vda5050/terms.h"
#include "cosiva/wire/vda5050/write_header.h"

namespace cosiva::wire::vda5050 {
namespace {

/// A peer of 2.0 may read the field names of its own version only; a message to such a peer contains both.
bool speaks_2_0(const Header& header) { return header.version.starts_with("2.0"); }

// The schema's bounds are π rounded to eleven and nine decimals; an angle within π satisfies both.
double angle_for_wire(double angle_rad) { return std::fabs(angle_rad) <= pi ? angle_rad : wrap_angle(angle_rad); }

void write_value(JsonOut& out, const ParameterValue& value) {
  if (const auto* raw = std::get_if<RawJson>(&value)) {
    COSIVA_EXPECT(!raw->text.empty());
    out.raw(raw->text);
  } else if (const auto* number = std::get_if<double>(&value)) {
    out.value(*number);
  } else if (const auto* flag = std::get_if<bool>(&value)) {
    out.value(*flag);
  } else {
    out.value(std::get<std::string>(value));
  }
}

/// @param name_too  also write the type as `actionName`, as in the 2.0.0 schema of instantActions
void write_action(JsonOut& out, const Action& action, bool name_too) {
  out.open('{');
  out.field(R"("actionType":)", action.action_type).field(R"("actionId":)", action.action_id);
  if (name_too) out.field(R"("actionName":)", action.action_type);
  out.text_if_any(R"("actionDescription":)", action.description);
  out.field(R"("blockingType":)", text_of(blocking_types, action.blocking_type));
  if (!action.parameters.empty()) {
    out.array(R"("actionParameters":)", action.parameters, [&](const Parameter& parameter) {
      out.open('{').field(R"("key":)", parameter.key).key(R"("value":)");
      write_value(out, parameter.value);
      out.close('}');
    });
  }
  out.close('}');
}

void write_actions(JsonOut& out, std::string_view key, const std::vector<Action>& actions, bool name_too = false) {
  out.array(key, actions, [&](const Action& action) { write_action(out, action, name_too); });
}

void write_node_position(JsonOut& out, const NodePosition& position, bool for_2_0) {
  out.key(R"("nodePosition":)").open('{');
  out.field(R"("x":)", position.x_m).field(R"("y":)", position.y_m);
  if (position.theta_rad) out.field(R"("theta":)", angle_for_wire(*position.theta_rad));
  if (position.allowed_deviation_xy_m) {
    const double deviation_m = std::max(0.0, *position.allowed_deviation_xy_m);
    out.field(R"("allowedDeviationXY":)", deviation_m);
    if (for_2_0) out.field(R"("allowedDeviationXy":)", deviation_m);
  }
  if (position.allowed_deviation_theta_rad)
    out.field(R"("allowedDeviationTheta":)", std::clamp(*position.allowed_deviation_theta_rad, -pi, pi));
  out.field(R"("mapId":)", position.map_id).close('}');
}

void write_agv_position(JsonOut& out, const AgvPosition& position) {
  out.key(R"("agvPosition":)").open('{');
  out.field(R"("x":)", position.pose.x_m).field(R"("y":)", position.pose.y_m);
  out.field(R"("theta":)", angle_for_wire(position.pose.heading_rad));
  out.field(R"("mapId":)", position.map_id).field(R"("positionInitialized":)", position.position_initialized);
  if (position.localization_score)
    out.field(R"("localizationScore":)", std::clamp(*position.localization_score, 0.0, 1.0));
  if (position.deviation_range_m) out.field(R"("deviationRange":)", *position.deviation_range_m);
  out.close('}');
}

void write_velocity(JsonOut& out, const Velocity& velocity) {
  out.key(R"("velocity":)").open('{');
  out.field(R"("vx":)", velocity.vx_mps).field(R"("vy":)", velocity.vy_mps);
  out.field(R"("omega":)", velocity.omega_radps).close('}');
}

void write_references(JsonOut& out, std::string_view key, const std::vector<Reference>& references) {
  if (references.empty()) return;
  out.array(key, references, [&](const Reference& reference) {
    out.open('{').field(R"("referenceKey":)", reference.key);
    out.field(R"("referenceValue":)", reference.value).close('}');
  });
}

void write_progress(JsonOut& out, const State& state) {
  out.array(R"("nodeStates":)", state.node_states, [&](const NodeState& node) {
    out.open('{').field(R"("nodeId":)", node.node_id).field(R"("sequenceId":)", node.sequence_id);
    out.field(R"("released":)", node.released);
    if (node.position) write_node_position(out, *node.position, false);
    out.close('}');
  });
  out.array(R"("edgeStates":)", state.edge_states, [&](const EdgeState& edge) {
    out.open('{').field(R"("edgeId":)", edge.edge_id).field(R"("sequenceId":)", edge.sequence_id);
    out.field(R"("released":)", edge.released).close('}');
  });
  out.array(R"("actionStates":)", state.action_states, [&](const ActionState& action) {
    out.open('{').field(R"("actionId":)", action.action_id);
    out.text_if_any(R"("actionType":)", action.action_type);
    out.field(R"("actionStatus":)", text_of(action_statuses, action.status));
    out.text_if_any(R"("resultDescription":)", action.result_description).close('}');
  });
}

void write_loads(JsonOut& out, const State& state) {
  if (!state.loads) return;
  out.array(R"("loads":)", *state.loads, [&](const Load& load) {
    out.open('{').text_if_any(R"("loadId":)", load.load_id).text_if_any(R"("loadType":)", load.load_type);
    out.text_if_any(R"("loadPosition":)", load.load_position);
    if (load.weight_kg) out.field(R"("weight":)", std::max(0.0, *load.weight_kg));
    out.close('}');
  });
}

void write_condition(JsonOut& out, const State& state) {
  out.key(R"("batteryState":)").open('{');
  out.field(R"("batteryCharge":)", state.battery.charge_percent);
  if (state.battery.voltage_v) out.field(R"("batteryVoltage":)", *state.battery.voltage_v);
  out.field(R"("charging":)", state.battery.charging);
  if (state.battery.reach_m) out.field(R"("reach":)", std::max(0.0, *state.battery.reach_m));
  out.close('}');
  out.array(R"("errors":)", state.errors, [&](const VehicleError& error) {
    out.open('{').field(R"("errorType":)", error.type);
    write_references(out, R"("errorReferences":)", error.references);
    out.text_if_any(R"("errorDescription":)", error.description);
    out.field(R"("errorLevel":)", text_of(error_levels, error.level)).close('}');
  });
  out.array(R"("information":)", state.information, [&](const Information& information) {
    out.open('{').field(R"("infoType":)", information.type);
    write_references(out, R"("infoReferences":)", information.references);
    out.text_if_any(R"("infoDescription":)", information.description);
    out.field(R"("infoLevel":)", "INFO").close('}');
  });
  out.key(R"("safetyState":)").open('{').field(R"("eStop":)", text_of(e_stops, state.e_stop));
  out.field(R"("fieldViolation":)", state.field_violation).close('}');
}

}  // namespace

std::string encode(const Order& message) {
  const bool for_2_0 = speaks_2_0(message.header);
  JsonOut out{512 + 256 * (message.nodes.size() + message.edges.size())};
  out.open('{');
  write_header(out, message.header);
  out.field(R"("orderId":)", message.order_id).field(R"("orderUpdateId":)", message.order_update_id);
  out.text_if_any(R"("zoneSetId":)", message.zone_set_id);
  out.array(R"("nodes":)", message.nodes, [&](const OrderNode& node) {
    out.open('{').field(R"("nodeId":)", node.node_id).field(R"("sequenceId":)", node.sequence_id);
    out.field(R"("released":)", node.released);
    if (node.position) write_node_position(out, *node.position, for_2_0);
    write_actions(out, R"("actions":)", node.actions);
    out.close('}');
  });
  out.array(R"("edges":)", message.edges, [&](const OrderEdge& edge) {
    out.open('{').field(R"("edgeId":)", edge.edge_id).field(R"("sequenceId":)", edge.sequence_id);
    out.field(R"("released":)", edge.released).field(R"("startNodeId":)", edge.start_node_id);
    out.field(R"("endNodeId":)", edge.end_node_id);
    if (edge.max_speed_mps) out.field(R"("maxSpeed":)", *edge.max_speed_mps);
    if (edge.backwards)
      out.field(R"("orientationType":)", std::string_view{"TANGENTIAL"})
          .field(R"("orientation":)", *edge.backwards ? pi : 0.0);
    if (edge.length_m) out.field(R"("length":)", *edge.length_m);
    write_actions(out, R"("actions":)", edge.actions);
    out.close('}');
  });
  out.close('}');
  return out.take();
}

std::string encode(const InstantActions& message) {
  JsonOut out{512};
  out.open('{');
  write_header(out, message.header);
  const bool for_2_0 = speaks_2_0(message.header);
  write_actions(out, R"("actions":)", message.actions, for_2_0);
  if (for_2_0) write_actions(out, R"("instantActions":)", message.actions, for_2_0);
  out.close('}');
  return out.take();
}

std::string encode(const State& message) {
  JsonOut out{1536 + 128 * (message.node_states.size() + message.edge_states.size())};
  out.open('{');
  write_header(out, message.header);
  if (!message.maps.empty()) {
    out.array(R"("maps":)", message.maps, [&](const MapInfo& map) {
      out.open('{').field(R"("mapId":)", map.map_id).field(R"("mapVersion":)", map.map_version);
      out.text_if_any(R"("mapDescription":)", map.description);
      out.field(R"("mapStatus":)", text_of(map_statuses, map.enabled)).close('}');
    });
  }
  out.field(R"("orderId":)", message.order_id).field(R"("orderUpdateId":)", message.order_update_id);
  out.text_if_any(R"("zoneSetId":)", message.zone_set_id);
  out.field(R"("lastNodeId":)", message.last_node_id);
  out.field(R"("lastNodeSequenceId":)", message.last_node_sequence_id);
  out.field(R"("driving":)", message.driving).field(R"("paused":)", message.paused);
  out.field(R"("newBaseRequest":)", message.new_base_request);
  if (message.distance_since_last_node_m) out.field(R"("distanceSinceLastNode":)", *message.distance_since_last_node_m);
  out.field(R"("operatingMode":)", text_of(operating_modes, message.operating_mode));
  if (message.position) write_agv_position(out, *message.position);
  if (message.velocity) write_velocity(out, *message.velocity);
  write_progress(out, message);
  write_loads(out, message);
  write_condition(out, message);
  out.close('}');
  return out.take();
}

std::string encode(const Visualization& message) {
  JsonOut out{512};
  out.open('{');
  write_header(out, message.header);
  if (message.position) write_agv_position(out, *message.position);
  if (message.velocity) write_velocity(out, *message.velocity);
  out.close('}');
  return out.take();
}

std::string encode(const Connection& message) {
  JsonOut out{256};
  out.open('{');
  write_header(out, message.header);
  out.field(R"("connectionState":)", text_of(connection_states, message.state));
  out.close('}');
  return out.take();
}

std::string_view to_string(ConnectionState state) { return text_of(connection_states, state); }
std::string_view to_string(ActionStatus status) { return text_of(action_statuses, status); }
std::string_view to_string(BlockingType type) { return text_of(blocking_types, type); }
std::string_view to_string(OperatingMode mode) { return text_of(operating_modes, mode); }

}  // namespace cosiva::wire::vda5050
