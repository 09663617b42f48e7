// The options of `cosiva vehicle` and its subcommands, with their help texts.
#include "cosiva/app/vehicle/command_line_vehicle.h"

#include "cosiva/app/vehicle/line_tracking_command.h"
#include "cosiva/app/vehicle/presence_command.h"
#include "cosiva/app/vehicle/vehicle_boards_command.h"
#include "cosiva/app/vehicle/vehicle_list_command.h"

namespace cosiva::app {
namespace {

constexpr const char* vehicle_examples =
    "Examples:\n"
    "  cosiva vehicle list                       each vehicle with its twin, and why one is absent\n"
    "  cosiva vehicle exclude AIV3               AIV3 gets no orders; its twin stays on the map, and an obstacle\n"
    "  cosiva vehicle include AIV3               AIV3 drives again\n"
    "  cosiva vehicle retire ACME/7              ACME/7 has been taken away: its twin leaves the map\n"
    "  cosiva vehicle self-test AIV3             tests all boards of AIV3 at standstill; the result: vehicle boards\n"
    "  cosiva vehicle boards AIV3                health, self-test and readings of AIV3's boards and their parts\n"
    "\n"
    "A twin is retired only while its vehicle is absent: it has signed off, its connection has ended, or it no longer\n"
    "reports. A vehicle that was retired arrives again with its next report.\n"
    "Exit status: 0 done; 2 the platform refused the command or cannot be reached.";

Command add(Command parent, const char* name, const char* what, VehicleArguments& arguments) {
  const Command command = parent.add_subcommand(name, what);
  command.add_option("vehicle", arguments.vehicles, "manufacturer/serial number, or a serial number that is unique")
      .value_name("NAME…")
      .required();
  return command;
}

void describe_line_tracking(Command command, LineTrackingArguments& line) {
  command.add_option("algorithm", line.algorithms, "centroid_pd, path_observer or threshold; without: all")
      .value_name("NAME…");
  command.add_option("--zone", line.zone, "traffic zone: a ready one's name or a file")
      .value_name("NAME|FILE")
      .show_default();
  command.add_option("--speed", line.speeds_mps, "speeds to compare at").value_name("M/S…").show_default();
  command.add_option("--distance", line.distance_m, "driven at each speed").value_name("M").show_default();
  command.add_option("--unevenness", line.unevenness_mm, "of the line: standard deviation")
      .value_name("MM")
      .in_range(0.0, 10.0)
      .show_default();
  command.add_option("--seed", line.seed, "of the line's unevenness").value_name("S").show_default();
  command.add_option("--out", line.out_file, "the offsets at the last speed as a chart").value_name("FILE.svg");
  command.add_flag("--json", line.json, "print the result as JSON");
  command.footer(
      "Example:\n"
      "  cosiva vehicle line-tracking --speed 0.2 0.4 0.6 --out offsets.svg\n"
      "A vehicle has one of them: cosiva up --line-tracking path_observer --line-tracking 2=threshold");
}

}  // namespace

VehicleCommands describe_vehicle(Command root, VehicleArguments& arguments) {
  VehicleCommands commands{};
  commands.vehicle =
      root.add_subcommand("vehicle", "List, exclude, include, retire and test vehicles of a running platform");
  commands.vehicle.at_most_one_subcommand();
  commands.vehicle.footer(vehicle_examples);
  commands.list = commands.vehicle.add_subcommand("list", "Each vehicle, its twin, and why one is absent");
  commands.exclude = add(commands.vehicle, "exclude", "Give vehicles no orders until they are included", arguments);
  commands.include = add(commands.vehicle, "include", "Give excluded vehicles orders again", arguments);
  commands.retire =
      add(commands.vehicle, "retire", "Remove the twins of vehicles that have been taken away", arguments);
  commands.self_test = add(commands.vehicle, "self-test", "Test all boards of vehicles at standstill", arguments);
  commands.boards = commands.vehicle.add_subcommand("boards", "Health, self-test and readings of the boards");
  commands.boards.add_option("vehicle", arguments.vehicles, "those of these vehicles; without: of all")
      .value_name("NAME…");
  commands.boards.add_flag("--json", arguments.json, "print the result as JSON");
  commands.line_tracking = commands.vehicle.add_subcommand(
      "line-tracking", "Compare the line-tracking algorithms of PILS on a zone's path, in virtual time");
  describe_line_tracking(commands.line_tracking, arguments.line);
  commands.list.add_flag("--json", arguments.json, "print the result as JSON");
  for (const Command command :
       {commands.list, commands.exclude, commands.include, commands.retire, commands.self_test, commands.boards})
    command.add_option("--url", arguments.url, "address of the platform's API").value_name("URL").show_default();
  return commands;
}

std::optional<int> run_vehicle_command(const VehicleCommands& commands, const VehicleArguments& arguments) {
  if (commands.list.chosen()) return run_vehicle_list(arguments);
  if (commands.exclude.chosen()) return run_presence_command(arguments, "exclude");
  if (commands.include.chosen()) return run_presence_command(arguments, "include");
  if (commands.retire.chosen()) return run_presence_command(arguments, "retire");
  if (commands.self_test.chosen()) return run_presence_command(arguments, "self-test");
  if (commands.line_tracking.chosen()) return run_line_tracking(arguments.line);
  if (commands.boards.chosen()) return run_vehicle_boards(arguments);
  return std::nullopt;
}

}  // namespace cosiva::app
