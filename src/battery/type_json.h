#pragma once

#include <string>
#include <string_view>

#include "cosiva/base/result.h"
#include "cosiva/battery/type.h"

namespace cosiva::battery {

/// Reads one type's file (docs/protocols/battery-type.schema.json). Fails ("battery.type") naming the file and the key:
/// a key that is missing, unknown, without its unit or out of range, or an open-circuit voltage that does not increase
/// with charge.
[[nodiscard]] Result<BatteryType> read_type(std::string_view json, const std::string& origin);
/// The text from which read_type restores the same type, to the bit.
[[nodiscard]] std::string to_json(const BatteryType& type);

}  // namespace cosiva::battery
