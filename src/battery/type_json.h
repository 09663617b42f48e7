#pragma once

#include <string>
#include <string_view>

#include "cosiva/base/result.h"
#include "cosiva/battery/type.h"

namespace cosiva::battery {

/// Reads one type's file (docs/protocols/battery-type.schema.json). Fails ("battery.type") naming the file and the key:
/// what is missing, unknown, without its unit, out of range, or an open-circuit voltage that does not grow with charge.
[[nodiscard]] Result<BatteryType> read_type(std::string_view json, const std::string& origin);
/// As read_type reads it back, to the bit.
[[nodiscard]] std::string to_json(const BatteryType& type);

}  // namespace cosiva::battery
