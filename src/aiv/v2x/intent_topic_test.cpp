#include "cosiva/aiv/v2x/intent_topic.h"

#include <gtest/gtest.h>

namespace cosiva::aiv {
namespace {

TEST(IntentTopic, is_that_of_the_vehicle_s_present_map_and_cell) {
  const wire::VehicleId vehicle{"CoSiVA", "AIV7"};
  IntentTopic topic{vehicle};
  const wire::Cell cell{-1, 2};
  EXPECT_EQ(topic.at("clover", cell), wire::v2x_topic("clover", cell, vehicle));
  EXPECT_EQ(topic.at("clover", cell), wire::v2x_topic("clover", cell, vehicle)) << "again";
  for (const wire::Cell next : {wire::Cell{-1, 3}, wire::Cell{0, 3}})
    EXPECT_EQ(topic.at("clover", next), wire::v2x_topic("clover", next, vehicle));
  EXPECT_EQ(topic.at("indus", {0, 3}), wire::v2x_topic("indus", {0, 3}, vehicle)) << "the same cell of another map";
  EXPECT_EQ(topic.at("clover", {0, 0}), wire::v2x_topic("clover", {0, 0}, vehicle));
}

TEST(IntentTopic, is_complete_on_a_map_without_a_name) {
  const wire::VehicleId vehicle{"CoSiVA", "AIV7"};
  IntentTopic topic{vehicle};
  EXPECT_EQ(topic.at("", {}), wire::v2x_topic("", {}, vehicle));
}

}  // namespace
}  // namespace cosiva::aiv
