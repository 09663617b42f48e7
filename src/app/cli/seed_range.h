#pragma once

#include <cstdint>
#include <string_view>

#include "cosiva/base/result.h"

namespace cosiva::app {

struct SeedRange {
  std::uint64_t first;
  std::uint64_t last;  ///< >= first
  [[nodiscard]] std::uint64_t count() const { return last - first + 1; }
};

/// "7" or "1..200". Fails with `code` on anything else, and on more than ten million seeds.
[[nodiscard]] Result<SeedRange> read_seed_range(std::string_view text, std::string_view option, std::string_view code);

}  // namespace cosiva::app
