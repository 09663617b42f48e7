#include "cosiva/base/digest.h"

#include <cstring>

namespace cosiva {
namespace {

/// A word of eight bytes, little-endian on every machine.
std::uint64_t word_at(const char* bytes) {
  std::uint64_t word = 0;
  std::memcpy(&word, bytes, 8);
  if constexpr (std::endian::native == std::endian::big) word = __builtin_bswap64(word);
  return word;
}

}  // namespace

void Digest::add(std::string_view bytes) noexcept {
  add(static_cast<std::uint64_t>(bytes.size()));
  const bool fills_word = bytes.size() >= 8;
  for (; bytes.size() >= 8; bytes.remove_prefix(8)) add(word_at(bytes.data()));
  if (bytes.empty()) return;
  // The bytes before the last ones are there to be read, and shifted out.
  if (fills_word) return add(word_at(bytes.data() + bytes.size() - 8) >> (64U - 8U * bytes.size()));
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
