#pragma once

#include <string>
#include <vector>

#include "cosiva/aiv/estimation/registry.h"
#include "cosiva/app/positioning/qualify_arguments.h"
#include "cosiva/experiments/positioning/metrology/qualification.h"

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

}  // namespace cosiva::app
