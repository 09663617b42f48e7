#include "cosiva/wire/module_link/cobs.h"

#include "cosiva/base/expect.h"

namespace cosiva::wire::module_link {

void append_cobs(std::string& out, std::span<const std::uint8_t> content) {
  COSIVA_EXPECT(content.size() <= content_bytes_max);
  std::array<char, content_bytes_max + 1> stuffed;  // written below, up to `end`
  std::size_t code_at = 0;
  std::size_t end = 1;
  for (const std::uint8_t byte : content) {
    if (byte == 0) {
      stuffed[code_at] = static_cast<char>(end - code_at);
      code_at = end;
    } else {
      stuffed[end] = static_cast<char>(byte);
    }
    ++end;
  }
  stuffed[code_at] = static_cast<char>(end - code_at);
  out.append(stuffed.data(), end);
}

std::optional<Content> from_cobs(std::string_view frame) {
  if (frame.empty() || frame.size() > content_bytes_max + 1) return std::nullopt;
  Content content;  // its bytes are written below, up to size
  content.size = 0;
  for (std::size_t at = 0; at < frame.size();) {
    const auto code = static_cast<std::uint8_t>(frame[at]);
    if (code == 0 || at + code > frame.size()) return std::nullopt;
    for (std::size_t i = at + 1; i < at + code; ++i) {
      if (frame[i] == '\0') return std::nullopt;
      content.bytes[content.size++] = static_cast<std::uint8_t>(frame[i]);
    }
    at += code;
    if (at < frame.size()) content.bytes[content.size++] = 0;
  }
  return content;
}

}  // namespace cosiva::wire::module_link
