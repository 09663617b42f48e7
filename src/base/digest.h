#pragma once

#include <bit>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "cosiva/base/time.h"

namespace cosiva {

/// A 64-bit hash over all events of a run: equal runs give equal digests. A digest proves identity, not correctness.
class Digest {
 public:
  void add(std::uint64_t value) noexcept {
    // One round of a multiply-rotate mix per word; the order matters, as required for a run's history.
    state_ = std::rotl(state_ ^ (value * 0x9E3779B97F4A7C15ULL), 29) * 0xBF58476D1CE4E5B9ULL;
  }
  void add(std::int64_t value) noexcept { add(static_cast<std::uint64_t>(value)); }
  void add(double value) noexcept { add(std::bit_cast<std::uint64_t>(value)); }
  void add(SimTime time) noexcept { add(static_cast<std::uint64_t>(time.time_since_epoch().count())); }
  void add(std::string_view bytes) noexcept {
    add(static_cast<std::uint64_t>(bytes.size()));
    if (!bytes.empty()) add_bytes(bytes);
  }

  [[nodiscard]] std::uint64_t value() const noexcept { return state_; }
  [[nodiscard]] std::string hex() const;  ///< 16 lower-case digits
  friend bool operator==(const Digest&, const Digest&) = default;

 private:
  void add_bytes(std::string_view bytes) noexcept;

  std::uint64_t state_{0x6A09E667F3BCC908ULL};
};

}  // namespace cosiva
