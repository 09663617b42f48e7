#pragma once

#include "cosiva/virtual/server/context/augmented_parts.h"
#include "cosiva/virtual/server/context/server_context.h"

namespace cosiva::virtual_side {

/// The intake of V2X messages between vehicles (A3, A10). The server takes no part in them: the virtual AIVs, which run
/// in this process, receive them here, and some are traced.
/// Invariant: a V2X message registers no vehicle, so invented names occupy no memory of the server.
class V2xIntake {
 public:
  V2xIntake(ServerContext& context, AugmentedParts& augmented) : context_{context}, augmented_{augmented} {}

  void receive(const wire::Input& input);

 private:
  void trace(AivProxy& proxy, const wire::Input& input);

  ServerContext& context_;
  AugmentedParts& augmented_;
};

}  // namespace cosiva::virtual_side
