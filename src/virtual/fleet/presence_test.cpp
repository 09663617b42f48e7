#include <gtest/gtest.h>

#include <vector>

#include "cosiva/base/random.h"
#include "cosiva/virtual/fleet/test_fleet.h"

namespace cosiva::virtual_side::test {
namespace {

/// Sends a vehicle this far ahead on a one-way loop, and steps until it is stopped there.
void send_on(Fleet& fleet, Fleet::Vehicle vehicle, double ahead_m) {
  const auto kept = fleet.committed(vehicle);
  std::vector<zone::SectionId> route(kept.begin(), kept.end());
  const zone::Circuit& circuit = fleet.zone().circuit;
  double goal_m = fleet.track_position(vehicle).s_m + ahead_m;
  for (std::size_t k = 0; goal_m > circuit.section(route[k]).length_m(); ++k) {
    goal_m -= circuit.section(route[k]).length_m();
    if (k + 1 == route.size()) route.push_back(circuit.next(route[k]).front());
  }
  ASSERT_TRUE(fleet.send(vehicle, route, goal_m));
  for (int i = 0; i < 3000 && !fleet.is_at_goal(vehicle); ++i) fleet.step();
  ASSERT_TRUE(fleet.is_at_goal(vehicle));
}

}  // namespace

TEST(FleetPresence, a_vehicle_at_its_goal_can_be_removed_and_a_vehicle_waiting_behind_it_drives_on) {
  const Zone zone = zone_file("zones/lacet4.toml");
  auto made = fleet(zone, Fleet::spread(*zone, 4));
  EXPECT_FALSE(made.take_away(1)) << "the vehicle drives";
  send_on(made, 1, 3.0);
  for (int i = 0; i < 600; ++i) made.step();
  const double stopped_m = made.distance_m(0);
  for (int i = 0; i < 100; ++i) made.step();
  EXPECT_LT(made.distance_m(0) - stopped_m, 0.01) << "behind the one at its goal";
  const double taken_m = made.distance_m(1);
  ASSERT_TRUE(made.take_away(1));
  EXPECT_TRUE(made.is_away(1));
  EXPECT_FALSE(made.is_at_goal(1));
  EXPECT_FALSE(made.take_away(1)) << "the vehicle is away";
  for (int i = 0; i < 300; ++i) made.step();
  EXPECT_GT(made.distance_m(0), stopped_m + 3.0);
  EXPECT_EQ(made.distance_m(1), taken_m);
  EXPECT_EQ(made.collisions(), 0U);
  EXPECT_EQ(made.stuck(), 0U);
}

TEST(FleetPresence, no_vehicle_is_added_where_a_follower_could_not_stop_or_a_vehicle_is_stopped) {
  const Zone zone = zone_file("zones/lacet4.toml");
  auto starts = Fleet::spread(*zone, 1);
  ASSERT_EQ(starts.size(), 1U);
  starts.push_back({0, {zone::no_section, 0.0}, 0});
  auto made = fleet(zone, starts);
  EXPECT_TRUE(made.is_away(1));
  const std::vector<zone::SectionId> route{made.track_position(0).section};
  EXPECT_FALSE(made.send(1, route, 0.1)) << "a vehicle that is away cannot be sent";
  for (int i = 0; i < 50; ++i) made.step();
  const zone::TrackPosition here = made.track_position(0);
  EXPECT_FALSE(made.bring(1, here));
  EXPECT_FALSE(made.bring(1, {here.section, here.s_m + zone->vehicle.length_m + 0.05}))
      << "the vehicle drives and would not stop";
  EXPECT_FALSE(made.bring(1, {here.section, 1e6})) << "no such position";
  EXPECT_FALSE(made.bring(1, {zone::no_section, 0.0})) << "no section";
  EXPECT_FALSE(made.bring(0, here)) << "the vehicle is present";
  const std::uint64_t before = made.digest();
  EXPECT_FALSE(made.bring(1, here));
  EXPECT_EQ(made.digest(), before) << "a refusal changes nothing";
}

TEST(FleetPresence, an_hour_of_removals_and_additions_causes_no_collision_and_gives_the_same_digest_twice) {
  const Zone zone = zone_file("zones/indus8.toml");
  const auto run = [&](std::size_t& came) {
    auto starts = Fleet::spread(*zone, 8);
    for (int i = 0; i < 8; ++i) starts.push_back({0, {zone::no_section, 0.0}, 0});
    auto made = fleet(zone, starts);
    Random random{7, "test/coming"};
    for (int step = 0; step < 36000; ++step) {
      made.step();
      for (const Fleet::Vehicle there : std::vector(made.arrived().begin(), made.arrived().end()))
        EXPECT_TRUE(made.take_away(there));
      const auto vehicle = static_cast<Fleet::Vehicle>(random.below(starts.size()));
      if (made.is_away(vehicle)) {
        const auto& station = zone->stations[random.below(zone->stations.size())];
        came += made.bring(vehicle, station.position) ? 1U : 0U;
      } else if (step % 10 == 0) {
        // The next goal of a stopped vehicle is somewhere on its own section.
        const auto kept = made.committed(vehicle);
        const std::vector<zone::SectionId> route(kept.begin(), kept.end());
        const double length_m = zone->circuit.section(route.back()).length_m();
        (void)made.send(vehicle, route, random.uniform() * length_m);
      }
    }
    EXPECT_EQ(made.collisions(), 0U);
    EXPECT_GE(made.smallest_gap_m(), 0.0);
    return made.digest();
  };
  std::size_t came = 0;
  const std::uint64_t first = run(came);
  EXPECT_GT(came, 100U);
  EXPECT_EQ(run(came), first);
}

}  // namespace cosiva::virtual_side::test
