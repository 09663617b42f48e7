#include "cosiva/zone/generate/generated_text.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace cosiva::zone {

double rounded(double value) { return std::nearbyint(value * 1e6) / 1e6; }

std::string text_of(double value) {
  char buffer[32];
  const double shown = rounded(value);
  return {buffer, std::to_chars(buffer, buffer + sizeof buffer, shown == 0.0 ? 0.0 : shown).ptr};
}

void write_head(std::string& out, std::string_view name, const VehicleShape& vehicle) {
  out.append("name = \"").append(name).append("\"\nformat_version = 1\n\n[vehicle]\nlength_m = ");
  out.append(text_of(vehicle.length_m)).append("\nwidth_m = ").append(text_of(vehicle.width_m));
  out.append(R"(

[profiles.slow]
speed_mps = 0.3
acceleration_mps2 = 0.3
braking_mps2 = 0.6

[profiles.medium]
speed_mps = 0.8
acceleration_mps2 = 0.5
braking_mps2 = 0.8

[profiles.fast]
speed_mps = 1.5
acceleration_mps2 = 0.8
braking_mps2 = 1.0

[crossings]
clearance_m = )");
  out.append(text_of(generated_clearance_m)).append("\n\n");
}

Result<void> check_vehicle_and_name(const VehicleShape& vehicle, std::string_view name) {
  const auto good = [](double size_m) { return size_m >= 0.05 && size_m <= 5.0; };
  if (!good(vehicle.length_m) || !good(vehicle.width_m))
    return fail("generate.options", "expected a vehicle of 0.05 to 5 m, long and wide");
  const auto plain = [](char c) { return static_cast<unsigned char>(c) >= 0x20 && c != 0x7F && c != '"' && c != '\\'; };
  if (name.empty() || name.size() > 64 || !std::ranges::all_of(name, plain))
    return fail("generate.options",
                "expected a name of 1 to 64 bytes without control characters, quotes and backslashes");
  return {};
}

}  // namespace cosiva::zone
