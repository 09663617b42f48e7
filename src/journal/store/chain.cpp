#include "cosiva/journal/store/chain.h"

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

Chain Chain::after(std::string_view batch) const {
  ChainHash hash{*this};
  hash.add(batch);
  return hash.end();
}

ChainHash::ChainHash(const Chain& before) {
  const int begun = crypto_generichash_init(&state_, nullptr, 0, Chain::bytes_count);
  COSIVA_EXPECT(begun == 0);
  add(before.bytes());
}

void ChainHash::add(std::string_view part) { crypto_generichash_update(&state_, octets(part), part.size()); }

Chain ChainHash::end() {
  std::array<char, Chain::bytes_count> hash{};
  crypto_generichash_final(&state_, reinterpret_cast<unsigned char*>(hash.data()), hash.size());
  return Chain::from({hash.data(), hash.size()});
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
