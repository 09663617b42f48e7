#pragma once

#include <cstdint>
#include <string>
#include <vector>

/// The options of `cosiva agent measure` and `cosiva agent search`.
namespace cosiva::app {

struct FleetArguments {
  std::string rules{"fuzzy"};  ///< crisp, fuzzy or a file
  std::string zone{"lacet4"};
  std::vector<std::uint32_t> vehicles{4, 12, 24};
  std::vector<std::uint32_t> persons{0, 2};
  std::string seeds{"1..20"};
  double minutes{10.0};
  std::uint32_t jobs{0};
  std::string out_folder;
};

struct AgentMeasureArguments : FleetArguments {
  double fewer_stops_percent{0.0};
  bool json{false};
};

struct AgentSearchArguments : FleetArguments {
  AgentSearchArguments() {
    vehicles = {12, 24};
    persons = {0};
    seeds = "1..2";
    minutes = 3.0;
    out_folder = "search";
  }
  std::vector<std::string> variables;
  std::uint64_t seed{1};
  std::uint32_t budget{40};
};

/// The options that both have, as one states them.
[[nodiscard]] std::string options_text(const FleetArguments& arguments);

}  // namespace cosiva::app
