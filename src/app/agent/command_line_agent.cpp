// The options of `cosiva agent` and its subcommands, with their help texts.
#include "cosiva/app/agent/command_line_agent.h"

#include "cosiva/app/agent/agent_explain_command.h"
#include "cosiva/app/agent/agent_measure_command.h"
#include "cosiva/app/agent/agent_search_command.h"
#include "cosiva/app/agent/agent_surface_command.h"
#include "cosiva/app/cli/common_options.h"

namespace cosiva::app {
namespace {

constexpr const char* agent_examples =
    "Examples:\n"
    "  cosiva agent explain --gap 1.2 --closing 40          which rules fire, how strongly, and why\n"
    "  cosiva agent surface --x gap --y closing             the chosen speed, in the terminal\n"
    "  cosiva agent surface --x margin --y priority --crossing 1 --of go --out go.png\n"
    "  cosiva agent measure --rules my.fll                  laps, stops and energy against the crisp rules\n"
    "  cosiva agent search --rules my.fll --out search      better numbers for a rule file\n"
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

constexpr const char* measure_examples =
    "Each seed is a run of the whole platform in virtual time at the live platform's cycle with the crisp rules, and "
    "one\n"
    "with the given rules; a stop is a transition from moving to standstill (less than 1 cm/s). Status 1 where the "
    "rules\n"
    "drive fewer laps or stop more often in any case (shown at 95 % over the pairs), or vehicles collide.\n"
    "\n"
    "Examples:\n"
    "  cosiva agent measure                                 the built-in rules, 20 seeds of 10 min in six cases\n"
    "  cosiva agent measure --rules my.fll --seeds 1..4 --minutes 3 --vehicles 24 --persons 0\n"
    "  cosiva agent measure --fewer-stops 20 --out measured";

constexpr const char* search_examples =
    "An evolution strategy changes the corners of the inputs' terms and the constants of the outputs. The properties "
    "that\n"
    "tests require of the rules hold for every candidate. Measure the result with other seeds than the training's.\n"
    "\n"
    "Examples:\n"
    "  cosiva agent search --budget 80 --out search         writes agent.fll, report.json and report.html\n"
    "  cosiva agent search --rules my.fll --vehicles 24 --seeds 1..3";

void add_fleet(Command command, FleetArguments& fleet) {
  command.add_option("--rules", fleet.rules, "the rules: a file, or fuzzy for the built-in rules")
      .value_name("FILE")
      .show_default();
  command.add_option("--zone", fleet.zone, "traffic zone: a ready one's name or a file")
      .value_name("NAME|FILE")
      .show_default();
  command.add_option("--vehicles", fleet.vehicles, "how many vehicles, one case for each number")
      .value_name("N,N…")
      .separator(',')
      .in_range(1U, 200U)
      .show_default();
  command.add_option("--persons", fleet.persons, "how many persons walk to and fro across the path, likewise")
      .value_name("N,N…")
      .separator(',')
      .in_range(0U, 20U)
      .show_default();
  command.add_option("--seeds", fleet.seeds, "the first and the last one").value_name("A..B").show_default();
  command.add_option("--minutes", fleet.minutes, "of virtual time, for each run")
      .value_name("M")
      .in_range(0.2, 1000.0)
      .show_default();
  command.add_option("--jobs", fleet.jobs, "runs at a time; 0: one for each processor").value_name("N").show_default();
}

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

/// The subcommands that run whole fleets.
void describe_fleets(AgentCommands& commands, AllAgentArguments& all) {
  commands.measure = commands.agent.add_subcommand("measure", "Compare fleets that drive by rules with crisp ones");
  add_fleet(commands.measure, all.measure);
  commands.measure
      .add_option("--fewer-stops", all.measure.fewer_stops_percent,
                  "status 1 unless the largest fleet stops less often")
      .value_name("PERCENT")
      .in_range(0.0, 100.0)
      .show_default();
  commands.measure.add_option("--out", all.measure.out_folder, "a folder for report.html and report.json")
      .value_name("FOLDER");
  commands.measure.add_flag("--json", all.measure.json, "print the result as JSON");
  commands.measure.footer(measure_examples);
  commands.search = commands.agent.add_subcommand("search", "Search better numbers for a rule file");
  add_fleet(commands.search, all.search);
  commands.search.add_option("--variables", all.search.variables, "whose numbers are changed; without: all")
      .value_name("NAME,NAME…")
      .separator(',');
  commands.search.add_option("--seed", all.search.seed, "of the search's own draws").value_name("N").show_default();
  commands.search.add_option("--budget", all.search.budget, "how many candidates are run")
      .value_name("N")
      .in_range(0U, 100'000U)
      .show_default();
  commands.search.add_option("--out", all.search.out_folder, "a folder for the rules and the reports")
      .value_name("FOLDER")
      .show_default();
  commands.search.footer(search_examples);
}

}  // namespace

AgentCommands describe_agent(Command root, AllAgentArguments& all) {
  AgentArguments& agent = all.inspect;
  AgentCommands commands{};
  commands.agent = root.add_subcommand("agent", "Inspect, measure and improve the fuzzy rules of the AIVs");
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
  describe_fleets(commands, all);
  return commands;
}

std::optional<int> run_agent_command(const AgentCommands& commands, const AllAgentArguments& agent) {
  if (commands.explain.chosen()) return run_agent_explain(agent.inspect);
  if (commands.surface.chosen()) return run_agent_surface(agent.inspect);
  if (commands.measure.chosen()) return run_agent_measure(agent.measure);
  if (commands.search.chosen()) return run_agent_search(agent.search);
  return std::nullopt;
}

}  // namespace cosiva::app
