#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "cosiva/base/test_paths.h"
#include "cosiva/zone/check/check.h"
#include "cosiva/zone/check/deadlock.h"
#include "cosiva/zone/rtm/rtm.h"
#include "cosiva/zone/testing/test_zones.h"

namespace cosiva::zone {
namespace {

namespace fs = std::filesystem;

/// The zones that come with the platform, each with its sidecar file.
std::vector<ZoneConfiguration> ready_zones() {
  std::vector<ZoneConfiguration> zones;
  for (const auto& entry : fs::directory_iterator{fs::path{source_dir()} / "zones"}) {
    const std::string file = entry.path().filename().string();
    if (format_of_file(file) && !file.ends_with(".zone.toml")) zones.push_back(testing::configuration_file(file));
  }
  return zones;
}

TEST(ReadyZones, are_of_every_format_and_one_is_large) {
  std::vector<std::string> formats;
  std::size_t sections_most = 0;
  for (const ZoneConfiguration& configuration : ready_zones()) {
    formats.push_back(configuration.format);
    const auto rtm = Rtm::initialise(configuration);
    ASSERT_TRUE(rtm) << to_string(rtm.error());
    sections_most = std::max(sections_most, rtm->zone().circuit.size());
  }
  for (const std::string_view format : known_formats()) EXPECT_THAT(formats, ::testing::Contains(std::string{format}));
  EXPECT_GT(sections_most, 1000U);
}

TEST(ReadyZones, are_named_as_their_files_and_hold_twelve_vehicles) {
  for (const ZoneConfiguration& configuration : ready_zones()) {
    const auto rtm = Rtm::initialise(configuration);
    ASSERT_TRUE(rtm) << to_string(rtm.error());
    const std::string file = fs::path{configuration.origin}.filename().string();
    EXPECT_EQ(rtm->zone().name, file.substr(0, file.find('.')));
    EXPECT_EQ(rtm->zone().start_positions(12).size(), 12U) << file;
  }
}

// Tracks driven both ways, and stations where vehicles obstruct others, are typical of a workshop.
TEST(ReadyZones, have_no_faults) {
  for (const ZoneConfiguration& configuration : ready_zones()) {
    const auto rtm = Rtm::initialise(configuration);
    ASSERT_TRUE(rtm) << to_string(rtm.error());
    for (const Problem& problem : problems(rtm->zone())) {
      if (problem.code == "zone.single_track" || problem.code == "zone.station") continue;
      ADD_FAILURE() << configuration.origin << ": " << to_string(problem, rtm->zone());
    }
  }
}

TEST(ReadyZones, have_no_position_where_vehicles_come_to_wait_for_each_other_unless_they_are_full) {
  for (const ZoneConfiguration& configuration : ready_zones()) {
    const auto rtm = Rtm::initialise(configuration);
    ASSERT_TRUE(rtm) << to_string(rtm.error());
    std::size_t loops = 0;
    for (const Problem& spot : deadlock_spots(rtm->zone())) {
      EXPECT_EQ(spot.severity, Problem::Severity::notice);
      if (spot.code == "deadlock.loop") ++loops;
      // A workshop's stations are left in the direction of entry. On a map of squares every track is driven both ways,
      // and there is no room between crossings: only a planner of the whole fleet leads vehicles over it.
      const bool expected = spot.code == "deadlock.loop" || spot.code == "deadlock.dead_end" ||
                            (spot.code == "deadlock.no_room" && configuration.format == "movingai");
      EXPECT_TRUE(expected) << configuration.origin << ": " << to_string(spot, rtm->zone());
    }
    EXPECT_GE(loops, 1U) << configuration.origin;
  }
}

}  // namespace
}  // namespace cosiva::zone
