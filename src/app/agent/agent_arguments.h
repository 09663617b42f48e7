#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "cosiva/aiv/decision/agent_rules.h"

/// The options of `cosiva agent`.
namespace cosiva::app {

/// Arguments of the subcommands of `agent`.
struct AgentArguments {
  std::string rules{"fuzzy"};  ///< fuzzy or a file
  bool json{false};
  aiv::AgentInputs inputs{aiv::free_path_inputs()};
  std::string instruction{"none"};  ///< the name of a profile, or none
  std::optional<double> speed_mps;  ///< own speed towards a stopped body; empty: `closing` is used
  std::string zone{"lacet4"};       ///< the zone whose medium speed is the reference of speed_mps

  // explain
  std::string present;  ///< the name of a profile; empty: none
  bool every_rule{false};

  // surface
  std::string x{"gap"};
  std::string y{"closing"};
  std::string of{"speed"};
  std::string out_file;
  std::uint32_t width_px{1200};
};

}  // namespace cosiva::app
