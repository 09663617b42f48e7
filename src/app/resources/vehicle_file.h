#pragma once

#include <string>
#include <string_view>

#include "cosiva/aiv/order/action_catalogue.h"
#include "cosiva/base/result.h"

namespace cosiva::app {

/// A vehicle file (TOML, docs/guide/vehicle-file.md): the load handling devices of a vehicle, the durations of the
/// predefined actions, and further actions with their scopes. What the file leaves out has its usual value. Fails
/// ("vehicle.…") with file, line and field.
/// @param origin  the file's name, for errors
[[nodiscard]] Result<aiv::ActionCatalogue> read_vehicle_file(std::string_view text, std::string_view origin);
/// Fails also ("file.read") on a file that cannot be read.
[[nodiscard]] Result<aiv::ActionCatalogue> load_vehicle_file(const std::string& file);

}  // namespace cosiva::app
