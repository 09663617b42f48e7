#pragma once

#include <memory>

#include "base/ranks.h"
#include "base/result.h"

namespace cosiva::app {

/// All that mpirun or Slurm has started together with us; one where neither has. Fails ("mpi.missing") where they have,
/// and this build has no MPI.
[[nodiscard]] Result<std::unique_ptr<Ranks>> start_ranks();

}  // namespace cosiva::app
