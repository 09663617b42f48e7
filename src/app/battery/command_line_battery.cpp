// The options of `cosiva battery` and its subcommands, with their help texts.
#include "cosiva/app/battery/command_line_battery.h"

#include "cosiva/app/battery/battery_check_command.h"
#include "cosiva/app/battery/battery_compare_command.h"
#include "cosiva/app/battery/battery_test_command.h"
#include "cosiva/app/cli/common_options.h"

namespace cosiva::app {
namespace {

constexpr const char* battery_examples =
    "Examples:\n"
    "  cosiva battery sampled --repeat 4                          one battery, four times: autonomy and its drift\n"
    "  cosiva battery fleet --aivs 12 --out report                twelve at once, with a report\n"
    "  cosiva battery fleet --aivs 4 --repeat 4 --swap            separates battery from vehicle\n"
    "  cosiva battery fleet --live --broker 127.0.0.1:1883 --state test.json   on a running platform (`cosiva up`)\n"
    "  cosiva battery plan --cv 1.4 --half-width 1 --aivs 4       how many batteries it takes, and the swaps\n"
    "  cosiva battery analyse durations.csv                       what may be claimed from tests made elsewhere\n"
    "  cosiva battery discharge leaf33 --rate 1                   how long a type lasts under a load\n"
    "  cosiva battery fit pulses.csv --predict 2C.csv --name mine --licence CC-BY-4.0 --out mine.json\n"
    "\n"
    "docs/guide/batteries.md explains more; every subcommand has its own --help.";

constexpr const char* sampled_examples =
    "The article's exchange (A37): changeBattery, batteryReady, run, then {rc, sendMsg} until rc stays below the "
    "floor.\n"
    "\n"
    "Examples:\n"
    "  cosiva battery sampled                                     the carts' own battery, from full to 20 %\n"
    "  cosiva battery sampled --repeat 4 --json                   four times: slope per run, and the chance of none\n"
    "  cosiva battery sampled --type leaf33 --scale 0.05 --floor 0   until the battery's own protection cuts off\n"
    "  cosiva battery sampled --pause-every 600 --pause 60        calibrated pauses, booked apart\n"
    "  cosiva battery sampled --live --by-hand --vehicle ACME/A1 --battery red --state red.json   real hardware";

constexpr const char* fleet_examples =
    "All run when the last is ready; AT is the mean of equation (4), with its uncertainty (A38).\n"
    "\n"
    "Examples:\n"
    "  cosiva battery fleet --aivs 12 --out report                report.html, result.json, curves.csv\n"
    "  cosiva battery fleet --aivs 4 --repeat 4 --swap            variance by cause: battery, vehicle, run, rest\n"
    "  cosiva battery fleet --aivs 12 --failures 0.05             vehicles fail: censored, never counted as ends\n"
    "  cosiva battery fleet --aivs 12 --half-width 1              after how many batteries the mean is known to 1 %\n"
    "  cosiva battery fleet --aivs 6 --repeat 8 --half-width 1    runs are repeated until it is, eight times at most\n"
    "  cosiva battery fleet --live --broker 127.0.0.1:1883 --state test.json   on a running platform (`cosiva up`)";

constexpr const char* fit_examples =
    "A pulse test from full to empty is best; constant discharges at two rates do. One rate alone does not separate\n"
    "resistance from voltage. A discharge must begin full; + charges, as in the Battery Data Format. Columns:\n"
    "test_time_second, voltage_volt, current_ampere; or a tester's own, where they name their unit, as Test_Time(s),\n"
    "Voltage(V), Current(mA). Where the tester counted charge itself (discharging_capacity_ah, charging_capacity_ah),\n"
    "its count is used. Where samples lie too far apart to derive the charge, the output states its possible error:\n"
    "--capacity, where known, corrects that.\n"
    "\n"
    "Examples:\n"
    "  cosiva battery fit pulses.csv --predict 1C.csv --predict 2C.csv   error of logs that were not fitted\n"
    "  cosiva battery fit rates.csv --predict rate=2C             hold one series out\n"
    "  cosiva battery fit rates.csv --only rate=0.1C --only rate=1C --floor 3.0\n"
    "  cosiva battery fit all.csv --predict 'discharge 3'         a file's discharges are numbered as they come\n"
    "  cosiva battery fit pulses.csv --name mine --licence CC-BY-4.0 --out mine.json\n"
    "  cosiva battery check mine.json && cosiva battery sampled --type mine.json";

constexpr const char* analyse_examples =
    "A table has a header and a row for each run: a column for how long it lasted (its name ends with its unit), and\n"
    "where there are any: battery_id or cell, vehicle or tester_channel, run, stop, and series where tests are "
    "several.\n"
    "\n"
    "Examples:\n"
    "  cosiva battery analyse durations.csv                       every series of it\n"
    "  cosiva battery analyse durations.csv --only first_run --failed 6=2000 --failed 9=3000   as if two had failed\n"
    "  cosiva battery analyse monday/result.json tuesday/result.json --half-width 1   enough, or test another?\n"
    "  cosiva battery analyse durations.csv --only first_run --json > a.json && cosiva battery compare a.json b.json";

constexpr const char* discharge_examples =
    "The model that tests use, alone: constant current or power, from full and rested to the voltage floor.\n"
    "\n"
    "Examples:\n"
    "  cosiva battery discharge leaf33                            at C/5, C/2, 1C and 2C, with Peukert's exponent\n"
    "  cosiva battery discharge leaf33 --current 30.6 --floor 3.0 measured: 3568.8 s\n"
    "  cosiva battery discharge lipo850 --power 1 --power 2       constant power, as a vehicle draws it\n"
    "  cosiva battery discharge mine.json --rate 1 --csv 1C.csv   as a log in the Battery Data Format's columns";

constexpr const char* plan_examples =
    "Examples:\n"
    "  cosiva battery plan --cv 1.4 --half-width 1                how many batteries for a mean known to 1 %\n"
    "  cosiva battery plan --cv 1.4 --difference 2                how many of each type to detect a difference of 2 %\n"
    "  cosiva battery plan --aivs 4                               a Latin square: which battery on which AIV, run by "
    "run";

constexpr const char* compare_examples =
    "Examples:\n"
    "  cosiva battery compare old/result.json new/result.json     difference, its interval, effect size, power\n"
    "\n"
    "Runs that a vehicle's failure ended are left out.";

constexpr const char* ready_examples =
    "Examples:\n"
    "  cosiva battery ready ACME/A1 red --type leaf33 --cycles 12 --rest 3600 --temperature 23.5\n"
    "\n"
    "A battery that is not full, not in its type's temperature band, or not the requested one is refused by the test.";

constexpr const char* check_examples =
    "Examples:\n"
    "  cosiva battery check mine.json leaf33                      files, or types that come with the platform\n"
    "\n"
    "The form is docs/protocols/battery-type.schema.json. Exit 2 where one is bad.";

/// Options of tests on a running platform, instead of in virtual time.
void add_live_options(Command command, BatteryTestArguments& test) {
  command.add_flag("--live", test.live, "on a running platform, over its broker, instead of in virtual time");
  command.add_option("--url", test.url, "of its server, with --live").value_name("URL").show_default();
  add_broker(command, test.broker, "127.0.0.1:1883; with --live");
  command.add_option("--vehicle", test.vehicles, "whose batteries are tested; without: AIV1, AIV2 …")
      .value_name("MANUFACTURER/SERIAL");
  command.add_option("--battery", test.batteries, "name of each battery, in the vehicles' order").value_name("ID");
  command.add_flag(
      "--by-hand", test.by_hand,
      "operators change the batteries and confirm with `cosiva battery ready`; without: the plant changes them, and "
      "each vehicle confirms as soon as it reads a full battery");
  command
      .add_option("--park", test.park, "station for vehicles whose run has ended, with --by-hand; without: they stop")
      .value_name("STATION");
  command.add_option("--lost-after", test.lost_after_s, "a vehicle without reports for this time is lost [s]")
      .value_name("S")
      .in_range(2.0, 86400.0)
      .show_default();
  command
      .add_option("--notify", test.notify,
                  "shell command that is run with each operator message as its last argument (live tests)")
      .value_name("COMMAND");
}

void add_test_options(Command command, BatteryTestArguments& test) {
  command
      .add_option(
          "--zone", test.zone,
          "traffic zone: a ready one's name or a file; without: lacet4, and oval for a fleet, as vehicles that wait "
          "for each other at crossings discharge less")
      .value_name("NAME|FILE");
  command.add_option("--type", test.type, "battery type: a shipped one's name (leaf33, lipo850) or a file")
      .value_name("NAME|FILE")
      .show_default();
  command.add_option("--series", test.series, "cells in series; without: the type's").value_name("N").in_range(1, 100);
  command.add_option("--parallel", test.parallel, "cells in parallel; without: the type's")
      .value_name("N")
      .in_range(1, 100);
  command.add_option("--scale", test.scale, "cells of another size: capacity times this")
      .value_name("X")
      .in_range(1e-4, 1e4);
  command.add_option("--gauge", test.gauge, "counter, rest or kalman: method of the vehicles' gauges")
      .value_name("WORD")
      .show_default();
  command.add_option("--floor", test.floor_percent, "charge at which a run ends [%]")
      .value_name("PERCENT")
      .show_default();
  command.add_option("--pause-every", test.pause_every_s, "running time between calibrated pauses [s]; 0: none")
      .value_name("S")
      .not_negative();
  command.add_option("--pause", test.pause_s, "length of a pause [s], booked apart").value_name("S").not_negative();
  command.add_option("--failures", test.failures_per_hour, "other failures, of a vehicle in an hour")
      .value_name("RATE")
      .in_range(0.0, 1000.0);
  command.add_option("--load-spread", test.load_sd_percent, "standard deviation of the load between vehicles [%]")
      .value_name("PERCENT")
      .in_range(0.0, 30.0)
      .show_default();
  command.add_option("--ambient", test.ambient_c, "temperature around the batteries [°C]")
      .value_name("C")
      .in_range(-30.0, 60.0)
      .show_default();
  command.add_option("--measure", test.measure_s, "duration of the whole platform's run that measures the load [s]")
      .value_name("S")
      .in_range(10.0, 36000.0)
      .show_default();
  command.add_flag("--whole", test.whole,
                   "the whole platform in the loop to the end, instead of repeating the load that was measured");
  command
      .add_option(
          "--hz", test.hz,
          "with --whole: actions of each component per second; 50 is the live platform's rate, and the default. "
          "At 10 the test takes three fifths of the time, and vehicles in dense traffic wait slightly longer")
      .value_name("N")
      .in_range(10.0, 50.0);
  add_rules(command, test.rules, "how the AIVs choose their speed (docs/guide/agents.md); without: fuzzy");
  command.add_option("--state", test.state_file, "saved during the test; an existing file is continued")
      .value_name("FILE");
  command.add_option("--out", test.out_directory, "folder for report.html, result.json and curves.csv")
      .value_name("DIR");
  command.add_option("--seed", test.seed, "fixes every random draw").value_name("S").show_default();
  command.add_flag("--json", test.json, "print the result as JSON");
  add_live_options(command, test);
}

void describe_ready(Command command, BatteryReadyArguments& ready) {
  command.add_option("vehicle", ready.vehicle, "AIV3, or MANUFACTURER/SERIAL").value_name("VEHICLE").required();
  command.add_option("battery", ready.battery, "the battery's own id").value_name("ID").required();
  command.add_option("--type", ready.type, "its type").value_name("NAME").show_default();
  command.add_option("--cycles", ready.cycles, "full cycles so far").value_name("N").not_negative();
  command.add_option("--rest", ready.rest_s, "since it was charged [s]").value_name("S").not_negative();
  command.add_option("--temperature", ready.temperature_c, "of the pack [°C]")
      .value_name("C")
      .in_range(-100.0, 200.0)
      .show_default();
  command.add_option("--charge", ready.charge_percent, "if known [%]")
      .value_name("PERCENT")
      .in_range(0.0, 100.0)
      .show_default();
  add_broker(command, ready.broker, "127.0.0.1:1883");
}

void describe_fit(Command command, BatteryFitArguments& fit) {
  command.add_option("files", fit.files, "logs with the Battery Data Format's columns").value_name("CSV").required();
  command.add_option("--only", fit.series, "only the series whose name contains this: rate=1C, discharge 2")
      .value_name("TEXT");
  command.add_option("--predict", fit.predict, "predicted, not fitted: another log, or series whose name contains this")
      .value_name("CSV|TEXT");
  command.add_option("--name", fit.name, "of the type").value_name("TEXT").show_default();
  command.add_option("--source", fit.source, "origin of the measurements; without: the files' names")
      .value_name("TEXT");
  command.add_option("--licence", fit.licence, "of the logs; a type's file must state it").value_name("TEXT");
  command.add_option("--capacity", fit.capacity_ah, "of a cell [Ah]; without: what the slowest discharge took out")
      .value_name("AH")
      .positive();
  command.add_option("--floor", fit.floor_v, "where a discharge ends [V]; without: the lowest voltage under load")
      .value_name("V")
      .positive();
  command.add_option("--out", fit.out_file, "output file of the type").value_name("FILE");
  command.add_flag("--json", fit.json, "print the result as JSON");
}

void describe_discharge(Command command, BatteryDischargeArguments& discharge) {
  command.add_option("type", discharge.type, "a shipped type's name (leaf33, lipo850) or a file")
      .value_name("NAME|FILE")
      .required();
  command.add_option("--current", discharge.currents_a, "of the whole pack [A]").value_name("A").positive();
  command.add_option("--power", discharge.powers_w, "of the whole pack [W]").value_name("W").positive();
  command.add_option("--rate", discharge.rates, "current in multiples of the capacity: 0.2 is C/5")
      .value_name("C")
      .positive();
  command.add_option("--floor", discharge.floor_v, "of a cell [V]; without: the type's").value_name("V").positive();
  command.add_option("--ambient", discharge.ambient_c, "ambient temperature, and initial temperature of the pack [°C]")
      .value_name("C")
      .in_range(-40.0, 85.0)
      .show_default();
  command.add_option("--step", discharge.step_s, "of the simulation [s]")
      .value_name("S")
      .in_range(0.001, 10.0)
      .show_default();
  command.add_option("--series", discharge.series, "cells in series").value_name("N").in_range(1, 100);
  command.add_option("--parallel", discharge.parallel, "cells in parallel").value_name("N").in_range(1, 100);
  command.add_option("--scale", discharge.scale, "cells of another size: capacity times this")
      .value_name("X")
      .in_range(1e-4, 1e4);
  command.add_option("--csv", discharge.csv_file, "output file of time, voltage, current and temperature; for one load")
      .value_name("FILE");
  command.add_flag("--json", discharge.json, "print the result as JSON");
}

void describe_analyse(Command command, BatteryAnalyseArguments& analyse) {
  command.add_option("files", analyse.files, "tables of durations, or results of `--out` or `--json`")
      .value_name("CSV|JSON")
      .required();
  command.add_option("--only", analyse.only, "only this series of them").value_name("SERIES");
  command
      .add_option("--failed", analyse.failed,
                  "as if this battery's first run had been ended at this time by another cause")
      .value_name("BATTERY=SECONDS");
  command.add_option("--time", analyse.time, "column: how long it lasted, such as time_to_2V5_second")
      .value_name("COLUMN");
  command.add_option("--battery", analyse.battery, "column: which battery").value_name("COLUMN");
  command.add_option("--vehicle", analyse.vehicle, "column: on which vehicle, or tester channel").value_name("COLUMN");
  command.add_option("--run", analyse.run, "column: which of its runs, from 1").value_name("COLUMN");
  command
      .add_option("--half-width", analyse.half_width_percent,
                  "report after how many batteries the mean is known to this [%]")
      .value_name("PERCENT")
      .in_range(0.001, 100.0);
  command.add_option("--out", analyse.out_directory, "report.html and result.json go there").value_name("DIR");
  command.add_option("--seed", analyse.seed, "of the bootstrap").value_name("S").show_default();
  command.add_flag("--json", analyse.json, "print the result as JSON; of several series, a list of them");
}

/// Sets the help texts that follow a subcommand's options.
void teach(const BatteryCommands& commands) {
  commands.battery.footer(battery_examples);
  commands.sampled.footer(sampled_examples);
  commands.fleet.footer(fleet_examples);
  commands.fit.footer(fit_examples);
  commands.ready.footer(ready_examples);
  commands.plan.footer(plan_examples);
  commands.analyse.footer(analyse_examples);
  commands.discharge.footer(discharge_examples);
  commands.compare.footer(compare_examples);
  commands.check.footer(check_examples);
}

}  // namespace

BatteryCommands describe_battery(Command root, BatteryArguments& battery) {
  BatteryCommands commands{};
  commands.battery =
      root.add_subcommand("battery", "Autonomy of batteries: types, tests, and what may be claimed from them");
  commands.battery.at_most_one_subcommand();
  commands.sampled =
      commands.battery.add_subcommand("sampled", "One AIV, one battery, from full to the floor, as often as wanted");
  commands.fleet =
      commands.battery.add_subcommand("fleet", "N AIVs on one circuit, each with its battery, all at once");
  commands.fit = commands.battery.add_subcommand("fit", "Make a battery type of a tester's logs");
  commands.ready =
      commands.battery.add_subcommand("ready", "Confirm that a battery has been put into a vehicle (live tests)");
  commands.plan = commands.battery.add_subcommand(
      "plan", "Compute how many batteries a claim needs, and the swaps between vehicles");
  commands.analyse = commands.battery.add_subcommand(
      "analyse", "What may be claimed from tests that were made before, here or elsewhere");
  commands.discharge =
      commands.battery.add_subcommand("discharge", "Compute how long a type's battery lasts under a load");
  commands.compare = commands.battery.add_subcommand("compare", "Compare the batteries of two results");
  commands.check =
      commands.battery.add_subcommand("check", "Check whether files are valid battery types, and report errors");
  for (const Command command : {commands.sampled, commands.fleet}) {
    add_test_options(command, battery.test);
    command.add_option("--repeat", battery.test.repeat, "runs of each battery")
        .value_name("N")
        .in_range(1, 1000)
        .show_default();
  }
  commands.fleet.add_option("--aivs", battery.test.aivs, "how many").value_name("N").in_range(2, 200).show_default();
  commands.fleet.add_flag("--swap", battery.test.swap, "batteries change vehicles from run to run, by a Latin square");
  commands.fleet
      .add_option(
          "--half-width", battery.test.half_width_percent,
          "requested half width of the mean [%]: reports after how many batteries it was reached, and makes no further "
          "run of --repeat then")
      .value_name("PERCENT");
  describe_fit(commands.fit, battery.fit);
  describe_ready(commands.ready, battery.ready);
  describe_analyse(commands.analyse, battery.analyse);
  describe_discharge(commands.discharge, battery.discharge);
  commands.plan.add_option("--cv", battery.plan.cv_percent, "standard deviation that is expected [%]")
      .value_name("PERCENT")
      .in_range(0.001, 100.0)
      .show_default();
  commands.plan.add_option("--half-width", battery.plan.half_width_percent, "of the mean's 95 % interval [%]")
      .value_name("PERCENT")
      .in_range(0.001, 100.0)
      .show_default();
  commands.plan
      .add_option("--difference", battery.plan.difference_percent,
                  "between two types, that a comparison should detect [%]")
      .value_name("PERCENT")
      .in_range(0.001, 100.0);
  commands.plan.add_option("--aivs", battery.plan.aivs, "print the square for this number of AIVs")
      .value_name("N")
      .in_range(2, 200);
  commands.plan.add_flag("--json", battery.plan.json, "print the result as JSON");
  commands.compare.add_option("results", battery.compare.files, "two results, of `--out` or `--json`")
      .value_name("FILE")
      .required()
      .value_count(2);
  commands.compare.add_flag("--json", battery.compare.json, "print the result as JSON");
  commands.check.add_option("files", battery.check.files, "battery types").value_name("FILE").required();
  commands.check.add_flag("--json", battery.check.json, "print the result as JSON");
  teach(commands);
  return commands;
}

std::optional<int> run_battery_command(const BatteryCommands& commands, const BatteryArguments& battery) {
  if (commands.sampled.chosen()) return run_battery_sampled(battery.test);
  if (commands.fleet.chosen()) return run_battery_fleet(battery.test);
  if (commands.fit.chosen()) return run_battery_fit(battery.fit);
  if (commands.ready.chosen()) return run_battery_ready(battery.ready);
  if (commands.plan.chosen()) return run_battery_plan(battery.plan);
  if (commands.discharge.chosen()) return run_battery_discharge(battery.discharge);
  if (commands.analyse.chosen()) return run_battery_analyse(battery.analyse);
  if (commands.compare.chosen()) return run_battery_compare(battery.compare);
  if (commands.check.chosen()) return run_battery_check(battery.check);
  return std::nullopt;
}

}  // namespace cosiva::app
