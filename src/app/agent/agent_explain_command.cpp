#include "cosiva/app/agent/agent_explain_command.h"

#include <optional>
#include <string>

#include "cosiva/app/agent/agent_inputs.h"
#include "cosiva/app/cli/console.h"
#include "cosiva/app/resources/rule_files.h"
#include "cosiva/base/json_writer.h"

namespace cosiva::app {
namespace {

std::string decision_text(const aiv::AgentRules& rules, const aiv::AgentDecision& decision) {
  std::string text = "decision: " + std::string(to_string(decision.profile)) + " (" + decimals(decision.speed, 2) +
                     " of 0 stop, 1 slow, 2 medium, 3 fast)";
  if (decision.decided_by) text += ", because of " + rules.base().engine().outputs[*decision.decided_by].name;
  if (rules.base().find_output("go"))
    text += std::string("; at the crossing it ") + (decision.goes() ? "goes" : "yields");
  return text;
}

std::string decision_json(const aiv::AgentRules& rules, const aiv::AgentDecision& decision,
                          const fuzzy::Explanation& explanation) {
  JsonWriter json;
  json.begin_object().field("profile", to_string(decision.profile)).field("speed", decision.speed);
  json.key("decided_by");
  if (decision.decided_by)
    json.value(rules.base().engine().outputs[*decision.decided_by].name);
  else
    json.null();
  json.field("go", decision.go).field("goes", decision.goes());
  fuzzy::write_json(json.key("explanation"), explanation);
  json.end_object();
  return json.take();
}

}  // namespace

int run_agent_explain(const AgentArguments& arguments) {
  const auto rules = load_agent_rules(arguments.rules);
  if (!rules) return report_error(rules.error());
  const auto inputs = inputs_from(arguments);
  if (!inputs) return report_error(inputs.error());
  std::optional<aiv::Profile> present;
  if (!arguments.present.empty()) {
    present = aiv::parse_profile(arguments.present);
    if (!present) return report_error({"agent.present", "expected stop, slow, medium or fast", "--present"});
  }
  const aiv::AgentDecision decision = (*rules)->decide(*inputs, present);
  const fuzzy::Explanation explanation = (*rules)->explain(*inputs);
  if (arguments.json) {
    print(decision_json(**rules, decision, explanation));
    return exit_done;
  }
  std::string text = decision_text(**rules, decision) + "\n" + to_text(explanation, arguments.every_rule);
  text.pop_back();  // print ends the line
  print(text);
  return exit_done;
}

}  // namespace cosiva::app
