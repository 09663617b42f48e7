#pragma once

#include <memory>
#include <string>
#include <vector>

#include "cosiva/aiv/estimation/registry.h"
#include "cosiva/app/positioning/qualify_arguments.h"
#include "cosiva/experiments/positioning/metrology/qualification.h"
#include "cosiva/experiments/positioning/metrology/result.h"

namespace cosiva::app {

/// Those that were asked for, by name or as programs; where nobody was, those that suit. Fails ("algorithm.unknown"),
/// ("algorithm.external") on what is not NAME=COMMAND, ("algorithm.duplicate").
/// @param on_track  there is a line to follow
/// @param usual     what is taken where no names are given
[[nodiscard]] Result<std::vector<experiments::Candidate>> candidates_of(const QualifyArguments& arguments,
                                                                        const estimation::Registry& registry,
                                                                        bool on_track,
                                                                        const std::vector<std::string>& usual);

/// How many `--threads` asks for: without it as many as there are cores.
[[nodiscard]] std::size_t threads_for(const QualifyArguments& arguments);
/// What `--align` asks for.
[[nodiscard]] experiments::Alignment alignment_of(const QualifyArguments& arguments);

/// Of `--reference-budget` or `--reference-error`; nothing where neither is given. Fails as reading does, and
/// ("compare.reference") where both are.
[[nodiscard]] Result<experiments::ReferenceBudget> reference_of(const QualifyArguments& arguments);

/// What is taken where nobody was named: one that suits to qualify, or all that it makes sense to compare.
[[nodiscard]] std::vector<std::string> usual_algorithms(const QualifyArguments& arguments, bool on_track,
                                                        std::size_t at_least);

/// Where runs come from: made in virtual time, read from folders, or lived on a platform that runs.
struct Runs {
  experiments::TrialSource source;
  std::size_t count{};
  bool on_track{};
  bool complete{true};  ///< as many as were asked for
  experiments::Conditions conditions;
  std::shared_ptr<void> kept;  ///< what the source refers to
};
[[nodiscard]] Result<Runs> virtual_runs(const QualifyArguments& arguments);
[[nodiscard]] Result<Runs> recorded_runs(const QualifyArguments& arguments);

/// Qualifies the candidates on the runs, prints and writes what is found. Gives the exit status.
int judge(const QualifyArguments& arguments, const std::vector<experiments::Candidate>& candidates, const Runs& runs,
          experiments::ReferenceBudget reference);

/// Of `--reference` and `--estimate`: figures of trajectories that others have estimated.
int run_trajectories(const QualifyArguments& arguments);

}  // namespace cosiva::app
