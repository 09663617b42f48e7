#pragma once

#include <string>
#include <vector>

#include "cosiva/aiv/estimation/registry.h"
#include "cosiva/app/positioning/qualify_arguments.h"
#include "cosiva/experiments/positioning/metrology/qualification.h"

namespace cosiva::app {

/// The requested algorithms, by name or as programs; without any, the suitable ones. Fails ("algorithm.unknown"),
/// ("algorithm.external") on what is not NAME=COMMAND, ("algorithm.duplicate").
/// @param on_track  there is a path to follow
/// @param usual     the algorithms that are used where no names are given
[[nodiscard]] Result<std::vector<experiments::Candidate>> candidates_of(const QualifyArguments& arguments,
                                                                        const estimation::Registry& registry,
                                                                        bool on_track,
                                                                        const std::vector<std::string>& usual);

/// The number of threads that `--threads` requests; without the option, one per core.
[[nodiscard]] std::size_t threads_for(const QualifyArguments& arguments);
/// The alignment that `--align` requests.
[[nodiscard]] experiments::Alignment alignment_of(const QualifyArguments& arguments);

/// The budget of `--reference-budget` or `--reference-error`; empty where neither is given. Fails as reading does, and
/// ("compare.reference") where both are given.
[[nodiscard]] Result<experiments::ReferenceBudget> reference_of(const QualifyArguments& arguments);

/// The algorithms that are used where none is named: one that suits to qualify, or all that can be compared reasonably.
[[nodiscard]] std::vector<std::string> usual_algorithms(const QualifyArguments& arguments, bool on_track,
                                                        std::size_t at_least);

}  // namespace cosiva::app
