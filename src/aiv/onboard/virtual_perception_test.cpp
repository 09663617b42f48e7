#include "cosiva/aiv/onboard/virtual_perception.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "cosiva/aiv/testing/test_orders.h"
#include "cosiva/aiv/testing/test_zone.h"

namespace cosiva::aiv {
namespace {

using test::lacet4;

struct VirtualPerceptionTest : ::testing::Test {
  VirtualPerception perception;
  DrivingContext context{lacet4(), {}};
  ServerProxy server_proxy{{"CoSiVA", "AIV1"}, wire::default_interface};
  wire::Effects effects;
  SimTime now{std::chrono::seconds{100}};

  VirtualPerceptionTest() { server_proxy.set_online(true); }
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
    perception.acknowledge(now, context, server_proxy, effects);
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
  EXPECT_EQ(publish.topic, server_proxy.topics().virtual_obstacles_ack);
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

/// A vehicle at the start of a loop with an order of over a metre, and bodies on its path.
struct VirtualBrakingTest : VirtualPerceptionTest {
  VirtualBrakingTest() {
    context.vehicle().estimator().position_at(test::at(lacet4(), "loop_se", 0.0));
    EXPECT_TRUE(context.vehicle().take_order(test::order("O-1").through({"loop_se@0", "loop_se@1131"})));
  }
  /// A disc of 6 cm on the path.
  [[nodiscard]] static wire::Body body(const std::string& id, double s_m) {
    const Pose2 pose = lacet4().circuit.pose_at(test::at(lacet4(), "loop_se", s_m));
    return {id, "person", pose.x_m, pose.y_m, 0.0, 0.0, 0.06, 0.0, 0.0};
  }
  void receive(std::uint32_t header_id, std::vector<wire::Body> bodies) {
    const wire::VirtualObstacles obstacles{header_id, now, "lacet4", std::move(bodies)};
    const wire::Input input{now, wire::InputKind::message, "", wire::to_json(obstacles), false};
    EXPECT_TRUE(perception.on_bodies(now, input, context, effects));
  }
  void decide(bool server_lost = false) {
    perception.update(now, server_lost, context);
    (void)context.agent().decide();
  }
  [[nodiscard]] std::vector<wire::VirtualObstaclesAck> responses() {
    std::vector<wire::VirtualObstaclesAck> all;
    for (const wire::Effect& effect : effects)
      all.push_back(wire::virtual_obstacles_ack_from_json(std::get<wire::Publish>(effect).payload).value());
    effects.clear();
    return all;
  }
};

TEST_F(VirtualBrakingTest, names_the_body_for_which_it_brakes_and_the_distance) {
  receive(5, {body("far", 0.6), body("near", 0.3)});
  decide();
  perception.acknowledge(now, context, server_proxy, effects);
  const auto all = responses();
  ASSERT_EQ(all.size(), 1U);
  EXPECT_EQ(all[0].virtual_obstacles_header_id, 5U);
  EXPECT_EQ(all[0].decided, now);
  EXPECT_TRUE(all[0].braking);
  EXPECT_EQ(all[0].body, "near");
  ASSERT_TRUE(all[0].distance_m);
  EXPECT_NEAR(*all[0].distance_m, 0.3 - 0.06 - 0.1, 0.01);
}

TEST_F(VirtualBrakingTest, acknowledges_a_list_by_which_it_brakes_for_another_body) {
  receive(5, {body("a", 0.3), body("b", 0.5)});
  decide();
  perception.acknowledge(now, context, server_proxy, effects);
  EXPECT_EQ(responses().size(), 1U);
  now += std::chrono::milliseconds{100};
  receive(6, {body("a", 0.3), body("b", 0.5)});
  decide();
  perception.acknowledge(now, context, server_proxy, effects);
  EXPECT_TRUE(responses().empty());
  now += std::chrono::milliseconds{100};
  receive(7, {body("a", 0.5), body("b", 0.3)});
  decide();
  perception.acknowledge(now, context, server_proxy, effects);
  const auto all = responses();
  ASSERT_EQ(all.size(), 1U);
  EXPECT_EQ(all[0].body, "b");
}

TEST_F(VirtualBrakingTest, responds_once_when_braking_begins_and_once_when_it_ends) {
  decide();
  perception.publish_change(now, context, server_proxy, effects);
  EXPECT_TRUE(responses().empty());
  receive(5, {body("a", 0.3)});
  decide();
  perception.publish_change(now, context, server_proxy, effects);
  const auto begun = responses();
  ASSERT_EQ(begun.size(), 1U);
  EXPECT_TRUE(begun[0].braking);
  perception.acknowledge(now, context, server_proxy, effects);
  EXPECT_TRUE(responses().empty()) << "the list has its response already";
  now += std::chrono::milliseconds{1001};
  decide();
  perception.publish_change(now, context, server_proxy, effects);
  const auto ended = responses();
  ASSERT_EQ(ended.size(), 1U);
  EXPECT_FALSE(ended[0].braking);
  EXPECT_EQ(ended[0].body, "");
  EXPECT_FALSE(ended[0].distance_m);
  perception.publish_change(now, context, server_proxy, effects);
  EXPECT_TRUE(responses().empty());
}

TEST_F(VirtualBrakingTest, keeps_its_bodies_while_the_server_is_lost) {
  receive(5, {body("a", 0.3)});
  for (int i = 0; i < 4; ++i) {
    now += std::chrono::milliseconds{900};
    decide(true);
    EXPECT_TRUE(context.agent().decision().braking_for_virtual) << i;
  }
  now += std::chrono::milliseconds{1000};
  decide();
  EXPECT_TRUE(context.agent().decision().braking_for_virtual);
  now += std::chrono::milliseconds{1};
  decide();
  EXPECT_FALSE(context.agent().decision().braking_for_virtual);
  EXPECT_FALSE(context.virtual_bodies().informed());
}

TEST_F(VirtualBrakingTest, perceives_nothing_without_a_position_and_uses_no_list_that_cannot_be_read) {
  DrivingContext lost{lacet4(), {}};
  const wire::Input unreadable{now, wire::InputKind::message, "", "{", false};
  EXPECT_FALSE(perception.on_bodies(now, unreadable, lost, effects));
  EXPECT_FALSE(perception.on_bodies(now, unreadable, lost, effects));
  ASSERT_EQ(effects.size(), 1U) << "one line per kind";
  EXPECT_EQ(std::get<wire::Log>(effects[0]).level, 'w');
  EXPECT_EQ(std::get<wire::Log>(effects[0]).text.substr(0, 28), "virtual obstacles not used: ");
  receive(5, {body("a", 0.3)});
  lost.virtual_bodies().receive(now, {5, now, "lacet4", {body("a", 0.3)}});
  perception.update(now, false, lost);
  EXPECT_FALSE(lost.agent().finds_body());
}

}  // namespace
}  // namespace cosiva::aiv
