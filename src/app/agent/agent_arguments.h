#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "cosiva/aiv/decision/agent_rules.h"

/// The options of `cosiva agent`.
namespace cosiva::app {

/// Of the verbs of `agent`.
struct AgentArguments {
  std::string rules{"fuzzy"};  ///< fuzzy or a file
  bool json{false};
  aiv::AgentInputs inputs{aiv::free_path_inputs()};
  std::string instruction{"none"};  ///< a profile's word, or none
  std::optional<double> speed_mps;  ///< its own, towards what stands; nothing: `closing` says it
  std::string zone{"lacet4"};       ///< whose medium speed that counts by

  // explain
  std::string present;  ///< a profile's word; empty: none
  bool every_rule{false};

  // surface
  std::string x{"gap"};
  std::string y{"closing"};
  std::string of{"speed"};
  std::string out_file;
  std::uint32_t width_px{1200};
};

}  // namespace cosiva::app
