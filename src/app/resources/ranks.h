#pragma once

#include <cstddef>
#include <memory>

#include "cosiva/base/ranks.h"
#include "cosiva/base/result.h"

namespace cosiva::app {

/// All that mpirun or Slurm has started together with us; one where neither has. Fails ("mpi.missing") where they have,
/// and this build has no MPI.
[[nodiscard]] Result<std::unique_ptr<Ranks>> start_ranks();

/// How many threads each of them should use so that together they use all cores of this machine that they may; at least
/// one.
[[nodiscard]] std::size_t threads_for_each_rank();

}  // namespace cosiva::app
