#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

/// Integers in files, little endian on every machine.
namespace cosiva::journal {

template <typename T>
void append_integer(std::string& out, T value) {
  const auto bits = static_cast<std::uint64_t>(value);
  for (unsigned i = 0; i < sizeof(T); ++i) out += static_cast<char>((bits >> (8U * i)) & 0xFFU);
}

/// The integer at an offset; the bytes must contain it.
template <typename T>
[[nodiscard]] T integer_at(std::string_view bytes, std::size_t at) {
  std::uint64_t bits = 0;
  for (unsigned i = 0; i < sizeof(T); ++i)
    bits |= static_cast<std::uint64_t>(static_cast<unsigned char>(bytes[at + i])) << (8U * i);
  return static_cast<T>(bits);
}

}  // namespace cosiva::journal
