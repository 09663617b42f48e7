#include "cosiva/app/command_line.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <string>
#include <vector>

#include "cosiva/app/agent/command_line_agent.h"
#include "cosiva/app/battery/command_line_battery.h"
#include "cosiva/app/cli/console.h"
#include "cosiva/app/gvs/command_line_gvs.h"
#include "cosiva/app/platform/command_line_platform.h"
#include "cosiva/app/positioning/command_line_campaign.h"
#include "cosiva/app/positioning/command_line_qualify.h"
#include "cosiva/app/traffic/command_line_traffic.h"
#include "cosiva/app/traffic/traffic_command.h"
#include "cosiva/app/zone/command_line_zone.h"

namespace cosiva::app {
namespace {

constexpr const char* about =
    "CoSiVA: a fleet of autonomous industrial vehicles and its virtual twin, in step.\n"
    "\n"
    "  cosiva up                                      four AIVs on lacet4, with their page on http://127.0.0.1:8080\n"
    "  cosiva up --scenario showroom                   the same, with a varied scenario\n"
    "  cosiva up --virtual-time --duration 600 --json  ten minutes in seconds, the same digest every time\n"
    "  cosiva traffic --zone indus8 --jobs-per-hour 60 an hour of transport jobs in a second, with a heat map";

constexpr const char* exit_codes = "Exit status: 0 done, 1 the run's own checks failed, 2 bad usage or bad input.";

/// All options of a subcommand, for "did you mean".
std::vector<std::string> option_names(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

/// The command as typed, such as `cosiva zone check`.
std::string typed(const CLI::App& command) {
  return command.get_parent() == nullptr ? "cosiva" : typed(*command.get_parent()) + " " + command.get_name();
}

int refuse(const std::string& message, const CLI::App& command) {
  const std::string name = typed(command);
  print_info(name + ": " + message);
  print_info("`" + name + " --help` lists the options");
  return exit_bad_input;
}

int refuse_unknown(const CLI::App& root) {
  const CLI::App* command = &root;
  while (!command->get_subcommands().empty()) command = command->get_subcommands().front();
  std::vector<std::string> unknown = root.remaining(true);
  // The arguments after an unknown subcommand, and the value after an unknown option, are unknown as well; only the
  // first error is reported.
  const auto is_option = [](const std::string& word) { return word.starts_with('-'); };
  if (std::ranges::any_of(unknown, is_option)) {
    std::erase_if(unknown, [&](const std::string& word) { return !is_option(word); });
  } else {
    unknown.resize(1);
  }
  std::string message;
  for (const std::string& word : unknown) {
    message += (message.empty() ? "'" : "\n  '") + word + "' is unknown";
    std::vector<std::string> candidates = option_names(*command);
    for (const CLI::App* sub : command->get_subcommands([](const CLI::App*) { return true; }))
      candidates.push_back(sub->get_name());
    if (const std::string near = nearest_word(word, candidates); !near.empty())
      message += "; did you mean '" + near + "'?";
  }
  return refuse(message, *command);
}

}  // namespace

int run_command_line(int argc, const char* const* argv) {
  CLI::App root{about, "cosiva"};
  root.footer(exit_codes);
  root.set_version_flag("--version", std::string("cosiva ") + COSIVA_VERSION);
  root.require_subcommand(0, 1);

  PlatformArguments platform;
  ZoneArguments zone;
  GenerateArguments generate;
  ScenarioArguments scenario;
  AgentArguments agent;
  FleetTrafficArguments traffic;
  CapacityArguments capacity;
  QualifyArguments qualify;
  const PlatformCommands platform_commands = describe_platform(root, platform);
  CLI::App* traffic_command = describe_traffic(root, traffic);
  CLI::App* capacity_command = describe_capacity(root, capacity);
  const ZoneCommands zone_commands = describe_zone(root, zone, generate);
  const ScenarioCommands scenario_commands = describe_scenario(root, scenario);
  const AgentCommands agent_commands = describe_agent(root, agent);
  BatteryArguments battery;
  const BatteryCommands battery_commands = describe_battery(root, battery);
  const QualifyCommands qualify_commands = describe_qualify(root, qualify);
  CampaignArguments campaign;
  CLI::App* campaign_command = describe_campaign(root, campaign);
  GvsArguments gvs;
  const GvsCommands gvs_commands = describe_gvs(root, gvs);

  try {
    root.parse(argc, argv);
  } catch (const CLI::ExtrasError&) {
    return refuse_unknown(root);
  } catch (const CLI::Success& requested) {
    root.exit(requested);  // --help, --version: to standard output
    return exit_done;
  } catch (const CLI::ParseError& error) {
    const CLI::App* command = &root;
    while (!command->get_subcommands().empty()) command = command->get_subcommands().front();
    return refuse(error.what(), *command);
  }

  if (const auto status = run_platform_command(platform_commands, platform)) return *status;
  if (traffic_command->parsed()) return run_traffic(traffic);
  if (capacity_command->parsed()) return run_capacity(capacity);
  if (campaign_command->parsed()) return run_campaign(campaign);
  if (const auto status = run_zone_command(zone_commands, zone, generate)) return *status;
  if (const auto status = run_agent_command(agent_commands, agent)) return *status;
  if (const auto status = run_battery_command(battery_commands, battery)) return *status;
  if (battery_commands.battery->parsed())
    return refuse("a subcommand is missing: sampled, fleet, fit, ready, plan, discharge, analyse, compare or check",
                  *battery_commands.battery);
  if (const auto status = run_qualify_command(qualify_commands, qualify, argc, argv)) return *status;
  if (const auto status = run_gvs_command(gvs_commands, gvs)) return *status;
  if (gvs_commands.gvs->parsed())
    return refuse("a subcommand is missing: calibrate, track, render or watch", *gvs_commands.gvs);
  if (agent_commands.agent->parsed())
    return refuse("a subcommand is missing: explain or surface", *agent_commands.agent);
  if (const auto status = run_scenario_command(scenario_commands, scenario)) return *status;
  if (scenario_commands.scenario->parsed())
    return refuse("a subcommand is missing: check or list", *scenario_commands.scenario);
  if (zone_commands.zone->parsed())
    return refuse("a subcommand is missing: check, show, convert, generate or switch", *zone_commands.zone);
  print(root.help());
  return exit_done;
}

}  // namespace cosiva::app
