#include "cosiva/app/resources/resource_paths.h"

#include <gmock/gmock.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>

#include "cosiva/adapters/files.h"
#include "cosiva/adapters/test_fixture.h"
#include "cosiva/app/resources/run_directory.h"
#include "cosiva/app/resources/zone_files.h"

namespace cosiva::app {
namespace {

using adapters::testing::Scratch;
using ::testing::HasSubstr;

TEST(Zone, that_is_missing_fails_with_the_searched_folders) {
  const auto none = find_zone_file("lacet5");
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, "zone.missing");
  EXPECT_THAT(none.error().message, HasSubstr("searched:\n  /"));
  EXPECT_THAT(none.error().message, HasSubstr("share/cosiva/zones"));
  EXPECT_EQ(find_zone_file("/nonexistent/zone.toml").error().location, "/nonexistent/zone.toml");
}

TEST(Zone, keeps_its_file_s_name_for_errors) {
  Scratch scratch;
  const std::string file = scratch.write("mine.toml", "name = 'mine'\n");
  const auto zone = load_zone(file);
  ASSERT_TRUE(zone);
  EXPECT_EQ(zone->origin, file);
  EXPECT_EQ(zone->format, "toml");
  EXPECT_EQ(zone->text, "name = 'mine'\n");
}

TEST(Zone, of_the_user_is_preferred_to_the_ready_zone) {
  Scratch scratch;
  const std::string own = scratch.write("cosiva/zones/lacet4.toml", "name = 'mine'\n");
  ::setenv("XDG_DATA_HOME", scratch.path().c_str(), 1);
  EXPECT_EQ(find_zone_file("lacet4").value(), own);
  EXPECT_EQ(own_folder("zones"), scratch / "cosiva/zones");
  ::unsetenv("XDG_DATA_HOME");
}

TEST(Scenario, that_is_missing_fails_with_the_searched_folders) {
  const auto none = find_scenario_file("shwroom");
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, "scenario.missing");
  EXPECT_THAT(none.error().message, HasSubstr("share/cosiva/scenarios"));
  EXPECT_EQ(load_scenario("/nonexistent/day.toml").error().location, "/nonexistent/day.toml");
}

TEST(Scenario, finds_a_zone_next_to_its_file) {
  Scratch scratch;
  const std::string zone = scratch.write("mine.toml", "name = 'mine'\n");
  const auto local_path = load_scenario(scratch.write("day.toml", "name = 'day'\nzone = 'mine.toml'\n"));
  ASSERT_TRUE(local_path) << to_string(local_path.error());
  EXPECT_EQ(local_path->scenario.zone, zone);
  const auto ready = load_scenario(scratch.write("other.toml", "name = 'other'\nzone = 'lacet4'\n"));
  ASSERT_TRUE(ready);
  EXPECT_EQ(ready->scenario.zone, "lacet4");
}

TEST(RunName, contains_the_subject_and_the_time) {
  EXPECT_THAT(default_run_name("showroom"), ::testing::MatchesRegex("showroom, [0-9]+-[0-9]+-[0-9]+ [0-9]+:[0-9]+"));
}

TEST(BrokerArguments, that_are_incompatible_are_refused) {
  EXPECT_EQ(mqtt_options({"nonsense:", {}, {}, {}, {}, {}}, "x").error().code, "broker.address");
  EXPECT_EQ(mqtt_options({{}, "ca", "cert", {}, {}, {}}, "x").error().code, "broker.tls");
  EXPECT_EQ(mqtt_options({{}, {}, "cert", "key", {}, {}}, "x").error().code, "broker.tls");
  EXPECT_EQ(mqtt_options({{}, {}, {}, {}, {}, "password"}, "x").error().code, "broker.user");
  const auto good = mqtt_options({"10.0.0.1:8883", "ca", "cert", "key", "me", "password"}, "x");
  ASSERT_TRUE(good);
  EXPECT_EQ(good->port, 8883);
  EXPECT_EQ(good->tls->key_file, "key");
}

TEST(RunDirectory, is_private_and_leaves_no_files) {
  Scratch scratch;
  const std::string path = scratch / "a/run";
  {
    const auto run = RunDirectory::create(path);
    ASSERT_TRUE(run);
    struct stat metadata {};
    ASSERT_EQ(::stat(path.c_str(), &metadata), 0);
    EXPECT_EQ(metadata.st_mode & 0777U, 0700U);
    ASSERT_TRUE(adapters::write_file(*run / "aiv1.state_file", "x"));
  }
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(RunDirectory, that_existed_before_stays_but_empty) {
  Scratch scratch;
  {
    const auto run = RunDirectory::create(scratch.path());
    ASSERT_TRUE(run);
    ASSERT_TRUE(adapters::write_file(*run / "server.json", "{}"));
  }
  EXPECT_TRUE(std::filesystem::is_empty(scratch.path()));
}

TEST(RunDirectory, with_files_of_others_is_refused_unchanged) {
  Scratch scratch;
  const std::string file = scratch.write("thesis.tex", "years");
  const auto run = RunDirectory::create(scratch.path());
  ASSERT_FALSE(run);
  EXPECT_EQ(run.error().code, "run.directory");
  EXPECT_TRUE(std::filesystem::exists(file));
}

TEST(RunDirectory, of_a_killed_run_is_reused_but_not_of_a_running_one) {
  Scratch scratch;
  const auto logged = [&](pid_t pid) {
    scratch.write(children_file_name, R"({"children":[{"name":"plant","pid":)" + std::to_string(pid) + "}]}");
  };
  logged(::getpid());
  EXPECT_FALSE(RunDirectory::create(scratch.path()));
  logged(0x3FFFFFFF);  // greater than any process number
  scratch.write("boards/left.sock", "");
  const auto run = RunDirectory::create(scratch.path());
  ASSERT_TRUE(run) << to_string(run.error());
  EXPECT_FALSE(std::filesystem::exists(scratch / "boards"));
}

}  // namespace
}  // namespace cosiva::app
