#pragma once

#include <cstdlib>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/base/test_paths.h"
#include "cosiva/zone/rtm/rtm.h"

/// Zones and circuits that the tests of aiv and aiv/onboard drive on.
namespace cosiva::aiv::test {

inline zone::ZoneConfiguration lacet4_configuration() {
  const std::string path = source_dir() + "/zones/lacet4.toml";
  std::ifstream file{path};
  std::ostringstream text;
  text << file.rdbuf();
  return {"toml", path, text.str()};
}

/// The clover of A11, as every vehicle receives it.
inline const zone::TrafficZone& lacet4() {
  static const std::shared_ptr<const zone::TrafficZone> zone = [] {
    auto rtm = zone::Rtm::initialise(lacet4_configuration());
    if (!rtm) std::abort();
    return rtm->shared_zone();
  }();
  return *zone;
}

inline zone::TrackPosition at(const zone::TrafficZone& zone, std::string_view section, double s_m) {
  return {zone.circuit.find(section).value(), s_m};
}

/// One piece of a future circuit: its shape without its position.
struct Piece {
  double length_m;
  double curvature_per_m{0.0};
  double curvature_rate_per_m2{0.0};
};

/// Lays pieces end to end from `start`; `closed` joins the last to the first.
inline zone::Circuit lay(const std::vector<Piece>& pieces, bool closed, Pose2 start = {}) {
  std::vector<zone::Circuit::Part> parts;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    auto section =
        zone::Section::make(start, pieces[i].length_m, pieces[i].curvature_per_m, pieces[i].curvature_rate_per_m2);
    if (!section) std::abort();
    start = section->end();
    std::vector<zone::SectionId> next;
    if (i + 1 < pieces.size()) next = {static_cast<zone::SectionId>(i + 1)};
    if (i + 1 == pieces.size() && closed) next = {0};
    parts.push_back({"p" + std::to_string(i), std::move(*section), std::nullopt, std::move(next)});
  }
  auto circuit = zone::Circuit::make("test", std::move(parts));
  if (!circuit) std::abort();
  return std::move(*circuit);
}

}  // namespace cosiva::aiv::test
