#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/base/time.h"
#include "cosiva/zone/layout/circuit_factory.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::experiments {

/// What happens when: the same file for live and for virtual time (docs/guide/scenarios.md). Every step is a command to
/// the server (ServerCore's Input::command), so it stands in the journal and a replay has it too.
struct Scenario {
  std::string name;
  std::string description;
  std::string zone{"lacet4"};
  std::uint32_t aivs{4};
  std::uint64_t seed{1};
  std::optional<double> duration_s;
  struct Step {
    SimDuration at;       ///< since the fleet was complete
    std::string command;  ///< JSON for the server
    std::string what;     ///< as people read it: "person P1 walks 1.2 m"
    std::uint32_t line;   ///< in the file
    std::string zone{};   ///< of a step that switches: the name or file of the zone that is in force from here on
  };
  std::vector<Step> steps;  ///< in time order; equal times in the file's order
};

/// Reads a scenario; errors name origin, line and field, and what was expected, with the nearest word for a misspelt
/// one.
[[nodiscard]] Result<Scenario> scenario_from_toml(std::string_view text, const std::string& origin);
/// Finds the zones that the scenario switches to, and puts them into their steps' commands, whole: a server that plays
/// it needs no files. Fails as `load` does, naming the line.
using LoadZone = std::function<Result<zone::ZoneConfiguration>(const std::string& name_or_file)>;
[[nodiscard]] Result<void> resolve_zones(Scenario& scenario, const LoadZone& load, const std::string& origin);
/// Checks what only the zone in force at each step can tell: places on it, sections, stations and loops that exist,
/// vehicles 1…aivs or named virtual ones that are there at that time, ids used twice or removed before they came. Its
/// zones must have been resolved.
/// @param zone  in force at the beginning
[[nodiscard]] Result<void> check(const Scenario& scenario, const zone::TrafficZone& zone, const std::string& origin);

/// Hands out the steps that are due.
class ScenarioPlayer {
 public:
  explicit ScenarioPlayer(const Scenario& scenario) : steps_{scenario.steps} {}
  void begin(SimTime now) { begun_ = now; }
  [[nodiscard]] bool begun() const { return begun_.has_value(); }
  /// Those due up to `now`, each once; none before begin().
  [[nodiscard]] std::vector<Scenario::Step> due(SimTime now);
  [[nodiscard]] std::optional<SimTime> next_due() const;
  [[nodiscard]] bool done() const { return next_ == steps_.size(); }

 private:
  std::vector<Scenario::Step> steps_;
  std::size_t next_{0};
  std::optional<SimTime> begun_;
};

}  // namespace cosiva::experiments
