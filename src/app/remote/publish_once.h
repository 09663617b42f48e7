#pragma once

#include <string>
#include <vector>

#include "cosiva/app/resources/resource_paths.h"
#include "cosiva/base/result.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::app {

/// Connects, publishes these messages in order, and disconnects. Returns only after the broker has acknowledged each
/// message with QoS 1, so that the messages of a successful command have been received.
///
/// @param client_name  a name for the broker's log
/// Errors: those of mqtt_options(); `mqtt.connect` where no broker responds within 10 s; `mqtt.publish` where the
/// broker does not acknowledge within 10 s.
[[nodiscard]] Result<void> publish_once(const BrokerArguments& broker, const std::string& client_name,
                                        const std::vector<wire::Publish>& messages);

}  // namespace cosiva::app
