// The options of `cosiva qualify` and `cosiva compare`, with their help texts.
#include "cosiva/app/positioning/command_line_qualify.h"

#include "cosiva/app/cli/common_options.h"
#include "cosiva/app/cli/console.h"
#include "cosiva/app/positioning/qualify_command.h"

namespace cosiva::app {
namespace {

constexpr const char* qualify_examples =
    "Examples:\n"
    "  cosiva qualify arc_kalman --pitch 0.5 --runs 100           in virtual time, with the limit\n"
    "  cosiva qualify calibrating --recording plaza1 --out DIR    on a recording, with a report\n"
    "  cosiva qualify arc_kalman --live --broker 127.0.0.1:1883    on a running platform (`cosiva up`), over its "
    "vehicles\n"
    "  cosiva qualify arc_kalman --mode predict-then-move --distance 10 --runs 6    figure 16: estimate, move, "
    "compare with the actual position\n"
    "  cosiva qualify mine --external \"mine=python3 mine.py\"      any program that speaks JSON lines\n"
    "  cosiva qualify all --runs 500 --threads 4                  at most four threads; same result\n"
    "  cosiva qualify --list                                      lists the algorithms\n"
    "\n"
    "docs/guide/metrology.md explains the metrics.";

constexpr const char* compare_examples =
    "Examples:\n"
    "  cosiva compare reset_rule arc_kalman --runs 30             which is better, and how certain that is\n"
    "  cosiva compare --zone indus8 --fiducials beacons --json        the usual algorithms, with the zone's beacons\n"
    "  cosiva compare --live --vehicle AIV1 --vehicle AIV2 --distance 20 --runs 8    figure 17 on two driving "
    "vehicles\n"
    "  cosiva compare reset_rule arc_kalman --mode predict-then-move --step 0.2 --live    figure 17, move by move\n"
    "  cosiva compare ekf calibrating smoother --recording A --recording B\n"
    "  cosiva compare --reference ground_truth.tum --estimate a.tum --estimate b.tum\n"
    "  cosiva compare ekf smoother --recording A --reference-budget cal/reference_budget.json\n"
    "  cosiva compare --reference ground_truth.tum --estimate slam.tum --align se2     in a frame of its own";

void add_length(Command command, const std::string& name, double& metres, const std::string& what) {
  command.add_option(name, metres, what).value_name("M").in_range(0.0, 1e9).show_default();
}

void add_virtual_time(Command command, QualifyArguments& q) {
  command.add_option("--zone", q.zone, "whose loop is driven: a ready zone's name or a file; without: lacet4")
      .value_name("NAME|FILE");
  add_length(command, "--distance", q.distance_m, "length of each run");
  command.add_option("--runs", q.runs, "how many runs; each is one vote")
      .value_name("N")
      .in_range(1, 1000000)
      .show_default();
  command.add_option("--seed", q.seed, "of the first run; the following runs count up").value_name("N").show_default();
  command
      .add_option("--fiducials", q.fiducials, "what is read: a beacon every --pitch, the zone's tags, or its beacons")
      .one_of({"pitch", "tags", "beacons"})
      .show_default();
  add_length(command, "--pitch", q.pitch_m, "between beacons along the path");
  add_length(command, "--reach", q.reach_m, "greatest distance between the path and a beacon that is read");
  command.add_option("--speed", q.speed_mps, "of the vehicle").value_name("M/S").show_default();
  command.add_option("--rate", q.rate_hz, "odometry per second; each is an iteration").value_name("HZ").show_default();
  add_length(command, "--odometry-noise", q.odometry_m, "standard deviation of odometry after one metre");
  add_length(command, "--reading-noise", q.reading_m, "standard deviation of a reading");
  command.add_option("--missed", q.missed, "ratio of beacons that are not read").in_range(0.0, 0.99).show_default();
  command.add_option("--scale-error", q.scale, "standard deviation of the odometer's scale, a draw per run")
      .in_range(0.0, 0.5)
      .show_default();
  add_length(command, "--survey-error", q.survey_m, "standard deviation of the beacons' actual positions");
  command.add_option("--particles", q.particles, "of the particle filter").in_range(10, 1000000);
  command.add_option("--horizon", q.horizon, "number of readings that the unbiased FIR filter uses").in_range(1, 1000);
}

void add_mode(Command command, QualifyArguments& q) {
  command
      .add_option(
          "--mode", q.mode,
          "continuous: the vehicle drives on while its estimates are requested. predict-then-move, as in figures "
          "16 and 17: its next position is requested, a move of --step commanded, then the actual position "
          "requested from the GVS (without one from the emulated plant), until --distance (10 m and 6 runs if not "
          "given); in virtual time with "
          "the AIV's own on-board program, or with --live. --out adds steps.csv (PA, PE1, PE2 ...) and calls.txt")
      .one_of({"continuous", "predict-then-move"})
      .show_default();
  add_length(command, "--step", q.step_m, "of each move, with --mode predict-then-move");
}

void add_evaluation(Command command, QualifyArguments& q) {
  add_length(command, "--threshold", q.threshold_m, "of the precision: the ratio of iterations with an error below it");
  add_length(command, "--tolerance", q.tolerance_m, "a run passes when no error exceeds it");
  command.add_option("--reliability", q.reliability, "that consecutive passes should show").in_range(0.01, 0.9999);
  command.add_option("--confidence", q.confidence, "with which they should").in_range(0.01, 0.9999);
  command
      .add_option("--reference-error", q.reference_m, "standard uncertainty of the ground truth itself, as one value")
      .value_name("M")
      .in_range(0.0, 1e3);
  command
      .add_option(
          "--reference-budget", q.reference_budget,
          "the same part by part with sources, all printed in the result: reference_budget.json or calibration.json "
          "of gvs calibrate; differences below it are called unresolved")
      .value_name("FILE");
}

void add_others(Command command, QualifyArguments& q) {
  command
      .add_option("--recording", q.recordings,
                  "a folder with odometry, readings or ranges, and ground truth; may be repeated")
      .value_name("DIR")
      .one_value_each();
  command.add_option("--gap", q.gap_s, "greatest distance of stamps between which the ground truth is interpolated")
      .value_name("S")
      .in_range(1e-6, 1e6)
      .show_default();
  command.add_option("--external", q.external, "an algorithm in a program of its own; may be repeated")
      .value_name("NAME=COMMAND")
      .one_value_each();
  command.add_option("--timeout", q.timeout_s, "timeout of its response")
      .value_name("S")
      .in_range(0.001, 1e5)
      .show_default();
  command.add_option("--reference", q.reference, "a trajectory (TUM, KITTI or EuRoC) to evaluate --estimate against")
      .value_name("FILE");
  command.add_option("--estimate", q.estimates, "a trajectory; may be repeated").value_name("FILE").one_value_each();
  command.add_option("--associate", q.associate, "how poses are paired; nearest is evo's rule, within 10 ms")
      .one_of({"interpolate", "nearest"})
      .show_default();
  command
      .add_option("--align", q.align,
                  "aligns estimates with the ground truth before they are evaluated, and reports it: se2 turns about "
                  "the vertical and "
                  "shifts, by least squares; origin moves the first pose onto that of the ground truth; se3, of "
                  "trajectories, is evo's "
                  "--align. Where the frame is surveyed that hides errors")
      .one_of({"none", "se2", "se3", "origin"})
      .show_default();
}

void add_live(Command command, LiveQualifyArguments& live) {
  command.add_flag(
      "--live", live.live,
      "on a running platform: its vehicles run the algorithms while they drive, and receive --rate requests per "
      "second until they have driven --distance");
  command.add_option("--url", live.url, "of its server, with --live").value_name("URL").show_default();
  add_broker(command, live.broker, "127.0.0.1:1883; with --live");
  command.add_option("--vehicle", live.vehicles, "vehicle of the runs, with --live; may be repeated; without: AIV1")
      .value_name("AIV|MANUFACTURER/SERIAL")
      .one_value_each();
  command
      .add_option("--ground-truth", live.ground_truth_topic,
                  "topic of the vehicles' actual positions; without: the GVS's detections where a GVS is in operation, "
                  "otherwise the plant's ground truth; the report names the source")
      .value_name("TOPIC");
}

/// The options of a simulation or of a file have no meaning on a running platform.
std::optional<std::string> useless_live(Command command) {
  for (const char* name :
       {"--zone", "--fiducials", "--pitch", "--reach", "--odometry-noise", "--reading-noise", "--missed",
        "--scale-error", "--survey-error", "--recording", "--reference", "--estimate", "--associate", "--align"}) {
    if (command.given(name)) return name;
  }
  return std::nullopt;
}

/// The options of the continuous mode that have no meaning for moves.
std::optional<std::string> useless_for_moves(Command command, bool live) {
  for (const char* name : {"--fiducials", "--pitch", "--reach", "--odometry-noise", "--reading-noise", "--missed",
                           "--scale-error", "--survey-error", "--rate", "--recording", "--external", "--reference",
                           "--estimate", "--associate", "--align"}) {
    if (command.given(name)) return name;
  }
  return !live && command.given("--speed") ? std::optional<std::string>{"--speed"} : std::nullopt;
}

int run_live(Command command, const QualifyArguments& q, LiveQualifyArguments& live, std::size_t at_least) {
  if (const auto useless = useless_live(command))
    return report_error({"qualify.live", "the option has no meaning with --live", *useless});
  live.speed_given = command.given("--speed");
  return run_qualify_live(q, live, at_least);
}

}  // namespace

QualifyCommands describe_qualify(Command root, QualifyArguments& q) {
  QualifyCommands commands{{}, {}, std::make_shared<LiveQualifyArguments>()};
  commands.qualify = root.add_subcommand("qualify", "Qualify a position estimator, with intervals and its limit");
  commands.compare = root.add_subcommand("compare", "Compare position estimators, on the same runs");
  for (const Command command : {commands.qualify, commands.compare}) {
    command.add_option("algorithms", q.algorithms, "their names (--list), or all").value_name("NAME");
    command.add_flag("--list", q.list, "list the algorithms");
    command.add_flag("--json", q.json, "print the result as JSON");
    command.add_option("--out", q.out_folder, "writes report.html, result.json, TUM and CSV files, and zips for evo")
        .value_name("DIR");
    command.add_option("--threads", q.threads, "number of threads, with the same result; without: one for each core")
        .value_name("N")
        .in_range(1, 1024);
    add_virtual_time(command, q);
    add_mode(command, q);
    add_evaluation(command, q);
    add_others(command, q);
    add_live(command, *commands.live);
  }
  commands.qualify.footer(qualify_examples);
  commands.compare.footer(compare_examples);
  return commands;
}

std::optional<int> run_qualify_command(const QualifyCommands& commands, QualifyArguments& q, int argc,
                                       const char* const* argv) {
  if (!commands.qualify.chosen() && !commands.compare.chosen()) return std::nullopt;
  q.command = "cosiva";
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    // The number of threads is left out: the result, and therefore the report, does not depend on it.
    if (word == "--threads") ++i;
    if (word.starts_with("--threads")) continue;
    q.command += word.find(' ') == std::string::npos ? " " + word : " '" + word + "'";
  }
  const Command chosen = commands.qualify.chosen() ? commands.qualify : commands.compare;
  if (const auto useless = predicts_then_moves(q) ? useless_for_moves(chosen, commands.live->live) : std::nullopt)
    return report_error({"qualify.mode", "the option has no meaning with --mode predict-then-move", *useless});
  if (!predicts_then_moves(q) && chosen.given("--step"))
    return report_error({"qualify.mode", "the option has a meaning with --mode predict-then-move only", "--step"});
  // A move takes a second or more: the usual 30 runs of 100 m would be some hours of driving.
  if (predicts_then_moves(q) && !chosen.given("--distance")) q.distance_m = 10.0;
  if (predicts_then_moves(q) && !chosen.given("--runs")) q.runs = 6;
  if (commands.live->live && !q.list)
    return commands.qualify.chosen() ? run_live(commands.qualify, q, *commands.live, 1)
                                     : run_live(commands.compare, q, *commands.live, 2);
  return commands.qualify.chosen() ? run_qualify(q) : run_compare(q);
}

}  // namespace cosiva::app
