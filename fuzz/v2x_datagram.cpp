#include <sodium/crypto_auth_hmacsha256.h>

#include <string>

#include "cosiva/wire/direct/datagram.h"
#include "cosiva/wire/direct/direct_link.h"
#include "target.h"

/// The input as a datagram, and the input with a valid tag behind it, as a holder of the key could send it.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  namespace wire = cosiva::wire;
  static const wire::DirectKey key{1, 2, 3};
  std::string tagged{cosiva::fuzz::as_text(data, size)};
  unsigned char tag[crypto_auth_hmacsha256_BYTES];
  crypto_auth_hmacsha256(tag, data, size, key.data());
  tagged.append(reinterpret_cast<const char*>(tag), sizeof tag);
  wire::DirectLink link{{"CoSiVA", "AIV1"}, key, 1};
  for (const std::string_view bytes : {cosiva::fuzz::as_text(data, size), std::string_view{tagged}}) {
    const auto datagram = wire::decode_datagram(bytes, key);
    if (!datagram) COSIVA_EXPECT(datagram.error().code.starts_with("datagram."));
    if (datagram) COSIVA_EXPECT(*wire::encode_datagram(*datagram, key) == bytes);
    const bool own = datagram && datagram->sender == wire::VehicleId{"CoSiVA", "AIV1"};
    COSIVA_EXPECT(link.open(bytes).has_value() == (datagram && !own));
    COSIVA_EXPECT(!link.open(bytes));
  }
  return 0;
}
