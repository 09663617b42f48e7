#pragma once

#include <sodium/crypto_generichash.h>

#include <array>
#include <string>
#include <string_view>

namespace cosiva::journal {

/// The hash over everything that a store has held up to some record: BLAKE2b-256 of the hash before and of the batch
/// that follows. A record that is changed, removed or inserted changes every later hash.
class Chain {
 public:
  static constexpr std::size_t bytes_count = 32;

  /// Before the first record: zeros.
  Chain() = default;
  /// From its bytes, of which there are bytes_count.
  [[nodiscard]] static Chain from(std::string_view bytes);
  /// The hash after a batch of these bytes.
  [[nodiscard]] Chain after(std::string_view batch) const;

  [[nodiscard]] std::string_view bytes() const;
  /// 64 hexadecimal digits.
  [[nodiscard]] std::string hex() const;
  friend bool operator==(const Chain&, const Chain&) = default;

 private:
  std::array<char, bytes_count> hash_{};
};

/// The hash after a batch that is given part by part.
///
/// Invariant: the state has taken the hash before, and all parts in their order.
class ChainHash {
 public:
  explicit ChainHash(const Chain& before);
  void add(std::string_view part);
  /// Of all parts. Ends this hash.
  [[nodiscard]] Chain end();

 private:
  crypto_generichash_state state_;
};

}  // namespace cosiva::journal
