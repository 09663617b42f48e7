#pragma once

#include <gtest/gtest.h>

#include <string>

#include "cosiva/zone/testing/test_zones.h"

/// The files that the tests of edits begin with.
namespace cosiva::zone::testing {

inline ZoneConfiguration file(const std::string& text) { return {"toml", "test.toml", text}; }

inline ZoneConfiguration lacet4_file() { return configuration_file("lacet4.toml"); }

inline TrafficZone parsed(const ZoneConfiguration& configuration) {
  auto rtm = Rtm::initialise(configuration);
  EXPECT_TRUE(rtm) << to_string(rtm.error()) << "\n" << configuration.text;
  return rtm->zone();
}

}  // namespace cosiva::zone::testing
