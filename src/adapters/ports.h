#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/adapters/event_loop.h"
#include "cosiva/base/result.h"

namespace cosiva::adapters {

/// Byte streams to boards, by name ("1/PILS"). Over Unix sockets here; a serial port carries the same bytes.
struct PortHandlers {
  std::function<void(const std::string& port, bool up)> on_port;
  std::function<void(const std::string& port, std::string_view bytes)> on_bytes;
};

class Ports {
 public:
  virtual ~Ports() = default;
  /// Bytes for a stream that is not up, or whose other side does not read, are lost as on a wire.
  virtual void send(const std::string& port, std::string_view bytes) = 0;
};

/// The socket of a port in a directory: "DIR/1-PILS.sock".
[[nodiscard]] std::string socket_path(const std::string& directory, const std::string& port);

/// The boards' side: listens on one socket per port. One peer per port, as on a cable; a new one replaces the old.
/// The sockets are removed at the end. Fails ("port.path", "port.listen"), also where another process listens.
[[nodiscard]] Result<std::unique_ptr<Ports>> listen_unix_ports(EventLoop& loop, const std::string& directory,
                                                               const std::vector<std::string>& ports,
                                                               const PortHandlers& handlers);

/// The on-board side: connects to each port's socket, and again every 200 ms while there is none. Fails ("port.path").
[[nodiscard]] Result<std::unique_ptr<Ports>> connect_unix_ports(EventLoop& loop, const std::string& directory,
                                                                const std::vector<std::string>& ports,
                                                                const PortHandlers& handlers);

}  // namespace cosiva::adapters
