// The planner on the maps of two benchmarks, and its time against the size of fleet and floor. Vehicles do exactly what
// the plan states; a contact ends the program.
#include <cstdio>
#include <string>
#include <vector>

#include "cosiva/app/cli/options.h"
#include "planner_runs.h"

namespace {

using namespace cosiva;
using namespace cosiva::fixture;

struct Arguments {
  RunOptions run;
  std::string map;
  std::string tasks;
  std::string agents;
  std::string pick_ups;
  std::uint32_t vehicles = 50;
  std::uint32_t loads = 500;
  std::uint32_t per_step = 1;
  std::vector<std::uint32_t> fleets{12, 100, 1000};
  std::vector<std::uint32_t> sides{0};
  std::uint32_t expansions_per_vehicle = 50;
  std::uint32_t growth_steps = 200;
  bool no_cycles = false;
  bool json = false;
  std::uint64_t table_bytes = std::uint64_t{1} << 30U;
};

int refuse(const Error& error) {
  std::fprintf(stderr, "planner: %s\n", to_string(error).c_str());
  return 2;
}

Result<Grid> grid_of(const Arguments& arguments) {
  if (arguments.map.empty()) return draw_warehouse(37, 22);
  return read_map(arguments.map);
}

Result<DeliveryInstance> deliveries_of(const Arguments& arguments, const Grid& grid) {
  if (arguments.tasks.empty())
    return draw_deliveries(grid, arguments.vehicles, arguments.loads, arguments.per_step, arguments.run.seed);
  auto instance = read_pibt2(arguments.tasks, grid);
  if (!instance) return instance;
  if (!arguments.pick_ups.empty()) {
    auto squares = read_pick_ups(arguments.pick_ups, grid);
    if (!squares) return tl::unexpected{squares.error()};
    instance->pick_ups = *std::move(squares);
  }
  if (instance->pick_ups.empty()) instance->pick_ups = connected_squares(grid);
  return instance;
}

int deliveries(const Arguments& arguments) {
  const auto grid = grid_of(arguments);
  if (!grid) return refuse(grid.error());
  const auto instance = deliveries_of(arguments, *grid);
  if (!instance) return refuse(instance.error());
  const std::size_t loads = instance->deliveries.size();
  const auto summary = DeliveryRun{*grid, *instance, arguments.run}.run();
  if (arguments.json) {
    std::printf(
        "{\"vehicles\": %zu, \"loads\": %zu, \"delivered\": %zu, \"steps\": %u, \"service\": %.3f, "
        "\"pick_up\": %.3f, \"carrying\": %.3f, \"step_ms_mean\": %.3f, \"step_ms_p99\": %.3f}\n",
        instance->starts.size(), loads, summary.delivered, summary.steps, summary.service, summary.pick_up,
        summary.carrying, summary.step_ms.mean_ms(), summary.step_ms.percentile_ms(99.0));
  } else {
    std::printf("%zu vehicles, %zu of %zu loads delivered in %u steps\n", instance->starts.size(), summary.delivered,
                loads, summary.steps);
    std::printf("service %.2f steps: %.2f until the pick-up, the shortest path of the load %.2f\n", summary.service,
                summary.pick_up, summary.carrying);
    std::printf("a step: mean %.2f ms, p99 %.2f ms, of which dispatch and parking %.2f and %.2f ms\n",
                summary.step_ms.mean_ms(), summary.step_ms.percentile_ms(99.0), summary.dispatch_ms.mean_ms(),
                summary.dispatch_ms.percentile_ms(99.0));
  }
  return summary.delivered == loads ? 0 : 1;
}

int errands(const Arguments& arguments) {
  const auto grid = grid_of(arguments);
  if (!grid) return refuse(grid.error());
  Random random{arguments.run.seed, "errands"};
  std::vector<std::uint32_t> starts;
  std::vector<std::uint32_t> squares;
  if (arguments.agents.empty()) {
    const auto connected = connected_squares(*grid);
    starts = draw_starts(connected, arguments.vehicles, random);
    for (int i = 0; i < 10'000; ++i) squares.push_back(connected[random.below(connected.size())]);
  } else {
    auto agents = read_numbers(arguments.agents);
    if (!agents) return refuse(agents.error());
    auto tasks = read_numbers(arguments.tasks);
    if (!tasks) return refuse(tasks.error());
    starts = *std::move(agents);
    squares = *std::move(tasks);
  }
  for (const auto* list : {&starts, &squares})
    for (const std::uint32_t square : *list)
      if (square >= grid->free.size() || grid->free[square] == 0)
        return refuse(Error{"errands.square", "square " + std::to_string(square) + " is not free", arguments.map});
  const auto summary = run_errands(*grid, starts, squares, arguments.run);
  if (arguments.json)
    std::printf("{\"vehicles\": %zu, \"steps\": %u, \"errands\": %zu, \"step_ms_mean\": %.3f, \"step_ms_p99\": %.3f}\n",
                starts.size(), summary.steps, summary.errands, summary.step_ms.mean_ms(),
                summary.step_ms.percentile_ms(99.0));
  else
    std::printf("%zu vehicles, %u steps: %zu errands; %.0f expansions a step, mean %.2f ms, p99 %.2f ms\n",
                starts.size(), summary.steps, summary.errands, summary.expansions_per_step, summary.step_ms.mean_ms(),
                summary.step_ms.percentile_ms(99.0));
  return 0;
}

/// One row of the table: a fleet on a warehouse with a given side.
void grow(const Arguments& arguments, std::uint32_t fleet, std::uint32_t side, bool cycles) {
  const Grid grid = draw_warehouse(side, side);
  const auto connected = connected_squares(grid);
  Random random{arguments.run.seed, "growth"};
  const auto starts = draw_starts(connected, fleet, random);
  std::vector<std::uint32_t> squares;
  squares.reserve(50'021);
  // Goals are few, because the tables of their distances belong to the preparation of a layout.
  for (int i = 0; i < 64; ++i) squares.push_back(connected[random.below(connected.size())]);
  for (int i = 64; i < 50'021; ++i) squares.push_back(squares[random.below(64)]);
  RunOptions options = arguments.run;
  options.window.cycles = cycles;
  options.steps_max = arguments.growth_steps;
  options.expansions = std::uint64_t{arguments.expansions_per_vehicle} * fleet;
  const auto summary = run_errands(grid, starts, squares, options);
  std::printf("%8zu %8zu %7s %10.1f %10.3f %10.3f %12.3f\n", starts.size(), connected.size(), cycles ? "yes" : "no",
              summary.expansions_per_step, summary.step_ms.mean_ms(), summary.step_ms.percentile_ms(99.0),
              1e3 * static_cast<double>(summary.errands) / static_cast<double>(starts.size()) / summary.steps);
}

int growth(const Arguments& arguments) {
  std::printf("%8s %8s %7s %10s %10s %10s %12s\n", "vehicles", "squares", "cycles", "expansions", "mean ms", "p99 ms",
              "errands/1000");
  for (const std::uint32_t fleet : arguments.fleets) {
    for (const std::uint32_t given : arguments.sides) {
      // 0: a tenth of the free squares is occupied; 43 % of a large warehouse is free.
      std::uint32_t side = std::max(10U, given);
      while (given == 0 && side * side * 43 / 100 < 10 * fleet) ++side;
      for (const bool cycles : {false, true}) grow(arguments, fleet, side, cycles);
    }
  }
  return 0;
}

void add_planner_options(const app::Command& command, Arguments& arguments) {
  command.add_option("--window", arguments.run.window.horizon, "steps planned at once")
      .in_range(1U, 255U)
      .show_default();
  command.add_option("--group", arguments.run.window.group, "vehicles planned again together").show_default();
  command.add_option("--seed", arguments.run.seed).show_default();
}

void add_run_options(const app::Command& command, Arguments& arguments) {
  add_planner_options(command, arguments);
  command.add_option("--map", arguments.map, "MovingAI map; none: a warehouse of 37 x 22 squares");
  command.add_option("--vehicles", arguments.vehicles, "without file").show_default();
  command.add_option("--expansions", arguments.run.expansions, "nodes that the planner may examine per step")
      .show_default();
  command.add_option("--steps", arguments.run.steps_max, "ends after so many").show_default();
  command.add_flag("--no-cycles", arguments.no_cycles, "three and more vehicles may not move in a closed cycle");
  command.add_option("--table-bytes", arguments.table_bytes, "for tables of distances").show_default();
  command.add_flag("--json", arguments.json);
}

}  // namespace

int main(int argc, char** argv) {
  Arguments arguments;
  const app::CommandLine line{"Plans for fleets on grids"};
  const app::Command command = line.root();
  command.at_most_one_subcommand();
  const app::Command deliver = command.add_subcommand("deliveries", "pick-up and delivery, as Kei18/pibt2 runs it");
  const app::Command errand = command.add_subcommand("errands", "instances of the League of Robot Runners");
  const app::Command grown = command.add_subcommand("growth", "time per step on warehouses of different sizes");
  for (const auto& subcommand : {deliver, errand}) add_run_options(subcommand, arguments);
  deliver.add_option("--tasks", arguments.tasks, "result file of pibt2 with starts and tasks; none: drawn by the seed");
  deliver.add_option("--pick-ups", arguments.pick_ups,
                     "file .map.pd with squares where loads appear; none: all squares");
  deliver.add_option("--loads", arguments.loads, "without file").show_default();
  deliver.add_option("--per-step", arguments.per_step, "new loads in each step, 0: all at once").show_default();
  deliver.add_option("--exchanges", arguments.run.dispatch.exchanges_max, "attempts at better tours").show_default();
  const auto agents = errand.add_option("--agents", arguments.agents, "start squares");
  const auto tasks = errand.add_option("--tasks", arguments.tasks, "squares to visit, in turn");
  agents.needs(tasks);
  tasks.needs(agents);
  add_planner_options(grown, arguments);
  grown.add_option("--steps", arguments.growth_steps, "of each row").show_default();
  grown.add_option("--fleets", arguments.fleets, "numbers of vehicles").separator(',');
  grown.add_option("--sides", arguments.sides, "of the square floor; 0: ten free squares per vehicle").separator(',');
  grown.add_option("--expansions-per-vehicle", arguments.expansions_per_vehicle).show_default();
  if (const auto status = line.parse(argc, argv)) return *status;
  arguments.run.window.cycles = !arguments.no_cycles;
  arguments.run.table_bytes = arguments.table_bytes;
  if (deliver.chosen()) return deliveries(arguments);
  if (errand.chosen()) return errands(arguments);
  if (grown.chosen()) return growth(arguments);
  return command.refuse("one of deliveries, errands and growth is needed");
}
