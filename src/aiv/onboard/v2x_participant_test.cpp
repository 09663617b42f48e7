#include "cosiva/aiv/onboard/v2x_participant.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "cosiva/aiv/testing/test_zone.h"

namespace cosiva::aiv {
namespace {

using std::chrono::milliseconds;
using test::lacet4;

struct V2xParticipantTest : ::testing::Test {
  wire::VehicleId id{"CoSiVA", "AIV1"};
  V2xParticipant v2x{id, true};
  DrivingContext context{lacet4(), {}};
  bool online{true};
  wire::Effects effects;

  V2xParticipantTest() { context.vehicle().estimator().position_at(test::at(lacet4(), "loop_se", 0.5)); }
  std::size_t intents_at(int ms) {
    effects.clear();
    v2x.publish_intent(SimTime{milliseconds{ms}}, context, online, effects);
    return effects.size();
  }
};

TEST_F(V2xParticipantTest, subscribes_around_its_cell_once_it_knows_its_pose) {
  DrivingContext lost{lacet4(), {}};
  EXPECT_FALSE(v2x.update_cell(lost));
  EXPECT_TRUE(v2x.filters().empty());
  EXPECT_TRUE(v2x.update_cell(context));
  EXPECT_FALSE(v2x.filters().empty());
  EXPECT_FALSE(v2x.update_cell(context)) << "the same cell";
}

TEST_F(V2xParticipantTest, publishes_once_a_second_while_it_is_alone) {
  EXPECT_EQ(intents_at(0), 0U) << "there is no cell yet";
  ASSERT_TRUE(v2x.update_cell(context));
  EXPECT_EQ(intents_at(0), 1U);
  EXPECT_EQ(intents_at(990), 0U);
  EXPECT_EQ(intents_at(1000), 1U);
}

TEST_F(V2xParticipantTest, neither_publishes_nor_subscribes_when_it_is_disabled) {
  V2xParticipant disabled{id, false};
  EXPECT_FALSE(disabled.update_cell(context));
  EXPECT_TRUE(disabled.filters().empty());
  disabled.publish_intent(SimTime{}, context, online, effects);
  EXPECT_TRUE(effects.empty());
}

TEST_F(V2xParticipantTest, logs_an_intent_that_cannot_be_read_once) {
  ASSERT_TRUE(v2x.update_cell(context));
  const wire::Input input{SimTime{}, wire::InputKind::message,
                          wire::v2x_topic("lacet4", wire::Cell{0, 0}, {"CoSiVA", "AIV2"}), "{", false};
  v2x.on_intent(SimTime{}, input, context, effects);
  v2x.on_intent(SimTime{}, input, context, effects);
  EXPECT_EQ(effects.size(), 1U);
  v2x.on_zone_switched();
  v2x.on_intent(SimTime{}, input, context, effects);
  EXPECT_EQ(effects.size(), 2U);
}

TEST_F(V2xParticipantTest, that_negotiates_takes_the_status_of_crossing_units_by_the_direct_link) {
  OnboardOptions options;
  options.autonomy = Autonomy::negotiate;
  DrivingContext negotiating{lacet4(), options};
  wire::CrossingStatus status;
  status.map_id = "lacet4";
  status.unit = {"CoSiVA.unit", "X1"};
  status.crossing = "X1";
  status.holders.push_back({{"CoSiVA", "AIV2"}, 0});
  const auto receive = [&](DrivingContext& by, const std::string& payload) {
    effects.clear();
    v2x.on_direct(SimTime{}, {wire::unit_port, status.unit}, {SimTime{}, wire::InputKind::bytes, "", payload, false},
                  by, effects);
    return effects.size();
  };
  EXPECT_EQ(receive(context, "{"), 0U) << "a vehicle that does not negotiate has no use for it";
  EXPECT_EQ(receive(negotiating, to_json(status)), 0U);
  EXPECT_EQ(negotiating.negotiation()->units().holders(SimTime{}, "X1").size(), 1U);
  EXPECT_EQ(receive(negotiating, "{"), 1U) << "logged";
  status.map_id = "indus8";
  EXPECT_EQ(receive(negotiating, to_json(status)), 1U) << "logged";
  EXPECT_EQ(negotiating.negotiation()->units().units(), 1U);
}

TEST_F(V2xParticipantTest, changes_its_cell_more_than_30_cm_outside) {
  // lacet4's "east" leads along y = -0.15 m, from x = -0.75 m to 0.75 m: out of the cell -1, -1 at x = 0.
  DrivingContext there{lacet4(), {}};
  const auto changes_at = [&](double x_m) {
    there.vehicle().estimator().set_off_path({x_m, -0.15, 0.0});
    return v2x.update_cell(there);
  };
  EXPECT_TRUE(changes_at(-0.1));
  EXPECT_FALSE(changes_at(0.29));
  EXPECT_TRUE(changes_at(0.31));
  EXPECT_FALSE(changes_at(-0.29)) << "now the other cell is the vehicle's";
  EXPECT_FALSE(changes_at(-0.3)) << "exactly";
  EXPECT_TRUE(changes_at(-0.31));
}

TEST_F(V2xParticipantTest, changes_its_cell_with_the_map) {
  ASSERT_TRUE(v2x.update_cell(context));
  const auto before = v2x.filters();
  zone::TrafficZone other = lacet4();
  other.name = "other";
  DrivingContext there{other, {}};
  there.vehicle().estimator().position_at(test::at(lacet4(), "loop_se", 0.5));
  EXPECT_TRUE(v2x.update_cell(there));
  EXPECT_NE(v2x.filters(), before);
}

/// Another vehicle's intent from the position of this one, received at a time in milliseconds.
struct V2xNeighbourTest : V2xParticipantTest {
  V2xNeighbourTest() { EXPECT_TRUE(v2x.update_cell(context)); }
  [[nodiscard]] wire::Intent intent(const std::string& serial_number, std::uint32_t header_id) const {
    wire::Intent other;
    other.header_id = header_id;
    other.timestamp = virtual_epoch;
    other.map_id = "lacet4";
    other.vehicle = {"CoSiVA", serial_number};
    other.pose = context.vehicle().position().pose();
    return other;
  }
  /// The lines that are logged.
  std::vector<std::string> receive(int ms, const wire::Intent& other, bool retained = false,
                                   const std::string& topic_serial = "") {
    effects.clear();
    const wire::VehicleId sender{"CoSiVA", topic_serial.empty() ? other.vehicle.serial_number : topic_serial};
    const wire::Input input{SimTime{milliseconds{ms}}, wire::InputKind::message,
                            wire::v2x_topic(other.map_id, wire::cell_of(position(other.pose)), sender), to_json(other),
                            retained};
    v2x.on_intent(input.at, input, context, effects);
    std::vector<std::string> lines;
    for (const wire::Effect& effect : effects) lines.push_back(std::get<wire::Log>(effect).text);
    return lines;
  }
};

TEST_F(V2xNeighbourTest, causes_an_intent_when_it_is_new) {
  EXPECT_EQ(intents_at(0), 1U);
  EXPECT_TRUE(receive(50, intent("AIV2", 1)).empty());
  EXPECT_EQ(intents_at(99), 0U) << "ten times a second at most";
  EXPECT_EQ(intents_at(100), 1U);
  EXPECT_TRUE(receive(150, intent("AIV2", 2)).empty());
  EXPECT_EQ(intents_at(200), 0U) << "the vehicle is known";
}

TEST_F(V2xNeighbourTest, makes_a_stopped_vehicle_publish_twice_a_second) {
  EXPECT_TRUE(receive(0, intent("AIV2", 1)).empty());
  EXPECT_EQ(intents_at(0), 1U);
  EXPECT_EQ(intents_at(499), 0U);
  EXPECT_EQ(intents_at(500), 1U);
}

TEST_F(V2xNeighbourTest, makes_a_moving_vehicle_publish_five_times_a_second) {
  wire::Odometry moving{};
  moving.speed_mmps = 400;
  context.agent().on_odometry(moving);
  EXPECT_TRUE(receive(0, intent("AIV2", 1)).empty());
  EXPECT_EQ(intents_at(0), 1U);
  EXPECT_EQ(intents_at(199), 0U);
  EXPECT_EQ(intents_at(200), 1U);
}

TEST_F(V2xNeighbourTest, is_forgotten_after_a_second) {
  EXPECT_TRUE(receive(0, intent("AIV2", 1)).empty());
  EXPECT_EQ(intents_at(0), 1U);
  EXPECT_EQ(intents_at(500), 1U);
  EXPECT_EQ(intents_at(1100), 0U) << "alone: once a second";
  EXPECT_EQ(intents_at(1499), 0U);
  EXPECT_EQ(intents_at(1500), 1U);
}

TEST_F(V2xNeighbourTest, may_be_late_or_the_vehicle_s_own_without_a_log_line) {
  EXPECT_TRUE(receive(0, intent("AIV2", 5)).empty());
  EXPECT_TRUE(receive(10, intent("AIV2", 5)).empty());
  EXPECT_TRUE(receive(20, intent("AIV2", 4)).empty());
  EXPECT_TRUE(receive(30, intent("AIV1", 1)).empty());
  EXPECT_EQ(receive(40, intent("AIV1", 1), false, "AIV2").size(), 1U) << "an intent under a false name";
}

TEST_F(V2xNeighbourTest, is_not_used_where_it_is_retained_or_the_pose_is_not_known) {
  wire::Intent wrong = intent("AIV2", 1);
  wrong.speed_mps = 1e9;  // a reader logs a line
  EXPECT_TRUE(receive(0, wrong, true).empty());
  EXPECT_EQ(receive(0, wrong).size(), 1U);
  v2x.on_zone_switched();
  V2xParticipant disabled{id, false};
  const wire::Input input{SimTime{}, wire::InputKind::message, wire::v2x_topic("lacet4", {}, {"CoSiVA", "AIV2"}), "{",
                          false};
  effects.clear();
  disabled.on_intent(SimTime{}, input, context, effects);
  DrivingContext lost{lacet4(), {}};
  v2x.on_intent(SimTime{}, input, lost, effects);
  wire::Input elsewhere = input;
  elsewhere.source = "some/where/else";
  v2x.on_intent(SimTime{}, elsewhere, context, effects);
  EXPECT_TRUE(effects.empty());
  v2x.on_intent(SimTime{}, input, context, effects);
  EXPECT_EQ(effects.size(), 1U);
}

TEST_F(V2xNeighbourTest, publishes_again_where_the_clock_was_set_back) {
  EXPECT_EQ(intents_at(10'000), 1U);
  EXPECT_EQ(intents_at(5'000), 1U);
  EXPECT_EQ(intents_at(5'999), 0U);
  EXPECT_EQ(intents_at(6'000), 1U);
}

TEST_F(V2xNeighbourTest, publishes_its_name_and_its_priority_in_the_zone) {
  zone::TrafficZone zone = lacet4();
  zone.priorities = {{"CoSiVA/AIV1", 7}};
  DrivingContext there{zone, {}};
  there.vehicle().estimator().position_at(test::at(lacet4(), "loop_se", 0.5));
  v2x.publish_intent(SimTime{}, there, online, effects);
  ASSERT_EQ(effects.size(), 1U);
  const auto published = wire::intent_from_json(std::get<wire::Publish>(effects[0]).payload);
  ASSERT_TRUE(published);
  EXPECT_EQ(published->priority, 7U);
  EXPECT_EQ(published->vehicle, id);
}

TEST_F(V2xNeighbourTest, needs_broker_cell_and_pose_to_publish) {
  online = false;
  EXPECT_EQ(intents_at(0), 0U);
  online = true;
  DrivingContext lost{lacet4(), {}};
  v2x.publish_intent(SimTime{}, lost, online, effects);
  EXPECT_TRUE(effects.empty());
  EXPECT_EQ(intents_at(0), 1U);
}

}  // namespace
}  // namespace cosiva::aiv
