#include "cosiva/aiv/onboard/report.h"

#include <array>
#include <charconv>
#include <cmath>

#include "cosiva/wire/messages/charge.h"

namespace cosiva::aiv {
namespace {

constexpr double battery_low = 0.10;

std::string in_decimals(double value, int decimals) {
  std::array<char, 336> text{};  // any double has room
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed, decimals).ptr;
  return {text.data(), end};
}

std::string three_decimals(double value_m) { return in_decimals(value_m, 3); }

/// "0.42 m"
std::string in_three_decimals(double value_m) { return three_decimals(value_m) + " m"; }

wire::AgvPosition position_of(const Agent& agent, const std::string& map_id) {
  const PositionEstimator& estimator = agent.vehicle().position();
  return {body_pose(agent.zone(), estimator.pose()), map_id, true, std::nullopt,
          2.0 * estimator.on_path_estimator().sigma_m()};
}

/// In the body frame, as the standard has it.
wire::Velocity velocity_of(const Agent& agent) {
  const double speed_mps = agent.vehicle().motion().speed_mps();
  return {agent.zone().circuit.indirect() ? -speed_mps : speed_mps, 0.0, agent.vehicle().turn_rate_radps()};
}

wire::VehicleError condition(std::string type, std::string description, std::vector<wire::Reference> references = {}) {
  return {std::move(type), wire::ErrorLevel::warning, std::move(description), std::move(references)};
}

/// Present faults, which disappear by themselves when they are repaired.
void add_conditions(const ReportSources& from, std::vector<wire::VehicleError>& errors) {
  for (const wire::Board board : wire::all_boards) {
    const std::string name{to_string(board)};
    if (from.supervision.board_lost(from.now, board)) {
      errors.push_back(condition("boardLost", name + " does not respond", {{"board", name}}));
    } else if (const auto code = from.boards.health(board).self_test; code != 0) {
      errors.push_back(condition("boardFaulty", name + " reports " + wire::fault_text(code), {{"board", name}}));
    }
  }
  if (!from.zone_refused.empty()) errors.push_back(condition("zoneError", from.zone_refused));
  if (from.agent == nullptr) {
    errors.push_back(condition("zoneUnknown", "no zone configuration has arrived yet"));
    return;
  }
  if (from.agent->vehicle().holds().has(Hold::server_lost))
    errors.push_back(condition("serverLost", "the server's heartbeat stopped"));
  if (from.agent->vehicle().holds().has(Hold::line_lost))
    errors.push_back(condition("lineLost", "no line under the sensors"));
  const PositionEstimator& estimator = from.agent->vehicle().position();
  if (!estimator.pose_known()) errors.push_back(condition("positionUnknown", "the vehicle's position is not known"));
  if (estimator.pose_known() && !estimator.known()) {
    const std::string off = in_three_decimals(estimator.off_path_estimator().off_by_m());
    errors.push_back(
        condition("offCircuit", "the nearest path passes " + off +
                                    " away: the vehicle stays here until it is moved and its position is given"));
  }
  if (from.agent->charge() < battery_low) errors.push_back(condition("batteryLowError", "less than 10 % charge"));
}

/// "ok", "lost", "faulty" or "absent".
const char* health_of(const ReportSources& from, wire::Board board) {
  if (!from.supervision.has(board)) return "absent";
  if (from.supervision.board_lost(from.now, board)) return "lost";
  return from.boards.health(board).self_test != 0 ? "faulty" : "ok";
}

wire::Information boards_information(const ReportSources& from) {
  wire::Information information{"boards", {}, {}};
  for (const wire::Board board : wire::all_boards)
    information.references.push_back({std::string(to_string(board)), health_of(from, board)});
  return information;
}

double percent_of(const wire::Power& power) {
  // In the units of the message: 0.1 · 789 would be 78.9000…01.
  return power.gauge ? power.gauge->charge_ppm / 10'000.0 : 0.1 * power.charge_permille;
}

/// The gauge's uncertainty of the charge, for which the standard has no field.
wire::Information gauge_information(const wire::Power::Gauge& gauge) {
  constexpr std::uint16_t needs_full_charge = 500;  // 5 %: it has drifted so far that only a full charge helps
  return {"battery",
          {},
          {{"chargeStdDev_percent", three_decimals(gauge.charge_sd_01 / 100.0)},
           {"needsFullCharge", gauge.charge_sd_01 > needs_full_charge ? "true" : "false"}}};
}

void add_agent(const Agent& agent, const ReportSources& from, wire::State& state) {
  const VehicleState& vehicle = agent.vehicle();
  const OrderBook& order = vehicle.order();
  state.order_id = order.ids().order_id;
  state.order_update_id = order.ids().order_update_id;
  state.zone_set_id = order.ids().zone_set_id;
  state.last_node_id = order.last_node().node_id;
  state.last_node_sequence_id = order.last_node().sequence_id;
  state.node_states = order.node_states();
  state.edge_states = order.edge_states();
  if (!order.last_node().node_id.empty()) state.distance_since_last_node_m = order.since_last_node_m();
  state.driving = !vehicle.motion().stopped();
  state.paused = vehicle.holds().has(Hold::paused);
  state.new_base_request = agent.decision().wants_base;
  state.field_violation = agent.decision().blocked;
  state.velocity = velocity_of(agent);
  const PositionEstimator& estimator = vehicle.position();
  if (estimator.pose_known()) state.position = position_of(agent, from.maps.front().map_id);
  if (const auto& tag = estimator.last_tag()) {
    state.information.push_back({"lastTag",
                                 {},
                                 {{"tag", std::to_string(tag->number)},
                                  {"distance_m", three_decimals(estimator.travelled_m() - tag->travelled_m)}}});
  }
}

}  // namespace

wire::State compose_state(const ReportSources& from) {
  wire::State state;
  state.maps = from.maps;
  if (from.agent != nullptr) add_agent(*from.agent, from, state);
  if (from.order_actions != nullptr) {
    state.action_states = from.order_actions->states();
    state.battery.charging = from.order_actions->charging();
    const LoadBay& loads = from.order_actions->loads();
    if (!loads.positions().empty()) state.loads = loads.loads();
  }
  const auto& instant = from.actions.states();
  state.action_states.insert(state.action_states.end(), instant.begin(), instant.end());
  if (from.power) {
    state.battery.charge_percent = percent_of(*from.power);
    state.battery.voltage_v = 0.001 * from.power->voltage_mv;
  } else if (!from.supervision.has(wire::Board::RALI)) {
    wire::set_charge_unknown(state);
  }
  state.errors = from.warnings.all();
  add_conditions(from, state.errors);
  state.information.push_back(boards_information(from));
  if (from.power && from.power->gauge) state.information.push_back(gauge_information(*from.power->gauge));
  return state;
}

wire::BoardsReport compose_boards_report(const ReportSources& from, const std::optional<wire::Ranges>& ranges) {
  wire::BoardsReport report;
  for (const wire::Board board : wire::all_boards) {
    const BoardsLink::Health& health = from.boards.health(board);
    const BoardsLink::Frames frames = from.boards.frames(board);
    report.boards.push_back({board, health_of(from, board), health.hello ? health.hello->firmware_hash : 0,
                             health.uptime_ms, frames.good, frames.bad, frames.missed, health.self_test,
                             from.boards.self_tests().parts(board).value_or(std::vector<wire::PartFinding>{})});
  }
  report.power = from.power;
  report.ranges = ranges;
  report.pils = from.boards.pils();
  return report;
}

wire::Visualization compose_visualization(const Agent& agent, const std::string& map_id) {
  wire::Visualization visualization;
  if (agent.vehicle().position().pose_known()) visualization.position = position_of(agent, map_id);
  visualization.velocity = velocity_of(agent);
  return visualization;
}

std::string display_text(const std::string& serial_number, const Agent& agent) {
  constexpr std::size_t serial_bytes_max = 12;
  std::string text = serial_number.substr(0, serial_bytes_max);
  text += " " + std::string(to_string(agent.status())) + " ";
  return text + in_decimals(std::fabs(agent.vehicle().motion().speed_mps()), 1);
}

ReportFlags flags_of(const ReportSources& from) {
  ReportFlags flags;
  unsigned bit = 1;
  for (const wire::Board board : wire::all_boards) {
    if (from.supervision.board_lost(from.now, board)) flags.boards_lost |= bit;
    bit <<= 1U;
    if (from.boards.health(board).self_test != 0) flags.boards_lost |= bit;
    bit <<= 1U;
  }
  if (from.power) flags.charge_percent = from.power->charge_permille / 10;
  if (from.agent == nullptr) return flags;
  flags.holds = from.agent->vehicle().holds().bits();
  flags.driving = !from.agent->vehicle().motion().stopped();
  flags.blocked = from.agent->decision().blocked;
  flags.wants_base = from.agent->decision().wants_base;
  flags.position_known = from.agent->vehicle().position().pose_known();
  flags.near_path = from.agent->vehicle().position().near_path();
  return flags;
}

}  // namespace cosiva::aiv
