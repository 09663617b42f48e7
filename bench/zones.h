#pragma once

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <sstream>

#include "cosiva/aiv/estimation/track.h"
#include "cosiva/base/test_paths.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::fixture {

/// The article's circuit, one lap of its loop.
inline std::shared_ptr<const estimation::Track> lacet4_track() {
  std::stringstream text;
  text << std::ifstream(source_dir() + "/zones/lacet4.toml").rdbuf();
  const auto rtm = zone::Rtm::initialise({"toml", "zones/lacet4.toml", text.str()});
  if (!rtm) {
    std::fprintf(stderr, "%s\n", to_string(rtm.error()).c_str());
    std::exit(2);
  }
  const auto shared = rtm->shared_zone();
  const std::shared_ptr<const zone::Circuit> circuit(shared, &shared->circuit);
  return std::make_shared<const estimation::Track>(*estimation::Track::of_loop(circuit));
}

}  // namespace cosiva::fixture
