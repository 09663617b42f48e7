#pragma once

#include <string_view>

#include "cosiva/base/json_value.h"
#include "cosiva/base/result.h"
#include "cosiva/virtual/server/context/augmented_parts.h"
#include "cosiva/virtual/server/context/server_context.h"

namespace cosiva::virtual_side {

/// "plant" and "radio" are for the emulated world.
[[nodiscard]] bool is_world_command(std::string_view name);

/// The message to the emulated world that the command "plant" or "radio" means. Fails with a message that states what
/// to do.
[[nodiscard]] Result<wire::Publish> read_world_command(const JsonValue& command, const ServerContext& context,
                                                       const AugmentedParts& augmented);

}  // namespace cosiva::virtual_side
