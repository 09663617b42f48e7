#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "cosiva/base/result.h"
#include "cosiva/wire/messages/topics.h"

namespace cosiva::wire {

/// The key that all participants of a direct link have in common.
using DirectKey = std::array<unsigned char, 32>;

/// One datagram of the direct link (docs/protocols/v2x.md).
struct Datagram {
  std::uint8_t kind{};  ///< of the message
  VehicleId sender;
  std::uint64_t session{};   ///< of the sender's process; a later process has a higher number
  std::uint64_t sequence{};  ///< of the datagram in the session, from 1
  std::string payload;       ///< the message
  friend bool operator==(const Datagram&, const Datagram&) = default;
};

/// Longer datagrams are neither sent nor read: an intent has less than 2 kB.
inline constexpr std::size_t datagram_bytes_max = 8192;

/// Fails ("datagram.size") where the datagram would be longer than datagram_bytes_max.
[[nodiscard]] Result<std::string> encode_datagram(const Datagram& datagram, const DirectKey& key);
/// Fails with "datagram.size", "datagram.version", "datagram.tag" (another key, or changed bytes) or "datagram.form".
/// Nothing behind the first six bytes is read before the tag is verified.
[[nodiscard]] Result<Datagram> decode_datagram(std::string_view bytes, const DirectKey& key);

}  // namespace cosiva::wire
