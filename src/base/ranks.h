#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace cosiva {

/// Processes that do one job together, maybe on many machines. A core that could be spread over them takes one of these
/// instead of knowing how they talk; how many there are must not change what comes out.
class Ranks {
 public:
  virtual ~Ranks() = default;

  [[nodiscard]] virtual std::size_t rank() const = 0;  ///< which of them this process is, from 0
  [[nodiscard]] virtual std::size_t size() const = 0;
  /// Sends letters[r] to rank r and returns what each rank has sent to this one, in their order. All of them call it,
  /// the same number of times; it returns when all have.
  /// @param letters  size() of them, of any bytes, at most 2³¹ − 1 in all
  [[nodiscard]] virtual std::vector<std::string> exchange(std::vector<std::string> messages) = 0;
};

/// One process that does everything itself.
class OneRank final : public Ranks {
 public:
  [[nodiscard]] std::size_t rank() const override { return 0; }
  [[nodiscard]] std::size_t size() const override { return 1; }
  [[nodiscard]] std::vector<std::string> exchange(std::vector<std::string> messages) override { return messages; }
};

}  // namespace cosiva
