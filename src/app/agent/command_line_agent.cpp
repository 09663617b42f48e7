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

void add_inputs(CLI::App& command, AgentArguments& agent) {
  command.add_option("--rules", agent.rules, "rules to inspect: a file, or fuzzy for the built-in rules")
      ->type_name("FILE")
      ->capture_default_str();
  command
      .add_option("--instruction", agent.instruction, "what the operator requests: stop, slow, medium, fast or none")
      ->type_name("WORD")
      ->capture_default_str();
  CLI::Option* closing = nullptr;
  for (std::size_t i = 0; i < aiv::agent_input_count; ++i) {
    const auto input = static_cast<aiv::AgentInput>(i);
    if (input == aiv::AgentInput::instruction) continue;
    const aiv::AgentInputInfo& metadata = aiv::metadata_of(input);
    std::string what(metadata.meaning);
    if (!metadata.unit.empty()) what += " [" + std::string(metadata.unit) + "]";
    CLI::Option* option = command.add_option("--" + std::string(metadata.name), agent.inputs[i], what);
    option->type_name("N")->capture_default_str();
    if (input == aiv::AgentInput::closing) closing = option;
  }
  command.add_option("--speed", agent.speed_mps, "instead of --closing: own speed, towards a stopped body [m/s]")
      ->type_name("N")
      ->check(CLI::Range(0.0, 100.0))
      ->excludes(closing);
  command.add_option("--zone", agent.zone, "with --speed: the zone whose medium speed is used")
      ->type_name("NAME|FILE")
      ->capture_default_str();
  command.add_flag("--json", agent.json, "print the result as JSON");
}

}  // namespace

AgentCommands describe_agent(CLI::App& root, AgentArguments& agent) {
  AgentCommands commands{};
  commands.agent = root.add_subcommand("agent", "Inspect how an AIV chooses its speed: its fuzzy rules");
  commands.agent->require_subcommand(0, 1);
  commands.agent->footer(agent_examples);
  commands.explain =
      commands.agent->add_subcommand("explain", "Print which rules fire in a situation, why, and what they decide");
  commands.surface = commands.agent->add_subcommand("surface", "Draw the output of the rules over two of their inputs");
  for (CLI::App* command : {commands.explain, commands.surface}) add_inputs(*command, agent);
  commands.explain->add_option("--present", agent.present, "the present speed profile; without: none")
      ->type_name("WORD");
  commands.explain->add_flag("--all", agent.every_rule, "print the rules that did not fire as well");
  commands.explain->footer(explain_examples);
  commands.surface->add_option("--x", agent.x, "the input on the horizontal axis")
      ->type_name("INPUT")
      ->capture_default_str();
  commands.surface->add_option("--y", agent.y, "the input on the vertical axis")
      ->type_name("INPUT")
      ->capture_default_str();
  commands.surface->add_option("--of", agent.of, "what is drawn: speed, which decides, or one of the rules' outputs")
      ->type_name("OUTPUT")
      ->capture_default_str();
  commands.surface->add_option("--out", agent.out_file, "an image, .svg or .png; without: as text")->type_name("FILE");
  commands.surface->add_option("--width", agent.width_px, "of a PNG")
      ->type_name("PX")
      ->check(CLI::Range(16, 16384))
      ->capture_default_str();
  commands.surface->footer(surface_examples);
  return commands;
}

std::optional<int> run_agent_command(const AgentCommands& commands, const AgentArguments& agent) {
  if (commands.explain->parsed()) return run_agent_explain(agent);
  if (commands.surface->parsed()) return run_agent_surface(agent);
  return std::nullopt;
}

}  // namespace cosiva::app
