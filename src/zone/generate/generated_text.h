#pragma once

#include <string>
#include <string_view>

#include "cosiva/base/result.h"
#include "cosiva/zone/layout/traffic_zone.h"

/// What all generated zones have in common.
namespace cosiva::zone {

/// Between two bodies that pass each other on a generated zone.
inline constexpr double generated_clearance_m = 0.10;

/// To a micrometre: a thousandth of a joint's allowed gap, and short to read.
[[nodiscard]] double rounded(double value);
[[nodiscard]] std::string text_of(double value);

/// Name, version, vehicle, profiles and clearance of a zone's file.
void write_head(std::string& out, std::string_view name, const VehicleShape& vehicle);

/// Fails ("generate.options") for a vehicle or a name that no generated zone has.
[[nodiscard]] Result<void> check_vehicle_and_name(const VehicleShape& vehicle, std::string_view name);

}  // namespace cosiva::zone
