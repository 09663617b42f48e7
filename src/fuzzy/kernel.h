#pragma once

#include <cstddef>

#include "cosiva/fuzzy/program.h"

namespace cosiva::fuzzy {

/// Number of decisions computed side by side: enough for the widest vectors, few enough that a usual rule base's values
/// stay in the processor's first-level cache.
inline constexpr std::size_t lanes = 64;

/// Runs the program for one decision. The inputs are the first of program.values values.
void run_one(const Program& program, double* values);
/// The same for `lanes` decisions, bit for bit; value i of decision k is at [i][k].
void run_lanes(const Program& program, double (*values)[lanes]);

}  // namespace cosiva::fuzzy
