#pragma once

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <string>

#include "zone/rtm/rtm.h"

/// The files that the tests of edits begin with.
namespace cosiva::zone::testing {

inline const std::string straight = R"(name = "z"
format_version = 1
[[section]]
name = "a"
kind = "straight"
length_m = 2.0
)";

inline ZoneConfiguration file(const std::string& text) { return {"toml", "test.toml", text}; }

inline ZoneConfiguration lacet4_file() {
  std::ifstream in(COSIVA_SOURCE_DIR "/zones/lacet4.toml");
  std::stringstream text;
  text << in.rdbuf();
  return file(text.str());
}

inline TrafficZone parsed(const ZoneConfiguration& configuration) {
  auto rtm = Rtm::initialise(configuration);
  EXPECT_TRUE(rtm) << to_string(rtm.error()) << "\n" << configuration.text;
  return rtm->zone();
}

}  // namespace cosiva::zone::testing
