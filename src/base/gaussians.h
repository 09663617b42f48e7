#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "cosiva/base/random.h"

namespace cosiva {

/// The draws of Random{seed, stream}.gaussian(), to the bit, computed many at a time: a single draw would wait for its
/// logarithm.
class Gaussians {
 public:
  Gaussians(std::uint64_t seed, std::string_view stream) noexcept : random_{seed, stream} {}

  [[nodiscard]] double next() noexcept {
    if (at_ == made_.size()) make();
    return made_[at_++];
  }
  [[nodiscard]] double next(double mean, double sd) noexcept { return mean + sd * next(); }

 private:
  void make() noexcept;

  Random random_;
  std::array<double, 64> made_{};
  std::size_t at_{made_.size()};
};

}  // namespace cosiva
