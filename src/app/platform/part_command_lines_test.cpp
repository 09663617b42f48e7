#include "cosiva/app/platform/part_command_lines.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>

#include "cosiva/adapters/files.h"
#include "cosiva/adapters/test_fixture.h"
#include "cosiva/base/test_paths.h"

namespace cosiva::app {
namespace {

using adapters::testing::Scratch;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::Not;

/// A plan for lacet4 and the command lines of its parts, without the path of the program.
class PartCommands : public ::testing::Test {
 protected:
  PartCommands() {
    arguments.zone = source_dir() + "/zones/lacet4.toml";
    arguments.name = "Thursday";
    arguments.aivs = 3;
    arguments.seed = 7;
    arguments.store = folder + "/store";
    broker.address = "127.0.0.1:1883";
  }

  enum class Part { plant, aiv, unit, gvs, server };
  std::vector<std::string> line(Part part, const ServerProgress& progress = {}) {
    auto plan = plan_run(arguments);
    auto run = RunDirectory::create(folder);
    EXPECT_TRUE(plan && run);
    const PartCommandLines lines{*plan, *run, broker};
    auto argv = part == Part::plant  ? lines.plant()
                : part == Part::aiv  ? lines.aiv(2, {plan->rtm.zone().circuit.find("north").value(), 0.25})
                : part == Part::unit ? lines.unit(plan->units.at(0))
                : part == Part::gvs  ? lines.gvs()
                                     : lines.server(progress);
    argv.erase(argv.begin());
    return argv;
  }
  /// The argument after the option; "-" without the option.
  static std::string value(const std::vector<std::string>& argv, const std::string& option) {
    const auto at = std::ranges::find(argv, option);
    return at == argv.end() || at + 1 == argv.end() ? "-" : *(at + 1);
  }

  Scratch scratch;
  std::string folder{scratch / "run"};
  UpArguments arguments;
  BrokerArguments broker;
};

TEST_F(PartCommands, start_the_emulated_world_with_zone_vehicles_and_seed) {
  EXPECT_THAT(line(Part::plant),
              ElementsAre("plant", "--broker", "127.0.0.1:1883", "--zone", arguments.zone, "--vehicles", "3", "--seed",
                          "7", "--sockets", folder + "/boards", "--state-file", folder + "/plant.state_file",
                          "--summary", folder + "/plant.json", "--announce"));
}

TEST_F(PartCommands, start_a_vehicle_at_its_position) {
  EXPECT_THAT(line(Part::aiv), ElementsAre("aiv", "--broker", "127.0.0.1:1883", "--number", "2", "--sockets",
                                           folder + "/boards", "--start", "north:0.25", "--state-file",
                                           folder + "/aiv2.state_file", "--emulated", "--announce"));
  arguments.rules = "fuzzy";
  arguments.v2x = false;
  EXPECT_EQ(value(line(Part::aiv), "--rules"), "fuzzy");
  EXPECT_EQ(value(line(Part::aiv), "--v2x"), "off");
}

TEST_F(PartCommands, give_the_plant_and_each_vehicle_its_equipment) {
  arguments.line_tracking = {"path_observer", "2=threshold"};
  arguments.without_rali = {"2"};
  EXPECT_EQ(value(line(Part::plant), "--line-tracking"), "path_observer");
  EXPECT_THAT(line(Part::plant), Contains("2=threshold"));
  EXPECT_EQ(value(line(Part::plant), "--without-rali"), "2");
  EXPECT_EQ(value(line(Part::aiv), "--rali"), "off");
  arguments.without_rali = {"3"};
  EXPECT_THAT(line(Part::aiv), Not(Contains("--rali")));
  arguments.without_rali = {"all"};
  EXPECT_EQ(value(line(Part::aiv), "--rali"), "off");
}

TEST_F(PartCommands, start_a_crossing_unit_at_its_crossing_with_the_link_of_the_run) {
  arguments.crossing_units = {"X2"};
  EXPECT_THAT(line(Part::unit),
              ElementsAre("unit", "--broker", "127.0.0.1:1883", "--crossing", "X2", "--zone", arguments.zone,
                          "--emulated", "--announce", "--summary", folder + "/unit-X2.json"));
  arguments.direct.multicast = "239.192.7.50:7500";
  arguments.direct.key_file = scratch.write("key", std::string(32, 'k'));
  std::filesystem::permissions(arguments.direct.key_file, std::filesystem::perms::owner_read);
  EXPECT_EQ(value(line(Part::unit), "--v2x-multicast"), "239.192.7.50:7500");
  EXPECT_EQ(value(line(Part::unit), "--v2x-key"), arguments.direct.key_file);
  EXPECT_THAT(line(Part::unit), Not(Contains("--link-loss")));
}

TEST_F(PartCommands, start_the_server_with_the_options_of_the_run) {
  EXPECT_THAT(line(Part::server), ElementsAre("server", "--broker", "127.0.0.1:1883", "--port", "8080", "--summary",
                                              folder + "/server.json", "--announce", "--fleet", "3", "--emulated",
                                              "--store", folder + "/store", "--name", "Thursday", "--zone-file",
                                              arguments.zone, "--parts", folder + "/parts.json", "--vehicles-max",
                                              "2000", "--expire", "600", "--vehicle-rate-max", "500"));
  arguments.watch = true;
  arguments.convoys = false;
  arguments.v2x = false;
  arguments.headless = true;
  arguments.rules = "crisp";
  arguments.web_directory = "page";
  arguments.record_file = "day.journal";
  arguments.limits = {64, 30.5, 120.0};
  const auto argv = line(Part::server);
  EXPECT_EQ(value(argv, "--vehicles-max"), "64");
  EXPECT_EQ(value(argv, "--expire"), "30.5");
  EXPECT_EQ(value(argv, "--vehicle-rate-max"), "120");
  EXPECT_EQ(value(argv, "--watch-file"), arguments.zone);
  EXPECT_EQ(value(argv, "--convoys"), "off");
  EXPECT_EQ(value(argv, "--v2x"), "off");
  EXPECT_THAT(argv, Contains("--headless"));
  EXPECT_EQ(value(argv, "--rules"), "crisp");
  EXPECT_EQ(value(argv, "--web"), "page");
  EXPECT_EQ(value(argv, "--record"), "day.journal");
}

TEST_F(PartCommands, of_a_restarted_server_continue_the_run_and_keep_the_first_journal) {
  arguments.record_file = "day.journal";
  arguments.zone = scratch.write("zone.toml", adapters::read_file(arguments.zone).value());
  ServerProgress progress;
  progress.starts = 1;
  EXPECT_EQ(value(line(Part::server, progress), "--record"), "day.journal");
  EXPECT_THAT(line(Part::server, progress), Not(Contains("--scenario-began")));
  progress = {8093, {}, 1'700'000'000'123, 4, 2};
  const auto argv = line(Part::server, progress);
  EXPECT_EQ(value(argv, "--port"), "8093");
  EXPECT_EQ(value(argv, "--record"), "day.journal.2");
  EXPECT_EQ(value(argv, "--scenario-began"), "1700000000123");
  EXPECT_EQ(value(argv, "--scenario-steps-done"), "4");
}

TEST_F(PartCommands, name_the_scenario_to_the_server) {
  const std::string file = scratch.write("day.toml", "name = \"day\"\nzone = \"" + arguments.zone + "\"\naivs = 3\n");
  arguments.scenario = file;
  EXPECT_EQ(value(line(Part::server), "--scenario"), file);
}

TEST_F(PartCommands, watch_the_emulated_camera_or_a_real_one) {
  EXPECT_THAT(line(Part::gvs), ElementsAre("gvs", "watch", "--broker", "127.0.0.1:1883", "--announce", "--rate", "4"));
  arguments.gvs_source.camera = 2;
  arguments.gvs_source.calibration_file = "lens.json";
  arguments.gvs_source.tag_side_m = 0.08;
  arguments.gvs_source.vehicles = {"7=CoSiVA/AIV1", "9=CoSiVA/AIV2"};
  EXPECT_THAT(line(Part::gvs),
              ElementsAre("gvs", "watch", "--broker", "127.0.0.1:1883", "--announce", "--rate", "4", "--calibration",
                          "lens.json", "--camera", "2", "--exposure", "0", "--line", "0", "--tag-side", "0.08",
                          "--vehicle", "7=CoSiVA/AIV1", "--vehicle", "9=CoSiVA/AIV2"));
}

TEST_F(PartCommands, contain_the_files_that_secure_the_connection_and_no_password) {
  broker = {"10.0.0.5:8883", "ca.pem", "own.pem", "own.key", "server", "secret.txt"};
  for (const Part part : {Part::plant, Part::aiv, Part::gvs, Part::server}) {
    const auto argv = line(part);
    EXPECT_EQ(value(argv, "--broker"), "10.0.0.5:8883");
    EXPECT_EQ(value(argv, "--broker-ca"), "ca.pem");
    EXPECT_EQ(value(argv, "--broker-cert"), "own.pem");
    EXPECT_EQ(value(argv, "--broker-key"), "own.key");
    EXPECT_EQ(value(argv, "--broker-user"), "server");
    EXPECT_EQ(value(argv, "--broker-password-file"), "secret.txt");
  }
}

}  // namespace
}  // namespace cosiva::app
