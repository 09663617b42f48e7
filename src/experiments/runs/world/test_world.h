#pragma once

// Worlds for this folder's tests.

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>

#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/experiments/runs/world/world.h"
#include "cosiva/zone/testing/test_zones.h"

namespace cosiva::experiments::testing {

/// One of the ready zones in our own format.
inline zone::ZoneConfiguration zone_named(const std::string& name) {
  return zone::testing::configuration_file(name + ".toml");
}

/// A fleet on lacet4. @param loss  ratio of lost messages
inline std::unique_ptr<World> world_of(std::uint32_t aivs, std::uint64_t seed = 1, double loss = 0.0) {
  WorldOptions options;
  options.zone = zone_named("lacet4");
  options.aivs = aivs;
  options.seed = seed;
  options.network.loss = loss;
  auto world = World::make(std::move(options));
  EXPECT_TRUE(world.has_value()) << (world ? "" : to_string(world.error()));
  return std::move(*world);
}

/// An operator switches to this zone.
inline void switch_to(World& world, const zone::ZoneConfiguration& configuration) {
  JsonWriter json;
  json.begin_object().field("command", "switch").key("zone");
  write_json(json, configuration);
  json.end_object();
  world.command_server(json.take());
}

/// The server's snapshot, as the page receives it.
inline JsonValue snapshot(const World& world) {
  return *JsonValue::parse(world.server().snapshot_json(), std::size_t{1} << 24U);
}

/// The figures of the bijection.
inline JsonValue bijection(const World& world) {
  JsonWriter json;
  world.server().write_bijection(json);
  return *JsonValue::parse(json.text());
}

/// The distance that all vehicles together have driven along paths.
inline double total_m(const World& world) {
  double sum = 0.0;
  for (const auto& vehicle : world.plant().vehicles()) sum += vehicle.distance_m;
  return sum;
}

}  // namespace cosiva::experiments::testing
