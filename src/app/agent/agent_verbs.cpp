// `cosiva agent explain` and `surface`: why an agent's rules say what they say.
#include <optional>
#include <string>
#include <utility>

#include "cosiva/adapters/files.h"
#include "cosiva/aiv/motion/formulas.h"
#include "cosiva/app/agent/agent_arguments.h"
#include "cosiva/app/agent/surface.h"
#include "cosiva/app/cli/words.h"
#include "cosiva/app/resources/rule_files.h"
#include "cosiva/app/resources/zone_files.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/drawing/png/picture.h"

namespace cosiva::app {
namespace {

using aiv::AgentInput;

/// The inputs as the command line gave them; what the operator asks for came as a word, its speed in metres per second.
Result<aiv::AgentInputs> inputs_from(const AgentArguments& arguments) {
  aiv::AgentInputs inputs = arguments.inputs;
  const double gap = inputs[static_cast<std::size_t>(AgentInput::gap)];
  // Nothing is closed in on where nothing is.
  if (arguments.speed_mps && gap < aiv::facts_of(AgentInput::gap).free) {
    const auto rtm = open_zone(arguments.zone);
    if (!rtm) return tl::unexpected(rtm.error());
    inputs[static_cast<std::size_t>(AgentInput::closing)] =
        aiv::plain::closing_input(*arguments.speed_mps, rtm->zone().profiles.medium.speed_mps);
  }
  double& instruction = inputs[static_cast<std::size_t>(AgentInput::instruction)];
  if (arguments.instruction == "none") return inputs;
  const auto profile = aiv::parse_profile(arguments.instruction);
  if (!profile) return fail("agent.instruction", "it is stop, slow, medium, fast or none", "--instruction");
  instruction = static_cast<double>(*profile);
  return inputs;
}

std::string decision_text(const aiv::AgentRules& rules, const aiv::AgentDecision& decision) {
  std::string text = "decision: " + std::string(to_string(decision.profile)) + " (" + decimals(decision.speed, 2) +
                     " of 0 stop, 1 slow, 2 medium, 3 fast)";
  if (decision.decided_by) text += ", because of " + rules.base().engine().outputs[*decision.decided_by].name;
  if (rules.base().find_output("go"))
    text += std::string("; at the crossing it ") + (decision.goes() ? "goes" : "gives way");
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
  if (!rules) return complain(rules.error());
  const auto inputs = inputs_from(arguments);
  if (!inputs) return complain(inputs.error());
  std::optional<aiv::Profile> present;
  if (!arguments.present.empty()) {
    present = aiv::parse_profile(arguments.present);
    if (!present) return complain({"agent.present", "it is stop, slow, medium or fast", "--present"});
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

int run_agent_surface(const AgentArguments& arguments) {
  const auto rules = load_agent_rules(arguments.rules);
  if (!rules) return complain(rules.error());
  const auto inputs = inputs_from(arguments);
  if (!inputs) return complain(inputs.error());
  const std::string& out = arguments.out_file;
  const bool is_drawn = !out.empty();
  if (is_drawn && !out.ends_with(".svg") && !out.ends_with(".png"))
    return complain({"agent.out", "a picture's name ends with .svg or .png", out});
  // A terminal has fewer fields than a picture, and a program wants round steps.
  const std::size_t columns = is_drawn ? 161 : arguments.json ? 41 : 65;
  const std::size_t rows = is_drawn ? 121 : arguments.json ? 41 : 21;
  const auto surface = make_surface(**rules, arguments.x, arguments.y, arguments.of, *inputs, columns, rows);
  if (!surface) return complain(surface.error());
  if (!is_drawn) {
    print(arguments.json ? to_json(*surface) : to_text(*surface));
    return exit_done;
  }
  std::string bytes = to_svg(*surface);
  if (out.ends_with(".png")) {
    auto png = png_of(bytes, arguments.width_px);
    if (!png) return complain(png.error());
    bytes = std::move(*png);
  }
  if (auto written = adapters::write_file(out, bytes); !written) return complain(written.error());
  say("drawn into " + out);
  return exit_done;
}

}  // namespace cosiva::app
