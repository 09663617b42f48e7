#include "cosiva/app/command_line.h"

#include <string>

#include "cosiva/app/agent/command_line_agent.h"
#include "cosiva/app/battery/command_line_battery.h"
#include "cosiva/app/cli/console.h"
#include "cosiva/app/cli/options.h"
#include "cosiva/app/gvs/command_line_gvs.h"
#include "cosiva/app/journal/command_line_journal.h"
#include "cosiva/app/platform/command_line_platform.h"
#include "cosiva/app/positioning/command_line_campaign.h"
#include "cosiva/app/positioning/command_line_qualify.h"
#include "cosiva/app/simulate/command_line_simulate.h"
#include "cosiva/app/traffic/command_line_traffic.h"
#include "cosiva/app/traffic/traffic_command.h"
#include "cosiva/app/vehicle/command_line_vehicle.h"
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

}  // namespace

int run_command_line(int argc, const char* const* argv) {
  const CommandLine line{about, "cosiva"};
  const Command root = line.root();
  root.footer(exit_codes);
  line.version(std::string("cosiva ") + COSIVA_VERSION);
  root.at_most_one_subcommand();

  PlatformArguments platform;
  ZoneArguments zone;
  GenerateArguments generate;
  ScenarioArguments scenario;
  AllAgentArguments agent;
  FleetTrafficArguments traffic;
  CapacityArguments capacity;
  QualifyArguments qualify;
  const PlatformCommands platform_commands = describe_platform(root, platform);
  const Command traffic_command = describe_traffic(root, traffic);
  const Command capacity_command = describe_capacity(root, capacity);
  const ZoneCommands zone_commands = describe_zone(root, zone, generate);
  VehicleArguments vehicle;
  const VehicleCommands vehicle_commands = describe_vehicle(root, vehicle);
  const ScenarioCommands scenario_commands = describe_scenario(root, scenario);
  const AgentCommands agent_commands = describe_agent(root, agent);
  BatteryArguments battery;
  const BatteryCommands battery_commands = describe_battery(root, battery);
  const QualifyCommands qualify_commands = describe_qualify(root, qualify);
  CampaignArguments campaign;
  const Command campaign_command = describe_campaign(root, campaign);
  GvsArguments gvs;
  const GvsCommands gvs_commands = describe_gvs(root, gvs);

  JournalArguments journal;
  const JournalCommands journal_commands = describe_journal(root, journal);
  SimulateArguments simulate;
  const Command simulate_command = describe_simulate(root, simulate);

  if (const auto status = line.parse(argc, argv)) return *status;
  if (const auto status = run_platform_command(platform_commands, platform)) return *status;
  if (traffic_command.chosen()) return run_traffic(traffic);
  if (capacity_command.chosen()) return run_capacity(capacity);
  if (campaign_command.chosen()) return run_campaign(campaign);
  if (const auto status = run_zone_command(zone_commands, zone, generate)) return *status;
  if (const auto status = run_vehicle_command(vehicle_commands, vehicle)) return *status;
  if (const auto status = run_agent_command(agent_commands, agent)) return *status;
  if (const auto status = run_battery_command(battery_commands, battery)) return *status;
  if (battery_commands.battery.chosen())
    return battery_commands.battery.refuse(
        "a subcommand is missing: sampled, fleet, fit, ready, plan, discharge, analyse, compare or check");
  if (const auto status = run_qualify_command(qualify_commands, qualify, argc, argv)) return *status;
  if (const auto status = run_gvs_command(gvs_commands, gvs)) return *status;
  if (const auto status = run_journal_command(journal_commands, journal)) return *status;
  if (const auto status = run_simulate_command(simulate_command, simulate)) return *status;
  if (journal_commands.journal.chosen())
    return journal_commands.journal.refuse("a subcommand is missing: list, verify, export, compact or repair");
  if (gvs_commands.gvs.chosen())
    return gvs_commands.gvs.refuse("a subcommand is missing: calibrate, track, render or watch");
  if (agent_commands.agent.chosen())
    return agent_commands.agent.refuse("a subcommand is missing: explain, surface, measure or search");
  if (const auto status = run_scenario_command(scenario_commands, scenario)) return *status;
  if (scenario_commands.scenario.chosen())
    return scenario_commands.scenario.refuse("a subcommand is missing: check or list");
  if (zone_commands.zone.chosen())
    return zone_commands.zone.refuse("a subcommand is missing: check, show, convert, generate or switch");
  if (vehicle_commands.vehicle.chosen())
    return vehicle_commands.vehicle.refuse(
        "a subcommand is missing: list, exclude, include, retire, self-test, boards or line-tracking");
  print(root.help());
  return exit_done;
}

}  // namespace cosiva::app
