// The options of `cosiva traffic` and `cosiva capacity`, with their help texts.
#include "cosiva/app/traffic/command_line_traffic.h"

#include "cosiva/app/cli/common_options.h"

namespace cosiva::app {
namespace {

constexpr const char* examples =
    "Examples:\n"
    "  cosiva traffic --zone lacet4 --aivs 12                       an hour of laps, in a moment\n"
    "  cosiva traffic --zone indus8 --aivs 8 --jobs-per-hour 120    random transport jobs between its stations\n"
    "  cosiva traffic --zone my.lif.json --jobs monday.csv --out monday   your own jobs, with a report\n"
    "  cosiva traffic --zones lacet4,indus8 --jobs-per-hour 60      two control areas, and loads that are carried from "
    "one to the other\n"
    "  mpirun -n 4 cosiva traffic --zones 64*plant1000              many control areas on many cores or machines\n"
    "\n"
    "A job file's first line names its columns: time_s,from,to and, if wanted, priority. docs/guide/traffic.md "
    "explains more.";

constexpr const char* capacity_examples =
    "Examples:\n"
    "  cosiva capacity                                  a minute or two; a table that can be reproduced\n"
    "  cosiva capacity --live 10,50,100 --live-zone plant1000 --out this_machine.json";

}  // namespace

Command describe_capacity(Command root, CapacityArguments& capacity) {
  const Command command = root.add_subcommand(
      "capacity", "Measure how many vehicles this machine can run: a virtual fleet, and the whole platform over MQTT");
  command.footer(capacity_examples);
  command
      .add_option("--zone", capacity.zone,
                  "zone whose copies the virtual fleet drives on: a ready zone's name or a file")
      .value_name("NAME|FILE")
      .show_default();
  add_rules(command, capacity.rules, "how AIVs choose their speed (docs/guide/agents.md)");
  command.add_option("--max", capacity.vehicles_max, "largest virtual fleet; the size grows tenfold from 100")
      .value_name("N")
      .in_range(100, 100'000'000)
      .show_default();
  command.add_option("--seconds", capacity.seconds, "measuring time for each size")
      .value_name("S")
      .in_range(0.05, 3600.0)
      .show_default();
  command
      .add_option("--live", capacity.live,
                  "numbers of vehicles for the whole platform over MQTT; 0: skip this measurement")
      .value_name("N,N")
      .separator(',')
      .in_range(0, 200)
      .show_default();
  command.add_option("--live-zone", capacity.live_zone, "zone of the --live vehicles: a ready zone's name or a file")
      .value_name("NAME|FILE")
      .show_default();
  command.add_option("--live-seconds", capacity.live_s, "driving time for each number")
      .value_name("S")
      .in_range(1.0, 3600.0)
      .show_default();
  command.add_option("--out", capacity.out_file, "also write the table as JSON").value_name("FILE");
  command.add_flag("--json", capacity.json, "print the table as JSON");
  return command;
}

Command describe_traffic(Command root, FleetTrafficArguments& traffic) {
  const Command command = root.add_subcommand(
      "traffic",
      "Measure the throughput of a virtual fleet on a zone, much faster than real time: jobs, waits, a heat map");
  command.footer(examples);
  const Option zone = command.add_option("--zone", traffic.zone, "traffic zone: a ready one's name or a file")
                          .value_name("NAME|FILE")
                          .show_default();
  command
      .add_option("--zones", traffic.zones,
                  "several zones with transfer points between them: a TOML file, or names such as 4*lacet4,indus8")
      .value_name("FILE|LIST")
      .excludes(zone);
  command.add_option("--away", traffic.away_ratio, "with --zones: ratio of jobs that lead into a neighbouring zone")
      .value_name("RATIO")
      .in_range(0.0, 1.0)
      .show_default();
  command
      .add_option("--transfer-time", traffic.transfer_s, "with --zones and a list: seconds from one zone to the next")
      .value_name("S")
      .in_range(0.2, 1e5)
      .show_default();
  command.add_option("--threads", traffic.threads, "number of threads; the result does not depend on it")
      .value_name("N")
      .in_range(1, 1024)
      .show_default();
  command.add_option("--sidecar", traffic.sidecar, "what the zone's format cannot express, if not next to the file")
      .value_name("FILE");
  command.add_option("--aivs", traffic.aivs, "how many vehicles")
      .value_name("N")
      .in_range(1, 10'000'000)
      .show_default();
  command.add_option("--duration", traffic.duration_s, "measured virtual seconds")
      .value_name("S")
      .in_range(1.0, 1e8)
      .show_default();
  command
      .add_option("--warm-up", traffic.warm_up_s, "virtual seconds before the measurement, not included in the metrics")
      .value_name("S")
      .in_range(0.0, 1e8)
      .show_default();
  command.add_option("--seed", traffic.seed, "fixes every random draw").value_name("S").show_default();
  const Option rate =
      command.add_option("--jobs-per-hour", traffic.jobs_per_hour, "random transport jobs, average number per hour")
          .value_name("N");
  command.add_option("--jobs", traffic.jobs_file, "transport jobs from a CSV file; '-' reads standard input")
      .value_name("FILE")
      .excludes(rate);
  command.add_option("--handling", traffic.handling_s, "seconds to load, and to unload")
      .value_name("S")
      .in_range(0.0, 1e6)
      .show_default();
  add_rules(command, traffic.rules, "how AIVs choose their speed (docs/guide/agents.md)");
  command.add_option("--step", traffic.step_s, "seconds of one step")
      .value_name("S")
      .in_range(0.01, 0.2)
      .show_default();
  command.add_option("--out", traffic.out_directory, "write report.html, result.json and jobs.csv there")
      .value_name("DIR");
  command.add_flag("--json", traffic.json, "print the result as JSON");
  return command;
}

}  // namespace cosiva::app
