#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <string_view>

#include "cosiva/base/archive_fwd.h"

namespace cosiva {

/// A stream of random numbers that is the same on every machine. Streams of one run have different names, so that an
/// additional draw in one of them changes no other: Random{seed, "aiv3/odometry"}.
class Random {
 public:
  Random(std::uint64_t seed, std::string_view stream) noexcept;

  /// 64 uniform bits (xoshiro256**).
  [[nodiscard]] std::uint64_t next() noexcept {
    auto& s = state_;
    const std::uint64_t result = std::rotl(s[1] * 5, 7) * 9;
    const std::uint64_t t = s[1] << 17U;
    s[2] ^= s[0];
    s[3] ^= s[1];
    s[1] ^= s[2];
    s[0] ^= s[3];
    s[2] ^= t;
    s[3] = std::rotl(s[3], 45);
    return result;
  }
  /// In [0, 1).
  [[nodiscard]] double uniform() noexcept { return static_cast<double>(next() >> 11U) * 0x1.0p-53; }
  [[nodiscard]] double uniform(double low, double high) noexcept;   ///< in [low, high)
  [[nodiscard]] std::uint64_t below(std::uint64_t bound) noexcept;  ///< in [0, bound), bound ≥ 1
  [[nodiscard]] bool chance(double probability) noexcept { return uniform() < probability; }
  [[nodiscard]] double gaussian() noexcept;  ///< mean 0, standard deviation 1
  [[nodiscard]] double gaussian(double mean, double sd) noexcept { return mean + sd * gaussian(); }
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  std::array<std::uint64_t, 4> state_;
  double spare_{};
  bool has_spare_{false};
};

}  // namespace cosiva
