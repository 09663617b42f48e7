#include "cosiva/app/traffic/capacity.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "cosiva/app/cli/console.h"
#include "cosiva/base/json_value.h"
#include "cosiva/virtual/fleet/fleet.h"

namespace cosiva::app {
namespace {

using virtual_side::Fleet;
using virtual_side::FleetStart;

/// The number of vehicles in one copy of the zone, dense but without congestion.
constexpr std::size_t per_copy_max = 12;
constexpr std::size_t steps_min = 20;
constexpr std::size_t warm_up_steps = 50;

double ms_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

Result<Fleet> fleet_of(const std::shared_ptr<const zone::TrafficZone>& zone,
                       const std::shared_ptr<const aiv::AgentRules>& rules, std::uint64_t vehicles) {
  const std::vector<FleetStart> one = Fleet::spread(*zone, per_copy_max);
  if (one.empty()) return fail("capacity.zone", "no vehicle has room to start on zone '" + zone->name + "'");
  std::vector<FleetStart> all;
  all.reserve(vehicles);
  for (std::uint32_t copy = 0; all.size() < vehicles; ++copy)
    for (std::size_t i = 0; i < one.size() && all.size() < vehicles; ++i) {
      all.push_back(one[i]);
      all.back().copy = copy;
    }
  virtual_side::FleetOptions options;
  options.rules = rules;
  return Fleet::make(zone, options, all);
}

std::string thousands(std::uint64_t number) {
  std::string text = std::to_string(number);
  for (std::size_t at = text.size(); at > 3;) text.insert(at -= 3, 1, ' ');
  return text;
}

/// Rounds down to two significant digits, the precision of a measurement.
std::uint64_t rounded(double number) {
  const double power = std::pow(10.0, std::floor(std::log10(std::max(1.0, number))) - 1.0);
  return static_cast<std::uint64_t>(std::floor(number / power) * power);
}

std::string carried_text(const std::vector<StepMetrics>& steps, double speed) {
  const Carried carried = carried_at(steps, speed);
  if (!carried.sure) return "fewer than " + thousands(steps.front().vehicles);
  std::string text = thousands(*carried.sure) + " measured";
  if (carried.expected && *carried.expected > *carried.sure)
    text += ", about " + thousands(*carried.expected) + " expected";
  return text;
}

}  // namespace

Result<StepMetrics> measure_steps(const std::shared_ptr<const zone::TrafficZone>& zone,
                                  const std::shared_ptr<const aiv::AgentRules>& rules, std::uint64_t vehicles,
                                  double seconds) {
  auto fleet = fleet_of(zone, rules, vehicles);
  if (!fleet) return tl::unexpected(fleet.error());
  for (std::size_t i = 0; i < warm_up_steps; ++i) fleet->step();
  std::vector<double> times_ms;
  const auto start = std::chrono::steady_clock::now();
  while (times_ms.size() < steps_min || ms_since(start) < 1000.0 * seconds) {
    const auto step_start = std::chrono::steady_clock::now();
    fleet->step();
    times_ms.push_back(ms_since(step_start));
  }
  std::ranges::sort(times_ms);
  const auto at = [&](double ratio) {
    return times_ms[static_cast<std::size_t>(ratio * static_cast<double>(times_ms.size() - 1))];
  };
  return StepMetrics{fleet->size(), times_ms.size(), at(0.5), at(0.99),
                     static_cast<double>(fleet->bytes()) / static_cast<double>(fleet->size())};
}

Carried carried_at(const std::vector<StepMetrics>& measured, double speed) {
  const double limit_ms = 100.0 / speed;
  Carried carried;
  for (const StepMetrics& one : measured)
    if (one.p99_ms <= limit_ms) carried.sure = std::max(carried.sure.value_or(0), one.vehicles);
  if (!carried.sure) return carried;
  const StepMetrics& largest = *std::ranges::max_element(measured, {}, &StepMetrics::vehicles);
  carried.expected = rounded(static_cast<double>(largest.vehicles) * limit_ms / largest.p99_ms);
  return carried;
}

Result<LiveMetrics> live_metrics(std::uint32_t vehicles, std::string_view summary) {
  const auto json = JsonValue::parse(summary, std::size_t{1} << 22U);
  const JsonValue* bijection = json ? json->find("bijection") : nullptr;
  const JsonValue* age = bijection != nullptr ? bijection->find("age_ms") : nullptr;
  const JsonValue* divergence = bijection != nullptr ? bijection->find("divergence_m") : nullptr;
  if (age == nullptr || divergence == nullptr)
    return fail("capacity.live", "the platform with " + std::to_string(vehicles) + " vehicles gave no summary");
  return LiveMetrics{vehicles,
                     bijection->number("matched_ratio").value_or(0.0),
                     age->number("p50").value_or(0.0),
                     age->number("p99").value_or(0.0),
                     divergence->number("p99").value_or(0.0),
                     static_cast<std::uint64_t>(json->number("collisions").value_or(0.0))};
}

void write_json(JsonWriter& json, const CapacityMetrics& metrics) {
  json.begin_object().field("zone", metrics.zone).field("rules", metrics.rules).key("fleet").begin_array();
  for (const StepMetrics& one : metrics.steps) {
    json.begin_object().field("vehicles", one.vehicles).field("steps", one.steps).field("step_p50_ms", one.p50_ms);
    json.field("step_p99_ms", one.p99_ms).field("speed", one.speed());
    json.field("bytes_per_vehicle", one.bytes_per_vehicle).end_object();
  }
  json.end_array().key("carries").begin_object();
  for (const auto& [name, speed] : {std::pair{"at_1x", 1.0}, {"at_10x", 10.0}}) {
    const Carried carried = carried_at(metrics.steps, speed);
    json.key(name).begin_object();
    for (const auto& [key, value] : {std::pair{"measured", carried.sure}, {"expected", carried.expected}}) {
      json.key(key);
      if (value)
        json.value(*value);
      else
        json.null();
    }
    json.end_object();
  }
  json.end_object().key("live").begin_array();
  for (const LiveMetrics& one : metrics.live) {
    json.begin_object().field("vehicles", one.vehicles).field("matched_ratio", one.matched_ratio);
    json.field("age_p50_ms", one.age_p50_ms).field("age_p99_ms", one.age_p99_ms);
    json.field("divergence_p99_m", one.divergence_p99_m).field("collisions", one.collisions).end_object();
  }
  json.end_array().end_object();
}

std::string to_text(const CapacityMetrics& metrics) {
  std::string text = "A virtual fleet on copies of " + metrics.zone + ", rules " + metrics.rules +
                     ", one thread, steps of 0.1 s:\n"
                     "    vehicles   step p50 [ms]   step p99 [ms]   times real time   bytes per vehicle\n";
  const auto column = [](std::string cell, std::size_t width) {
    return std::string(width > cell.size() ? width - cell.size() : 1, ' ') + std::move(cell);
  };
  for (const StepMetrics& one : metrics.steps) {
    text += column(thousands(one.vehicles), 12) + column(decimals(one.p50_ms, 3), 16) +
            column(decimals(one.p99_ms, 3), 16) + column(decimals(one.speed(), 1), 18) +
            column(decimals(one.bytes_per_vehicle, 0), 20) + "\n";
  }
  text += "  capacity in real time: " + carried_text(metrics.steps, 1.0) +
          "\n  at ten times real time: " + carried_text(metrics.steps, 10.0) + "\n";
  if (metrics.live.empty()) return text;
  text +=
      "The whole platform over MQTT, a process for each vehicle:\n"
      "    vehicles   matched   age p50 [ms]   age p99 [ms]   divergence p99 [m]   collisions\n";
  for (const LiveMetrics& one : metrics.live) {
    text += column(std::to_string(one.vehicles), 12) + column(decimals(100.0 * one.matched_ratio, 1) + " %", 10) +
            column(decimals(one.age_p50_ms, 1), 15) + column(decimals(one.age_p99_ms, 1), 15) +
            column(decimals(one.divergence_p99_m, 4), 21) + column(std::to_string(one.collisions), 13) + "\n";
  }
  return text;
}

}  // namespace cosiva::app
