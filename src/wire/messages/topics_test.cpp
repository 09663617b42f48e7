#include "cosiva/wire/messages/topics.h"

#include <gtest/gtest.h>

#include "cosiva/wire/messages/board.h"

namespace cosiva::wire {
namespace {

TEST(VdaTopic, is_written_as_the_standard_specifies) {
  EXPECT_EQ(vda_topic({"CoSiVA", "aiv-1"}, "state"), "uagv/v2/CoSiVA/aiv-1/state");
  EXPECT_EQ(vda_topic({"RobotCompany", "001"}, "order", "twin"), "twin/v2/RobotCompany/001/order");
}

TEST(VdaTopic, reads_back_what_it_writes) {
  const auto topic = parse_vda_topic("uagv/v2/CoSiVA/aiv-1/instantActions");
  ASSERT_TRUE(topic);
  EXPECT_EQ(topic->interface_name, "uagv");
  EXPECT_EQ(topic->major_version, "v2");
  EXPECT_EQ(topic->vehicle, (VehicleId{"CoSiVA", "aiv-1"}));
  EXPECT_EQ(topic->name, "instantActions");
  EXPECT_EQ(to_string(*topic), "uagv/v2/CoSiVA/aiv-1/instantActions");
}

TEST(VdaTopic, has_exactly_five_non_empty_levels) {
  for (const char* text : {"", "/", "uagv", "uagv/v2/m/s", "uagv/v2/m/s/state/more", "uagv/v2//s/state",
                           "/v2/m/s/state", "uagv/v2/m/s/", "////", "uagv/v2/m/s/state/"})
    EXPECT_FALSE(parse_vda_topic(text)) << text;
}

TEST(VehicleId, is_ordered_and_case_sensitive) {
  EXPECT_LT((VehicleId{"A", "2"}), (VehicleId{"B", "1"}));
  EXPECT_NE((VehicleId{"cosiva", "1"}), (VehicleId{"CoSiVA", "1"}));
  EXPECT_EQ(to_string(VehicleId{"CoSiVA", "aiv-1"}), "CoSiVA/aiv-1");
}

TEST(SerialNumber, uses_the_standards_characters_only) {
  EXPECT_TRUE(valid_serial_number("AZaz09_.:-"));
  for (const char* text : {"", "a/b", "a b", "+", "#", "$x", "\xC3\xBC"})
    EXPECT_FALSE(valid_serial_number(text)) << text;
  EXPECT_TRUE(valid_serial_number(std::string(64, 'x')));
  EXPECT_FALSE(valid_serial_number(std::string(65, 'x')));
}

TEST(OwnTopic, is_a_prefix_and_the_vehicle_and_is_read_back) {
  const VehicleId vehicle{"CoSiVA.virtual", "V1"};
  EXPECT_EQ(own_topic(virtual_obstacles_topic_prefix, vehicle), "cosiva/v1/virtual_obstacles/CoSiVA.virtual/V1");
  for (const std::string_view prefix : {virtual_obstacles_topic_prefix, virtual_obstacles_ack_topic_prefix,
                                        detected_obstacle_topic_prefix, boards_topic_prefix})
    EXPECT_EQ(parse_own_topic(prefix, own_topic(prefix, vehicle)), vehicle) << prefix;
}

TEST(OwnTopic, names_exactly_one_vehicle) {
  for (const char* text :
       {"", "cosiva/v1/virtual_obstacles/", "cosiva/v1/virtual_obstacles/m", "cosiva/v1/virtual_obstacles/m/",
        "cosiva/v1/virtual_obstacles//s", "cosiva/v1/virtual_obstacles/m/s/more", "cosiva/v1/virtual_obstacles_ack/m/s",
        "cosiva/v1/virtual_obstacles"})
    EXPECT_FALSE(parse_own_topic(virtual_obstacles_topic_prefix, text)) << text;
}

TEST(PortName, names_vehicle_and_board) {
  EXPECT_EQ(port_name(3, Board::DOBS), "3/DOBS");
  EXPECT_EQ(to_string(Board::PILS), "PILS");
}

TEST(Topics, below_a_prefix_have_one_filter) {
  EXPECT_EQ(topics_below(zone_topic_prefix, 1), "cosiva/v1/zone/+");
  EXPECT_EQ(topics_below(virtual_obstacles_ack_topic_prefix, 2), "cosiva/v1/virtual_obstacles_ack/+/+");
}

TEST(SerialNumber, refuses_the_neighbours_of_the_standards_characters_in_ascii) {
  const std::string allowed = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_.:-";
  for (int code = 0; code < 256; ++code) {
    const char c = static_cast<char>(code);
    EXPECT_EQ(valid_serial_number(std::string{'a', c, 'z'}), allowed.find(c) != std::string::npos) << code;
  }
}

TEST(Topics, below_a_prefix_have_one_level_for_each_plus) {
  EXPECT_EQ(topics_below("a/", 0), "a/");
  EXPECT_EQ(topics_below("a/", 4), "a/+/+/+/+");
}

TEST(OwnTopic, may_have_names_of_one_character) {
  EXPECT_EQ(parse_own_topic("p/", "p/m/s"), (VehicleId{"m", "s"}));
  EXPECT_FALSE(parse_own_topic("p/", "p//s"));
  EXPECT_FALSE(parse_own_topic("p/", "p/m/"));
  EXPECT_FALSE(parse_own_topic("p/", "p/m//"));
}

TEST(PortName, has_the_name_of_each_board) {
  EXPECT_EQ(port_name(1, Board::PILS), "1/PILS");
  EXPECT_EQ(port_name(12, Board::PRAV), "12/PRAV");
  EXPECT_EQ(port_name(12, Board::RALI), "12/RALI");
}

}  // namespace
}  // namespace cosiva::wire
