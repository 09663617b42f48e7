#include "cosiva/aiv/onboard/virtual_perception.h"

#include <gtest/gtest.h>

#include "cosiva/aiv/testing/test_zone.h"

namespace cosiva::aiv {
namespace {

using test::lacet4;

struct VirtualPerceptionTest : ::testing::Test {
  VirtualPerception perception;
  DrivingContext context{lacet4(), {}};
  Session session{{"CoSiVA", "AIV1"}, wire::default_interface};
  wire::Effects effects;
  SimTime now{std::chrono::seconds{100}};

  VirtualPerceptionTest() { session.set_online(true); }
  /// True: the list was accepted. Then the vehicle has decided and acknowledged.
  bool list(std::uint32_t header_id, const std::string& map_id = "lacet4", bool retained = false) {
    effects.clear();
    wire::VirtualObstacles bodies;
    bodies.header_id = header_id;
    bodies.timestamp = now;
    bodies.map_id = map_id;
    const wire::Input input{now, wire::InputKind::message, "", wire::to_json(bodies), retained};
    if (!perception.on_bodies(now, input, context, effects)) return false;
    perception.update(now, false, context);
    perception.acknowledge(now, context, session, effects);
    return true;
  }
};

TEST_F(VirtualPerceptionTest, acknowledges_the_first_list_and_then_only_changes) {
  EXPECT_TRUE(list(5));
  EXPECT_EQ(effects.size(), 1U);
  EXPECT_TRUE(list(6));
  EXPECT_TRUE(effects.empty());
  perception.request_response();
  now += std::chrono::milliseconds{100};
  EXPECT_TRUE(list(7));
  EXPECT_EQ(effects.size(), 1U) << "a response was requested";
}

TEST_F(VirtualPerceptionTest, takes_a_decreasing_number_for_another_server_s) {
  EXPECT_TRUE(list(5));
  now += std::chrono::milliseconds{100};
  EXPECT_TRUE(list(1));
  EXPECT_EQ(effects.size(), 1U);
}

TEST_F(VirtualPerceptionTest, accepts_no_list_that_is_retained_or_of_another_map) {
  EXPECT_FALSE(list(5, "lacet4", true));
  EXPECT_TRUE(effects.empty());
  EXPECT_FALSE(list(5, "other"));
  EXPECT_EQ(effects.size(), 1U) << "a log line";
  EXPECT_FALSE(list(6, "other"));
  EXPECT_TRUE(effects.empty()) << "one line per kind";
}

TEST_F(VirtualPerceptionTest, acknowledges_once_a_second_in_any_case) {
  EXPECT_TRUE(list(5));
  ASSERT_EQ(effects.size(), 1U);
  now += std::chrono::milliseconds{999};
  EXPECT_TRUE(list(6));
  EXPECT_TRUE(effects.empty());
  now += std::chrono::milliseconds{1};
  EXPECT_TRUE(list(7));
  EXPECT_EQ(effects.size(), 1U);
}

TEST_F(VirtualPerceptionTest, acknowledges_at_once_where_the_clock_was_set_back) {
  EXPECT_TRUE(list(5));
  now -= std::chrono::milliseconds{500};
  EXPECT_TRUE(list(6));
  EXPECT_EQ(effects.size(), 1U);
}

TEST_F(VirtualPerceptionTest, does_not_acknowledge_the_same_list_twice_at_the_same_time) {
  EXPECT_TRUE(list(5));
  ASSERT_EQ(effects.size(), 1U);
  perception.request_response();
  EXPECT_TRUE(list(5));
  EXPECT_TRUE(effects.empty());
}

TEST_F(VirtualPerceptionTest, acknowledges_the_list_s_number_at_the_time_of_the_decision) {
  EXPECT_TRUE(list(5));
  const auto& publish = std::get<wire::Publish>(effects.at(0));
  EXPECT_EQ(publish.topic, session.topics().virtual_obstacles_ack);
  EXPECT_EQ(wire::virtual_obstacles_ack_from_json(publish.payload).value(),
            (wire::VirtualObstaclesAck{5, now, false, "", std::nullopt}));
}

TEST_F(VirtualPerceptionTest, acknowledges_and_logs_anew_after_a_zone_switch) {
  EXPECT_TRUE(list(5));
  EXPECT_FALSE(list(6, "other"));
  ASSERT_EQ(effects.size(), 1U);
  EXPECT_EQ(std::get<wire::Log>(effects[0]).text,
            "virtual obstacles not used: the list is of map 'other', this is 'lacet4'");
  perception.on_zone_switched();
  EXPECT_FALSE(list(7, "other"));
  EXPECT_EQ(effects.size(), 1U);
  now += std::chrono::milliseconds{100};
  EXPECT_TRUE(list(8));
  EXPECT_EQ(effects.size(), 1U);
}

}  // namespace
}  // namespace cosiva::aiv
