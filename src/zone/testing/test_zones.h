#pragma once

// Zones for this folder's tests, and short functions to make them.

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/base/test_paths.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::zone::testing {

inline Section section(const Pose2& start, double length_m, double curvature_per_m = 0.0) {
  auto made = Section::make(start, length_m, curvature_per_m);
  EXPECT_TRUE(made) << to_string(made.error());
  return std::move(*made);
}

inline Circuit::Part part(std::string name, Section section, std::vector<SectionId> next = {}) {
  return {std::move(name), std::move(section), std::nullopt, std::move(next)};
}

inline Circuit circuit(std::vector<Circuit::Part> parts) {
  auto made = Circuit::make("test", std::move(parts));
  EXPECT_TRUE(made) << to_string(made.error());
  return std::move(*made);
}

/// Two straights and two half circles: a running track, driven anticlockwise.
inline Circuit track(double straight_m = 2.0, double radius_m = 0.5) {
  const Section south = section({0.0, 0.0, 0.0}, straight_m);
  const Section east = section(south.end(), pi * radius_m, 1.0 / radius_m);
  const Section north = section(east.end(), straight_m);
  const Section west = section(north.end(), pi * radius_m, 1.0 / radius_m);
  return circuit(
      {part("south", south, {1}), part("east", east, {2}), part("north", north, {3}), part("west", west, {0})});
}

/// Six lines, so that a test's addition begins on line 7.
inline const std::string straight = R"(name = "z"
format_version = 1
[[section]]
name = "a"
kind = "straight"
length_m = 2.0
)";

inline Result<TrafficZone> read_zone(const std::string& text) {
  auto rtm = Rtm::initialise({"toml", "test.toml", text});
  if (!rtm) return tl::unexpected(rtm.error());
  return rtm->zone();
}

/// A file of zones/ with its sidecar file, if it has one, as the program reads it.
inline ZoneConfiguration configuration_file(const std::string& file_name) {
  const auto bytes = [](const std::string& path) {
    std::ifstream file(path);
    std::stringstream text;
    text << file.rdbuf();
    return text.str();
  };
  const std::string folder = source_dir() + "/zones/";
  const auto sidecar = sidecar_of_file(file_name);
  return {format_of_file(file_name).value_or("?"), "zones/" + file_name, bytes(folder + file_name),
          sidecar ? bytes(folder + *sidecar) : std::string()};
}

inline TrafficZone zone_file(const std::string& file_name) {
  auto rtm = Rtm::initialise(configuration_file(file_name));
  EXPECT_TRUE(rtm) << to_string(rtm.error());
  return rtm->zone();
}

inline TrafficZone lacet4() { return zone_file("lacet4.toml"); }

}  // namespace cosiva::zone::testing
