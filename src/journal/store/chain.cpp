#include "cosiva/journal/store/chain.h"

#include <sodium/crypto_generichash.h>

#include <algorithm>

#include "cosiva/base/expect.h"

namespace cosiva::journal {
namespace {

const unsigned char* octets(std::string_view bytes) { return reinterpret_cast<const unsigned char*>(bytes.data()); }

}  // namespace

Chain Chain::from(std::string_view bytes) {
  COSIVA_EXPECT(bytes.size() == bytes_count);
  Chain chain;
  std::copy(bytes.begin(), bytes.end(), chain.hash_.begin());
  return chain;
}

Chain Chain::after(std::initializer_list<std::string_view> parts) const {
  crypto_generichash_state state;
  crypto_generichash_init(&state, nullptr, 0, bytes_count);
  crypto_generichash_update(&state, octets(bytes()), bytes_count);
  for (const std::string_view part : parts) crypto_generichash_update(&state, octets(part), part.size());
  Chain next;
  crypto_generichash_final(&state, reinterpret_cast<unsigned char*>(next.hash_.data()), bytes_count);
  return next;
}

std::string_view Chain::bytes() const { return {hash_.data(), hash_.size()}; }

std::string Chain::hex() const {
  constexpr std::string_view digits = "0123456789abcdef";
  std::string text;
  for (const char c : hash_) {
    const auto octet = static_cast<unsigned char>(c);
    text += digits[octet >> 4U];
    text += digits[octet & 0xFU];
  }
  return text;
}

}  // namespace cosiva::journal
