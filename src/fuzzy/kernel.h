#pragma once

#include <cstddef>

#include "cosiva/fuzzy/program.h"

namespace cosiva::fuzzy {

/// Decisions that are taken side by side: enough for the widest vectors, few enough that a usual
/// rule base's values stay in the processor's first cache.
inline constexpr std::size_t lanes = 64;

/// Runs the program for one decision. The inputs stand in the first of program.values values.
void run_one(const Program& program, double* values);
/// The same for `lanes` decisions, bit for bit; value i of decision k stands at [i][k].
void run_lanes(const Program& program, double (*values)[lanes]);

}  // namespace cosiva::fuzzy
