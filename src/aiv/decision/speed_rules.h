#pragma once

#include <memory>
#include <string>

#include "cosiva/aiv/motion/speed.h"
#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/base/result.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::aiv {

/// The rules by which an agent chooses its speed; a value that options carry.
struct SpeedRules {
  enum class Kind {
    crisp,   ///< CrispSpeedPolicy
    fuzzy,   ///< the rules that come with the platform
    custom,  ///< those in `fll`
  };
  Kind kind{Kind::crisp};
  std::string origin;  ///< of custom rules: their file, for errors
  std::string fll;     ///< custom rules' text

  friend bool operator==(const SpeedRules&, const SpeedRules&) = default;
};

/// Fails on custom rules that cannot be used, as AgentRules::read.
[[nodiscard]] Result<std::unique_ptr<SpeedPolicy>> make_speed_policy(const SpeedRules& rules,
                                                                     const zone::SpeedProfiles& profiles);
/// "crisp", "fuzzy", or {"origin","fll"}.
void write_json(JsonWriter& json, const SpeedRules& rules);
/// Fails ("options.rules") on anything else, and on custom rules that cannot be used.
[[nodiscard]] Result<SpeedRules> speed_rules_from_json(const JsonValue& json);

}  // namespace cosiva::aiv
