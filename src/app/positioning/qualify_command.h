#pragma once

#include <vector>

#include "cosiva/app/positioning/qualify_arguments.h"
#include "cosiva/app/positioning/qualify_runs.h"
#include "cosiva/experiments/positioning/metrology/qualification.h"

namespace cosiva::app {

/// `cosiva qualify` and `cosiva compare`. Each gives the exit status: 0 done, 1 the run's own checks failed, 2 bad
/// usage or bad input.
int run_qualify(const QualifyArguments& arguments);
int run_compare(const QualifyArguments& arguments);

/// Qualifies the candidates on the runs, prints and writes the results. Gives the exit status.
int evaluate(const QualifyArguments& arguments, const std::vector<experiments::Candidate>& candidates, const Runs& runs,
             experiments::ReferenceBudget reference);

}  // namespace cosiva::app
