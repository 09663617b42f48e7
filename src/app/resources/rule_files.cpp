#include "cosiva/app/resources/rule_files.h"

#include "cosiva/adapters/files.h"

namespace cosiva::app {

Result<aiv::SpeedRules> load_speed_rules(const std::string& word_or_file) {
  using Kind = aiv::SpeedRules::Kind;
  if (word_or_file == "crisp") return aiv::SpeedRules{Kind::crisp, {}, {}};
  if (word_or_file == "fuzzy") return aiv::SpeedRules{Kind::fuzzy, {}, {}};
  auto text = adapters::read_file(word_or_file);
  if (!text) return tl::unexpected(text.error());
  if (auto read = aiv::AgentRules::read(*text, word_or_file); !read) return tl::unexpected(read.error());
  return aiv::SpeedRules{Kind::custom, word_or_file, std::move(*text)};
}

Result<std::shared_ptr<const aiv::AgentRules>> load_fleet_rules(const std::string& word_or_file) {
  if (word_or_file == "crisp") return nullptr;
  return load_agent_rules(word_or_file);
}

Result<std::shared_ptr<const aiv::AgentRules>> load_agent_rules(const std::string& word_or_file) {
  const auto rules = load_speed_rules(word_or_file);
  if (!rules) return tl::unexpected(rules.error());
  if (rules->kind == aiv::SpeedRules::Kind::custom) return aiv::AgentRules::read(rules->fll, rules->origin);
  if (rules->kind == aiv::SpeedRules::Kind::fuzzy) return aiv::AgentRules::built_in();
  return fail("rules.crisp", "the crisp speed policy has no rules to inspect; give a file or 'fuzzy'", "--rules");
}

}  // namespace cosiva::app
