// Fleets that are sent throughout a zone, including dead ends.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cosiva/base/random.h"
#include "cosiva/virtual/fleet/fleet.h"
#include "cosiva/virtual/fleet/test_fleet.h"
#include "cosiva/zone/routing/route.h"

namespace cosiva::virtual_side {
namespace {

using namespace test;

/// Sends all vehicles to random positions, again and again.
class Wanderers {
 public:
  /// @param to_stations  to stations only
  Wanderers(Zone zone, std::size_t count, std::uint64_t seed, bool to_stations = false)
      : fleet_{fleet(zone, count)},
        zone_{std::move(zone)},
        router_{*zone_},
        random_{seed, "wanderers"},
        to_stations_{to_stations} {
    for (Fleet::Vehicle i = 0; i < fleet_.size(); ++i) send(i);
  }

  void step() {
    fleet_.step();
    for (const Fleet::Vehicle i : std::vector<Fleet::Vehicle>{fleet_.arrived().begin(), fleet_.arrived().end()}) {
      EXPECT_TRUE(fleet_.is_at_goal(i));
      EXPECT_EQ(fleet_.track_position(i), goals_[i]);
      EXPECT_EQ(fleet_.speed_mps()[i], 0.0);
      ++arrivals_;
      send(i);
    }
  }
  [[nodiscard]] Fleet& fleet_of() { return fleet_; }
  [[nodiscard]] std::size_t arrivals() const { return arrivals_; }

 private:
  void send(Fleet::Vehicle i) {
    goals_.resize(fleet_.size());
    for (int attempt = 0; attempt < 20; ++attempt) {
      const zone::TrackPosition goal = somewhere();
      if (!to_stations_ && !zone_->may_stop(goal)) continue;
      const auto route = router_.plan(fleet_.track_position(i), goal);
      if (!route || !fleet_.send(i, route->sections, goal.s_m)) continue;
      goals_[i] = goal;
      return;
    }
  }

  [[nodiscard]] zone::TrackPosition somewhere() {
    if (to_stations_) return zone_->stations[random_.below(zone_->stations.size())].position;
    const auto section = static_cast<zone::SectionId>(random_.below(zone_->circuit.size()));
    return {section, random_.uniform(0.0, zone_->circuit.section(section).length_m())};
  }

  Fleet fleet_;
  Zone zone_;
  zone::Router router_;
  Random random_;
  bool to_stations_;
  std::vector<zone::TrackPosition> goals_;
  std::size_t arrivals_{0};
};

TEST(Fleet, sent_throughout_a_factory_layout_arrives_exactly_and_touches_no_vehicle) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Wanderers wanderers{plant({.rows = 2, .aisles = 5, .bays = 3, .seed = seed}), 4 + 4 * seed, seed};
    for (int k = 0; k < 4000; ++k) {
      wanderers.step();
      if (k % 13 == 0) {
        ASSERT_NO_FATAL_FAILURE(expect_safe(wanderers.fleet_of()));
      }
    }
    EXPECT_EQ(wanderers.fleet_of().collisions(), 0U);
    EXPECT_GT(wanderers.arrivals(), 10U);
  }
}

TEST(Fleet, drives_in_and_out_of_dead_ends_where_lanes_are_driven_both_ways) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    Wanderers wanderers{zone_file("zones/workshop.lif.json"), 2 + 2 * seed, seed, true};
    for (int k = 0; k < 6000; ++k) {
      wanderers.step();
      if (k % 13 == 0) {
        ASSERT_NO_FATAL_FAILURE(expect_safe(wanderers.fleet_of()));
      }
    }
    EXPECT_EQ(wanderers.fleet_of().collisions(), 0U);
    EXPECT_EQ(wanderers.fleet_of().stuck(), 0U);
    EXPECT_GT(wanderers.arrivals(), 20U);
  }
}

TEST(Fleet, is_not_sent_back_into_a_dead_end_that_it_leaves) {
  const Zone zone = zone_file("zones/workshop.lif.json");
  const auto id = [&](const char* name) { return *zone->circuit.find(name); };
  Fleet one = fleet(zone, std::vector<FleetStart>{{0, {id("SW-S1"), 0.1}, 0}});
  const std::vector<zone::SectionId> in{id("SW-S1"), id("S1-P1")};
  const std::vector<zone::SectionId> in_out_in{id("SW-S1"), id("S1-P1"), id("P1-S1"), id("S1-P1")};
  EXPECT_FALSE(one.send(0, in_out_in, 0.8));
  EXPECT_TRUE(one.send(0, in, 0.8));
}

TEST(Fleet, cannot_be_made_if_vehicles_cannot_stop_between_crossings) {
  // One lane, there and back: a vehicle on it has reserved all of it, for ever.
  const auto made = Fleet::make(zone_file("src/virtual/fleet/testdata/two_way_lane.toml"), {}, {});
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().code, "fleet.zone");
  EXPECT_THAT(made.error().location, testing::HasSubstr("section 'there'"));
  EXPECT_THAT(made.error().message,
              testing::AllOf(testing::HasSubstr("this section and 'back' are one track driven both ways"),
                             testing::HasSubstr("lead over sections next to the track"),
                             testing::HasSubstr("zone.single_track")));
}

TEST(Fleet, can_be_made_on_a_track_driven_both_ways_with_a_detour_as_the_error_advises) {
  const auto straight = [](const std::string& name, const std::string& start, double length_m, const char* next) {
    return "[[section]]\nname = \"" + name +
           "\"\nkind = \"straight\"\npivots = true\nlength_m = " + std::to_string(length_m) + "\nstart = { " + start +
           " }\nnext = [\"" + next + "\"]\n";
  };
  const Zone zone = zone_text("name = \"lane\"\nformat_version = 1\n" +
                              straight("there", "x = 0, y = 0, heading_deg = 0", 6.0, "up") +
                              straight("up", "x = 6, y = 0, heading_deg = 90", 2.0, "over") +
                              straight("over", "x = 6, y = 2, heading_deg = 180", 2.0, "down") +
                              straight("down", "x = 4, y = 2, heading_deg = -90", 2.0, "back") +
                              straight("back", "x = 4, y = 0, heading_deg = 180", 4.0, "there"));
  Fleet two = fleet(zone, std::vector<FleetStart>{{0, {*zone->circuit.find("up"), 1.0}, 0},
                                                  {0, {*zone->circuit.find("over"), 1.0}, 0}});
  for (int k = 0; k < 2000; ++k) {
    two.step();
    ASSERT_NO_FATAL_FAILURE(expect_safe(two));
  }
  EXPECT_GT(two.laps(0), 0U);
  EXPECT_GT(two.laps(1), 0U);
}

}  // namespace
}  // namespace cosiva::virtual_side
