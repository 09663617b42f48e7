#include "cosiva/experiments/faults/two_areas.h"

#include <gtest/gtest.h>

#include <string>

#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::experiments {
namespace {

zone::TrafficZone zone_of(const zone::ZoneConfiguration& configuration) {
  const auto rtm = zone::Rtm::initialise(configuration);
  EXPECT_TRUE(rtm) << to_string(rtm.error());
  return rtm->zone();
}

TEST(TwoAreas, are_zones_whose_paths_are_the_same_paths_of_the_floor) {
  const TwoAreas areas = two_areas();
  const zone::TrafficZone floor = zone_of(areas.floor);
  for (const zone::ZoneConfiguration& area : {areas.a, areas.b}) {
    const zone::TrafficZone zone = zone_of(area);
    for (zone::SectionId id = 0; id < zone.circuit.size(); ++id) {
      const auto same = floor.circuit.find(zone.circuit.part(id).name);
      ASSERT_TRUE(same) << zone.circuit.part(id).name;
      const Pose2 here = zone.circuit.section(id).end();
      const Pose2 there = floor.circuit.section(*same).end();
      EXPECT_NEAR(here.x_m, there.x_m, 1e-9);
      EXPECT_NEAR(here.y_m, there.y_m, 1e-9);
    }
  }
}

TEST(TwoAreas, have_a_transfer_point_in_each_direction_on_a_path_of_both) {
  const TwoAreas areas = two_areas();
  const zone::TrafficZone a = zone_of(areas.a);
  const zone::TrafficZone b = zone_of(areas.b);
  ASSERT_NE(a.find_station("to_b"), nullptr);
  ASSERT_NE(b.find_station("to_a"), nullptr);
  EXPECT_TRUE(b.circuit.find(a.circuit.part(a.find_station("to_b")->position.section).name));
  EXPECT_TRUE(a.circuit.find(b.circuit.part(b.find_station("to_a")->position.section).name));
}

TEST(TwoAreas, have_start_positions_for_four_vehicles) {
  EXPECT_EQ(zone_of(two_areas().floor).start_positions(4).size(), 4U);
}

}  // namespace
}  // namespace cosiva::experiments
