#include "cosiva/app/battery/battery_test_command.h"

#include <chrono>
#include <filesystem>
#include <string>
#include <utility>

#include "cosiva/adapters/files.h"
#include "cosiva/app/battery/battery_live.h"
#include "cosiva/app/battery/battery_text.h"
#include "cosiva/app/cli/console.h"
#include "cosiva/app/cli/progress.h"
#include "cosiva/app/resources/battery_types.h"
#include "cosiva/app/resources/rule_files.h"
#include "cosiva/app/resources/zone_files.h"
#include "cosiva/experiments/battery/analysis.h"
#include "cosiva/experiments/battery/autonomy_output.h"
#include "cosiva/experiments/battery/autonomy_report.h"
#include "cosiva/experiments/battery/load_profile.h"
#include "cosiva/experiments/battery/platform_rig.h"
#include "cosiva/experiments/battery/virtual_rig.h"

namespace cosiva::app {
namespace {

using experiments::VirtualRig;
using experiments::VirtualRigOptions;

/// The rate of the live platform's vehicles and server; boards and motion have rates of their own.
constexpr double live_hz = 50.0;

/// Prints operator messages at once, and the progress with its expected end once per second of real time.
class Teller {
 public:
  /// @return  whether a second has passed
  template <typename Rig>
  bool poll(Rig& rig) {
    for (const std::string& text : rig.take_messages()) print_info(text);
    if (!ticker_.ticks()) return false;
    print_info(progress_text(rig.procedure(), rig.now()));
    return true;
  }

 private:
  SecondsTicker ticker_;
};

Result<VirtualRigOptions> rig_options(const BatteryTestArguments& arguments, std::size_t vehicles) {
  VirtualRigOptions options;
  auto type = load_battery_type(arguments.type);
  if (!type) return tl::unexpected(type.error());
  const auto floor = ratio_of_percent(arguments.floor_percent, "--floor");
  if (!floor) return tl::unexpected(floor.error());
  if (*floor >= 0.97) return fail("battery.floor", "leave something to discharge", "--floor");
  const auto gauge = battery::parse_method(arguments.gauge);
  if (!gauge) return fail("battery.gauge", "expected counter, rest or kalman", "--gauge");
  // The carts' own battery is two of these in series, with a larger capacity: the default where no type is named.
  const bool usual =
      arguments.type == "lipo850" && arguments.series == 0 && arguments.parallel == 0 && arguments.scale == 0.0;
  options.battery.design =
      usual ? battery::PackDesign{2, 1, 2.2 / 0.85}
            : battery::PackDesign{
                  arguments.series > 0 ? arguments.series : static_cast<std::uint32_t>(type->series_cells),
                  arguments.parallel > 0 ? arguments.parallel : static_cast<std::uint32_t>(type->parallel_cells),
                  arguments.scale > 0.0 ? arguments.scale : 1.0};
  options.battery.type = std::move(*type);
  options.battery.gauge = *gauge;
  options.battery.ambient_c = arguments.ambient_c;
  options.procedure.vehicles = vehicles;
  options.procedure.runs = arguments.repeat;
  options.procedure.swap = arguments.swap;
  options.procedure.floor = *floor;
  options.procedure.temperature_min_c = options.battery.type.temperature_min_c;
  options.procedure.temperature_max_c = options.battery.type.temperature_max_c;
  options.procedure.pause_every = from_seconds(arguments.pause_every_s);
  options.procedure.pause_for = from_seconds(arguments.pause_s);
  options.seed = arguments.seed;
  options.load_sd = 0.01 * arguments.load_sd_percent;
  options.failures_per_hour = arguments.failures_per_hour;
  if (options.battery.ambient_c < options.procedure.temperature_min_c + 2.0 ||
      options.battery.ambient_c > options.procedure.temperature_max_c - 2.0)
    return fail("battery.temperature",
                "the procedure would refuse every battery: this type may be discharged from " +
                    decimals(options.procedure.temperature_min_c, 0) + " to " +
                    decimals(options.procedure.temperature_max_c, 0) + " °C",
                "--ambient");
  return options;
}

Result<experiments::WorldOptions> world_options(const BatteryTestArguments& arguments, std::size_t vehicles) {
  experiments::WorldOptions world;
  auto zone = load_zone(arguments.zone);
  if (!zone) return tl::unexpected(zone.error());
  world.zone = std::move(*zone);
  world.aivs = static_cast<std::uint32_t>(vehicles);
  world.seed = arguments.seed;
  if (!arguments.rules.empty()) {
    auto rules = load_speed_rules(arguments.rules);
    if (!rules) return tl::unexpected(rules.error());
    world.rules = std::move(*rules);
  }
  return world;
}

/// Prints and writes the results of a finished test of any kind.
struct Outcome {
  std::vector<experiments::BatteryRun> records;
  std::vector<experiments::TrueEnd> ground_truth;
  std::string load;
};

std::string again(const BatteryTestArguments& arguments, const std::string& command) {
  std::string text = "cosiva battery " + command + " --zone " + arguments.zone + " --type " + arguments.type +
                     " --floor " + decimals(arguments.floor_percent, 1) + " --repeat " +
                     std::to_string(arguments.repeat) + " --gauge " + arguments.gauge + " --ambient " +
                     decimals(arguments.ambient_c, 1) + " --load-spread " + decimals(arguments.load_sd_percent, 2) +
                     " --measure " + decimals(arguments.measure_s, 0) + " --seed " + std::to_string(arguments.seed);
  if (command == "fleet") text += " --aivs " + std::to_string(arguments.aivs) + (arguments.swap ? " --swap" : "");
  if (arguments.half_width_percent > 0.0) text += " --half-width " + decimals(arguments.half_width_percent, 3);
  if (arguments.series > 0) text += " --series " + std::to_string(arguments.series);
  if (arguments.parallel > 0) text += " --parallel " + std::to_string(arguments.parallel);
  if (arguments.scale > 0.0) text += " --scale " + decimals(arguments.scale, 6);
  if (arguments.pause_every_s > 0.0)
    text += " --pause-every " + decimals(arguments.pause_every_s, 1) + " --pause " + decimals(arguments.pause_s, 1);
  if (arguments.failures_per_hour > 0.0) text += " --failures " + decimals(arguments.failures_per_hour, 3);
  if (!arguments.rules.empty()) text += " --rules " + arguments.rules;
  if (arguments.whole) text += " --whole --hz " + decimals(arguments.hz.value_or(live_hz), 1);
  if (arguments.live) text += " --live --url " + arguments.url + (arguments.by_hand ? " --by-hand" : "");
  return text;
}

Result<void> write_report(const BatteryTestArguments& arguments, const std::string& command, const Outcome& outcome,
                          const VirtualRigOptions& options, const experiments::AutonomyMetrics& metrics,
                          const std::string& json) {
  const battery::PackDesign& design = options.battery.design;
  const experiments::ReportMetadata metadata{options.battery.type.name + ", " + std::to_string(design.series) + " × " +
                                                 std::to_string(design.parallel) + " cells of " +
                                                 decimals(options.battery.type.capacity_ah * design.scale, 2) + " Ah",
                                             options.battery.type.source,
                                             options.battery.type.licence,
                                             again(arguments, command),
                                             outcome.load,
                                             options.procedure.floor};
  return adapters::write_files(
      arguments.out_directory,
      {{"result.json", json},
       {"curves.csv", experiments::to_csv(outcome.records)},
       {"report.html", experiments::report_html(metrics, outcome.records, outcome.ground_truth, metadata)}});
}

/// Runs a test with the whole platform in the loop to the end.
Result<Outcome> run_whole(const BatteryTestArguments& arguments, experiments::WorldOptions world,
                          const VirtualRigOptions& options) {
  if (!arguments.state_file.empty())
    return fail("battery.state", "a whole platform's state is not saved; leave --whole or --state out", "--state");
  if (arguments.failures_per_hour > 0.0)
    return fail("battery.failures", "goes with measured loads only; leave --whole or --failures out", "--failures");
  const double hz = arguments.hz.value_or(live_hz);
  if (hz < live_hz) world.cycle = from_seconds(1.0 / hz);
  auto rig = experiments::PlatformRig::make(std::move(world), options);
  if (!rig) return tl::unexpected(rig.error());
  Teller teller;
  while (!rig->done()) {
    rig->step();
    teller.poll(*rig);
  }
  return Outcome{
      rig->procedure().records(), rig->ground_truth(),
      "AIVs driving on " + arguments.zone + ", the whole platform in the loop at " + decimals(hz, 0) + " Hz"};
}

/// Runs a test under the load that was measured on the whole platform.
Result<Outcome> run_measured(const BatteryTestArguments& arguments, experiments::WorldOptions world,
                             const VirtualRigOptions& options) {
  print_info("the whole platform drives for " + decimals(arguments.measure_s, 0) +
             " s, to measure the load of the vehicles");
  auto loads =
      experiments::measure_loads(std::move(world), std::chrono::seconds{10}, from_seconds(arguments.measure_s));
  if (!loads) return tl::unexpected(loads.error());
  double mean_w = 0.0;
  for (const auto& load : *loads) mean_w += load.mean_w() / static_cast<double>(loads->size());
  VirtualRig rig{options, std::move(*loads)};
  const std::string& file = arguments.state_file;
  if (!file.empty() && std::filesystem::exists(file)) {
    auto saved = adapters::read_file(file);
    if (!saved) return tl::unexpected(saved.error());
    if (auto done = rig.restore(*saved); !done) return fail(done.error().code, done.error().message, file);
    print_info("continues from " + file);
  }
  Teller teller;
  while (!rig.done()) {
    rig.step();
    const bool second = teller.poll(rig);
    if (file.empty() || !(second || rig.done())) continue;
    if (auto kept = adapters::write_file(file, rig.state_json()); !kept) return tl::unexpected(kept.error());
  }
  return Outcome{rig.procedure().records(), rig.ground_truth(),
                 "what AIVs on " + arguments.zone + " took in " + decimals(arguments.measure_s, 0) +
                     " s of the whole platform, " + decimals(mean_w, 2) + " W on average, again and again"};
}

/// Runs a test with vehicles of a running platform, over its broker.
Result<Outcome> run_on_platform(const BatteryTestArguments& arguments, const VirtualRigOptions& options) {
  if (arguments.hz) return fail("battery.live", "a running platform has its own rate; leave --hz out", "--hz");
  if (arguments.whole || arguments.failures_per_hour > 0.0)
    return fail("battery.live",
                "a running platform is whole and has its own failures; leave --whole and --failures out", "--live");
  experiments::LiveRigOptions live;
  live.procedure = options.procedure;
  live.procedure.lost_after = from_seconds(arguments.lost_after_s);
  live.procedure.curve_every = std::chrono::seconds{5};
  live.seed = options.seed;
  live.park = arguments.park;
  if (!arguments.by_hand) live.emulated = options.battery;
  const std::size_t vehicles = options.procedure.vehicles;
  for (std::size_t v = 0; v < vehicles && arguments.vehicles.empty(); ++v)
    live.vehicles.push_back({std::string(wire::our_manufacturer), "AIV" + std::to_string(v + 1)});
  for (const std::string& name : arguments.vehicles) {
    const std::size_t slash = name.find('/');
    if (slash == std::string::npos || slash == 0 || !wire::valid_serial_number(name.substr(slash + 1)))
      return fail("battery.vehicle", "'" + name + "' is not MANUFACTURER/SERIAL", "--vehicle");
    live.vehicles.push_back({name.substr(0, slash), name.substr(slash + 1)});
  }
  live.batteries = arguments.batteries;
  for (std::size_t b = 0; b < vehicles && arguments.batteries.empty(); ++b)
    live.batteries.push_back(options.battery.type.name + "-" + std::to_string(b + 1));
  if (live.vehicles.size() != vehicles || live.batteries.size() != vehicles)
    return fail("battery.vehicles",
                "as many --vehicle and --battery as vehicles are wanted: " + std::to_string(vehicles), "--aivs");
  const std::vector<wire::VehicleId> called = live.vehicles;
  auto records = run_live(arguments, std::move(live));
  if (!records) return tl::unexpected(records.error());
  for (experiments::BatteryRun& record : *records) {
    const wire::VehicleId& vehicle = called[record.vehicle];
    record.carrier =
        (vehicle.manufacturer == wire::our_manufacturer ? "" : vehicle.manufacturer + "/") + vehicle.serial_number;
  }
  return Outcome{std::move(*records), {}, "vehicles driving on the platform at " + arguments.url};
}

Result<Outcome> run_somehow(const BatteryTestArguments& arguments, const VirtualRigOptions& options,
                            std::size_t vehicles) {
  if (arguments.live) return run_on_platform(arguments, options);
  auto world = world_options(arguments, vehicles);
  if (!world) return tl::unexpected(world.error());
  if (arguments.hz && !arguments.whole)
    return fail("battery.hz", "is the rate of the whole platform in the loop; add --whole or leave --hz out", "--hz");
  return arguments.whole ? run_whole(arguments, std::move(*world), options)
                         : run_measured(arguments, std::move(*world), options);
}

int run_test(const BatteryTestArguments& arguments, const std::string& command, std::size_t vehicles) {
  auto options = rig_options(arguments, vehicles);
  if (!options) return report_error(options.error());
  const double half_width = 0.01 * arguments.half_width_percent;
  if (half_width > 0.0)
    options->procedure.enough = [=](const std::vector<experiments::BatteryRun>& records) {
      return experiments::analyse(records, vehicles, half_width).stopped_after.has_value();
    };
  const auto outcome = run_somehow(arguments, *options, vehicles);
  if (!outcome) return report_error(outcome.error());

  const auto metrics = experiments::analyse(outcome->records, vehicles, half_width, arguments.seed);
  const std::string json = experiments::to_json(metrics, outcome->records, outcome->ground_truth);
  if (!arguments.out_directory.empty()) {
    if (auto written = write_report(arguments, command, *outcome, *options, metrics, json); !written)
      return report_error(written.error());
    print_info("written to " + arguments.out_directory + ": report.html, result.json, curves.csv");
  }
  std::string text = experiments::to_text(metrics, outcome->records);
  if (half_width > 0.0) text += "\n" + stop_text(metrics.stopped_after, arguments.half_width_percent);
  if (half_width > 0.0 && metrics.stopped_after && metrics.runs < arguments.repeat)
    text += ", nor more runs than the " + std::to_string(metrics.runs) + " of " + std::to_string(arguments.repeat) +
            " that were made";
  // With a floor by charge counting alone, all batteries of a type have equal results: worth a message.
  if (options->battery.gauge != battery::GaugeMethod::kalman && options->procedure.floor > 0.0)
    print_info(
        "note: a gauge that only counts assumes the type's capacity for every battery; --gauge kalman or --floor 0 "
        "distinguishes them");
  print(arguments.json ? json : text);
  return exit_done;
}

}  // namespace

namespace {

BatteryTestArguments on_zone(const std::string& usual, BatteryTestArguments arguments) {
  if (arguments.zone.empty()) arguments.zone = usual;
  return arguments;
}

}  // namespace

int run_battery_sampled(const BatteryTestArguments& arguments) {
  return run_test(on_zone("lacet4", arguments), "sampled", 1);
}

// A38: one circuit, one direction, and vehicles that never cross.
int run_battery_fleet(const BatteryTestArguments& arguments) {
  return run_test(on_zone("oval", arguments), "fleet", arguments.aivs);
}

}  // namespace cosiva::app
