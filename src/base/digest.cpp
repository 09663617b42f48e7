#include "base/digest.h"

namespace cosiva {

void Digest::add(std::string_view bytes) noexcept {
  add(static_cast<std::uint64_t>(bytes.size()));
  std::uint64_t word = 0;
  unsigned filled = 0;
  for (const char c : bytes) {
    word |= static_cast<std::uint64_t>(static_cast<unsigned char>(c)) << (8U * filled);
    if (++filled == 8) {
      add(word);
      word = 0;
      filled = 0;
    }
  }
  if (filled != 0) add(word);
}

std::string Digest::hex() const {
  static constexpr char digits[] = "0123456789abcdef";
  std::string text(16, '0');
  for (unsigned i = 0; i < 16; ++i) text[i] = digits[(state_ >> (60U - 4U * i)) & 0xFU];
  return text;
}

}  // namespace cosiva
