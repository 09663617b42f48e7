#include "cosiva/wire/direct/direct_link.h"

#include "cosiva/base/expect.h"

namespace cosiva::wire {

Result<std::string> DirectLink::seal(std::uint8_t kind, std::string_view payload) {
  auto datagram = encode_datagram({kind, self_, session_, sequence_ + 1, std::string(payload)}, key_);
  if (!datagram) return datagram;
  ++sequence_;
  ++counters_.sent;
  return datagram;
}

std::optional<DirectLink::Received> DirectLink::open(std::string_view bytes) {
  auto datagram = decode_datagram(bytes, key_);
  if (!datagram) {
    ++(datagram.error().code == "datagram.tag" ? counters_.forged : counters_.malformed);
    return std::nullopt;
  }
  if (datagram->sender == self_) {
    ++counters_.own;
    return std::nullopt;
  }
  const std::string name = to_string(datagram->sender);
  if (windows_.size() >= senders_max && !windows_.contains(name)) {
    ++counters_.crowded;
    return std::nullopt;
  }
  if (!windows_[name].accept(datagram->session, datagram->sequence)) {
    ++counters_.replayed;
    return std::nullopt;
  }
  COSIVA_EXPECT(windows_.size() <= senders_max);
  ++counters_.accepted;
  return Received{datagram->kind, std::move(datagram->sender), std::move(datagram->payload)};
}

}  // namespace cosiva::wire
