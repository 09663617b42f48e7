#include "cosiva/virtual/server/right_of_way/closed_sections.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "cosiva/virtual/server/testing/server_fixture.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::virtual_side {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(ClosedSections, are_sorted_and_each_of_them_counts_once) {
  ClosedSections closed;
  closed.set({7, 2, 7, 5, 2});
  EXPECT_THAT(closed.all(), ElementsAre(2U, 5U, 7U));
  EXPECT_TRUE(closed.contains(2) && closed.contains(5) && closed.contains(7));
  EXPECT_FALSE(closed.contains(1) || closed.contains(3) || closed.contains(8));
}

TEST(ClosedSections, of_the_configuration_replace_what_an_operator_has_closed) {
  ClosedSections closed;
  closed.configure({1, 4});
  EXPECT_THAT(closed.all(), ElementsAre(1U, 4U));
  closed.set({3});
  EXPECT_THAT(closed.all(), ElementsAre(3U));
  EXPECT_THAT(closed.configured(), ElementsAre(1U, 4U));
  closed.configure({2});
  EXPECT_THAT(closed.all(), ElementsAre(2U));
  EXPECT_THAT(closed.configured(), ElementsAre(2U));
}

TEST(ClosedSections, are_joined_with_those_that_one_vehicle_avoids) {
  ClosedSections closed;
  closed.set({2, 6});
  EXPECT_THAT(closed.with(std::vector<zone::SectionId>{1, 6, 9}), ElementsAre(1U, 2U, 6U, 9U));
  EXPECT_THAT(closed.with({}), ElementsAre(2U, 6U));
  EXPECT_THAT(closed.all(), ElementsAre(2U, 6U));
}

TEST(ClosedSections, have_names_only_where_there_is_a_zone) {
  const WaypointGraph map{zone::Rtm::initialise(fixture::oval())->shared_zone()};
  ClosedSections closed;
  closed.set({3, 0});
  EXPECT_THAT(closed.names(&map), ElementsAre("south", "west"));
  EXPECT_THAT(closed.names(nullptr), IsEmpty());
}

}  // namespace
}  // namespace cosiva::virtual_side
