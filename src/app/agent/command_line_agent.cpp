// The options of `cosiva agent` and its subcommands, with their help texts.
#include "cosiva/app/agent/command_line_agent.h"

#include "cosiva/app/agent/agent_explain_command.h"
#include "cosiva/app/agent/agent_surface_command.h"
#include "cosiva/app/cli/common_options.h"

namespace cosiva::app {
namespace {

constexpr const char* agent_examples =
    "Examples:\n"
    "  cosiva agent explain --gap 1.2 --closing 40          which rules fire, how strongly, and why\n"
    "  cosiva agent surface --x gap --y closing             the chosen speed, in the terminal\n"
    "  cosiva agent surface --x margin --y priority --crossing 1 --of go --out go.png\n"
    "\n"
    "docs/guide/agents.md explains how to read and edit the rules.";

constexpr const char* explain_examples =
    "Examples:\n"
    "  cosiva agent explain --gap 0.9 --closing 60\n"
    "  cosiva agent explain --gap 0.9 --speed 0.4           towards a stopped body\n"
    "  cosiva agent explain --rules my.fll --charge 9 --json";

constexpr const char* surface_examples =
    "Examples:\n"
    "  cosiva agent surface --x gap --y closing --out surface.svg\n"
    "  cosiva agent surface --rules my.fll --x gap --y charge --instruction fast --out surface.png";

void add_inputs(Command command, AgentArguments& agent) {
  command.add_option("--rules", agent.rules, "rules to inspect: a file, or fuzzy for the built-in rules")
      .value_name("FILE")
      .show_default();
  command.add_option("--instruction", agent.instruction, "what the operator requests: stop, slow, medium, fast or none")
      .value_name("WORD")
      .show_default();
  for (std::size_t i = 0; i < aiv::agent_input_count; ++i) {
    const auto input = static_cast<aiv::AgentInput>(i);
    if (input == aiv::AgentInput::instruction) continue;
    const aiv::AgentInputInfo& metadata = aiv::metadata_of(input);
    std::string what(metadata.meaning);
    if (!metadata.unit.empty()) what += " [" + std::string(metadata.unit) + "]";
    command.add_option("--" + std::string(metadata.name), agent.inputs[i], what).value_name("N").show_default();
  }
  command.add_option("--speed", agent.speed_mps, "instead of --closing: own speed, towards a stopped body [m/s]")
      .value_name("N")
      .in_range(0.0, 100.0)
      .excludes(command.option("--closing"));
  command.add_option("--zone", agent.zone, "with --speed: the zone whose medium speed is used")
      .value_name("NAME|FILE")
      .show_default();
  command.add_flag("--json", agent.json, "print the result as JSON");
}

}  // namespace

AgentCommands describe_agent(Command root, AgentArguments& agent) {
  AgentCommands commands{};
  commands.agent = root.add_subcommand("agent", "Inspect how an AIV chooses its speed: its fuzzy rules");
  commands.agent.at_most_one_subcommand();
  commands.agent.footer(agent_examples);
  commands.explain =
      commands.agent.add_subcommand("explain", "Print which rules fire in a situation, why, and what they decide");
  commands.surface = commands.agent.add_subcommand("surface", "Draw the output of the rules over two of their inputs");
  for (const Command command : {commands.explain, commands.surface}) add_inputs(command, agent);
  commands.explain.add_option("--present", agent.present, "the present speed profile; without: none")
      .value_name("WORD");
  commands.explain.add_flag("--all", agent.every_rule, "print the rules that did not fire as well");
  commands.explain.footer(explain_examples);
  commands.surface.add_option("--x", agent.x, "the input on the horizontal axis").value_name("INPUT").show_default();
  commands.surface.add_option("--y", agent.y, "the input on the vertical axis").value_name("INPUT").show_default();
  commands.surface.add_option("--of", agent.of, "what is drawn: speed, which decides, or one of the rules' outputs")
      .value_name("OUTPUT")
      .show_default();
  commands.surface.add_option("--out", agent.out_file, "an image, .svg or .png; without: as text").value_name("FILE");
  commands.surface.add_option("--width", agent.width_px, "of a PNG")
      .value_name("PX")
      .in_range(16, 16384)
      .show_default();
  commands.surface.footer(surface_examples);
  return commands;
}

std::optional<int> run_agent_command(const AgentCommands& commands, const AgentArguments& agent) {
  if (commands.explain.chosen()) return run_agent_explain(agent);
  if (commands.surface.chosen()) return run_agent_surface(agent);
  return std::nullopt;
}

}  // namespace cosiva::app
