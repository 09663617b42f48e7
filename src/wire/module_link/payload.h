#pragma once

#include <array>
#include <concepts>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <type_traits>

#include "cosiva/base/expect.h"
#include "cosiva/base/result.h"
#include "cosiva/wire/messages/board.h"

namespace cosiva::wire::module_link {

/// Writes little-endian integers one after the other into a fixed buffer.
class PayloadWriter {
 public:
  explicit PayloadWriter(std::span<std::uint8_t> buffer) : buffer_{buffer} {}

  template <std::integral T>
  void put(T value) {
    COSIVA_EXPECT(size_ + sizeof(T) <= buffer_.size());
    auto bits = static_cast<std::make_unsigned_t<T>>(value);
    for (std::size_t i = 0; i < sizeof(T); ++i) {
      buffer_[size_++] = static_cast<std::uint8_t>(bits & 0xFFU);
      if constexpr (sizeof(T) > 1) bits = static_cast<std::make_unsigned_t<T>>(bits >> 8U);
    }
  }
  [[nodiscard]] std::size_t size() const { return size_; }

 private:
  std::span<std::uint8_t> buffer_;
  std::size_t size_{0};
};

/// Reads little-endian integers; the caller has checked the length.
class PayloadReader {
 public:
  explicit PayloadReader(std::span<const std::uint8_t> bytes) : bytes_{bytes} {}

  template <std::integral T>
  [[nodiscard]] T take() {
    COSIVA_EXPECT(sizeof(T) <= bytes_.size());
    std::uint64_t bits = 0;
    for (std::size_t i = sizeof(T); i-- > 0;) bits = bits << 8U | bytes_[i];
    bytes_ = bytes_.subspan(sizeof(T));
    return static_cast<T>(bits);
  }

 private:
  std::span<const std::uint8_t> bytes_;
};

/// The message's number in the frame's first byte: its index in BoardMessage, from 1. Never reuse a number.
[[nodiscard]] inline std::uint8_t type_number(const BoardMessage& message) {
  return static_cast<std::uint8_t>(message.index() + 1);
}

/// Length of the longest beginning of `text` within 32 bytes that cuts no UTF-8 character in two.
[[nodiscard]] std::size_t display_bytes(std::string_view text);

void write_payload(PayloadWriter& out, const BoardMessage& message);

/// Errors: link.type, link.length, link.value.
[[nodiscard]] Result<BoardMessage> read_payload(std::uint8_t type, std::span<const std::uint8_t> payload);

}  // namespace cosiva::wire::module_link
