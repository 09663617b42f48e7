#include "cosiva/virtual/server/reports/vehicle_reports.h"

#include <cmath>
#include <utility>

#include "cosiva/base/expect.h"
#include "cosiva/wire/vda5050/codec.h"
#include "cosiva/wire/vda5050/typed_messages.h"

namespace cosiva::virtual_side {
namespace {

constexpr SimDuration arrival_timeout{std::chrono::seconds{1}};

std::string summary_of(const wire::State& state) {
  std::string text = "order '" + state.order_id + "' update " + std::to_string(state.order_update_id) + ", node " +
                     state.last_node_id + " (" + std::to_string(state.last_node_sequence_id) + ")";
  text += state.driving ? ", driving" : ", stopped";
  if (state.paused) text += ", paused";
  if (state.field_violation) text += ", field violation";
  for (const wire::VehicleError& error : state.errors) text += ", " + error.type;
  return text;
}

}  // namespace

bool VehicleReports::receive(const wire::Input& input) {
  const auto address = address_of(input.source);
  if (address) receive(*address, input);
  return address.has_value();
}

std::optional<Registry::Address> VehicleReports::address_of(const std::string& topic) {
  if (const auto known = context_.registry.find_topic(topic)) return known;
  if (!topic.starts_with(context_.topic_prefix)) return std::nullopt;
  const auto parsed = wire::parse_vda_topic(topic);
  if (!parsed) return std::nullopt;
  const auto kind = parse_vehicle_topic(parsed->name);
  if (!kind) return std::nullopt;
  std::string fault;
  if (parsed->major_version != "v2")
    fault = "uses '" + parsed->major_version + "'; this server uses v2";
  else if (!wire::valid_serial_number(parsed->vehicle.serial_number) ||
           !wire::valid_serial_number(parsed->vehicle.manufacturer))
    fault = "has a name with characters that VDA 5050 does not permit";
  if (!fault.empty()) {
    refuse_unknown_sender(context_, topic, "it " + fault);
    return std::nullopt;
  }
  if (const auto index = vehicles_.register_vehicle(parsed->vehicle)) return Registry::Address{*index, *kind};
  refuse_excess_vehicle(context_, wire::to_string(parsed->vehicle));
  return std::nullopt;
}

void VehicleReports::receive(Registry::Address address, const wire::Input& input) {
  AivProxy& proxy = context_.registry[address.vehicle];
  proxy.counters.on_message();
  proxy.membership.on_message(context_.now);
  if (floods(proxy)) return;
  const bool reports = address.topic == VehicleTopic::state || address.topic == VehicleTopic::visualization;
  if (proxy.membership.departed() && reports && !input.flag) vehicles_.begin_life(proxy.id());
  if (proxy.retired()) return on_retired(proxy, address.topic, input);
  const bool moving = address.topic != VehicleTopic::connection && address.topic != VehicleTopic::factsheet;
  if (input.flag && moving) {
    // §6.2: only connection and factsheet are retained. An old state would move the twin to an outdated position.
    proxy.counters.on_refused();
    checks_.log_once(proxy, ReportChecks::retained, 'w',
                     "a retained " + std::string(to_string(address.topic)) + " is out of date; ignored");
    return;
  }
  if (input.payload.empty() && !input.typed) return;  // a retained message was cleared
  switch (address.topic) {
    case VehicleTopic::connection: on_connection(address.vehicle, input); break;
    case VehicleTopic::factsheet: on_factsheet(address.vehicle, input); break;
    case VehicleTopic::state: on_state(address.vehicle, input); break;
    case VehicleTopic::visualization: on_visualization(address.vehicle, input); break;
    case VehicleTopic::perceived: own_.on_acknowledged(address.vehicle, input); break;
    case VehicleTopic::detected: own_.on_detected(address.vehicle, input); break;
    case VehicleTopic::boards: own_.on_boards(address.vehicle, input); break;
  }
}

bool VehicleReports::floods(AivProxy& proxy) {
  if (proxy.augmented()) return false;
  const double per_s_max = context_.options.vehicle_messages_per_s_max;
  const MessageRate::Decision decision = proxy.counters.rate().on_message(context_.now, per_s_max);
  if (decision == MessageRate::Decision::accepted) return false;
  proxy.counters.on_dropped();
  if (decision == MessageRate::Decision::flood_begins)
    context_.publisher.log('w', proxy.name() + ": sends more than its limit of " +
                                    std::to_string(std::lround(proxy.counters.rate().limit_per_s(per_s_max))) +
                                    " messages per second; the excess is dropped and counted");
  return true;
}

void VehicleReports::on_retired(AivProxy& proxy, VehicleTopic topic, const wire::Input& input) {
  // A message that was in transit when the vehicle was retired: only a connection message counts.
  if (topic != VehicleTopic::connection) return;
  if (const auto message = wire::vda5050::decode_connection(input.payload))
    proxy.connection.on_connection(message->state, context_.now, message->header.timestamp);
}

void VehicleReports::deliver(AivProxy& proxy, std::string_view kind, std::string_view summary,
                             const wire::Input& input) {
  proxy.deliver(context_.traces, context_.now, {kind, summary, input.source, input.payload});
}

void VehicleReports::on_report(VehicleIndex vehicle, SimTime reported_at) {
  AivProxy& proxy = context_.registry[vehicle];
  COSIVA_EXPECT(!proxy.retired());
  if (proxy.connection.on_report(context_.now))
    context_.publisher.log('i', proxy.name() + ": continues to report; treated as connected");
  proxy.reports.on_report(context_.now, reported_at);
  // A vehicle that has just been switched on may need some time to find its position; a vehicle that does not is an
  // orphan.
  if (proxy.online() && context_.now - *proxy.reports.first() > arrival_timeout) twins_.set_present(proxy);
}

void VehicleReports::on_connection(VehicleIndex vehicle, const wire::Input& input) {
  const auto message = wire::vda5050::decode_connection(input.payload);
  if (!message) return checks_.refuse(vehicle, VehicleTopic::connection, input, message.error());
  if (!checks_.take_header(vehicle, VehicleTopic::connection, message->header)) return;
  AivProxy& proxy = context_.registry[vehicle];
  deliver(proxy, "connection", wire::vda5050::to_string(message->state), input);
  if (!proxy.connection.on_connection(message->state, context_.now, message->header.timestamp)) return;
  proxy.on_session();
  augmented_.virtual_obstacles.new_session(vehicle);
}

void VehicleReports::on_factsheet(VehicleIndex vehicle, const wire::Input& input) {
  auto message = wire::vda5050::decode_factsheet(input.payload);
  if (!message) return checks_.refuse(vehicle, VehicleTopic::factsheet, input, message.error());
  if (!checks_.take_header(vehicle, VehicleTopic::factsheet, message->header)) return;
  AivProxy& proxy = context_.registry[vehicle];
  deliver(proxy, "factsheet", message->series_name + ", " + std::to_string(message->actions.size()) + " actions",
          input);
  const auto per_s = [](double interval_s) { return interval_s > 0.0 ? 1.0 / interval_s : 0.0; };
  proxy.counters.rate().on_announced(per_s(message->default_state_interval_s) +
                                     per_s(message->visualization_interval_s));
  proxy.factsheet.on_factsheet(std::move(*message));
}

void VehicleReports::on_visualization(VehicleIndex vehicle, const wire::Input& input) {
  const auto received = wire::vda5050::visualization_from(input);
  if (!received) return checks_.refuse(vehicle, VehicleTopic::visualization, input, received.error());
  const wire::Visualization& message = **received;
  if (!checks_.take_header(vehicle, VehicleTopic::visualization, message.header)) return;
  AivProxy& proxy = context_.registry[vehicle];
  if (message.position)
    proxy.deliver_position(context_.traces, context_.now, {"visualization", {}, input.source, input.payload},
                           message.position->pose, message.velocity ? message.velocity->vx_mps : 0.0);
  else
    proxy.deliver_untraced();
  if (const auto stamp = fresh_position_stamp(proxy, message.header)) {
    on_report(vehicle, checks_.server_time(proxy, *stamp));
    if (message.position) on_position(vehicle, *stamp, *message.position, message.velocity);
  }
  master_.commands.on_state(vehicle);
}

void VehicleReports::on_state(VehicleIndex vehicle, const wire::Input& input) {
  auto message = wire::vda5050::state_from(input);
  if (!message) return checks_.refuse(vehicle, VehicleTopic::state, input, message.error());
  if (!checks_.take_header(vehicle, VehicleTopic::state, (*message)->header)) return;
  AivProxy& proxy = context_.registry[vehicle];
  if (proxy.reported_state.outdated((*message)->header)) {
    proxy.counters.on_outdated();
    return;
  }
  deliver(proxy, "state", summary_of(**message), input);
  const ReportedState::Change change = proxy.reported_state.on_state(std::move(*message), context_.link.up());
  if (!change.before && !proxy.augmented()) context_.state_stale = true;  // it is awaited after a restart
  const wire::State& state = *proxy.state();
  const SimTime reported_at = checks_.server_time(proxy, state.header.timestamp);
  on_report(vehicle, reported_at);

  twins_.apply_base_end(vehicle);
  const auto position_stamp = fresh_position_stamp(proxy, state.header);
  if (position_stamp && state.position) on_position(vehicle, *position_stamp, *state.position, state.velocity);
  master_.orders.on_state(vehicle, change.before.get());
  master_.actions.on_state(vehicle, state);
  master_.commands.on_state(vehicle);
  if (change.before) record_events(vehicle, change, reported_at);
}

std::optional<SimTime> VehicleReports::fresh_position_stamp(AivProxy& proxy, const wire::Header& header) const {
  const SimTime stamp = header.timestamp == SimTime{} ? context_.now : header.timestamp;
  const ReportedPosition::Order order = proxy.position.order_of(stamp);
  if (order == ReportedPosition::Order::newer) return stamp;
  if (order == ReportedPosition::Order::overtaken) proxy.counters.on_outdated();
  return std::nullopt;
}

void VehicleReports::on_position(VehicleIndex vehicle, SimTime stamp, const wire::AgvPosition& position,
                                 const std::optional<wire::Velocity>& velocity) {
  AivProxy& proxy = context_.registry[vehicle];
  const SimTime at = checks_.server_time(proxy, stamp);
  if (!position.position_initialized) return proxy.position.on_lost(stamp, position.map_id, context_.now);
  if (!ReportedPosition::plausible(position.pose)) {
    proxy.position.on_implausible(stamp, position.map_id);
    proxy.counters.on_refused();
    checks_.log_once(proxy, ReportChecks::position, 'w', "reports a position more than 100 km away; ignored");
    return;
  }
  proxy.position.on_position(stamp, position.map_id, position.pose);
  twins_.set_present(proxy);
  twins_.put(vehicle, at, position.pose, velocity);
}

void VehicleReports::record_events(VehicleIndex vehicle, const ReportedState::Change& change, SimTime reported_at) {
  COSIVA_EXPECT(change.before);
  AivProxy& proxy = context_.registry[vehicle];
  const wire::State& before = *change.before;
  const wire::State& state = *proxy.state();
  if (change.new_tag) {
    twins_.record_event(proxy, PhysicalEvent::tag, reported_at);
    if (!proxy.augmented()) instruments_.reports.on_tag(context_.now, proxy);
  }
  if (state.field_violation && !before.field_violation)
    twins_.record_event(proxy, PhysicalEvent::obstacle, reported_at);
  if (!state.driving && before.driving) twins_.record_event(proxy, PhysicalEvent::stop, reported_at);
  if (std::floor(state.battery.charge_percent) != std::floor(before.battery.charge_percent))
    twins_.record_event(proxy, PhysicalEvent::battery, reported_at);
}

}  // namespace cosiva::virtual_side
