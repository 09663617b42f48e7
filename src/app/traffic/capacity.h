#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cosiva/aiv/decision/agent_rules.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/base/result.h"
#include "cosiva/zone/layout/traffic_zone.h"

/// How many vehicles this machine carries, by measuring it.
namespace cosiva::app {

/// The virtual fleet of one size, stepped for a while.
struct StepMetrics {
  std::uint64_t vehicles{};
  std::uint64_t steps{};
  double p50_ms{};  ///< of a step of 0.1 s
  double p99_ms{};
  double bytes_per_vehicle{};  ///< in the engine
  /// Virtual seconds per second, by the median step.
  [[nodiscard]] double speed() const { return 100.0 / p50_ms; }
};
/// @param zone  as many copies of it as the vehicles need
[[nodiscard]] Result<StepMetrics> measure_steps(const std::shared_ptr<const zone::TrafficZone>& zone,
                                                const std::shared_ptr<const aiv::AgentRules>& rules,
                                                std::uint64_t vehicles, double seconds);

/// Of the sizes measured, what is sure at a speed: the largest whose p99 step took no longer than 0.1 s / `speed`; and
/// what the largest measured one's time per vehicle lets expect. Nothing: not even the smallest.
struct Carried {
  std::optional<std::uint64_t> sure;
  std::optional<std::uint64_t> expected;
};
[[nodiscard]] Carried carried_at(const std::vector<StepMetrics>& measured, double speed);

/// The whole platform on this machine with so many vehicles over MQTT.
struct LiveMetrics {
  std::uint32_t vehicles{};
  double matched_ratio{};
  double age_p50_ms{};
  double age_p99_ms{};
  double divergence_p99_m{};
  std::uint64_t collisions{};
};
/// From what `cosiva up --json` printed. Fails ("capacity.live") where that is no such summary.
[[nodiscard]] Result<LiveMetrics> live_metrics(std::uint32_t vehicles, std::string_view summary);

struct CapacityMetrics {
  std::string zone;
  std::string rules;
  std::vector<StepMetrics> steps;
  std::vector<LiveMetrics> live;
};
void write_json(JsonWriter& json, const CapacityMetrics& metrics);
[[nodiscard]] std::string to_text(const CapacityMetrics& metrics);

}  // namespace cosiva::app
