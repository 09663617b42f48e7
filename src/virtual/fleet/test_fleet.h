#pragma once

// Fleets for the tests of this folder, and a slow check of their invariants.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <memory>
#include <span>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/aiv/motion/formulas.h"
#include "cosiva/base/math.h"
#include "cosiva/base/test_paths.h"
#include "cosiva/virtual/fleet/fleet.h"
#include "cosiva/zone/generate/generate.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::virtual_side::test {

using Zone = std::shared_ptr<const zone::TrafficZone>;

inline Zone zone_text(std::string text) {
  auto rtm = zone::Rtm::initialise({"toml", "test.toml", std::move(text)});
  EXPECT_TRUE(rtm) << to_string(rtm.error());
  return rtm->shared_zone();
}

inline Zone zone_file(const std::string& name) {
  const auto bytes = [](const std::string& path) {
    std::ifstream file(path);
    std::stringstream text;
    text << file.rdbuf();
    return text.str();
  };
  const std::string path = source_dir() + "/" + name;
  const auto sidecar = zone::sidecar_of_file(path);
  auto rtm = zone::Rtm::initialise(
      {zone::format_of_file(path).value_or("?"), path, bytes(path), sidecar ? bytes(*sidecar) : std::string{}});
  EXPECT_TRUE(rtm) << to_string(rtm.error());
  return rtm->shared_zone();
}

inline Zone plant(const zone::PlantOptions& options) {
  auto text = zone::generate_plant(options);
  EXPECT_TRUE(text) << to_string(text.error());
  return zone_text(*text);
}

/// @param rules  fuzzy ones; false: the crisp
inline Fleet fleet(const Zone& zone, std::span<const FleetStart> starts, bool rules = true) {
  auto made = Fleet::make(
      zone, {.rules = rules ? aiv::AgentRules::built_in() : std::shared_ptr<const aiv::AgentRules>{}}, starts);
  EXPECT_TRUE(made) << to_string(made.error());
  return std::move(*made);
}
inline Fleet fleet(const Zone& zone, std::size_t count, bool rules = true) {
  const std::vector<FleetStart> starts = Fleet::spread(*zone, count);
  EXPECT_FALSE(starts.empty());
  return fleet(zone, starts, rules);
}

/// Corners of a vehicle's body.
inline std::array<Point2, 4> corners(const Pose2& X_MB, const zone::VehicleShape& shape) {
  const double l = 0.5 * shape.length_m;
  const double w = 0.5 * shape.width_m;
  return {X_MB * Point2{l, w}, X_MB * Point2{-l, w}, X_MB * Point2{-l, -w}, X_MB * Point2{l, -w}};
}

/// Whether two bodies overlap: no edge of theirs separates them (separating axes).
inline bool overlap(const Pose2& a, const Pose2& b, const zone::VehicleShape& shape) {
  if (norm(a.x_m - b.x_m, a.y_m - b.y_m) > norm(shape.length_m, shape.width_m)) return false;
  const auto p = corners(a, shape);
  const auto q = corners(b, shape);
  for (const double heading : {a.heading_rad, a.heading_rad + pi / 2, b.heading_rad, b.heading_rad + pi / 2}) {
    const SinCos along = sincos(heading);
    const auto range = [&](const std::array<Point2, 4>& points) {
      double low = 1e9;
      double high = -1e9;
      for (const Point2& point : points) {
        low = std::min(low, along.cos * point.x_m + along.sin * point.y_m);
        high = std::max(high, along.cos * point.x_m + along.sin * point.y_m);
      }
      return std::pair{low, high};
    };
    const auto [p_low, p_high] = range(p);
    const auto [q_low, q_high] = range(q);
    if (p_high <= q_low || q_high <= p_low) return false;
  }
  return true;
}

/// No bodies overlap, and every vehicle in a crossing holds it.
inline void expect_safe(const Fleet& fleet) {
  const zone::TrafficZone& zone = fleet.zone();
  const auto count = static_cast<Fleet::Vehicle>(fleet.size());
  // Sorted along x, so that each vehicle is compared only with its neighbours.
  std::vector<Fleet::Vehicle> order(count);
  for (Fleet::Vehicle i = 0; i < count; ++i) order[i] = i;
  std::ranges::sort(order, {}, [&](Fleet::Vehicle i) { return fleet.x_m()[i]; });
  const double reach_m = norm(zone.vehicle.length_m, zone.vehicle.width_m);
  for (std::size_t k = 0; k < count; ++k) {
    for (std::size_t j = k + 1; j < count && fleet.x_m()[order[j]] - fleet.x_m()[order[k]] <= reach_m; ++j) {
      if (fleet.copy_of(order[k]) != fleet.copy_of(order[j])) continue;
      ASSERT_FALSE(overlap(fleet.pose(order[k]), fleet.pose(order[j]), zone.vehicle))
          << order[k] << " and " << order[j] << " at step " << fleet.steps() << ", sections "
          << zone.circuit.part(fleet.track_position(order[k]).section).name << " " << fleet.track_position(order[k]).s_m
          << " and " << zone.circuit.part(fleet.track_position(order[j]).section).name << " "
          << fleet.track_position(order[j]).s_m;
    }
  }
  std::vector<std::vector<std::pair<zone::CrossingSpan, std::size_t>>> spans(zone.circuit.size());
  for (std::size_t x = 0; x < zone.crossings.size(); ++x)
    for (const zone::CrossingSpan& span : zone.crossings[x].spans) spans[span.section].push_back({span, x});
  for (Fleet::Vehicle i = 0; i < count; ++i) {
    const zone::TrackPosition position = fleet.track_position(i);
    for (const auto& [span, crossing] : spans[position.section]) {
      if (position.s_m > span.from_m && position.s_m < span.to_m) {
        ASSERT_EQ(fleet.holder(fleet.copy_of(i), crossing), i) << "at step " << fleet.steps();
      }
    }
  }
}

}  // namespace cosiva::virtual_side::test
