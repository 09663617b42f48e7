// The options of `cosiva battery` and its verbs, and what their help says.
#include "app/command_line_verbs.h"

namespace cosiva::app {
namespace {

constexpr const char* battery_examples =
    "Examples:\n"
    "  cosiva battery sampled --repeat 4                          one battery, four times: autonomy and its drift\n"
    "  cosiva battery fleet --aivs 12 --out report                twelve at once, with a report\n"
    "  cosiva battery fleet --aivs 4 --repeat 4 --swap            tells battery from vehicle\n"
    "  cosiva battery fleet --live --broker 127.0.0.1:1883 --state test.json   on a platform that runs (`cosiva up`)\n"
    "  cosiva battery plan --cv 1.4 --half-width 1 --aivs 4       how many batteries it takes, who swaps with whom\n"
    "  cosiva battery fit pulses.csv --predict 2C.csv --name mine --licence CC-BY-4.0 --out mine.json\n"
    "\n"
    "docs/guide/batteries.md tells more.";

/// On a platform that runs, instead of in virtual time.
void add_live_options(CLI::App& verb, BatteryTestArguments& test) {
  verb.add_flag("--live", test.live, "on a platform that runs, by its wire, instead of in virtual time");
  verb.add_option("--url", test.url, "of its server, with --live")->type_name("URL")->capture_default_str();
  add_broker(verb, test.broker, "127.0.0.1:1883; with --live");
  verb.add_option("--vehicle", test.vehicles, "whose batteries are tested; without: AIV1, AIV2 …")
      ->type_name("MANUFACTURER/SERIAL");
  verb.add_option("--battery", test.batteries, "what people call each battery, in the vehicles' order")
      ->type_name("ID");
  verb.add_flag("--by-hand", test.by_hand,
                "people change the batteries, and say so with `cosiva battery ready`; without, the plant is told to");
  verb.add_option("--park", test.park, "a station where who has ended goes, with --by-hand; without, it stands")
      ->type_name("STATION");
  verb.add_option("--lost-after", test.lost_after_s, "without a word from it a vehicle is lost [s]")
      ->type_name("S")
      ->check(CLI::Range(2.0, 86400.0))
      ->capture_default_str();
  verb.add_option("--notify", test.notify,
                  "told what the operator is told, as the last argument of this shell command (live tests)")
      ->type_name("COMMAND");
}

void add_test_options(CLI::App& verb, BatteryTestArguments& test) {
  verb.add_option("--zone", test.zone, "traffic zone: a ready one's name or a file")
      ->type_name("NAME|FILE")
      ->capture_default_str();
  verb.add_option("--type", test.type, "battery type: a shipped one's name (leaf33, lipo850) or a file")
      ->type_name("NAME|FILE")
      ->capture_default_str();
  verb.add_option("--series", test.series, "cells in series; without: the type's")
      ->type_name("N")
      ->check(CLI::Range(1, 100));
  verb.add_option("--parallel", test.parallel, "cells beside each other; without: the type's")
      ->type_name("N")
      ->check(CLI::Range(1, 100));
  verb.add_option("--scale", test.scale, "cells of another size: capacity times this")
      ->type_name("X")
      ->check(CLI::Range(1e-4, 1e4));
  verb.add_option("--gauge", test.gauge, "counter, rest or kalman: what the vehicles' gauges do")
      ->type_name("WORD")
      ->capture_default_str();
  verb.add_option("--floor", test.floor_percent, "charge at which a run ends [%]")
      ->type_name("PERCENT")
      ->capture_default_str();
  verb.add_option("--pause-every", test.pause_every_s, "running time between calibrated pauses [s]; 0: none")
      ->type_name("S")
      ->check(CLI::NonNegativeNumber);
  verb.add_option("--pause", test.pause_s, "length of a pause [s], booked apart")
      ->type_name("S")
      ->check(CLI::NonNegativeNumber);
  verb.add_option("--failures", test.failures_per_hour, "other failures, of a vehicle in an hour")
      ->type_name("RATE")
      ->check(CLI::Range(0.0, 1000.0));
  verb.add_option("--load-spread", test.load_sd_percent, "how much vehicles differ in what they take [%]")
      ->type_name("PERCENT")
      ->check(CLI::Range(0.0, 30.0))
      ->capture_default_str();
  verb.add_option("--ambient", test.ambient_c, "temperature around the batteries [°C]")
      ->type_name("C")
      ->check(CLI::Range(-30.0, 60.0))
      ->capture_default_str();
  verb.add_option("--measure", test.measure_s, "so long the whole platform drives to measure the load [s]")
      ->type_name("S")
      ->check(CLI::Range(10.0, 36000.0))
      ->capture_default_str();
  verb.add_flag("--whole", test.whole,
                "the whole platform in the loop to the end, instead of repeating the load that was measured");
  add_rules(verb, test.rules, "how the AIVs choose their speed (docs/guide/agents.md); without: crisp");
  verb.add_option("--state", test.state_file, "saved while it runs; where it is there, the test goes on from it")
      ->type_name("FILE");
  verb.add_option("--out", test.out_directory, "report.html, result.json and curves.csv go there")->type_name("DIR");
  verb.add_option("--seed", test.seed, "fixes every random draw")->type_name("S")->capture_default_str();
  verb.add_flag("--json", test.json, "print the result as JSON");
  add_live_options(verb, test);
}

void describe_ready(CLI::App& verb, BatteryReadyArguments& ready) {
  verb.add_option("vehicle", ready.vehicle, "AIV3, or MANUFACTURER/SERIAL")->type_name("VEHICLE")->required();
  verb.add_option("battery", ready.battery, "the battery's own id")->type_name("ID")->required();
  verb.add_option("--type", ready.type, "its type")->type_name("NAME")->capture_default_str();
  verb.add_option("--cycles", ready.cycles, "full ones that it has gone through")
      ->type_name("N")
      ->check(CLI::NonNegativeNumber);
  verb.add_option("--rest", ready.rest_s, "since it was charged [s]")->type_name("S")->check(CLI::NonNegativeNumber);
  verb.add_option("--temperature", ready.temperature_c, "of the pack [°C]")
      ->type_name("C")
      ->check(CLI::Range(-100.0, 200.0))
      ->capture_default_str();
  verb.add_option("--charge", ready.charge_percent, "as far as is known [%]")
      ->type_name("PERCENT")
      ->check(CLI::Range(0.0, 100.0))
      ->capture_default_str();
  add_broker(verb, ready.broker, "127.0.0.1:1883");
}

void describe_fit(CLI::App& verb, BatteryFitArguments& fit) {
  verb.add_option("files", fit.files, "logs with the Battery Data Format's columns")->type_name("CSV")->required();
  verb.add_option("--only", fit.series, "only the series whose name holds this, such as rate=1C")->type_name("TEXT");
  verb.add_option("--predict", fit.predict, "not fitted but foretold: another log, or series whose name holds this")
      ->type_name("CSV|TEXT");
  verb.add_option("--name", fit.name, "of the type")->type_name("TEXT")->capture_default_str();
  verb.add_option("--source", fit.source, "who measured it; without: the files' names")->type_name("TEXT");
  verb.add_option("--licence", fit.licence, "of the logs; a type's file must say it")->type_name("TEXT");
  verb.add_option("--capacity", fit.capacity_ah, "of a cell [Ah]; without: what the slowest discharge took out")
      ->type_name("AH")
      ->check(CLI::PositiveNumber);
  verb.add_option("--floor", fit.floor_v, "where a discharge ends [V]; without: the lowest voltage under load")
      ->type_name("V")
      ->check(CLI::PositiveNumber);
  verb.add_option("--out", fit.out_file, "the type goes there")->type_name("FILE");
  verb.add_flag("--json", fit.json, "print the result as JSON");
}

}  // namespace

BatteryVerbs describe_battery(CLI::App& root, BatteryArguments& battery) {
  BatteryVerbs verbs{};
  verbs.battery =
      root.add_subcommand("battery", "Autonomy of batteries: types, tests, and what may be claimed from them");
  verbs.battery->require_subcommand(0, 1);
  verbs.battery->footer(battery_examples);
  verbs.sampled =
      verbs.battery->add_subcommand("sampled", "One AIV, one battery, from full to the floor, as often as wanted");
  verbs.fleet = verbs.battery->add_subcommand("fleet", "N AIVs on one circuit, each with its battery, all at once");
  verbs.fit = verbs.battery->add_subcommand("fit", "Make a battery type of a tester's logs");
  verbs.ready = verbs.battery->add_subcommand("ready", "Say that a battery has been put into a vehicle (live tests)");
  verbs.plan = verbs.battery->add_subcommand("plan", "Say how many batteries a claim takes, and who swaps with whom");
  verbs.compare = verbs.battery->add_subcommand("compare", "Compare the batteries of two results");
  verbs.check =
      verbs.battery->add_subcommand("check", "Say whether files are battery types, or what is wrong with them");
  for (CLI::App* verb : {verbs.sampled, verbs.fleet}) {
    add_test_options(*verb, battery.test);
    verb->add_option("--repeat", battery.test.repeat, "runs of each battery")
        ->type_name("N")
        ->check(CLI::Range(1, 1000))
        ->capture_default_str();
  }
  verbs.fleet->add_option("--aivs", battery.test.aivs, "how many")
      ->type_name("N")
      ->check(CLI::Range(2, 200))
      ->capture_default_str();
  verbs.fleet->add_flag("--swap", battery.test.swap, "batteries change vehicles from run to run, by a Latin square");
  verbs.fleet
      ->add_option("--half-width", battery.test.half_width_percent,
                   "say after how many batteries the mean is known to this [%]")
      ->type_name("PERCENT");
  describe_fit(*verbs.fit, battery.fit);
  describe_ready(*verbs.ready, battery.ready);
  verbs.plan->add_option("--cv", battery.plan.cv_percent, "standard deviation that is expected [%]")
      ->type_name("PERCENT")
      ->check(CLI::Range(0.001, 100.0))
      ->capture_default_str();
  verbs.plan->add_option("--half-width", battery.plan.half_width_percent, "of the mean's 95 % interval [%]")
      ->type_name("PERCENT")
      ->check(CLI::Range(0.001, 100.0))
      ->capture_default_str();
  verbs.plan
      ->add_option("--difference", battery.plan.difference_percent,
                   "between two types, that a comparison should see [%]")
      ->type_name("PERCENT")
      ->check(CLI::Range(0.001, 100.0));
  verbs.plan->add_option("--aivs", battery.plan.aivs, "print the square for so many")
      ->type_name("N")
      ->check(CLI::Range(2, 200));
  verbs.plan->add_flag("--json", battery.plan.json, "print the result as JSON");
  verbs.compare->add_option("results", battery.compare.files, "two results, of `--out` or `--json`")
      ->type_name("FILE")
      ->required()
      ->expected(2);
  verbs.compare->add_flag("--json", battery.compare.json, "print the result as JSON");
  verbs.check->add_option("files", battery.check.files, "battery types")->type_name("FILE")->required();
  verbs.check->add_flag("--json", battery.check.json, "print the result as JSON");
  return verbs;
}

std::optional<int> run_battery_verb(const BatteryVerbs& verbs, const BatteryArguments& battery) {
  if (verbs.sampled->parsed()) return run_battery_sampled(battery.test);
  if (verbs.fleet->parsed()) return run_battery_fleet(battery.test);
  if (verbs.fit->parsed()) return run_battery_fit(battery.fit);
  if (verbs.ready->parsed()) return run_battery_ready(battery.ready);
  if (verbs.plan->parsed()) return run_battery_plan(battery.plan);
  if (verbs.compare->parsed()) return run_battery_compare(battery.compare);
  if (verbs.check->parsed()) return run_battery_check(battery.check);
  return std::nullopt;
}

}  // namespace cosiva::app
