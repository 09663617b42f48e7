#pragma once

#include <optional>

#include "cosiva/adapters/v2x/multicast_link.h"
#include "cosiva/app/platform/direct_arguments.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/base/result.h"
#include "cosiva/wire/messages/topics.h"

namespace cosiva::app {

/// The direct link to open; nothing: none. Fails where its address or its key cannot be used.
[[nodiscard]] Result<std::optional<adapters::MulticastOptions>> direct_link_options(const DirectArguments& direct,
                                                                                    const wire::VehicleId& id);
/// Prints, and writes as the field "direct", how many datagrams were sent, accepted, and refused for each reason.
void report_counters(JsonWriter& json, const adapters::MulticastLink& link);

}  // namespace cosiva::app
