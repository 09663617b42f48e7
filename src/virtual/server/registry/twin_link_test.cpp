#include "cosiva/virtual/server/registry/twin_link.h"

#include <gtest/gtest.h>

namespace cosiva::virtual_side {
namespace {

TEST(TwinLink, has_nothing_before_the_first_position) {
  const TwinLink link;
  EXPECT_FALSE(link.twin());
  EXPECT_FALSE(link.present());
  EXPECT_FALSE(link.base_end());
}

TEST(TwinLink, keeps_twin_and_entity_of_a_vehicle_that_returns_and_nothing_else) {
  TwinLink link;
  link.on_monitored(5);
  link.on_appeared(3);
  link.on_present();
  link.on_base(zone::TrackPosition{1, 0.5});
  link.on_returned();
  EXPECT_EQ(link.twin(), 3U);
  EXPECT_EQ(link.entity(), 5U);
  EXPECT_FALSE(link.present());
  EXPECT_FALSE(link.base_end());
}

TEST(TwinLink, follows_the_base_of_the_vehicle) {
  TwinLink link;
  link.on_appeared(0);
  link.on_base(zone::TrackPosition{1, 0.5});
  EXPECT_EQ(link.base_end(), (zone::TrackPosition{1, 0.5}));
  link.on_base({});
  EXPECT_FALSE(link.base_end());
}

TEST(TwinLink, refuses_a_second_twin_and_a_second_entity) {
  TwinLink link;
  link.on_appeared(0);
  link.on_monitored(0);
  EXPECT_DEATH(link.on_appeared(1), "!twin_");
  EXPECT_DEATH(link.on_monitored(1), "!entity_");
}

TEST(TwinLink, refuses_a_base_without_a_twin) {
  TwinLink link;
  EXPECT_DEATH(link.on_base({}), "twin_");
}

TEST(TwinLink, has_no_entity_of_a_vehicle_that_the_monitor_does_not_count) {
  const TwinLink link;
  EXPECT_DEATH(static_cast<void>(link.entity()), "entity_");
}

}  // namespace
}  // namespace cosiva::virtual_side
