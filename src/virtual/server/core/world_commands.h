#pragma once

#include "cosiva/base/result.h"
#include "cosiva/virtual/server/commands/values/operator_command.h"
#include "cosiva/virtual/server/context/augmented_parts.h"
#include "cosiva/virtual/server/context/server_context.h"

namespace cosiva::virtual_side {

/// The message to the emulated world that the command "plant" or "radio" means. Fails with a message that states what
/// to do.
[[nodiscard]] Result<wire::Publish> read_world_command(const PlantCommand& command, const ServerContext& context,
                                                       const AugmentedParts& augmented);
[[nodiscard]] Result<wire::Publish> read_world_command(const RadioCommand& command, const ServerContext& context);

}  // namespace cosiva::virtual_side
