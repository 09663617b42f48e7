#pragma once

#include <memory>
#include <string>

#include "cosiva/aiv/decision/agent_rules.h"
#include "cosiva/aiv/decision/speed_rules.h"
#include "cosiva/base/result.h"

namespace cosiva::app {

/// Loads the rules of `--rules`: "crisp", "fuzzy" (the built-in rules) or a file, which is read and checked. Fails
/// ("file.read") on a file that cannot be read, and with file and line on invalid rules.
[[nodiscard]] Result<aiv::SpeedRules> load_speed_rules(const std::string& word_or_file);
/// The same for a fleet; null: crisp.
[[nodiscard]] Result<std::shared_ptr<const aiv::AgentRules>> load_fleet_rules(const std::string& word_or_file);
/// The same for commands that inspect rules: "crisp" fails ("rules.crisp").
[[nodiscard]] Result<std::shared_ptr<const aiv::AgentRules>> load_agent_rules(const std::string& word_or_file);

}  // namespace cosiva::app
