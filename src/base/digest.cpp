#include "cosiva/base/digest.h"

#include <cstring>

namespace cosiva {
namespace {

/// Little-endian on every machine.
template <typename Word>
std::uint64_t word_at(const char* bytes) {
  Word word = 0;
  std::memcpy(&word, bytes, sizeof(Word));
  if constexpr (std::endian::native == std::endian::little) return word;
  return __builtin_bswap64(word) >> (64U - 8U * sizeof(Word));
}

/// Of one to seven bytes, the first one lowest: read in two or three parts that may have bytes in common.
std::uint64_t short_word(std::string_view bytes) {
  const std::size_t size = bytes.size();
  if (size >= 4)
    return word_at<std::uint32_t>(bytes.data()) | word_at<std::uint32_t>(bytes.data() + size - 4) << (8U * (size - 4));
  const auto at = [&](std::size_t i) {
    return static_cast<std::uint64_t>(static_cast<unsigned char>(bytes[i])) << (8U * i);
  };
  return at(0) | at(size / 2) | at(size - 1);
}

}  // namespace

void Digest::add_bytes(std::string_view bytes) noexcept {
  if (bytes.size() < 8) return add(short_word(bytes));
  for (; bytes.size() >= 8; bytes.remove_prefix(8)) add(word_at<std::uint64_t>(bytes.data()));
  if (bytes.empty()) return;
  // The bytes before the last ones are there to be read, and shifted out.
  add(word_at<std::uint64_t>(bytes.data() + bytes.size() - 8) >> (64U - 8U * bytes.size()));
}

std::string Digest::hex() const {
  static constexpr char digits[] = "0123456789abcdef";
  std::string text(16, '0');
  for (unsigned i = 0; i < 16; ++i) text[i] = digits[(state_ >> (60U - 4U * i)) & 0xFU];
  return text;
}

}  // namespace cosiva
