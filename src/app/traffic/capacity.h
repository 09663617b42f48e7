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

/// Measures how many vehicles this machine can run.
namespace cosiva::app {

/// The virtual fleet of one size, stepped for a short time.
struct StepMetrics {
  std::uint64_t vehicles{};
  std::uint64_t steps{};
  double p50_ms{};  ///< of a step of 0.1 s
  double p99_ms{};
  double bytes_per_vehicle{};  ///< in the engine
  /// Virtual seconds per second, from the median step.
  [[nodiscard]] double speed() const { return 100.0 / p50_ms; }
};
/// @param zone  copied as often as the vehicles need
[[nodiscard]] Result<StepMetrics> measure_steps(const std::shared_ptr<const zone::TrafficZone>& zone,
                                                const std::shared_ptr<const aiv::AgentRules>& rules,
                                                std::uint64_t vehicles, double seconds);

/// The capacity at a speed, from the measured sizes: `sure` is the largest size whose p99 step took no longer than 0.1
/// s / `speed`; `expected` is extrapolated from the time per vehicle of the largest measured size. Nothing where even
/// the smallest size is too slow.
struct Carried {
  std::optional<std::uint64_t> sure;
  std::optional<std::uint64_t> expected;
};
[[nodiscard]] Carried carried_at(const std::vector<StepMetrics>& measured, double speed);

/// The whole platform on this machine with this number of vehicles over MQTT.
struct LiveMetrics {
  std::uint32_t vehicles{};
  double matched_ratio{};
  double age_p50_ms{};
  double age_p99_ms{};
  double divergence_p99_m{};
  std::uint64_t collisions{};
};
/// Reads the output of `cosiva up --json`. Fails ("capacity.live") where the text is no such summary.
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
