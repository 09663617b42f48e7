#include "cosiva/wire/own/battery_exchange.h"

#include <array>

#include "cosiva/base/json_writer.h"
#include "cosiva/wire/own/own_fields.h"

namespace cosiva::wire {

using own::Fields;
using own::read_message;

namespace {

constexpr std::array<std::string_view, 5> phase_terms{"changing", "ready", "running", "paused", "ended"};
/// The size of a test of vehicles_max vehicles with the longest names.
constexpr std::size_t test_bytes_max = 256U << 10U;
constexpr double seconds_max = 1e9;

void read_slot(Fields& in, BatteryTest::Slot& slot) {
  in.text("vehicle", slot.vehicle);
  in.text("battery", slot.battery);
  std::string phase;
  in.text("phase", phase);
  bool known = false;
  for (std::size_t i = 0; i < phase_terms.size(); ++i) {
    if (phase_terms[i] != phase) continue;
    slot.phase = static_cast<BatteryPhase>(i);
    known = true;
  }
  if (!known) in.report_fault("phase", "changing, ready, running, paused or ended");
  in.text("stop", slot.stop);
  in.number("autonomy_s", 0.0, seconds_max, slot.autonomy_s);
  in.number("charge", 0.0, 100.0, slot.charge_percent);
}

}  // namespace

std::string_view to_string(BatteryPhase phase) { return phase_terms[static_cast<std::size_t>(phase)]; }

std::string to_json(const BatteryTest& test) {
  JsonWriter json;
  json.begin_object().field("timestamp", to_iso8601(test.timestamp)).field("began", to_iso8601(test.began));
  json.field("run", test.run).field("runs", test.runs).field("floor", test.floor_percent).field("progress", test.ratio);
  json.key("expectedEnd");
  if (test.expected_end)
    json.value(to_iso8601(*test.expected_end));
  else
    json.null();
  json.field("done", test.done).key("vehicles").begin_array();
  for (const BatteryTest::Slot& slot : test.vehicles) {
    json.begin_object().field("vehicle", slot.vehicle).field("battery", slot.battery);
    json.field("phase", to_string(slot.phase)).field("stop", slot.stop).field("autonomy_s", slot.autonomy_s);
    if (slot.charge_percent) json.field("charge", *slot.charge_percent);
    json.end_object();
  }
  return json.end_array().end_object().take();
}

Result<BatteryTest> battery_test_from_json(std::string_view text) {
  const auto read = [](Fields& in, BatteryTest& test) {
    in.time("timestamp", test.timestamp);
    in.time("began", test.began);
    in.whole("run", test.run);
    in.whole("runs", test.runs);
    in.number("floor", 0.0, 100.0, test.floor_percent);
    in.number("progress", 0.0, 1.0, test.ratio);
    if (in.optional("expectedEnd") != nullptr) in.time("expectedEnd", test.expected_end.emplace());
    in.flag("done", test.done);
    in.list("vehicles", BatteryTest::vehicles_max, [&](const JsonValue& item, const std::string& name) {
      Fields fields{item, name + "."};
      read_slot(fields, test.vehicles.emplace_back());
      in.take_over(fields.error());
    });
  };
  return read_message<BatteryTest>(text, read, test_bytes_max);
}

std::string to_json(const BatteryChange& change) { return to_json(BatteryRequest{change, false}); }

std::string to_json(const BatteryRequest& request) {
  const BatteryChange& change = request.change;
  JsonWriter json;
  json.begin_object().field("battery", change.battery).field("run", change.run).field("reason", change.reason);
  if (request.by_hand) json.field("byHand", true);
  return json.end_object().take();
}

std::string to_json(const BatteryReady& ready) {
  JsonWriter json;
  json.begin_object().field("battery", ready.battery).field("type", ready.type).field("cycles", ready.cycles);
  json.field("rest_s", ready.rest_s).field("temperature", ready.temperature_c).field("charge", ready.charge_percent);
  return json.end_object().take();
}

Result<BatteryRequest> battery_request_from_json(std::string_view text) {
  return read_message<BatteryRequest>(text, [](Fields& in, BatteryRequest& request) {
    in.text("battery", request.change.battery);
    in.whole("run", request.change.run);
    in.text("reason", request.change.reason);
    if (in.optional("byHand") != nullptr) in.flag("byHand", request.by_hand);
  });
}

Result<BatteryChange> battery_change_from_json(std::string_view text) {
  auto request = battery_request_from_json(text);
  if (!request) return tl::unexpected(request.error());
  return std::move(request->change);
}

Result<BatteryReady> battery_ready_from_json(std::string_view text) {
  return read_message<BatteryReady>(text, [](Fields& in, BatteryReady& ready) {
    in.text("battery", ready.battery);
    if (ready.battery.empty()) in.report_fault("battery", "its id");
    in.text("type", ready.type);
    in.number("cycles", 0.0, 1e6, ready.cycles);
    in.number("rest_s", 0.0, 1e9, ready.rest_s);
    in.number("temperature", -100.0, 200.0, ready.temperature_c);
    in.number("charge", 0.0, 100.0, ready.charge_percent);
  });
}

}  // namespace cosiva::wire
