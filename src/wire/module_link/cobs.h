#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace cosiva::wire::module_link {

/// Longest content of a frame, before COBS: under 254 bytes COBS adds exactly one byte, so no 0xFF code ever occurs.
inline constexpr std::size_t content_bytes_max = 126;

/// Consistent Overhead Byte Stuffing: appends `content` without its zeros, one byte longer, and no delimiter.
/// @param content  at most content_bytes_max bytes (checked)
void append_cobs(std::string& out, std::span<const std::uint8_t> content);

/// The content of a frame without its delimiter; nothing where the codes do not end with the frame or the frame holds a
/// zero.
struct Content {
  std::array<std::uint8_t, content_bytes_max> bytes;
  std::size_t size;
  [[nodiscard]] std::span<const std::uint8_t> view() const { return {bytes.data(), size}; }
};
[[nodiscard]] std::optional<Content> from_cobs(std::string_view frame);

}  // namespace cosiva::wire::module_link
