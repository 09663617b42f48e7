#include "cosiva/virtual/server/registry/vehicle_topic.h"

#include <gtest/gtest.h>

#include <optional>
#include <string_view>

namespace cosiva::virtual_side {
namespace {

TEST(VehicleTopic, of_the_standard_is_read_from_its_name) {
  for (const VehicleTopic topic :
       {VehicleTopic::connection, VehicleTopic::state, VehicleTopic::visualization, VehicleTopic::factsheet})
    EXPECT_EQ(parse_vehicle_topic(to_string(topic)), topic) << to_string(topic);
  EXPECT_EQ(parse_vehicle_topic("connection"), VehicleTopic::connection);
  EXPECT_EQ(parse_vehicle_topic("state"), VehicleTopic::state);
  EXPECT_EQ(parse_vehicle_topic("visualization"), VehicleTopic::visualization);
  EXPECT_EQ(parse_vehicle_topic("factsheet"), VehicleTopic::factsheet);
}

TEST(VehicleTopic, of_our_own_and_of_the_server_is_not_read) {
  for (const std::string_view name : {"order", "instantActions", "boards", "detected_obstacle", "State", "states", ""})
    EXPECT_EQ(parse_vehicle_topic(name), std::nullopt) << name;
}

TEST(VehicleTopic, has_the_name_of_its_last_level) {
  EXPECT_EQ(to_string(VehicleTopic::perceived), "virtual_obstacles_ack");
  EXPECT_EQ(to_string(VehicleTopic::detected), "detected_obstacle");
  EXPECT_EQ(to_string(VehicleTopic::boards), "boards");
}

}  // namespace
}  // namespace cosiva::virtual_side
