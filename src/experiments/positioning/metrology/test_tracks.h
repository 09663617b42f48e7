#pragma once

// Tracks for this folder's tests.

#include <gtest/gtest.h>

#include <memory>
#include <utility>

#include "cosiva/aiv/estimation/track.h"

namespace cosiva::experiments::testing {

/// Two straights and two half circles, a loop of 2·straight + 2π·radius.
inline std::shared_ptr<const estimation::Track> oval(double straight_m = 3.0, double radius_m = 0.8) {
  const auto part = [](const char* name, const Pose2& start, double length_m, double curvature, zone::SectionId next) {
    auto section = zone::Section::make(start, length_m, curvature);
    EXPECT_TRUE(section);
    return zone::Circuit::Part{name, std::move(*section), std::nullopt, {next}};
  };
  std::vector<zone::Circuit::Part> parts;
  parts.push_back(part("south", {0.0, 0.0, 0.0}, straight_m, 0.0, 1));
  parts.push_back(part("east", parts.back().section.end(), pi * radius_m, 1.0 / radius_m, 2));
  parts.push_back(part("north", parts.back().section.end(), straight_m, 0.0, 3));
  parts.push_back(part("west", parts.back().section.end(), pi * radius_m, 1.0 / radius_m, 0));
  auto circuit = zone::Circuit::make("oval", std::move(parts));
  EXPECT_TRUE(circuit) << to_string(circuit.error());
  auto track = estimation::Track::of_loop(std::make_shared<const zone::Circuit>(std::move(*circuit)));
  EXPECT_TRUE(track) << to_string(track.error());
  return std::make_shared<const estimation::Track>(std::move(*track));
}

}  // namespace cosiva::experiments::testing
