#include "cosiva/app/positioning/qualify_moves.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "cosiva/adapters/thread_pool.h"
#include "cosiva/app/cli/console.h"
#include "cosiva/app/positioning/qualify_candidates.h"
#include "cosiva/app/positioning/qualify_command.h"
#include "cosiva/app/resources/zone_files.h"
#include "cosiva/experiments/positioning/moves/world_session.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::app {
namespace {

using experiments::PredictThenMove;

/// A move of a stopped vehicle takes a second more than its distance does at this speed.
constexpr double slow_mps = 0.1;
constexpr double seconds_per_move = 3.0;

struct VirtualRun {
  std::vector<std::shared_ptr<const experiments::LiveRun>> runs;
  experiments::MoveStepsByRun steps;
  std::vector<experiments::Call> calls;
  std::optional<Error> error;
};

VirtualRun virtual_run(const QualifyArguments& arguments, const zone::Rtm& rtm,
                       const std::vector<std::string>& algorithms, std::size_t index) {
  VirtualRun result;
  experiments::WorldOptions world_options;
  world_options.zone = rtm.configuration();
  world_options.aivs = 1;
  world_options.seed = arguments.seed + index;
  world_options.as_values = true;
  world_options.ground_truth = true;
  auto world = experiments::World::make(std::move(world_options));
  if (!world) {
    result.error = world.error();
    return result;
  }
  experiments::PredictThenMoveOptions options = move_options(arguments, algorithms);
  options.vehicles = {{std::string(wire::our_manufacturer), "AIV1"}};
  options.runs = 1;
  options.seed = arguments.seed + index;
  options.name = "run " + std::to_string(index + 1);
  PredictThenMove test{options};
  test.on_zone(rtm.shared_zone());
  const double moves = std::ceil(arguments.distance_m / arguments.step_m) + 2.0;
  const double longest_s = 60.0 + moves * (seconds_per_move + arguments.step_m / slow_mps);
  if (auto done = experiments::drive_in_world(test, **world, 1, from_seconds(longest_s)); !done) {
    result.error = done.error();
    return result;
  }
  result.runs = test.take_runs();
  result.steps = test.steps();
  result.calls = test.calls();
  if (result.runs.empty())
    result.error =
        Error{"moves.run", test.losses().empty() ? "the run did not end" : test.losses().back(), options.name};
  return result;
}

Result<Runs> virtual_moves(const QualifyArguments& arguments, std::vector<experiments::Candidate>& candidates,
                           const std::vector<std::string>& algorithms) {
  auto rtm = open_zone(arguments.zone.empty() ? "lacet4" : arguments.zone);
  if (!rtm) return tl::unexpected(rtm.error());
  if (rtm->zone().circuit.indirect())
    return fail("qualify.zone", "runs are in direct direction of travel", rtm->zone().name);
  std::vector<VirtualRun> results(arguments.runs);
  adapters::ThreadPool workers{std::min<std::size_t>(threads_for(arguments), arguments.runs)};
  workers.for_each(results.size(),
                   [&](std::size_t index) { results[index] = virtual_run(arguments, *rtm, algorithms, index); });
  MovedRuns moved;
  for (std::size_t index = 0; index < results.size(); ++index) {
    VirtualRun& one = results[index];
    if (one.error) return tl::unexpected(*one.error);
    moved.runs.push_back(std::move(one.runs.front()));
    moved.steps[index] = std::move(one.steps.begin()->second);
    if (index == 0) moved.calls = std::move(one.calls);
  }
  for (auto& one : candidates) one = experiments::on_board(one.name, one.what, moved.runs);
  Runs runs;
  runs.count = moved.runs.size();
  runs.on_track = true;
  runs.conditions = {arguments.command, "virtual time on " + rtm->zone().name + ", predict then move", {}, {}};
  runs.conditions.settings = {{"zone", rtm->zone().name},
                              {"vehicle", "the on-board program of an AIV, with emulated boards"},
                              {"ground_truth", experiments::GroundTruthSource{}.name()},
                              {"seeds", "from " + std::to_string(arguments.seed)}};
  add_moves(arguments, moved, algorithms, runs);
  return runs;
}

}  // namespace

Result<std::vector<std::string>> moving_algorithms(const QualifyArguments& arguments,
                                                   const std::vector<experiments::Candidate>& candidates) {
  using Options = experiments::PredictThenMoveOptions;
  if (!(arguments.step_m >= Options::step_m_min && arguments.step_m <= wire::EstimateRequest::move_m_max))
    return fail("qualify.step", "a move is from 0.02 to 10 m", "--step " + decimals(arguments.step_m, 3));
  if (!(arguments.distance_m > 0.0)) return fail("qualify.distance", "a distance must be more than 0", "--distance");
  const estimation::Registry registry;
  std::vector<std::string> names;
  for (const auto& one : candidates) {
    if (one.backtracks || !registry.find(one.name))
      return fail("qualify.mode",
                  "predict-then-move estimates on board, before each move: smoothers and other programs cannot",
                  one.name);
    names.push_back(one.name);
  }
  if (names.size() > wire::EstimateRequest::algorithms_max)
    return fail("qualify.mode", "on board there are at most 16 algorithms", std::to_string(names.size()));
  return names;
}

experiments::PredictThenMoveOptions move_options(const QualifyArguments& arguments,
                                                 std::vector<std::string> algorithms) {
  experiments::PredictThenMoveOptions options;
  options.runs = arguments.runs;
  options.distance_m = arguments.distance_m;
  options.step_m = arguments.step_m;
  options.algorithms = std::move(algorithms);
  options.seed = arguments.seed;
  options.particles = arguments.particles;
  options.horizon = arguments.horizon;
  options.timeout = from_seconds(arguments.timeout_s);
  return options;
}

void add_moves(const QualifyArguments& arguments, const MovedRuns& moved, const std::vector<std::string>& algorithms,
               Runs& runs) {
  auto& settings = runs.conditions.settings;
  settings.emplace_back("mode", "predict then move: each estimate is of the position after the next move");
  settings.emplace_back("move", decimals(arguments.step_m, 3) + " m");
  settings.emplace_back("distance of each run", decimals(arguments.distance_m, 1) + " m");
  runs.conditions.diagnostics.emplace_back(
      "An error contains the deviation of the move from its commanded distance, the same for all algorithms. There is "
      "no limit: the vehicle had not moved yet when it estimated.");
  runs.files.emplace_back("steps.csv", experiments::steps_csv(moved.steps, algorithms));
  runs.files.emplace_back("calls.txt", experiments::calls_text(moved.calls));
  auto kept = std::make_shared<std::vector<std::shared_ptr<const experiments::LiveRun>>>(moved.runs);
  runs.source = [kept = kept.get()](std::size_t index, experiments::Trial&) -> Result<const experiments::Trial*> {
    return &(*kept)[index]->trial;
  };
  runs.kept = std::move(kept);
}

int run_moves(const QualifyArguments& arguments, std::size_t at_least) {
  const estimation::Registry registry;
  auto usual = usual_algorithms(arguments, true, at_least);
  std::erase_if(usual, [&](const std::string& name) {
    const auto known = registry.find(name);
    return known && (*known)->backtracks;
  });
  auto candidates = candidates_of(arguments, registry, true, usual);
  if (!candidates) return report_error(candidates.error());
  if (candidates->size() < at_least)
    return report_error({"compare.few", "a comparison needs at least two", "algorithms"});
  const auto algorithms = moving_algorithms(arguments, *candidates);
  if (!algorithms) return report_error(algorithms.error());
  auto reference = reference_of(arguments);
  if (!reference) return report_error(reference.error());
  const auto runs = virtual_moves(arguments, *candidates, *algorithms);
  if (!runs) return report_error(runs.error());
  return evaluate(arguments, *candidates, *runs, std::move(*reference));
}

}  // namespace cosiva::app
