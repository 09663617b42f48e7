#pragma once

#include <memory>
#include <string>
#include <vector>

#include "cosiva/app/positioning/qualify_arguments.h"
#include "cosiva/app/positioning/qualify_runs.h"
#include "cosiva/experiments/positioning/metrology/live_run.h"
#include "cosiva/experiments/positioning/metrology/qualification.h"
#include "cosiva/experiments/positioning/moves/predict_then_move.h"

/// `--mode predict-then-move`: figures 16 and 17 with the simulator as the pivot, in virtual time and live.
namespace cosiva::app {

/// In virtual time: the whole platform with one AIV per run. Gives the exit status.
/// @param at_least  minimum number of algorithms
int run_moves(const QualifyArguments& arguments, std::size_t at_least);

/// The algorithms on board; those of a predict-then-move test are all on board. Fails ("qualify.mode") on an algorithm
/// that a vehicle cannot run, and on a step out of range.
[[nodiscard]] Result<std::vector<std::string>> moving_algorithms(const QualifyArguments& arguments,
                                                                 const std::vector<experiments::Candidate>& candidates);
/// The options of a test without its vehicles, speed and name.
[[nodiscard]] experiments::PredictThenMoveOptions move_options(const QualifyArguments& arguments,
                                                               std::vector<std::string> algorithms);

/// The complete runs of a predict-then-move test for their evaluation.
struct MovedRuns {
  std::vector<std::shared_ptr<const experiments::LiveRun>> runs;
  experiments::MoveStepsByRun steps;
  std::vector<experiments::Call> calls;  ///< of the first run
};
/// Steps and calls as files, and the settings that every such test states.
void add_moves(const QualifyArguments& arguments, const MovedRuns& moved, const std::vector<std::string>& algorithms,
               Runs& runs);

}  // namespace cosiva::app
