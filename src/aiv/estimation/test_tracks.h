#pragma once

// Tracks and drives for this folder's tests.

#include <gtest/gtest.h>

#include <memory>
#include <utility>
#include <vector>

#include "cosiva/aiv/estimation/track.h"

namespace cosiva::estimation::testing {

inline zone::Circuit::Part part(const char* name, const Pose2& start, double length_m, double curvature,
                                std::vector<zone::SectionId> next) {
  auto section = zone::Section::make(start, length_m, curvature);
  EXPECT_TRUE(section);
  return {name, std::move(*section), std::nullopt, std::move(next)};
}

inline std::shared_ptr<const zone::Circuit> circuit(std::vector<zone::Circuit::Part> parts) {
  auto made = zone::Circuit::make("test", std::move(parts));
  EXPECT_TRUE(made) << to_string(made.error());
  return std::make_shared<const zone::Circuit>(std::move(*made));
}

inline std::shared_ptr<const Track> track(std::shared_ptr<const zone::Circuit> circuit,
                                          std::vector<zone::SectionId> sections, bool closed) {
  auto made = Track::make(std::move(circuit), std::move(sections), closed);
  EXPECT_TRUE(made) << to_string(made.error());
  return std::make_shared<const Track>(std::move(*made));
}

/// 3 m straight, a half circle of 0.8 m to the left, 3 m back, and another.
inline std::shared_ptr<const zone::Circuit> oval_circuit() {
  std::vector<zone::Circuit::Part> parts;
  parts.push_back(part("south", {0.0, 0.0, 0.0}, 3.0, 0.0, {1}));
  parts.push_back(part("east", parts.back().section.end(), pi * 0.8, 1.25, {2}));
  parts.push_back(part("north", parts.back().section.end(), 3.0, 0.0, {3}));
  parts.push_back(part("west", parts.back().section.end(), pi * 0.8, 1.25, {0}));
  return circuit(std::move(parts));
}
inline std::shared_ptr<const Track> oval() { return track(oval_circuit(), {0, 1, 2, 3}, true); }

/// 10 m straight on.
inline std::shared_ptr<const Track> straight() {
  std::vector<zone::Circuit::Part> parts;
  parts.push_back(part("a", {0.0, 0.0, 0.0}, 10.0, 0.0, {}));
  return track(circuit(std::move(parts)), {0}, false);
}

}  // namespace cosiva::estimation::testing
