// What vehicles say, and what becomes of it.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include "cosiva/virtual/server/core/inside.h"
#include "cosiva/wire/vda5050/codec.h"
#include "cosiva/wire/vda5050/said.h"

namespace cosiva::virtual_side {
namespace {

constexpr SimDuration clock_tolerance{std::chrono::seconds{2}};
/// A time stamp that falls back further than any network delays is a clock that was set, not a late message.
constexpr SimDuration reorder_max{std::chrono::seconds{5}};
/// A vehicle that goes on reporting so long after its last will was published is there: the will was of an old session.
constexpr SimDuration will_outlived{std::chrono::seconds{2}};
constexpr SimDuration position_lost_max{std::chrono::seconds{1}};
constexpr SimDuration init_again{std::chrono::seconds{5}};
constexpr SimDuration factsheet_patience{std::chrono::seconds{1}};
constexpr SimDuration arrival_patience{std::chrono::seconds{1}};
constexpr double coordinate_m_max = 1e5;

// Bits of AivProxy::notes.
constexpr std::uint32_t note_identity = 1;
constexpr std::uint32_t note_version = 2;
constexpr std::uint32_t note_retained = 4;
constexpr std::uint32_t note_clock = 8;
constexpr std::uint32_t note_place = 16;
constexpr std::uint32_t note_unreadable = 32;  // shifted by the topic's number

/// The major version of "2.1.0", "2.0.0", "v2"; nothing where there is none.
std::optional<int> major_of(std::string_view version) {
  if (version.starts_with('v') || version.starts_with('V')) version.remove_prefix(1);
  int major = 0;
  const auto [end, error] = std::from_chars(version.data(), version.data() + version.size(), major);
  if (error != std::errc{}) return std::nullopt;
  if (end != version.data() + version.size() && *end != '.') return std::nullopt;
  return major;
}

template <typename Number>
std::optional<Number> number_in(const std::vector<wire::Reference>& references, std::string_view key) {
  const auto it = std::ranges::find(references, key, &wire::Reference::key);
  if (it == references.end()) return std::nullopt;
  Number number{};
  const char* end = it->value.data() + it->value.size();
  const auto read = std::from_chars(it->value.data(), end, number);
  if (read.ec != std::errc{} || read.ptr != end) return std::nullopt;
  return number;
}

std::string summary_of(const wire::State& state) {
  std::string text = "order '" + state.order_id + "' update " + std::to_string(state.order_update_id) + ", node " +
                     state.last_node_id + " (" + std::to_string(state.last_node_sequence_id) + ")";
  text += state.driving ? ", driving" : ", standing";
  if (state.paused) text += ", paused";
  if (state.field_violation) text += ", field violation";
  for (const wire::VehicleError& error : state.errors) text += ", " + error.type;
  return text;
}

}  // namespace

void ServerCore::Inside::log_once(AivProxy& proxy, std::uint32_t note, char level, std::string text) {
  if ((proxy.notes & note) != 0) return;
  proxy.notes |= note;
  publisher.log(level, proxy.name + ": " + std::move(text));
}

void ServerCore::Inside::refuse(VehicleIndex vehicle, VehicleTopic topic, const wire::Input& input,
                                const Error& error) {
  AivProxy& proxy = registry[vehicle];
  ++proxy.refused;
  ++messages_refused;
  // Where it is wrong shows beside the schema, when somebody reads the trace.
  traces.add(now, proxy.name, "AIV_Server", to_string(topic), "refused: " + to_string(error), input.source,
             input.payload);
  log_once(
      proxy, note_unreadable << static_cast<std::uint32_t>(topic), 'w',
      std::string(to_string(topic)) + " message refused: " + to_string(error) + " (said once; the rest is counted)");
}

void ServerCore::Inside::on_vehicle_message(Registry::Address address, const wire::Input& input) {
  AivProxy& proxy = registry[address.vehicle];
  ++proxy.messages;
  if (proxy.retired) return on_ghost(proxy, address.topic, input);
  const bool moving = address.topic != VehicleTopic::connection && address.topic != VehicleTopic::factsheet;
  if (input.flag && moving) {
    // §6.2: only connection and factsheet are retained. An old state would put the twin where the vehicle once was.
    ++proxy.refused;
    log_once(proxy, note_retained, 'w',
             "a retained " + std::string(to_string(address.topic)) + " is out of date; ignored");
    return;
  }
  if (input.payload.empty() && !input.said) return;  // somebody cleared a retained message
  switch (address.topic) {
    case VehicleTopic::connection: on_connection(address.vehicle, input); break;
    case VehicleTopic::factsheet: on_factsheet(address.vehicle, input); break;
    case VehicleTopic::state: on_state(address.vehicle, input); break;
    case VehicleTopic::visualization: on_visualization(address.vehicle, input); break;
    case VehicleTopic::felt: on_felt(address.vehicle, input); break;
    case VehicleTopic::seen: on_seen(address.vehicle, input); break;
    case VehicleTopic::boards: on_boards(address.vehicle, input); break;
  }
}

void ServerCore::Inside::on_ghost(AivProxy& proxy, VehicleTopic topic, const wire::Input& input) {
  // What was still on its way when it was taken away. Only whether it says to be there counts.
  if (topic != VehicleTopic::connection) return;
  if (const auto message = wire::vda5050::decode_connection(input.payload)) proxy.connection = message->state;
}

bool ServerCore::Inside::take_header(VehicleIndex vehicle, VehicleTopic topic, const wire::Header& header) {
  AivProxy& proxy = registry[vehicle];
  const auto differs = [](const std::string& said, const std::string& known) { return !said.empty() && said != known; };
  if (differs(header.manufacturer, proxy.id.manufacturer) || differs(header.serial_number, proxy.id.serial_number)) {
    ++proxy.refused;
    ++messages_refused;
    log_once(proxy, note_identity, 'w',
             "a message on its topic says it is from '" + header.manufacturer.substr(0, 64) + "/" +
                 header.serial_number.substr(0, 64) + "'; ignored");
    return false;
  }
  if (!header.version.empty()) {
    if (major_of(header.version) != 2) {
      ++proxy.refused;
      ++messages_refused;
      log_once(proxy, note_version, 'w',
               "speaks version '" + header.version.substr(0, 32) + "'; this server reads 2.x; ignored");
      return false;
    }
    proxy.version = header.version;
  }
  auto& last = proxy.last_header_id[static_cast<std::size_t>(topic)];
  if (last) {
    // Counts modulo 2³²; a large step is a restart or an old message, not thousands of lost ones.
    const std::uint32_t step = header.header_id - *last;
    if (step > 1 && step < 1000) proxy.headers_missed += step - 1;
  }
  last = header.header_id;
  return true;
}

SimTime ServerCore::Inside::clock_of(AivProxy& proxy, SimTime stamp) {
  const SimDuration off = now - stamp;
  if (off > clock_tolerance || off < -clock_tolerance) {
    proxy.clock_off_s = to_seconds(off);
    log_once(proxy, note_clock, 'w',
             "its clock is off by " + std::to_string(proxy.clock_off_s) + " s; arrival times are used instead");
    return now;
  }
  proxy.clock_off_s = 0.0;
  return std::min(stamp, now);
}

void ServerCore::Inside::on_report(VehicleIndex vehicle, SimTime reported_at) {
  AivProxy& proxy = registry[vehicle];
  if (!proxy.online() && now - proxy.connection_at > will_outlived) {
    publisher.log('i', proxy.name + ": goes on reporting; taken as connected");
    proxy.connection = wire::ConnectionState::online;
    proxy.connection_at = now;
  }
  proxy.reports.on_report(now);
  proxy.reported_at = std::max(proxy.reported_at, reported_at);
  // A vehicle that has just been switched on may need a moment to find its place; one that does not is an orphan.
  if (proxy.online() && now - *proxy.reports.first() > arrival_patience) twins.set_present(proxy);
}

void ServerCore::Inside::on_connection(VehicleIndex vehicle, const wire::Input& input) {
  const auto message = wire::vda5050::decode_connection(input.payload);
  if (!message) return refuse(vehicle, VehicleTopic::connection, input, message.error());
  if (!take_header(vehicle, VehicleTopic::connection, message->header)) return;
  AivProxy& proxy = registry[vehicle];
  traces.add(now, proxy.name, "AIV_Server", "connection", wire::vda5050::to_string(message->state), input.source,
             input.payload);
  const bool was_online = proxy.connection == wire::ConnectionState::online;
  proxy.connection = message->state;
  proxy.connection_at = now;
  if (message->state == wire::ConnectionState::online && !was_online) {
    // A new session: it counts and perhaps dates anew, and has forgotten what speed it was told.
    proxy.last_header_id = {};
    proxy.position_stamp.reset();
    proxy.state_stamp.reset();
    proxy.imposed.reset();
    // Whatever it said in its last life, where it is now it has yet to say.
    proxy.state_in_session = false;
    proxy.position_known = false;
    proxy.position_lost_since.reset();
    proxy.factsheet_asked = false;
    proxy.boards.reset();
    proxy.boards_stamp.reset();
    proxy.seen_stamp.reset();
    virtual_obstacles.new_session(vehicle);
  }
}

void ServerCore::Inside::on_factsheet(VehicleIndex vehicle, const wire::Input& input) {
  auto message = wire::vda5050::decode_factsheet(input.payload);
  if (!message) return refuse(vehicle, VehicleTopic::factsheet, input, message.error());
  if (!take_header(vehicle, VehicleTopic::factsheet, message->header)) return;
  AivProxy& proxy = registry[vehicle];
  traces.add(now, proxy.name, "AIV_Server", "factsheet",
             message->series_name + ", " + std::to_string(message->actions.size()) + " actions", input.source,
             input.payload);
  proxy.factsheet = std::move(*message);
}

void ServerCore::Inside::on_visualization(VehicleIndex vehicle, const wire::Input& input) {
  const auto message = wire::vda5050::heard_visualization(input);
  if (!message) return refuse(vehicle, VehicleTopic::visualization, input, message.error());
  if (!take_header(vehicle, VehicleTopic::visualization, message->header)) return;
  AivProxy& proxy = registry[vehicle];
  if (message->position)
    traces.add_position(now, proxy.name, "AIV_Server", "visualization", message->position->pose,
                        message->velocity ? message->velocity->vx_mps : 0.0, input.source, input.payload);
  if (const auto stamp = fresh_position_stamp(proxy, message->header)) {
    on_report(vehicle, clock_of(proxy, *stamp));
    if (message->position) on_position(vehicle, *stamp, *message->position, message->velocity);
  }
  commands.on_state(vehicle);
}

void ServerCore::Inside::on_state(VehicleIndex vehicle, const wire::Input& input) {
  auto message = wire::vda5050::heard_state(input);
  if (!message) return refuse(vehicle, VehicleTopic::state, input, message.error());
  if (!take_header(vehicle, VehicleTopic::state, message->header)) return;
  AivProxy& proxy = registry[vehicle];
  const SimTime stamp = message->header.timestamp;
  if (proxy.state_stamp) {
    const bool late = stamp < *proxy.state_stamp && *proxy.state_stamp - stamp < reorder_max;
    const bool again = stamp == *proxy.state_stamp && message->header.header_id == proxy.state->header.header_id;
    if (late || again) {
      ++proxy.outdated;
      return;
    }
  }
  traces.add(now, proxy.name, "AIV_Server", "state", summary_of(*message), input.source, input.payload);
  const std::optional<wire::State> before = std::exchange(proxy.state, std::move(*message));
  const wire::State& state = *proxy.state;
  proxy.state_stamp = stamp;
  proxy.state_since_link = proxy.state_since_link || link.up();
  proxy.state_in_session = true;
  const SimTime reported_at = clock_of(proxy, stamp);
  on_report(vehicle, reported_at);

  read_limits_and_tags(proxy);
  twins.apply_base_end(vehicle);
  const auto position_stamp = fresh_position_stamp(proxy, state.header);
  if (position_stamp && state.position) on_position(vehicle, *position_stamp, *state.position, state.velocity);
  orders.on_state(vehicle, before ? &*before : nullptr);
  actions.on_state(vehicle, state);
  commands.on_state(vehicle);
  show_events(vehicle, before ? &*before : nullptr, reported_at);
}

std::optional<SimTime> ServerCore::Inside::fresh_position_stamp(AivProxy& proxy, const wire::Header& header) const {
  const SimTime stamp = header.timestamp == SimTime{} ? now : header.timestamp;
  if (!proxy.position_stamp) return stamp;
  const SimDuration back = *proxy.position_stamp - stamp;
  if (back < SimDuration::zero() || back >= reorder_max) return stamp;
  // State and visualization of one instant say the same; an older one must not take the twin back.
  if (back > SimDuration::zero()) ++proxy.outdated;
  return std::nullopt;
}

void ServerCore::Inside::on_position(VehicleIndex vehicle, SimTime stamp, const wire::AgvPosition& position,
                                     const std::optional<wire::Velocity>& velocity) {
  AivProxy& proxy = registry[vehicle];
  const SimTime at = clock_of(proxy, stamp);
  proxy.position_stamp = stamp;
  proxy.map_id = position.map_id;
  if (!position.position_initialized) {
    proxy.position_known = false;
    if (!proxy.position_lost_since) proxy.position_lost_since = now;
    return;
  }
  const Pose2& pose = position.pose;
  if (!(std::fabs(pose.x_m) <= coordinate_m_max && std::fabs(pose.y_m) <= coordinate_m_max)) {
    ++proxy.refused;
    log_once(proxy, note_place, 'w', "reports a place more than 100 km away; ignored");
    return;
  }
  proxy.position_known = true;
  proxy.position_lost_since.reset();
  proxy.reported = pose;
  twins.set_present(proxy);
  twins.place(vehicle, at, pose, velocity);
}

void ServerCore::Inside::read_limits_and_tags(AivProxy& proxy) {
  const wire::State& state = *proxy.state;
  for (auto action = state.action_states.rbegin(); action != state.action_states.rend(); ++action) {
    if (action->action_type != "setSpeedLimit" || action->status != wire::ActionStatus::finished) continue;
    proxy.imposed = aiv::parse_profile(action->result_description);  // "normal" is none of the profiles
    break;
  }
  for (const wire::Information& information : state.information) {
    if (information.type != "lastTag") continue;
    if (const auto tag = number_in<std::uint32_t>(information.references, "tag")) {
      proxy.last_tag = *tag;
      proxy.since_tag_m = number_in<double>(information.references, "distance_m").value_or(0.0);
    }
  }
}

void ServerCore::Inside::show_events(VehicleIndex vehicle, const wire::State* before, SimTime reported_at) {
  AivProxy& proxy = registry[vehicle];
  const wire::State& state = *proxy.state;
  if (proxy.last_tag != proxy.tag_shown) {
    if (before != nullptr) twins.record_event(proxy, PhysicalEvent::tag, reported_at);
    proxy.tag_shown = proxy.last_tag;
  }
  if (before == nullptr) return;
  if (state.field_violation && !before->field_violation)
    twins.record_event(proxy, PhysicalEvent::obstacle, reported_at);
  if (!state.driving && before->driving) twins.record_event(proxy, PhysicalEvent::stop, reported_at);
  if (std::floor(state.battery.charge_percent) != std::floor(before->battery.charge_percent))
    twins.record_event(proxy, PhysicalEvent::battery, reported_at);
}

void ServerCore::Inside::help_lost_position(VehicleIndex vehicle) {
  AivProxy& proxy = registry[vehicle];
  if (!proxy.position_lost_since || now - *proxy.position_lost_since <= position_lost_max) return;
  if (!proxy.reported || !zones.map() || !proxy.online() || proxy.lost(now, options.lost_after)) return;
  if (proxy.init_sent_at && now - *proxy.init_sent_at < init_again) return;
  if (proxy.supports("initPosition") == std::optional{false}) return;
  // One that no way comes near stands where it says, and has nothing to be told.
  if (!zones.change().off_route(vehicle).empty()) return;
  proxy.init_sent_at = now;
  wire::Action action{"initPosition", {}, {}, wire::BlockingType::hard, {}};
  action.parameters = {{"x", proxy.reported->x_m},
                       {"y", proxy.reported->y_m},
                       {"theta", proxy.reported->heading_rad},
                       {"mapId", simulator.zone()->name}};
  const Twin& twin = simulator.twin(*proxy.twin);
  if (twin.on_circuit()) {
    if (const auto behind = zones.map()->behind(twin.reported_place(), traffic.gone(vehicle)))
      action.parameters.push_back({"lastNodeId", zones.map()->waypoint(behind->waypoint).id});
  }
  publisher.log('i', proxy.name + ": does not know where it is; told its last place");
  actions.send(proxy, vehicle, {std::move(action)}, std::chrono::seconds{2}, false);
}

void ServerCore::Inside::ask_factsheet(VehicleIndex vehicle) {
  AivProxy& proxy = registry[vehicle];
  if (proxy.factsheet || proxy.factsheet_asked || !proxy.present || !proxy.online()) return;
  if (now - proxy.first_heard < factsheet_patience) return;
  proxy.factsheet_asked = true;
  actions.send(proxy, vehicle, {{"factsheetRequest", {}, {}, wire::BlockingType::none, {}}}, SimDuration::zero(),
               false);
}

}  // namespace cosiva::virtual_side
