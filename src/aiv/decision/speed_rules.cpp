#include "cosiva/aiv/decision/speed_rules.h"

#include <utility>

#include "cosiva/aiv/decision/agent_rules.h"

namespace cosiva::aiv {

Result<std::unique_ptr<SpeedPolicy>> make_speed_policy(const SpeedRules& rules, const zone::SpeedProfiles& profiles) {
  if (rules.kind == SpeedRules::Kind::crisp) return std::make_unique<CrispSpeedPolicy>();
  if (rules.kind == SpeedRules::Kind::fuzzy)
    return std::make_unique<FuzzySpeedPolicy>(AgentRules::built_in(), profiles);
  auto read = AgentRules::read(rules.fll, rules.origin);
  if (!read) return tl::unexpected(read.error());
  return std::make_unique<FuzzySpeedPolicy>(std::move(*read), profiles);
}

void write_json(JsonWriter& json, const SpeedRules& rules) {
  if (rules.kind == SpeedRules::Kind::custom)
    json.begin_object().field("origin", rules.origin).field("fll", rules.fll).end_object();
  else
    json.value(rules.kind == SpeedRules::Kind::fuzzy ? "fuzzy" : "crisp");
}

Result<SpeedRules> speed_rules_from_json(const JsonValue& json) {
  if (const std::string* word = json.text()) {
    if (*word == "crisp") return SpeedRules{};
    if (*word == "fuzzy") return SpeedRules{SpeedRules::Kind::fuzzy, {}, {}};
  }
  if (json.object() != nullptr) {
    if (const auto fll = json.text("fll")) {
      SpeedRules rules{SpeedRules::Kind::custom, json.text("origin").value_or("rules"), *fll};
      if (auto read = AgentRules::read(rules.fll, rules.origin); !read) return tl::unexpected(read.error());
      return rules;
    }
  }
  return fail("options.rules", "expected 'crisp', 'fuzzy' or an object with origin and fll", "rules");
}

}  // namespace cosiva::aiv
