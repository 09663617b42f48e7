#pragma once

#include <cstdint>
#include <string>

#include "cosiva/base/result.h"

namespace cosiva::adapters {

/// Where the datagrams of a direct link go: a multicast group, and a port.
struct MulticastAddress {
  std::string group;  ///< "239.192.7.50" or "ff15::c051:7a"
  std::uint16_t port{};
  bool ipv6{};
  friend bool operator==(const MulticastAddress&, const MulticastAddress&) = default;
};

/// "239.192.7.50:7500" or "[ff15::c051:7a]:7500". Fails ("v2x.multicast") where the text is not a multicast group of
/// IPv4 or IPv6 with a port from 1 to 65535.
[[nodiscard]] Result<MulticastAddress> parse_multicast(const std::string& text);

}  // namespace cosiva::adapters
