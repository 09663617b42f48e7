#pragma once

#include <algorithm>
#include <string>

#include "cosiva/zone/rtm/rtm.h"

/// Zones for the tests of this folder.
namespace cosiva::physical {

/// zones/lacet4.toml as it is.
zone::ZoneConfiguration lacet4();
/// The same with another pitch: with the file's own pitch the sections may have no beacon in reach.
zone::ZoneConfiguration lacet4_with_beacons_every(double pitch_m);

inline constexpr std::string_view zone_head = R"(
name = "test"
format_version = 1
[vehicle]
length_m = 0.20
width_m = 0.12
[profiles.slow]
speed_mps = 0.15
acceleration_mps2 = 0.3
braking_mps2 = 0.6
[profiles.medium]
speed_mps = 0.30
acceleration_mps2 = 0.5
braking_mps2 = 0.8
[profiles.fast]
speed_mps = 0.50
acceleration_mps2 = 0.8
braking_mps2 = 1.0
[circuit]
start = { x = 0.0, y = 0.0, heading_deg = 0 }
closed = false
)";

/// A straight section along +x with one vehicle per start and nothing else on it but the content of `more`.
inline zone::ZoneConfiguration straight(double length_m, const std::string& starts_m = "0.5",
                                        const std::string& more = "") {
  std::string text{zone_head};
  text += "[[section]]\nname = \"line\"\nkind = \"straight\"\nlength_m = " + std::to_string(length_m) + "\n";
  text += more;
  for (std::size_t from = 0; from < starts_m.size();) {
    const std::size_t end = std::min(starts_m.find(' ', from), starts_m.size());
    text += "[[start]]\nsection = \"line\"\ns_m = " + starts_m.substr(from, end - from) + "\n";
    from = end + 1;
  }
  return {"toml", "straight", text};
}

}  // namespace cosiva::physical
