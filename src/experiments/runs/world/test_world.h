#pragma once

// Worlds for this folder's tests.

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>

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

}  // namespace cosiva::experiments::testing
