#include "cosiva/journal/store/chain.h"

#include <sodium/crypto_generichash.h>
#include <xxhash.h>

#include <algorithm>
#include <initializer_list>

#include "cosiva/base/expect.h"

namespace cosiva::journal {
namespace {

Chain blake2b(std::initializer_list<std::string_view> parts) {
  crypto_generichash_state state;
  const int begun = crypto_generichash_init(&state, nullptr, 0, Chain::bytes_count);
  COSIVA_EXPECT(begun == 0);
  for (const std::string_view part : parts)
    crypto_generichash_update(&state, reinterpret_cast<const unsigned char*>(part.data()), part.size());
  std::array<char, Chain::bytes_count> hash{};
  crypto_generichash_final(&state, reinterpret_cast<unsigned char*>(hash.data()), hash.size());
  return Chain::from({hash.data(), hash.size()});
}

}  // namespace

Chain Chain::from(std::string_view bytes) {
  COSIVA_EXPECT(bytes.size() == bytes_count);
  Chain chain;
  std::copy(bytes.begin(), bytes.end(), chain.hash_.begin());
  return chain;
}

Chain Chain::after(std::string_view header, std::string_view records) const {
  XXH128_canonical_t digest{};
  XXH128_canonicalFromHash(&digest, XXH3_128bits(records.data(), records.size()));
  return blake2b({bytes(), header, {reinterpret_cast<const char*>(&digest.digest), sizeof digest.digest}});
}

Chain Chain::after_in_format_1(std::string_view header, std::string_view records) const {
  return blake2b({bytes(), header, records});
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
