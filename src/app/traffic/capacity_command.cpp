#include "cosiva/app/traffic/capacity_command.h"

#include <memory>
#include <utility>

#include "cosiva/adapters/child_process.h"
#include "cosiva/adapters/event_loop.h"
#include "cosiva/adapters/files.h"
#include "cosiva/app/cli/console.h"
#include "cosiva/app/resources/resource_paths.h"
#include "cosiva/app/resources/rule_files.h"
#include "cosiva/app/resources/zone_files.h"
#include "cosiva/app/traffic/capacity.h"

namespace cosiva::app {
namespace {

/// A size with a step longer than this is the last.
constexpr double step_ms_max = 150.0;

/// The whole platform as a separate process, started as a user starts it.
Result<LiveMetrics> measure_live(const CapacityArguments& arguments, std::uint32_t vehicles) {
  adapters::EventLoop loop;
  std::string summary;
  bool ended = false;
  adapters::ChildOptions options;
  options.argv = {own_executable(), "up",
                  "--headless",     "--json",
                  "--zone",         arguments.live_zone,
                  "--aivs",         std::to_string(vehicles),
                  "--duration",     decimals(arguments.live_s, 1),
                  "--port",         "0"};
  options.log_file = "/dev/null";
  options.on_line = [&](const std::string& line) {
    if (line.starts_with("{")) summary = line;
  };
  options.on_exit = [&](const adapters::ChildExit&) { ended = true; };
  auto child = adapters::Child::start(loop, std::move(options));
  if (!child) return tl::unexpected(child.error());
  const auto timeout = std::chrono::milliseconds{static_cast<std::int64_t>(1000.0 * arguments.live_s) + 60'000};
  if (!loop.run_until([&] { return ended; }, timeout))
    return fail("capacity.live", "the platform with " + std::to_string(vehicles) + " vehicles did not end in time");
  return live_metrics(vehicles, summary);
}

Result<CapacityMetrics> measure(const CapacityArguments& arguments) {
  const auto rtm = open_zone(arguments.zone);
  if (!rtm) return tl::unexpected(rtm.error());
  const auto rules = load_fleet_rules(arguments.rules);
  if (!rules) return tl::unexpected(rules.error());
  CapacityMetrics metrics{rtm->zone().name, arguments.rules, {}, {}};
  for (std::uint64_t vehicles = 100; vehicles <= arguments.vehicles_max; vehicles *= 10) {
    print_info("measuring a fleet of " + std::to_string(vehicles));
    auto one = measure_steps(rtm->shared_zone(), *rules, vehicles, arguments.seconds);
    if (!one) return tl::unexpected(one.error());
    metrics.steps.push_back(*one);
    if (one->p50_ms > step_ms_max) break;
  }
  for (const std::uint32_t vehicles : arguments.live) {
    if (vehicles == 0) continue;
    print_info("measuring the platform with " + std::to_string(vehicles) + " vehicles over MQTT");
    auto one = measure_live(arguments, vehicles);
    if (!one) return tl::unexpected(one.error());
    metrics.live.push_back(*one);
  }
  return metrics;
}

}  // namespace

int run_capacity(const CapacityArguments& arguments) {
  const auto metrics = measure(arguments);
  if (!metrics) return report_error(metrics.error());
  JsonWriter json;
  write_json(json, *metrics);
  if (!arguments.out_file.empty())
    if (auto written = adapters::write_file(arguments.out_file, json.text() + "\n"); !written)
      return report_error(written.error());
  if (arguments.json) {
    print(json.take());
    return exit_done;
  }
  std::string text = to_text(*metrics);
  text.pop_back();
  print(text);
  return exit_done;
}

}  // namespace cosiva::app
