#pragma once

#include <array>
#include <memory>
#include <string>
#include <string_view>

struct XXH3_state_s;

namespace cosiva::journal {

/// The hash over everything that a store has held up to some record: BLAKE2b-256 of the hash before, of the header of
/// the batch that follows, and of the XXH3-128 of its records. A record that is changed, removed or inserted changes
/// every later hash. BLAKE2b of the records themselves, as in format 1, is slower than a disk.
class Chain {
 public:
  static constexpr std::size_t bytes_count = 32;

  /// Before the first record: zeros.
  Chain() = default;
  /// From its bytes, of which there are bytes_count.
  [[nodiscard]] static Chain from(std::string_view bytes);
  /// The hash after a batch of this header and these records.
  [[nodiscard]] Chain after(std::string_view header, std::string_view records) const;
  /// The same in segments of format 1: BLAKE2b-256 of the hash before, of the header and of the records.
  [[nodiscard]] Chain after_in_format_1(std::string_view header, std::string_view records) const;

  [[nodiscard]] std::string_view bytes() const;
  /// 64 hexadecimal digits.
  [[nodiscard]] std::string hex() const;
  friend bool operator==(const Chain&, const Chain&) = default;

 private:
  std::array<char, bytes_count> hash_{};
};

/// The hash after a batch whose records are given part by part, while each is in the processor's cache.
///
/// Invariant: the state has taken all parts in their order.
class ChainHash {
 public:
  ChainHash(const Chain& before, std::string_view header);
  void add(std::string_view records);
  [[nodiscard]] Chain end() const;

 private:
  struct Free {
    void operator()(XXH3_state_s* state) const;
  };
  Chain before_;
  std::string header_;
  std::unique_ptr<XXH3_state_s, Free> state_;
};

}  // namespace cosiva::journal
