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
  ChainHash hash{*this, header};
  hash.add(records);
  return hash.end();
}

Chain Chain::after_in_format_1(std::string_view header, std::string_view records) const {
  return blake2b({bytes(), header, records});
}

void ChainHash::Free::operator()(XXH3_state_s* state) const { XXH3_freeState(state); }

ChainHash::ChainHash(const Chain& before, std::string_view header)
    : before_{before}, header_{header}, state_{XXH3_createState()} {
  COSIVA_EXPECT(state_ != nullptr);
  XXH3_128bits_reset(state_.get());
}

void ChainHash::add(std::string_view records) { XXH3_128bits_update(state_.get(), records.data(), records.size()); }

Chain ChainHash::end() const {
  XXH128_canonical_t digest{};
  XXH128_canonicalFromHash(&digest, XXH3_128bits_digest(state_.get()));
  return blake2b({before_.bytes(), header_, {reinterpret_cast<const char*>(&digest.digest), sizeof digest.digest}});
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
