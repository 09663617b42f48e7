#include "cosiva/experiments/battery/live_rig.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "cosiva/base/expect.h"
#include "cosiva/base/json_value.h"
#include "cosiva/battery/type_json.h"

namespace cosiva::experiments {
namespace {

/// A larger distance between two position reports was not driven: the vehicle's position was reset.
constexpr double hop_max_m = 1.0;

wire::BatteryPhase phase_of(const Procedure::SlotNow& slot) {
  switch (slot.phase) {
    case Procedure::Phase::changing: return wire::BatteryPhase::changing;
    case Procedure::Phase::ready: return wire::BatteryPhase::ready;
    case Procedure::Phase::running: return slot.paused ? wire::BatteryPhase::paused : wire::BatteryPhase::running;
    case Procedure::Phase::ended: break;
  }
  return wire::BatteryPhase::ended;
}

}  // namespace

std::string plant_battery_json(std::size_t vehicle, const std::string& id, const BatteryUnderTest* kind,
                               std::uint64_t seed, double cycles) {
  JsonWriter json;
  json.begin_object().key("changeBattery").begin_object().field("vehicle", vehicle).field("id", id);
  if (kind != nullptr) {
    json.field("type", battery::to_json(kind->type)).field("series", kind->design.series);
    json.field("parallel", kind->design.parallel).field("scale", kind->design.scale).field("spread", kind->spread);
    json.field("seed", seed).field("cycles", cycles);
    json.field("gauge", battery::to_string(kind->gauge)).field("temperature", kind->ambient_c);
  } else {
    json.field("scale", 1000.0);
  }
  return json.end_object().end_object().take();
}

std::string server_command_json(std::string_view command, const std::string& vehicle) {
  JsonWriter json;
  json.begin_object().field("command", command).field("vehicle", vehicle).end_object();
  return json.take();
}

LiveRig::LiveRig(LiveRigOptions options)
    : options_{std::move(options)}, procedure_{options_.procedure}, slots_(options_.vehicles.size()) {
  COSIVA_EXPECT(slots_.size() == options_.procedure.vehicles && options_.batteries.size() == slots_.size());
}

std::vector<std::string> LiveRig::subscriptions() {
  std::vector<std::string> topics{wire::topics_below(wire::boards_topic_prefix, 2),
                                  wire::topics_below(wire::battery_ready_topic_prefix, 2)};
  topics.emplace_back(wire::default_interface).append("/+/+/+/visualization");
  return topics;
}

LiveRig::Responses LiveRig::start(SimTime now) {
  Responses responses;
  began_ = now;
  obey(procedure_.start(now), responses);
  return responses;
}

bool LiveRig::complete() const { return missing().empty(); }

std::string LiveRig::missing() const {
  std::string names;
  for (std::size_t v = 0; v < slots_.size(); ++v)
    if (!slots_[v].received) names += (names.empty() ? "" : ", ") + to_string(options_.vehicles[v]);
  return names;
}

std::optional<std::size_t> LiveRig::slot_of(const wire::VehicleId& id) const {
  const auto found = std::ranges::find(options_.vehicles, id);
  if (found == options_.vehicles.end()) return std::nullopt;
  return static_cast<std::size_t>(found - options_.vehicles.begin());
}

LiveRig::Responses LiveRig::on_message(SimTime now, std::string_view topic, std::string_view payload) {
  Responses responses;
  if (const auto id = wire::parse_own_topic(wire::boards_topic_prefix, topic)) {
    if (const auto v = slot_of(*id)) on_report(now, *v, payload, responses);
  } else if (const auto ready = wire::parse_own_topic(wire::battery_ready_topic_prefix, topic)) {
    if (const auto v = slot_of(*ready)) on_ready(now, *v, payload, responses);
  } else if (const auto vda = wire::parse_vda_topic(topic); vda && vda->name == "visualization") {
    if (const auto v = slot_of(vda->vehicle)) on_position(*v, payload);
  }
  return responses;
}

void LiveRig::on_report(SimTime now, std::size_t vehicle, std::string_view payload, Responses& responses) {
  const auto report = wire::boards_report_from_json(payload);
  if (!report) return;
  Slot& slot = slots_[vehicle];
  slot.received = true;
  if (!report->power || !procedure_.running(vehicle)) return;
  const wire::Power& power = *report->power;
  obey(procedure_.on_sample(
           vehicle,
           {report->timestamp, power.charge(), power.gauge ? 1e-4 * power.gauge->charge_sd_01 : 0.0,
            0.001 * power.voltage_mv, 0.001 * power.current_ma, 0.1 * power.temperature_01C, slot.odometer_m},
           now),
       responses);
}

void LiveRig::on_ready(SimTime now, std::size_t vehicle, std::string_view payload, Responses& responses) {
  const auto ready = wire::battery_ready_from_json(payload);
  if (!ready) {
    responses.operator_messages.push_back(to_string(options_.vehicles[vehicle]) +
                                          " sent an invalid batteryReady: " + to_string(ready.error()));
    return;
  }
  Slot& slot = slots_[vehicle];
  if (!slot.wanted) return;  // a battery that was not requested
  clear_request(vehicle, responses);
  BatteryTag tag{ready->battery, ready->type,          ready->cycles,
                 ready->rest_s,  ready->temperature_c, 0.01 * ready->charge_percent};
  // The vehicle reads neither type nor age: of an emulated battery the test knows both.
  if (options_.emulated) {
    tag.type = options_.emulated->type.name;
    tag.cycles = cycles_of(procedure_.battery_of(procedure_.run(), vehicle));
  }
  obey(procedure_.on_ready(now, vehicle, tag), responses);
}

double LiveRig::cycles_of(std::size_t battery) const {
  // Each full run so far was a cycle, less the remaining charge.
  double cycles = 0.0;
  for (const BatteryRun& record : procedure_.records())
    if (record.battery == battery) cycles += record.tag.charge - record.charge_end;
  return cycles;
}

void LiveRig::on_position(std::size_t vehicle, std::string_view payload) {
  const auto json = JsonValue::parse(payload);
  const JsonValue* position = json ? json->find("agvPosition") : nullptr;
  if (position == nullptr) return;
  const auto x = position->number("x");
  const auto y = position->number("y");
  if (!x || !y) return;
  Slot& slot = slots_[vehicle];
  if (slot.at) {
    const double traversed_m = distance(*slot.at, {*x, *y});
    if (traversed_m < hop_max_m) slot.odometer_m += traversed_m;
  }
  slot.at = Point2{*x, *y};
}

LiveRig::Responses LiveRig::tick(SimTime now) {
  Responses responses;
  obey(procedure_.tick(now), responses);
  return responses;
}

LiveRig::Responses LiveRig::give_up(SimTime now) {
  Responses responses;
  given_up_ = true;
  for (std::size_t v = 0; v < slots_.size(); ++v) {
    if (slots_[v].wanted) clear_request(v, responses);
    // Only of the present run: with the run's last end the next run would begin.
    if (procedure_.running(v)) obey(procedure_.on_stop(now, v, StopCause::operator_stop), responses);
  }
  return responses;
}

wire::BatteryTest LiveRig::test(SimTime now) const {
  const ProcedureOptions& requested = options_.procedure;
  const Procedure::Progress progress = procedure_.progress(now);
  wire::BatteryTest test;
  test.timestamp = now;
  test.began = began_;
  test.run = static_cast<std::uint32_t>(std::min(procedure_.present_run() + 1, requested.runs));
  test.runs = static_cast<std::uint32_t>(requested.runs);
  test.floor_percent = 100.0 * requested.floor;
  test.ratio = std::clamp(progress.ratio, 0.0, 1.0);
  test.done = done();
  if (!test.done) test.expected_end = progress.expected_end;
  for (std::size_t v = 0; v < std::min(slots_.size(), wire::BatteryTest::vehicles_max); ++v) {
    const Procedure::SlotNow slot = procedure_.slot(now, v);
    std::optional<double> charge_percent;
    if (slot.charge) charge_percent = std::clamp(100.0 * *slot.charge, 0.0, 100.0);
    test.vehicles.push_back({to_string(options_.vehicles[v]), options_.batteries[slot.battery], phase_of(slot),
                             slot.stop ? std::string(to_string(*slot.stop)) : std::string{}, slot.autonomy_s,
                             charge_percent});
  }
  return test;
}

void LiveRig::drive(std::size_t vehicle, const char* command, Responses& responses) const {
  responses.commands.push_back(server_command_json(command, to_string(options_.vehicles[vehicle])));
}

void LiveRig::obey(const ProcedureCommands& commands, Responses& responses) {
  for (const ProcedureCommand& command : commands) {
    using Kind = ProcedureCommand::Kind;
    switch (command.kind) {
      case Kind::change_battery:
        if (!given_up_) request(command.vehicle, command.battery, command.text, responses);
        break;
      case Kind::notify_operator:
        if (!given_up_) responses.operator_messages.push_back(command.text);
        break;
      case Kind::run:
      case Kind::resume: drive(command.vehicle, "restart", responses); break;
      case Kind::pause: drive(command.vehicle, "stop", responses); break;
      case Kind::stop: end(command.vehicle, responses); break;
    }
  }
}

void LiveRig::request(std::size_t vehicle, std::size_t battery, const std::string& reason, Responses& responses) {
  drive(vehicle, "stop", responses);
  slots_[vehicle].wanted = options_.batteries[battery];
  responses.messages.push_back({wire::own_topic(wire::battery_change_topic_prefix, options_.vehicles[vehicle]),
                                to_json(wire::BatteryRequest{{options_.batteries[battery],
                                                              static_cast<std::uint32_t>(procedure_.run() + 1), reason},
                                                             !options_.emulated}),
                                1, true});
  put_in(vehicle, battery, responses);
}

void LiveRig::clear_request(std::size_t vehicle, Responses& responses) {
  slots_[vehicle].wanted.reset();
  responses.messages.push_back(
      {wire::own_topic(wire::battery_change_topic_prefix, options_.vehicles[vehicle]), {}, 1, true});
}

void LiveRig::put_in(std::size_t vehicle, std::optional<std::size_t> battery, Responses& responses) const {
  if (!options_.emulated) return;
  const std::string json = battery ? plant_battery_json(vehicle + 1, options_.batteries[*battery], &*options_.emulated,
                                                        options_.seed * 1000 + *battery, cycles_of(*battery))
                                   : plant_battery_json(vehicle + 1, "service", nullptr, 0, 0.0);
  responses.messages.push_back({std::string(wire::plant_command_topic), json, 1, false});
}

void LiveRig::end(std::size_t vehicle, Responses& responses) {
  const std::string name = to_string(options_.vehicles[vehicle]);
  const BatteryRun& record = procedure_.records().back();
  responses.operator_messages.push_back(name + " has ended: " + std::string(to_string(record.stop)) + " after " +
                                        std::to_string(std::lround(record.autonomy_s)) + " s");
  if (options_.emulated) {
    put_in(vehicle, std::nullopt, responses);
    return drive(vehicle, "restart", responses);
  }
  if (options_.park.empty()) return drive(vehicle, "stop", responses);
  JsonWriter json;
  json.begin_object().field("command", "go").field("vehicle", name).field("to", options_.park).end_object();
  responses.commands.push_back(json.take());
}

std::string LiveRig::state_json() const {
  JsonWriter json;
  json.begin_object().field("procedure", procedure_.state_json()).field("began", to_iso8601(began_));
  json.key("slots").begin_array();
  for (const Slot& slot : slots_) {
    json.begin_object().field("odometer_m", slot.odometer_m);
    if (slot.wanted) json.field("wanted", *slot.wanted);
    json.end_object();
  }
  return json.end_array().end_object().take();
}

Result<LiveRig::Responses> LiveRig::restore(SimTime now, std::string_view state_json) {
  constexpr std::size_t bytes_max = 512U << 20U;
  const auto json = JsonValue::parse(state_json, bytes_max);
  if (!json) return fail("battery.state", json.error().message, "saved state");
  const auto procedure = json->text("procedure");
  const JsonValue* slots = json->find("slots");
  if (!procedure || slots == nullptr || slots->array() == nullptr || slots->array()->size() != slots_.size())
    return fail("battery.state", "the state is of another kind of test, or of another number of vehicles",
                "saved state");
  if (auto restored = procedure_.restore(*procedure); !restored) return tl::unexpected(restored.error());
  procedure_.forgive(now);
  began_ = parse_iso8601(json->text("began").value_or("")).value_or(now);
  Responses responses;
  for (std::size_t v = 0; v < slots_.size(); ++v) {
    const JsonValue& saved = (*slots->array())[v];
    slots_[v].odometer_m = saved.number("odometer_m").value_or(0.0);
    // The battery was requested before the restart: the response may have been lost meanwhile, so the request is
    // repeated.
    if (saved.text("wanted")) request(v, procedure_.battery_of(procedure_.run(), v), {}, responses);
  }
  return responses;
}

}  // namespace cosiva::experiments
