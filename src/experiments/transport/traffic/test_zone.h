#pragma once

#include <memory>

#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::experiments {

/// An oval with one direction of travel: straights of 6 m and half circles of 1 m radius.
inline std::shared_ptr<const zone::TrafficZone> zone_of(const char* more) {
  std::string text = R"(name = "yard"
format_version = 1
[circuit]
start = { x = 0, y = 0, heading_deg = 0 }
closed = true
)";
  for (const char* side : {"south", "north"}) {
    text += std::string("[[section]]\nname = \"") + side + "\"\nkind = \"straight\"\nlength_m = 6\n";
    text += std::string("[[section]]\nname = \"") + side + "_bend\"\nkind = \"arc\"\nradius_m = 1\nangle_deg = 180\n";
  }
  auto rtm = zone::Rtm::initialise({"toml", "yard.toml", text + more, {}});
  return rtm ? rtm->shared_zone() : nullptr;
}
inline std::shared_ptr<const zone::TrafficZone> cycle() {
  static const auto zone = zone_of("");
  return zone;
}
/// A zone with three stops, dock, rack and ship, and a charger.
inline std::shared_ptr<const zone::TrafficZone> yard() {
  static const auto zone = zone_of(R"([[station]]
name = "dock"
section = "south"
s_m = 1.0
[[station]]
name = "rack"
section = "south"
s_m = 4.5
[[station]]
name = "ship"
section = "north"
s_m = 3.0
[[station]]
name = "plug"
section = "north"
s_m = 5.0
kind = "charger"
)");
  return zone;
}

}  // namespace cosiva::experiments
