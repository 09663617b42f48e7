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

CLI::App* describe_capacity(CLI::App& root, CapacityArguments& capacity) {
  CLI::App* command = root.add_subcommand(
      "capacity", "Measure how many vehicles this machine can run: a virtual fleet, and the whole platform over MQTT");
  command->footer(capacity_examples);
  command
      ->add_option("--zone", capacity.zone,
                   "zone whose copies the virtual fleet drives on: a ready zone's name or a file")
      ->type_name("NAME|FILE")
      ->capture_default_str();
  add_rules(*command, capacity.rules, "how AIVs choose their speed (docs/guide/agents.md)");
  command->add_option("--max", capacity.vehicles_max, "largest virtual fleet; the size grows tenfold from 100")
      ->type_name("N")
      ->check(CLI::Range(100, 100'000'000))
      ->capture_default_str();
  command->add_option("--seconds", capacity.seconds, "measuring time for each size")
      ->type_name("S")
      ->check(CLI::Range(0.05, 3600.0))
      ->capture_default_str();
  command
      ->add_option("--live", capacity.live,
                   "numbers of vehicles for the whole platform over MQTT; 0: skip this measurement")
      ->type_name("N,N")
      ->delimiter(',')
      ->check(CLI::Range(0, 200))
      ->capture_default_str();
  command->add_option("--live-zone", capacity.live_zone, "zone of the --live vehicles: a ready zone's name or a file")
      ->type_name("NAME|FILE")
      ->capture_default_str();
  command->add_option("--live-seconds", capacity.live_s, "driving time for each number")
      ->type_name("S")
      ->check(CLI::Range(1.0, 3600.0))
      ->capture_default_str();
  command->add_option("--out", capacity.out_file, "also write the table as JSON")->type_name("FILE");
  command->add_flag("--json", capacity.json, "print the table as JSON");
  return command;
}

CLI::App* describe_traffic(CLI::App& root, FleetTrafficArguments& traffic) {
  CLI::App* command = root.add_subcommand(
      "traffic",
      "Measure the throughput of a virtual fleet on a zone, much faster than real time: jobs, waits, a heat map");
  command->footer(examples);
  CLI::Option* zone = command->add_option("--zone", traffic.zone, "traffic zone: a ready one's name or a file")
                          ->type_name("NAME|FILE")
                          ->capture_default_str();
  command
      ->add_option("--zones", traffic.zones,
                   "several zones with transfer points between them: a TOML file, or names such as 4*lacet4,indus8")
      ->type_name("FILE|LIST")
      ->excludes(zone);
  command->add_option("--away", traffic.away_ratio, "with --zones: ratio of jobs that lead into a neighbouring zone")
      ->type_name("RATIO")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  command
      ->add_option("--transfer-time", traffic.transfer_s, "with --zones and a list: seconds from one zone to the next")
      ->type_name("S")
      ->check(CLI::Range(0.2, 1e5))
      ->capture_default_str();
  command->add_option("--threads", traffic.threads, "number of threads; the result does not depend on it")
      ->type_name("N")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  command->add_option("--sidecar", traffic.sidecar, "what the zone's format cannot express, if not next to the file")
      ->type_name("FILE");
  command->add_option("--aivs", traffic.aivs, "how many vehicles")
      ->type_name("N")
      ->check(CLI::Range(1, 10'000'000))
      ->capture_default_str();
  command->add_option("--duration", traffic.duration_s, "measured virtual seconds")
      ->type_name("S")
      ->check(CLI::Range(1.0, 1e8))
      ->capture_default_str();
  command
      ->add_option("--warm-up", traffic.warm_up_s,
                   "virtual seconds before the measurement, not included in the metrics")
      ->type_name("S")
      ->check(CLI::Range(0.0, 1e8))
      ->capture_default_str();
  command->add_option("--seed", traffic.seed, "fixes every random draw")->type_name("S")->capture_default_str();
  CLI::Option* rate =
      command->add_option("--jobs-per-hour", traffic.jobs_per_hour, "random transport jobs, average number per hour")
          ->type_name("N");
  command->add_option("--jobs", traffic.jobs_file, "transport jobs from a CSV file; '-' reads standard input")
      ->type_name("FILE")
      ->excludes(rate);
  command->add_option("--handling", traffic.handling_s, "seconds to load, and to unload")
      ->type_name("S")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  add_rules(*command, traffic.rules, "how AIVs choose their speed (docs/guide/agents.md)");
  command->add_option("--step", traffic.step_s, "seconds of one step")
      ->type_name("S")
      ->check(CLI::Range(0.01, 0.2))
      ->capture_default_str();
  command->add_option("--out", traffic.out_directory, "write report.html, result.json and jobs.csv there")
      ->type_name("DIR");
  command->add_flag("--json", traffic.json, "print the result as JSON");
  return command;
}

}  // namespace cosiva::app
