#pragma once

#include <cstddef>
#include <memory>

#include "cosiva/base/ranks.h"
#include "cosiva/base/result.h"

namespace cosiva::app {

/// All processes that mpirun or Slurm has started together with this one; one rank where neither has. Fails
/// ("mpi.missing") where there are several processes, and this build has no MPI.
[[nodiscard]] Result<std::unique_ptr<Ranks>> start_ranks();

/// How many threads each of them should use so that together they use all available cores of this machine; at least
/// one.
[[nodiscard]] std::size_t threads_for_each_rank();

}  // namespace cosiva::app
