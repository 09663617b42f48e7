// The ready zone without crossings, for tests of batteries (A38).
#include <gtest/gtest.h>

#include "cosiva/zone/testing/test_zones.h"

namespace cosiva::zone {
namespace {

const TrafficZone& oval() {
  static const TrafficZone zone = Rtm::initialise(testing::configuration_file("oval.toml"))->zone();
  return zone;
}

TEST(Oval, is_one_loop_of_two_straights_and_two_half_circles_without_crossings) {
  EXPECT_EQ(oval().circuit.size(), 4U);
  EXPECT_NEAR(oval().circuit.total_length_m(), 2.0 * 6.0 + 2.0 * pi * 0.8, 1e-9);
  EXPECT_TRUE(oval().crossings.empty());
  for (SectionId id = 0; id < 4; ++id) EXPECT_EQ(oval().circuit.next(id).size(), 1U);
}

TEST(Oval, has_room_for_two_dozen_vehicles) { EXPECT_EQ(oval().start_positions(24).size(), 24U); }

TEST(Oval, has_a_tag_within_two_metres_of_the_one_before) {
  ASSERT_EQ(oval().tags.size(), 12U);
  for (std::size_t i = 0; i < 12; ++i) {
    const auto route = oval().circuit.shortest_route(oval().tags[i].position, oval().tags[(i + 1) % 12].position, 2.0);
    EXPECT_TRUE(route && route->length_m > 0.5) << "after tag " << oval().tags[i].number;
  }
}

}  // namespace
}  // namespace cosiva::zone
