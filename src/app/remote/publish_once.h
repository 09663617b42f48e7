#pragma once

#include <string>
#include <vector>

#include "cosiva/app/resources/resource_paths.h"
#include "cosiva/base/result.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::app {

/// Connects, says these messages in their order, and goes. Done only once the broker has acknowledged each that asks
/// for it (QoS 1), so that a command which ends well has been heard.
///
/// @param client_name  a word for the broker's log
/// Errors: what mqtt_options() refuses; `mqtt.connect` where nobody answers within 10 s; `mqtt.publish` where the
/// broker does not acknowledge within 10 s.
[[nodiscard]] Result<void> publish_once(const BrokerArguments& broker, const std::string& client_name,
                                        const std::vector<wire::Publish>& messages);

}  // namespace cosiva::app
