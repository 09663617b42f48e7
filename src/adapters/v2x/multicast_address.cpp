#include "cosiva/adapters/v2x/multicast_address.h"

#include <arpa/inet.h>

#include <charconv>
#include <optional>
#include <string_view>

namespace cosiva::adapters {
namespace {

std::optional<std::uint16_t> parse_port(std::string_view text) {
  std::uint16_t port = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
  if (error != std::errc{} || end != text.data() + text.size() || port == 0) return std::nullopt;
  return port;
}

}  // namespace

Result<MulticastAddress> parse_multicast(const std::string& text) {
  const auto bad = [&] {
    return fail(
        "v2x.multicast",
        "'" + text + "' is not GROUP:PORT, such as 239.192.7.50:7500 or [ff15::c051:7a]:7500 (a multicast group)",
        "--v2x-multicast");
  };
  const std::size_t colon = text.rfind(':');
  if (colon == std::string::npos) return bad();
  MulticastAddress address;
  const auto port = parse_port(std::string_view{text}.substr(colon + 1));
  if (!port) return bad();
  address.port = *port;
  address.group = text.substr(0, colon);
  if (address.group.starts_with('[') && address.group.ends_with(']')) {
    address.group = address.group.substr(1, address.group.size() - 2);
    in6_addr ip{};
    if (::inet_pton(AF_INET6, address.group.c_str(), &ip) != 1 || !IN6_IS_ADDR_MULTICAST(&ip)) return bad();
    address.ipv6 = true;
    return address;
  }
  in_addr ip{};
  if (::inet_pton(AF_INET, address.group.c_str(), &ip) != 1 || !IN_MULTICAST(ntohl(ip.s_addr))) return bad();
  return address;
}

}  // namespace cosiva::adapters
