// The options of `cosiva vehicle` and its subcommands, with their help texts.
#include "cosiva/app/vehicle/command_line_vehicle.h"

#include "cosiva/app/vehicle/presence_command.h"
#include "cosiva/app/vehicle/vehicle_list_command.h"

namespace cosiva::app {
namespace {

constexpr const char* vehicle_examples =
    "Examples:\n"
    "  cosiva vehicle list                       each vehicle with its twin, and why one is absent\n"
    "  cosiva vehicle exclude AIV3               AIV3 gets no orders; its twin stays on the map, and an obstacle\n"
    "  cosiva vehicle include AIV3               AIV3 drives again\n"
    "  cosiva vehicle retire ACME/7              ACME/7 has been taken away: its twin leaves the map\n"
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

}  // namespace

VehicleCommands describe_vehicle(Command root, VehicleArguments& arguments) {
  VehicleCommands commands{};
  commands.vehicle = root.add_subcommand("vehicle", "List, exclude, include and retire vehicles of a running platform");
  commands.vehicle.at_most_one_subcommand();
  commands.vehicle.footer(vehicle_examples);
  commands.list = commands.vehicle.add_subcommand("list", "Each vehicle, its twin, and why one is absent");
  commands.exclude = add(commands.vehicle, "exclude", "Give vehicles no orders until they are included", arguments);
  commands.include = add(commands.vehicle, "include", "Give excluded vehicles orders again", arguments);
  commands.retire =
      add(commands.vehicle, "retire", "Remove the twins of vehicles that have been taken away", arguments);
  commands.list.add_flag("--json", arguments.json, "print the result as JSON");
  for (const Command command : {commands.list, commands.exclude, commands.include, commands.retire})
    command.add_option("--url", arguments.url, "address of the platform's API").value_name("URL").show_default();
  return commands;
}

std::optional<int> run_vehicle_command(const VehicleCommands& commands, const VehicleArguments& arguments) {
  if (commands.list.chosen()) return run_vehicle_list(arguments);
  if (commands.exclude.chosen()) return run_presence_command(arguments, "exclude");
  if (commands.include.chosen()) return run_presence_command(arguments, "include");
  if (commands.retire.chosen()) return run_presence_command(arguments, "retire");
  return std::nullopt;
}

}  // namespace cosiva::app
