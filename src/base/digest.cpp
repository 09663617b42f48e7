#include "cosiva/base/digest.h"

#include <cstring>

namespace cosiva {

void Digest::add(std::string_view bytes) noexcept {
  add(static_cast<std::uint64_t>(bytes.size()));
  // Words of eight bytes, little-endian on every machine.
  for (; bytes.size() >= 8; bytes.remove_prefix(8)) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes.data(), 8);
    if constexpr (std::endian::native == std::endian::big) word = __builtin_bswap64(word);
    add(word);
  }
  if (bytes.empty()) return;
  std::uint64_t word = 0;
  for (unsigned i = 0; i < bytes.size(); ++i)
    word |= static_cast<std::uint64_t>(static_cast<unsigned char>(bytes[i])) << (8U * i);
  add(word);
}

std::string Digest::hex() const {
  static constexpr char digits[] = "0123456789abcdef";
  std::string text(16, '0');
  for (unsigned i = 0; i < 16; ++i) text[i] = digits[(state_ >> (60U - 4U * i)) & 0xFU];
  return text;
}

}  // namespace cosiva
