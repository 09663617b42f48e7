#include "cosiva/planning/layout_check/station_points.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cosiva/zone/testing/test_zones.h"

namespace cosiva::planning {
namespace {

using ::testing::ElementsAre;
using ::testing::SizeIs;

TEST(StationPoints, are_the_points_of_stations_that_a_move_leads_to) {
  const auto zone = zone::testing::read_zone(zone::testing::straight +
                                             "[[station]]\nname = \"begin\"\nsection = \"a\"\ns_m = 0\n"
                                             "[[station]]\nname = \"end\"\nsection = \"a\"\ns_m = 2\n"
                                             "[[station]]\nname = \"rack\"\nsection = \"a\"\ns_m = 2\n"
                                             "[[station]]\nname = \"near\"\nsection = \"a\"\ns_m = 1.995\n");
  ASSERT_TRUE(zone) << to_string(zone.error());
  const TrackFloor tracks = TrackFloor::make(*zone);
  const auto points = station_points(*zone, tracks);
  ASSERT_THAT(points, SizeIs(1)) << "no section leads to the beginning, and the others are one point";
  EXPECT_THAT(points[0].stations, ElementsAre(1, 2, 3));
  ASSERT_THAT(points[0].states, SizeIs(1));
  EXPECT_EQ(tracks.position(points[0].states[0]).s_m, 2.0);
  EXPECT_FALSE(points[0].cells.empty());
}

}  // namespace
}  // namespace cosiva::planning
