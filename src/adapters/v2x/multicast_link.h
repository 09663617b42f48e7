#pragma once

#include <memory>
#include <string>

#include "cosiva/adapters/event_loop.h"
#include "cosiva/adapters/ports.h"
#include "cosiva/adapters/v2x/multicast_address.h"
#include "cosiva/base/result.h"
#include "cosiva/wire/direct/direct_link.h"
#include "cosiva/wire/messages/topics.h"

namespace cosiva::adapters {

struct MulticastOptions {
  MulticastAddress address;
  std::string interface_name;  ///< "wlan0"; empty: the system's choice
  wire::VehicleId self;
  wire::DirectKey key;
  /// The link can repeat: what is sent on the port of another sender (wire::v2x_port_of) is that sender's newest
  /// datagram of this kind, byte for byte, if it holds these bytes; nothing else is ever sent in another name.
  bool repeats{false};
};

/// The direct link over UDP multicast, as the ports of wire/own/v2x_port.h. Datagrams that are not accepted are counted
/// and ignored. What this machine sends, other processes of this machine receive, too.
class MulticastLink : public Ports {
 public:
  [[nodiscard]] virtual const wire::DirectLink::Counters& counters() const = 0;
  /// Datagrams that the system did not take: the network is down, or its queue is full.
  [[nodiscard]] virtual std::uint64_t unsent() const = 0;
};

/// Joins the group. Fails ("v2x.interface" where there is no such interface, "v2x.socket").
[[nodiscard]] Result<std::unique_ptr<MulticastLink>> open_multicast(EventLoop& loop, const MulticastOptions& options,
                                                                    const PortHandlers& handlers);

}  // namespace cosiva::adapters
