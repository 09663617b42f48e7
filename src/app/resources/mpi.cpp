// The ranks of an MPI run, as a separate library that is opened only where mpirun or Slurm has started the process: a
// command linked with MPI would take 10 ms longer to start, each time.
#include <mpi.h>

#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/base/ranks.h"

namespace {

/// MPI's own error handler stays installed: the handler ends all ranks with a message, because no rank can continue
/// alone.
class MpiRanks final : public cosiva::Ranks {
 public:
  MpiRanks() {
    MPI_Init(nullptr, nullptr);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
    MPI_Comm_size(MPI_COMM_WORLD, &size_);
  }
  MpiRanks(const MpiRanks&) = delete;
  MpiRanks& operator=(const MpiRanks&) = delete;
  ~MpiRanks() override { MPI_Finalize(); }

  [[nodiscard]] std::size_t rank() const override { return static_cast<std::size_t>(rank_); }
  [[nodiscard]] std::size_t size() const override { return static_cast<std::size_t>(size_); }

  [[nodiscard]] std::vector<std::string> exchange(std::vector<std::string> messages) override {
    Box out{size()};
    std::string sent;
    for (std::size_t r = 0; r < size(); ++r) {
      out.sizes[r] = static_cast<int>(messages[r].size());
      sent += messages[r];
    }
    Box in{size()};
    MPI_Alltoall(out.sizes.data(), 1, MPI_INT, in.sizes.data(), 1, MPI_INT, MPI_COMM_WORLD);
    std::string got(static_cast<std::size_t>(std::accumulate(in.sizes.begin(), in.sizes.end(), 0)), '\0');
    MPI_Alltoallv(sent.data(), out.sizes.data(), out.starts(), MPI_CHAR, got.data(), in.sizes.data(), in.starts(),
                  MPI_CHAR, MPI_COMM_WORLD);
    for (std::size_t r = 0; r < size(); ++r)
      messages[r] = got.substr(static_cast<std::size_t>(in.at[r]), static_cast<std::size_t>(in.sizes[r]));
    return messages;
  }

 private:
  /// Sizes and offsets of the ranks' messages in the joint buffer, as MPI expects them.
  struct Box {
    explicit Box(std::size_t count) : sizes(count), at(count) {}
    const int* starts() {
      std::exclusive_scan(sizes.begin(), sizes.end(), at.begin(), 0);
      return at.data();
    }
    std::vector<int> sizes;
    std::vector<int> at;
  };

  int rank_{0};
  int size_{1};
};

}  // namespace

extern "C" cosiva::Ranks* cosiva_start_ranks();
/// The caller owns the result, and deletes it before the program ends.
extern "C" cosiva::Ranks* cosiva_start_ranks() { return new MpiRanks; }
