#include "cosiva/app/resources/ranks.h"

#include <dlfcn.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <thread>

namespace cosiva::app {
namespace {

/// Each launcher publishes the number of started processes in its own environment variable.
bool has_sidecars() {
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMIX_SIZE", "SLURM_STEP_NUM_TASKS"}) {
    const char* const count = std::getenv(name);
    if (count != nullptr && std::atol(count) > 1) return true;
  }
  return false;
}

}  // namespace

std::size_t threads_for_each_rank() {
  // Where the launcher has bound each process to cores of its own, only those cores are counted here.
  const std::size_t cores = std::max(1U, std::thread::hardware_concurrency());
  for (const char* name : {"OMPI_COMM_WORLD_LOCAL_SIZE", "MPI_LOCALNRANKS", "SLURM_NTASKS_PER_NODE"}) {
    const char* const count = std::getenv(name);
    if (count != nullptr && std::atol(count) > 1)
      return std::max<std::size_t>(1, cores / static_cast<std::size_t>(std::atol(count)));
  }
  return cores;
}

Result<std::unique_ptr<Ranks>> start_ranks() {
  if (!has_sidecars()) return std::make_unique<OneRank>();
  std::error_code error;
  const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", error);
  const std::string library = (self.parent_path() / "cosiva_mpi.so").string();
  // The library stays open: MPI cannot be closed and reopened.
  void* const opened = dlopen(library.c_str(), RTLD_NOW | RTLD_GLOBAL);
  if (opened == nullptr) {
    const char* const why = dlerror();
    return fail("mpi.missing",
                std::string("several processes were started together, but MPI is not available: ") +
                    (why != nullptr ? why : "no reason given") +
                    "; is libopenmpi-dev installed and cosiva built since?",
                library);
  }
  using Start = Ranks* (*)();
  const auto start = reinterpret_cast<Start>(dlsym(opened, "cosiva_start_ranks"));
  if (start == nullptr) return fail("mpi.missing", "the library for MPI is of another version", library);
  return std::unique_ptr<Ranks>{start()};
}

}  // namespace cosiva::app
