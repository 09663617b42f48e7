#include "cosiva/virtual/server/view/battery_test_relay.h"

#include <cmath>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {
namespace {

/// Rounds to the precision of the quantity; further digits of a float are noise.
double rounded(double value, double steps_per_unit) { return std::nearbyint(value * steps_per_unit) / steps_per_unit; }

void text_or_null(JsonWriter& json, std::string_view name, const std::string& text) {
  json.key(name);
  if (text.empty())
    json.null();
  else
    json.value(text);
}

/// A field of an operator's command; if the field is missing, `out` is unchanged.
Result<void> take(OptionalNumber given, const char* field, double low, double high, double& out) {
  if (!given) return {};
  if (!(*given >= low && *given <= high)) {
    return fail(std::string("battery.") + field,
                "give a number from " + std::to_string(std::lround(low)) + " to " + std::to_string(std::lround(high)),
                field);
  }
  out = *given;
  return {};
}

}  // namespace

void BatteryCurve::add(const Point& point) {
  if (!points_.empty() && point.at < points_.back().at) points_.clear();  // the clock was set
  if (!points_.empty() && point.at - points_.back().at < every_) return;
  if (points_.size() >= points_max) {
    for (std::size_t i = 0; 2 * i < points_.size(); ++i) points_[i] = points_[2 * i];
    points_.resize((points_.size() + 1) / 2);
    every_ *= 2;
  }
  COSIVA_EXPECT(points_.size() < points_max && (points_.empty() || point.at - points_.back().at >= every_));
  points_.push_back(point);
}

void BatteryCurve::forget_before(SimTime at) {
  std::erase_if(points_, [at](const Point& point) { return point.at < at; });
  if (points_.empty()) every_ = std::chrono::seconds{1};
}

std::vector<std::string> BatteryTestRelay::subscriptions() {
  return {wire::topics_below(wire::battery_change_topic_prefix, 2), std::string(wire::battery_test_topic)};
}

Result<std::string> BatteryTestRelay::on_message(const wire::Input& input) {
  if (input.source == wire::battery_test_topic) {
    if (input.payload.empty()) {
      test_.reset();
      return std::string{};
    }
    auto test = wire::battery_test_from_json(input.payload);
    if (!test) return tl::unexpected(test.error());
    const bool another = !test_ || test_->began != test->began;
    const std::string phrase = another ? "run " + std::to_string(test->run) + " of " + std::to_string(test->runs) : "";
    test_ = std::move(*test);
    if (another) {
      for (const wire::BatteryTest::Slot& slot : test_->vehicles)
        if (const auto curve = curves_.find(slot.vehicle); curve != curves_.end())
          curve->second.forget_before(test_->began);
    }
    return phrase;
  }
  const auto vehicle = wire::parse_own_topic(wire::battery_change_topic_prefix, input.source);
  if (!vehicle) return std::string{};
  const std::string name = to_string(*vehicle);
  if (input.payload.empty()) {
    changes_.erase(name);
    return std::string{};
  }
  auto change = wire::battery_change_from_json(input.payload);
  if (!change) return tl::unexpected(change.error());
  if (changes_.size() >= changes_max && !changes_.contains(name))
    return fail("battery.many", "more than " + std::to_string(changes_max) + " battery changes at a time", name);
  std::string phrase = "changeBattery in " + name + ": '" + change->battery + "'";
  changes_.insert_or_assign(name, Change{*vehicle, std::move(*change), input.at});
  COSIVA_EXPECT(changes_.size() <= changes_max);
  return phrase;
}

void BatteryTestRelay::link_up() {
  changes_.clear();
  test_.reset();
}

void BatteryTestRelay::on_power(SimTime at, const std::string& vehicle, const wire::Power& power) {
  curves_[vehicle].add({at, static_cast<float>(100.0 * power.charge()), 0.001F * static_cast<float>(power.voltage_mv),
                        0.1F * static_cast<float>(power.temperature_01C)});
}

Result<wire::Publish> BatteryTestRelay::ready(const BatteryReadyCommand& command) const {
  const std::string& vehicle = command.vehicle;
  if (vehicle.empty()) return fail("battery.vehicle", "give the vehicle as manufacturer/serial number", "vehicle");
  wire::BatteryReady ready{command.battery, "unknown", 0.0, 0.0, 22.0, 100.0};
  if (ready.battery.empty() || ready.battery.size() > 64)
    return fail("battery.battery", "give the battery's own id, of 1 to 64 bytes", "battery");
  if (command.type) {
    if (!command.type_is_text || command.type->size() > 64)
      return fail("battery.type", "give its type's name, of at most 64 bytes", "type");
    if (!command.type->empty()) ready.type = *command.type;
  }
  for (const auto& taken :
       {take(command.cycles, "cycles", 0.0, 1e6, ready.cycles), take(command.rest_s, "rest_s", 0.0, 1e9, ready.rest_s),
        take(command.temperature_c, "temperature", -100.0, 200.0, ready.temperature_c),
        take(command.charge_percent, "charge", 0.0, 100.0, ready.charge_percent)})
    if (!taken) return tl::unexpected(taken.error());
  const auto requested = changes_.find(vehicle);
  if (requested == changes_.end())
    return fail("battery.not_requested", "no test wants a battery changed in '" + vehicle.substr(0, 80) + "' now");
  return wire::Publish{wire::own_topic(wire::battery_fitted_topic_prefix, requested->second.vehicle), to_json(ready), 1,
                       false};
}

void BatteryTestRelay::write(JsonWriter& json) const {
  if (changes_.empty() && !test_) {
    json.null();
    return;
  }
  json.begin_object().key("changes").begin_array();
  for (const auto& [name, change] : changes_) {
    json.begin_object().field("vehicle", name).field("battery", change.wanted.battery).field("run", change.wanted.run);
    json.field("reason", change.wanted.reason).field("since_ms", to_milliseconds_scaled(change.since)).end_object();
  }
  json.end_array().key("test");
  if (test_)
    write_test(json);
  else
    json.null();
  json.end_object();
}

void BatteryTestRelay::write_test(JsonWriter& json) const {
  json.begin_object()
      .field("began_ms", to_milliseconds_scaled(test_->began))
      .field("received_ms", to_milliseconds_scaled(test_->timestamp));
  json.field("run", test_->run).field("runs", test_->runs).field("floor", test_->floor_percent);
  json.field("progress", test_->ratio).key("expectedEnd_ms");
  if (test_->expected_end)
    json.value(to_milliseconds_scaled(*test_->expected_end));
  else
    json.null();
  json.field("done", test_->done).key("vehicles").begin_array();
  for (const wire::BatteryTest::Slot& slot : test_->vehicles) {
    json.begin_object().field("id", slot.vehicle).field("battery", slot.battery).field("phase", to_string(slot.phase));
    text_or_null(json, "stop", slot.stop);
    json.field("autonomy_s", rounded(slot.autonomy_s, 10.0)).key("charge");
    if (slot.charge_percent)
      json.value(rounded(*slot.charge_percent, 1000.0));
    else
      json.null();
    json.end_object();
  }
  json.end_array().end_object();
}

std::optional<std::string> BatteryTestRelay::curve_json(const std::string& vehicle) const {
  const auto curve = curves_.find(vehicle);
  if (curve == curves_.end()) return std::nullopt;
  JsonWriter json;
  json.begin_object().field("vehicle", vehicle).key("points").begin_array();
  for (const BatteryCurve::Point& point : curve->second.points()) {
    json.begin_array().value(to_milliseconds_scaled(point.at)).value(rounded(point.charge_percent, 1000.0));
    json.value(rounded(point.voltage_v, 1000.0)).value(rounded(point.temperature_c, 10.0)).end_array();
  }
  json.end_array().end_object();
  return json.take();
}

void BatteryCurve::archive(Archive& archive) { archive(points_, every_); }

void BatteryTestRelay::archive(Archive& archive) { archive(changes_, test_, curves_); }

}  // namespace cosiva::virtual_side
