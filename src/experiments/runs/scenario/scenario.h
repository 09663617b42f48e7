#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/base/time.h"

namespace cosiva::experiments {

/// A scenario: the events over time, in one format for live and for virtual time (docs/guide/scenarios.md). Every step
/// is a command to the server (ServerCore's Input::command), so it is recorded in the journal and replayed.
struct Scenario {
  std::string name;
  std::string description;
  std::string zone{"lacet4"};
  std::uint32_t aivs{4};
  std::uint64_t seed{1};
  std::optional<double> duration_s;
  std::vector<std::string> crossing_units;  ///< crossings with a unit from the start on, or "all"
  struct Step {
    SimDuration at;       ///< since the fleet was complete
    std::string command;  ///< JSON for the server
    std::string what;     ///< for display: "person P1 walks 1.2 m"
    std::uint32_t line;   ///< in the file
    std::string zone{};   ///< of a step that switches: the name or file of the zone in force from here on
  };
  /// Crossings whose unit a step adds, or switches off and on.
  std::vector<std::string> switched_units;
  std::vector<Step> steps;  ///< in time order; equal times in the file's order
};

/// Reads a scenario; errors name origin, line and field, and the expected value, with the nearest term for a misspelt
/// one.
[[nodiscard]] Result<Scenario> scenario_from_toml(std::string_view text, const std::string& origin);
}  // namespace cosiva::experiments
