#pragma once

#include <gtest/gtest.h>
#include <fstream>
#include <sstream>
#include <string>

#include "cosiva/base/test_paths.h"
#include "cosiva/experiments/runs/scenario/scenario.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::experiments::testing {

inline const std::string head = "name = \"test\"\n";

/// A scenario with a head and this body; line 1 is the head's.
inline Result<Scenario> read(const std::string& body) { return scenario_from_toml(head + body, "test.toml"); }

/// One [[at]] table: the time is in line 2, the action in line 3.
inline std::string at(double t_s, const std::string& action) {
  std::ostringstream text;
  text << "[[at]]\nt_s = " << t_s << "\n" << action << "\n";
  return text.str();
}

inline std::string file_text(const std::string& below_root) {
  std::ifstream file{source_dir() + "/" + below_root};
  EXPECT_TRUE(file) << below_root;
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

inline zone::TrafficZone lacet4() {
  auto rtm = zone::Rtm::initialise({"toml", "zones/lacet4.toml", file_text("zones/lacet4.toml")});
  EXPECT_TRUE(rtm) << to_string(rtm.error());
  return rtm->zone();
}

}  // namespace cosiva::experiments::testing
