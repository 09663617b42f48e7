// The options of `cosiva simulate`, with their help texts.
#include "cosiva/app/simulate/command_line_simulate.h"

#include <string>

#include "cosiva/app/simulate/simulate_command.h"
#include "cosiva/experiments/faults/planted.h"

namespace cosiva::app {
namespace {

constexpr const char* footer =
    "Each seed gives a schedule of faults: loss, duplication, reordering and delay (F1), partitions (F2), crashes of\n"
    "processes and of the plant (F3), the broker's death (F4), power cuts and refusals of the disk (F5), inverted "
    "bits\n"
    "(F6), clocks (F7), floods (F10), contradicting operators (F13), and persons in the paths of vehicles. After "
    "every\n"
    "step the invariants are checked: I1 the state follows from the store, I2 accepted commands survive and take "
    "effect\n"
    "once, I3 received and missing messages are all that were sent, I4 one vehicle one twin, I5 no command before its\n"
    "record, I6 a Stop outranks everything, I7 no twin is shown as newer than its last report, I9 bounded queues, and\n"
    "that no vehicle touches a person or another vehicle (safety). Then the faults end, and within 2 s all twins must\n"
    "be fresh and afterwards all vehicles drive (I10).\n"
    "\n"
    "With --handovers two servers control the areas a and b of one floor, with a store each, and operators send the\n"
    "vehicles from one area to the other while both servers suffer these faults. Checked are I1 and I9 of both "
    "stores,\n"
    "I4 (no server commands a vehicle that is not its own, and no two servers command one vehicle) and safety; after\n"
    "the faults every vehicle must be in exactly one table within 10 s, and each be handed over once more and drive "
    "on\n"
    "(I10).\n"
    "\n"
    "Examples:\n"
    "  cosiva simulate --seeds 1..200 --minutes 1              two hundred minutes in less than one\n"
    "  cosiva simulate --seeds 1..50 --minutes 1 --handovers   two control areas, with hand-overs between them\n"
    "  cosiva simulate --seeds 17 --minutes 1 --list           the faults of a seed, without running it\n"
    "  cosiva simulate --seeds 17 --minutes 1 --shrink         the fewest faults with which seed 17 still fails\n"
    "  cosiva simulate --seeds 17 --minutes 1 --faults 3,12    seed 17 with two of its faults only\n"
    "  cosiva simulate --seeds 1..200 --plant forgotten-stop   how soon a planted defect is found";

std::string planted_names() {
  std::string names;
  for (const experiments::Planted planted : experiments::all_planted)
    names += (names.empty() ? "" : ", ") + std::string(experiments::to_string(planted));
  return names;
}

}  // namespace

Command describe_simulate(Command root, SimulateArguments& arguments) {
  const Command command =
      root.add_subcommand("simulate", "The platform in virtual time under seeded faults, with its invariants checked");
  command.footer(footer);
  command.add_option("--seeds", arguments.seeds, "one seed, or the first and the last one")
      .value_name("A..B")
      .show_default();
  command.add_option("--minutes", arguments.minutes, "of virtual time with faults, for each seed")
      .value_name("M")
      .in_range(0.2, 10'000.0)
      .show_default();
  command.add_option("--zone", arguments.zone, "traffic zone: a ready one's name or a file")
      .value_name("NAME|FILE")
      .show_default();
  command
      .add_option("--other-zone", arguments.other_zone,
                  "operators also switch to this zone and back; without: no zone is switched")
      .value_name("NAME|FILE");
  command
      .add_flag("--handovers", arguments.handovers,
                "two control areas on one floor, each with a server, and vehicles that are sent from one to the other")
      .excludes(command.option("--zone"))
      .excludes(command.option("--other-zone"));
  command.add_option("--aivs", arguments.aivs, "how many vehicles").value_name("N").in_range(1, 200).show_default();
  command.add_option("--jobs", arguments.jobs, "seeds at a time; 0: one for each processor")
      .value_name("N")
      .show_default();
  command.add_option("--faults", arguments.faults, "inject only the faults with these numbers of the schedule")
      .value_name("N,N…")
      .separator(',');
  command.add_flag("--shrink", arguments.shrink, "remove the faults that a failed seed does not need to fail");
  command.add_flag("--list", arguments.list, "print the schedules without running them");
  command.add_option("--plant", arguments.plant, "a defect that the invariants should detect: " + planted_names())
      .value_name("NAME");
  command.add_flag("--json", arguments.json, "print one JSON object for each seed");
  return command;
}

std::optional<int> run_simulate_command(const Command& command, const SimulateArguments& arguments) {
  if (!command.chosen()) return std::nullopt;
  return run_simulate(arguments);
}

}  // namespace cosiva::app
