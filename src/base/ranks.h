#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace cosiva {

/// Processes that do one job together, possibly on many machines. A core that can be distributed uses this interface
/// instead of a communication library; the number of processes must not change the result.
class Ranks {
 public:
  virtual ~Ranks() = default;

  [[nodiscard]] virtual std::size_t rank() const = 0;  ///< index of this process, from 0
  [[nodiscard]] virtual std::size_t size() const = 0;
  /// Sends messages[r] to rank r and returns the messages of all ranks to this one, in the order of ranks. All ranks
  /// must call it, the same number of times; the call returns when all ranks have called it. @param messages  size() of
  /// them, of any bytes, at most 2³¹ − 1 in all
  [[nodiscard]] virtual std::vector<std::string> exchange(std::vector<std::string> messages) = 0;
};

/// A single process that does the whole job.
class OneRank final : public Ranks {
 public:
  [[nodiscard]] std::size_t rank() const override { return 0; }
  [[nodiscard]] std::size_t size() const override { return 1; }
  [[nodiscard]] std::vector<std::string> exchange(std::vector<std::string> messages) override { return messages; }
};

}  // namespace cosiva
