#include "cosiva/adapters/v2x/direct_ports.h"

#include "cosiva/base/expect.h"
#include "cosiva/wire/own/v2x_port.h"

namespace cosiva::adapters {

DirectPorts::DirectPorts(std::unique_ptr<Ports> boards, std::unique_ptr<MulticastLink> link)
    : boards_{std::move(boards)}, link_{std::move(link)} {
  COSIVA_EXPECT(link_ != nullptr);
}

void DirectPorts::send(const std::string& port, std::string_view bytes) {
  if (wire::v2x_port_number(port))
    link_->send(port, bytes);
  else if (boards_)
    boards_->send(port, bytes);
}

}  // namespace cosiva::adapters
