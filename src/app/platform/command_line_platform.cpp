// The options of the platform and its parts, with their help texts.
#include "cosiva/app/platform/command_line_platform.h"

#include <string>

#include "cosiva/app/cli/common_options.h"
#include "cosiva/app/gvs/command_line_gvs.h"
#include "cosiva/app/platform/up_command.h"

namespace cosiva::app {
namespace {

void add_equipment(Command command, std::vector<std::string>& line_tracking, std::vector<std::string>& without_rali) {
  command
      .add_option("--line-tracking", line_tracking,
                  "algorithm of PILS, of all AIVs or of one: centroid_pd (usual), path_observer or threshold")
      .value_name("[N=]NAME")
      .one_value_each();
  command.add_option("--without-rali", without_rali, "these AIVs have no RALI: their charge is unknown")
      .value_name("N|all")
      .one_value_each();
}

Option add_seconds(Command command, const std::string& name, std::optional<double>& seconds, const std::string& what) {
  return command.add_option(name, seconds, what).value_name("S").in_range(0.001, 1e9);
}

void add_part(Command command, PartArguments& part) {
  add_broker(command, part.broker, "127.0.0.1:1883");
  command.add_option("--record", part.record_file, "record all inputs of this part in a journal (see `replay`)")
      .value_name("FILE");
  command.add_option("--summary", part.summary_file, "write the metrics at the end to a JSON file").value_name("FILE");
  command.add_flag("--json", part.json, "print the metrics at the end as JSON");
  add_seconds(command, "--duration", part.duration_s, "end after this number of seconds");
  command.add_flag("--announce", part.announce).hidden();
}

void add_link(Command command, DirectArguments& direct) {
  const Option multicast =
      command
          .add_option("--v2x-multicast", direct.multicast,
                      "AIVs send V2X messages to each other directly, too, by UDP to this group, such as "
                      "239.192.7.50:7500 or [ff15::c051:7a]:7500 (docs/guide/direct_link.md)")
          .value_name("GROUP:PORT");
  const Option key =
      command
          .add_option("--v2x-key", direct.key_file, "with --v2x-multicast: file of 32 random bytes that all AIVs have")
          .value_name("FILE")
          .needs(multicast);
  multicast.needs(key);
  command.add_option("--v2x-interface", direct.interface_name, "with --v2x-multicast: network interface, such as wlan0")
      .value_name("NAME")
      .needs(multicast);
}

void add_direct(Command command, DirectArguments& direct) {
  add_link(command, direct);
  command
      .add_option("--link-loss", direct.link_loss,
                  "500 ms after the last message of broker or server an AIV brakes, or finishes its base while it "
                  "receives V2X messages of all AIVs there")
      .one_of({"brake", "finish-base"})
      .show_default();
  command
      .add_option("--autonomy", direct.autonomy,
                  "who decides which AIV enters a crossing: the server, or the AIVs among themselves over the direct "
                  "link, while the server observes (negotiate; with --v2x-multicast)")
      .one_of({"server", "negotiate"})
      .show_default();
}

void add_limits(Command command, ServerLimitArguments& limits) {
  command.add_option("--vehicles-max", limits.vehicles_max, "vehicles that the server accepts")
      .value_name("N")
      .in_range(std::uint32_t{1}, std::uint32_t{100'000})
      .show_default();
  command
      .add_option("--expire", limits.entries_expire_s,
                  "a name without a vehicle is removed this number of seconds after its last message; 0: never")
      .value_name("S")
      .in_range(0.0, 3600.0)
      .show_default();
  command
      .add_option("--vehicle-rate-max", limits.vehicle_rate_max_per_s,
                  "messages per second that are accepted of one vehicle; 0: unlimited")
      .value_name("N")
      .in_range(0.0, 1e6)
      .show_default();
}

constexpr const char* up_examples =
    "Examples:\n"
    "  cosiva up --aivs 8                                   eight AIVs, until Ctrl-C\n"
    "  cosiva up --scenario laboratory                      events over time from a file (cosiva scenario list)\n"
    "  cosiva up --scenario my.toml --aivs 2 --duration 60  the command line overrides the file\n"
    "  cosiva up --virtual-time --scenario rush_hour --json the same in seconds, the same digest every time\n"
    "  cosiva up --virtual-time --page --speed 10           the page at ten times real time; stop and step it there\n"
    "  cosiva up --gvs                                      a camera over the zone measures each AIV's position";

void describe_up(Command command, UpArguments& up) {
  command.footer(up_examples);
  command
      .add_option("--scenario", up.scenario,
                  "events over time: a ready scenario's name or a file (docs/guide/scenarios.md)")
      .value_name("NAME|FILE");
  command.add_option("--name", up.name, "of the run, shown on the page; without: scenario or zone, date and time")
      .value_name("TEXT");
  command.add_option("--zone", up.zone, "traffic zone: a ready one's name or a file")
      .value_name("NAME|FILE")
      .show_default();
  command.add_flag("--watch", up.watch, "switch to the zone's file whenever it is saved, during the run");
  command.add_option("--aivs", up.aivs, "how many vehicles").value_name("N").in_range(1, 200).show_default();
  command.add_flag("--headless", up.headless, "no page; /api/v1 remains available");
  add_seconds(command, "--duration", up.duration_s, "end this number of seconds after the fleet is up, with a summary");
  command.add_flag("--json", up.json, "print the summary as JSON");
  command.add_option("--seed", up.seed, "fixes every random draw of the emulated world").value_name("S").show_default();
  command.add_option("--port", up.port, "of the page on 127.0.0.1; if busy, the next free port is used")
      .value_name("PORT")
      .show_default();
  command.add_option("--record", up.record_file, "record all inputs of the server in a journal (see `replay`)")
      .value_name("FILE");
  command.add_option("--log-dir", up.log_directory, "folder of the logs; it is not deleted").value_name("DIR");
  command.add_option("--log-size", up.log_limits.file_size_max_mb, "largest size of a log file, in MB")
      .value_name("MB")
      .in_range(std::uint32_t{1}, std::uint32_t{10'000})
      .show_default();
  command.add_option("--log-files", up.log_limits.files_max, "number of files of each log; older ones are deleted")
      .value_name("N")
      .in_range(std::uint32_t{1}, std::uint32_t{100})
      .show_default();
  command
      .add_option("--store", up.store,
                  "continue with what this folder keeps: commands, stops, virtual objects, edits; without: a new one "
                  "next to the logs")
      .value_name("DIR");
  command
      .add_option("--keep", up.keep,
                  "remove old parts of the store beyond this age or size, for example 30d/20GB or 12h; all: none; "
                  "without: 30d/20GB")
      .value_name("AGE/SIZE");
  command.add_option("--run-dir", up.run_directory, "folder of sockets and other temporary files; cleared at the end")
      .value_name("DIR");
  command.add_option("--respawn", up.respawn_s, "restart an AIV that died after this number of seconds; 0: never")
      .value_name("S")
      .in_range(0.0, 1e6)
      .show_default();
  command.add_flag("--virtual-time", up.virtual_time,
                   "all in one process, as fast as possible, bit for bit the same each time");
  command.add_flag("--page", up.page, "with --virtual-time: at an adjustable speed, with the page");
  command.add_option("--speed", up.speed, "with --page: virtual seconds per second to begin with; without: 1")
      .value_name("X")
      .in_range(0.1, 100.0);
  command.add_option("--loss", up.loss, "ratio of lost messages, with --virtual-time")
      .value_name("P")
      .in_range(0.0, 0.9);
  command.add_switch("--v2x", up.v2x, "AIVs send V2X messages about their intent to AIVs nearby");
  add_equipment(command, up.line_tracking, up.without_rali);
  add_direct(command, up.direct);
  command
      .add_option(
          "--crossing-units", up.crossing_units,
          "a roadside unit at each crossing, or at the named ones: it repeats V2X messages for AIVs that do not "
          "receive each other, and reports who is in the crossing and who waits (docs/guide/direct_link.md)")
      .value_name("NAME|all")
      .one_value_each();
  command.add_switch("--convoys", up.convoys,
                     "several AIVs of the same direction pass a crossing as a convoy, when that saves time");
  add_limits(command, up.limits);
  const Option gvs = command.add_flag("--gvs", up.gvs,
                                      "a camera over the zone measures each AIV's position, and is shown on the "
                                      "page (docs/guide/gvs.md); without further options: the emulated world's");
  add_gvs_source(command, up.gvs_source, "--gvs-");
  for (const char* name :
       {"calibration", "images", "video", "camera", "rate", "exposure", "line", "tag-side", "vehicle"})
    command.option(std::string("--gvs-") + name).needs(gvs);
  add_rules(command, up.rules, "how all AIVs choose their speed; without: fuzzy");
  command.add_option("--trace-messages", up.trace_file, "write every message as a JSON line").value_name("FILE");
  command.add_option("--web", up.web_directory, "the page's built files, if not web/dist").value_name("DIR");
  add_broker(command, up.broker, "a private one is started on 127.0.0.1");
}

void describe_server(Command command, ServerArguments& server) {
  command.add_option("--port", server.port, "of the page on 127.0.0.1; if busy, the next free port is used")
      .value_name("PORT")
      .show_default();
  command
      .add_option("--area", server.area,
                  "name of this server's control area, where several share a broker (docs/guide/control_areas.md)")
      .value_name("NAME");
  command.add_option("--zone", server.zone, "traffic zone, when no plant serves it").value_name("NAME|FILE");
  command.add_flag("--watch", server.watch, "with --zone: switch to its file whenever it is saved, during the run");
  command
      .add_option("--map-link", server.map_link,
                  "where third-party vehicles download the zone's file; without: from our page's address")
      .value_name("URL");
  command.add_flag("--no-drive", server.no_drive, "monitor only: another master control gives the orders");
  command.add_switch("--v2x", server.v2x, "its virtual AIVs send V2X messages about their intent to AIVs nearby");
  command
      .add_option("--autonomy", server.autonomy,
                  "who decides which AIV enters a crossing: this server, or the AIVs among themselves (negotiate)")
      .one_of({"server", "negotiate"})
      .show_default();
  command.add_switch("--convoys", server.convoys,
                     "several AIVs of the same direction pass a crossing as a convoy, when that saves time");
  add_limits(command, server.limits);
  command.add_flag("--headless", server.headless, "no page; /api/v1 remains available");
  command.add_option("--web", server.web_directory, "the page's built files, if not web/dist").value_name("DIR");
  command
      .add_option("--store", server.store,
                  "folder of the inputs, commands and state that the server keeps and continues with; without: "
                  "$XDG_STATE_HOME/cosiva/store")
      .value_name("DIR");
  command
      .add_option("--keep", server.keep,
                  "remove old parts of the store beyond this age or size, for example 30d/20GB or 12h; all: none; "
                  "without: 30d/20GB")
      .value_name("AGE/SIZE");
  command.add_option("--scenario", server.scenario, "events over time, once its AIVs are present")
      .value_name("NAME|FILE");
  command.add_option("--name", server.name, "of the run, shown on the page").value_name("TEXT");
  add_rules(command, server.rules, "how its virtual AIVs choose their speed; without: fuzzy");
  command.add_flag("--emulated", server.emulated, "there is a plant: the page may show its ground truth");
  command.add_option("--fleet", server.fleet).hidden();
  command.add_option("--zone-file", server.zone_file).hidden();
  command.add_option("--parts", server.parts_file).hidden();
  command.add_option("--watch-file", server.watch_file).hidden();
  command.add_option("--scenario-began", server.began_ms).hidden();
  command.add_option("--scenario-steps-done", server.steps_done).hidden();
  command.footer(
      "Example, a server for vehicles of your own on your own broker:\n"
      "  cosiva server --zone my.toml --broker 10.0.0.5:1883 --store /var/lib/cosiva\n"
      "Two control areas on one broker:\n"
      "  cosiva server --area north --zone north.toml --port 8080\n"
      "  cosiva server --area south --zone south.toml --port 8081");
  add_part(command, server.part);
}

void describe_plant(Command command, PlantArguments& plant) {
  command.add_option("--zone", plant.zone, "traffic zone: a ready one's name or a file")
      .value_name("NAME|FILE")
      .required();
  command.add_option("--vehicles", plant.vehicles, "how many vehicles to emulate")
      .value_name("N")
      .in_range(1, 200)
      .show_default();
  command.add_option("--sockets", plant.sockets_directory, "folder of the boards' sockets")
      .value_name("DIR")
      .required();
  command.add_option("--seed", plant.seed, "fixes every random draw").value_name("S").show_default();
  add_equipment(command, plant.line_tracking, plant.without_rali);
  command.add_option("--state-file", plant.state_file, "preserves the world over a crash: it begins where it ended")
      .value_name("FILE");
  command.footer(
      "Example, the worlds of two vehicles for two on-board programs:\n"
      "  cosiva plant --zone lacet4 --vehicles 2 --sockets /tmp/boards");
  add_part(command, plant.part);
}

void describe_aiv(Command command, AivArguments& aiv) {
  command.add_option("--number", aiv.number, "its number, part of its boards' socket names")
      .value_name("N")
      .in_range(1, 1'000'000)
      .required();
  command.add_option("--sockets", aiv.sockets_directory, "folder of the boards' sockets").value_name("DIR").required();
  command.add_option("--serial", aiv.serial, "its serial number; without: AIV<number>").value_name("TEXT");
  command.add_option("--zone", aiv.zone, "traffic zone; without: from the broker").value_name("NAME|FILE");
  command.add_option("--start", aiv.start, "initial position, such as east:0.85; without: waits for a position")
      .value_name("SECTION:S");
  command.add_option("--state-file", aiv.state_file, "preserves its position and loads over a crash; overrides --start")
      .value_name("FILE");
  add_rules(command, aiv.rules, "how it chooses its speed (docs/guide/agents.md); without: fuzzy");
  command
      .add_option("--vehicle-file", aiv.vehicle_file,
                  "its load positions and actions (docs/guide/vehicle-file.md); without: the usual ones")
      .value_name("FILE");
  command.add_switch("--v2x", aiv.v2x, "sends V2X messages about its intent to AIVs nearby");
  command.add_switch("--rali", aiv.rali, "it has the board RALI; without, its charge is unknown");
  add_direct(command, aiv.direct);
  command.add_flag("--emulated", aiv.emulated,
                   "its radio is the emulated world's, where scenarios can cause message loss");
  command.footer(
      "Example, the program of the first of a plant's vehicles:\n"
      "  cosiva aiv --number 1 --sockets /tmp/boards --start east:0.85");
  add_part(command, aiv.part);
}

void describe_unit(Command command, UnitArguments& unit) {
  command.add_option("--crossing", unit.crossing, "its crossing, such as X1").value_name("NAME").required();
  command.add_option("--zone", unit.zone, "traffic zone: a ready one's name or a file")
      .value_name("NAME|FILE")
      .required();
  add_link(command, unit.direct);
  command.add_flag("--emulated", unit.emulated, "scenarios may switch it off and on");
  command.add_flag("--off", unit.off, "with --emulated: it begins switched off");
  command.footer(
      "Example, the unit of a crossing on a broker and a direct link of your own:\n"
      "  cosiva unit --crossing X1 --zone lacet4 --broker 10.0.0.5 --v2x-multicast 239.192.7.50:7500 --v2x-key "
      "v2x.key");
  add_part(command, unit.part);
}

}  // namespace

PlatformCommands describe_platform(Command root, PlatformArguments& platform) {
  PlatformCommands commands{};
  commands.up =
      root.add_subcommand("up", "The whole platform on this machine: broker, emulated vehicles, server, page");
  commands.server = root.add_subcommand("server", "AIV_Server, simulator and page alone");
  commands.plant = root.add_subcommand("plant", "The emulated physical world alone");
  commands.aiv = root.add_subcommand("aiv", "One vehicle's on-board program alone");
  commands.unit = root.add_subcommand("unit", "One crossing unit alone: a roadside unit of V2X");
  commands.replay = root.add_subcommand("replay", "Run a recorded journal again and compare the digests");
  describe_up(commands.up, platform.up);
  describe_server(commands.server, platform.server);
  describe_plant(commands.plant, platform.plant);
  describe_aiv(commands.aiv, platform.aiv);
  describe_unit(commands.unit, platform.unit);
  commands.replay.add_option("file", platform.replay.file, "journal made with --record; '-' reads standard input")
      .value_name("FILE")
      .required();
  commands.replay.add_flag("--json", platform.replay.json, "print the result as JSON");
  return commands;
}

std::optional<int> run_platform_command(const PlatformCommands& commands, PlatformArguments& platform) {
  platform.up.given = {commands.up.given("--zone"), commands.up.given("--aivs"), commands.up.given("--seed"),
                       commands.up.given("--duration"), commands.up.given("--crossing-units")};
  if (commands.up.chosen()) return run_up(platform.up);
  if (commands.server.chosen()) return run_server(platform.server);
  if (commands.plant.chosen()) return run_plant(platform.plant);
  if (commands.aiv.chosen()) return run_aiv(platform.aiv);
  if (commands.unit.chosen()) return run_unit(platform.unit);
  if (commands.replay.chosen()) return run_replay(platform.replay);
  return std::nullopt;
}

ScenarioCommands describe_scenario(Command root, ScenarioArguments& scenario) {
  ScenarioCommands commands{};
  commands.scenario = root.add_subcommand("scenario", "Inspect scenarios: events over time");
  commands.check =
      commands.scenario.add_subcommand("check", "Print a scenario's steps, or its errors with their location");
  commands.list = commands.scenario.add_subcommand("list", "List the ready scenarios");
  commands.scenario.at_most_one_subcommand();
  commands.scenario.footer("Example:\n  cosiva scenario check showroom");
  commands.check.add_option("scenario", scenario.scenario, "a ready scenario's name or a file")
      .value_name("NAME|FILE")
      .required();
  for (const Command command : {commands.check, commands.list})
    command.add_flag("--json", scenario.json, "print the result as JSON");
  return commands;
}

std::optional<int> run_scenario_command(const ScenarioCommands& commands, const ScenarioArguments& scenario) {
  if (commands.check.chosen()) return run_scenario_check(scenario);
  if (commands.list.chosen()) return run_scenario_list(scenario);
  return std::nullopt;
}

}  // namespace cosiva::app
