#include "cosiva/experiments/battery/record_json.h"

#include <array>
#include <utility>

namespace cosiva::experiments {
namespace {

/// A JSON number cannot hold nanoseconds exactly; they are written as strings.
std::string time_text(SimTime time) { return std::to_string(time.time_since_epoch().count()); }

std::optional<std::int64_t> whole(const std::string* text) {
  if (text == nullptr || text->empty() || text->size() > 19) return std::nullopt;
  std::int64_t value = 0;
  const bool is_negative = text->front() == '-';
  for (std::size_t i = is_negative ? 1 : 0; i < text->size(); ++i) {
    const char digit = (*text)[i];
    if (digit < '0' || digit > '9' || value > 900'000'000'000'000'000) return std::nullopt;
    value = 10 * value + (digit - '0');
  }
  return is_negative ? -value : value;
}

tl::unexpected<Error> bad(std::string what) { return fail("battery.state", std::move(what), "saved state"); }

using Number = std::pair<const char*, double BatteryRun::*>;
constexpr std::array<Number, 9> numbers{{{"autonomy_s", &BatteryRun::autonomy_s},
                                         {"paused_s", &BatteryRun::paused_s},
                                         {"charge_ah", &BatteryRun::charge_ah},
                                         {"energy_wh", &BatteryRun::energy_wh},
                                         {"distance_m", &BatteryRun::distance_m},
                                         {"charge_end", &BatteryRun::charge_end},
                                         {"charge_end_sd", &BatteryRun::charge_end_sd},
                                         {"voltage_end_v", &BatteryRun::voltage_end_v},
                                         {"temperature_end_c", &BatteryRun::temperature_end_c}}};

}  // namespace

void write_sample(JsonWriter& json, const BatterySample& sample) {
  json.begin_array().value(time_text(sample.at));
  for (const double value :
       {sample.charge, sample.charge_sd, sample.voltage_v, sample.current_a, sample.temperature_c, sample.distance_m})
    json.value(value);
  json.end_array();
}

Result<BatterySample> read_sample(const JsonValue& json) {
  const JsonValue::Array* row = json.array();
  if (row == nullptr || row->size() != 7) return bad("a sample is no list of seven");
  BatterySample sample;
  const auto at = whole((*row)[0].text());
  if (!at) return bad("a sample has no time");
  sample.at = SimTime{SimDuration{*at}};
  const std::array targets{&sample.charge,    &sample.charge_sd,     &sample.voltage_v,
                           &sample.current_a, &sample.temperature_c, &sample.distance_m};
  for (std::size_t i = 0; i < targets.size(); ++i) {
    const double* value = (*row)[i + 1].number();
    if (value == nullptr) return bad("a sample holds something else than numbers");
    *targets[i] = *value;
  }
  return sample;
}

void write_record(JsonWriter& json, const BatteryRun& run) {
  json.begin_object().field("run", run.run).field("vehicle", run.vehicle).field("battery", run.battery);
  json.field("id", run.tag.id).field("type", run.tag.type).field("cycles", run.tag.cycles);
  json.field("rest_s", run.tag.rest_s).field("temperature_c", run.tag.temperature_c).field("charge", run.tag.charge);
  json.field("started", time_text(run.started)).field("stop", to_string(run.stop));
  for (const auto& [name, member] : numbers) json.field(name, run.*member);
  json.key("curve").begin_array();
  for (const BatterySample& sample : run.curve) write_sample(json, sample);
  json.end_array().end_object();
}

Result<BatteryRun> read_record(const JsonValue& json) {
  BatteryRun run;
  bool good = true;
  const auto number = [&](std::string_view key) {
    const auto found = json.number(key);
    good = good && found;
    return found.value_or(0.0);
  };
  const auto index = [&](std::string_view key) {
    const double found = number(key);
    good = good && found >= 0.0 && found < 1e6;
    return good ? static_cast<std::size_t>(found) : 0;
  };
  run.run = index("run");
  run.vehicle = index("vehicle");
  run.battery = index("battery");
  run.tag = {json.text("id").value_or(""),
             json.text("type").value_or(""),
             number("cycles"),
             number("rest_s"),
             number("temperature_c"),
             number("charge")};
  const JsonValue* started = json.find("started");
  const auto at = whole(started == nullptr ? nullptr : started->text());
  const auto stop = parse_stop(json.text("stop").value_or(""));
  if (!at || !stop) return bad("a record has no start or stop");
  run.started = SimTime{SimDuration{*at}};
  run.stop = *stop;
  for (const auto& [name, member] : numbers) run.*member = number(name);
  const JsonValue* curve = json.find("curve");
  if (!good || curve == nullptr || curve->array() == nullptr) return bad("a record lacks a quantity");
  for (const JsonValue& item : *curve->array()) {
    auto sample = read_sample(item);
    if (!sample) return tl::unexpected(sample.error());
    run.curve.push_back(*sample);
  }
  return run;
}

}  // namespace cosiva::experiments
