#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace cosiva {

/// A stream of random numbers that is the same on every machine. Streams of one run have different names, so that an
/// additional draw in one of them changes no other: Random{seed, "aiv3/odometry"}.
class Random {
 public:
  Random(std::uint64_t seed, std::string_view stream) noexcept;

  [[nodiscard]] std::uint64_t next() noexcept;                      ///< 64 uniform bits (xoshiro256**)
  [[nodiscard]] double uniform() noexcept;                          ///< in [0, 1)
  [[nodiscard]] double uniform(double low, double high) noexcept;   ///< in [low, high)
  [[nodiscard]] std::uint64_t below(std::uint64_t bound) noexcept;  ///< in [0, bound), bound ≥ 1
  [[nodiscard]] bool chance(double probability) noexcept;           ///< true with this probability
  [[nodiscard]] double gaussian() noexcept;                         ///< mean 0, standard deviation 1
  [[nodiscard]] double gaussian(double mean, double sd) noexcept { return mean + sd * gaussian(); }

 private:
  std::array<std::uint64_t, 4> state_;
  double spare_{};
  bool has_spare_{false};
};

}  // namespace cosiva
