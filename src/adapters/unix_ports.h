#pragma once

#include <memory>
#include <string>
#include <vector>

#include "cosiva/adapters/event_loop.h"
#include "cosiva/adapters/ports.h"
#include "cosiva/base/result.h"

namespace cosiva::adapters {

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
