#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "zone/edit.h"
#include "zone/traffic_zone.h"

/// What reading a zone and editing it agree on.
namespace cosiva::zone {

inline constexpr TagNumber tag_number_max = 4'000'000'000;
inline constexpr double rad_per_deg = pi / 180.0;

/// To 0.1 mm, as edits are written: nearer than anybody lays a tag.
[[nodiscard]] double rounded_m(double value_m);
/// The place with its s rounded, but still on the section.
[[nodiscard]] Place place_as_written(const Circuit& circuit, Place place);
/// "1.4137", "0.20": what rounded_m leaves, with at least two decimals.
[[nodiscard]] std::string metres_text(double value_m);

/// An angle as edits write it: degrees with four decimals, and the radians that a reader makes of them.
[[nodiscard]] double rounded_deg(double angle_rad);
[[nodiscard]] double rounded_rad(double angle_rad);

/// What is wrong with the name of a vehicle that a priority is for; nothing when it is "manufacturer/serial".
[[nodiscard]] std::optional<std::string> wrong_vehicle_name(std::string_view name);

/// What an edit may have left other than wanted, as a sentence; nothing when all of the zone is the same.
[[nodiscard]] std::optional<std::string> difference(const TrafficZone& wanted, const TrafficZone& found);

}  // namespace cosiva::zone
