#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "cosiva/adapters/ports.h"
#include "cosiva/adapters/v2x/multicast_link.h"

namespace cosiva::adapters {

/// The ports of a vehicle's program with a direct link: those of its boards, and those of the link.
///
/// Invariant: there is a link.
class DirectPorts final : public Ports {
 public:
  /// @param boards  null: none
  /// @param link    not null (checked)
  DirectPorts(std::unique_ptr<Ports> boards, std::unique_ptr<MulticastLink> link);

  void send(const std::string& port, std::string_view bytes) override;

 private:
  std::unique_ptr<Ports> boards_;
  std::unique_ptr<MulticastLink> link_;
};

}  // namespace cosiva::adapters
