#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

namespace cosiva::virtual_side {

/// Topics on which a vehicle publishes.
enum class VehicleTopic : std::uint8_t { connection, state, visualization, factsheet, perceived, detected, boards };
inline constexpr std::size_t vehicle_topics = 7;
/// Parses the topics of VDA 5050; CoSiVA's own topics are not below the interface name.
[[nodiscard]] std::optional<VehicleTopic> parse_vehicle_topic(std::string_view name);
[[nodiscard]] std::string_view to_string(VehicleTopic topic);

}  // namespace cosiva::virtual_side
