#include "cosiva/adapters/stop/pending_stops.h"

#include <gmock/gmock.h>

#include <array>

#include "cosiva/wire/messages/messages.h"
#include "cosiva/wire/vda5050/decode.h"
#include "cosiva/wire/vda5050/encode.h"

namespace cosiva::adapters {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Pair;
using ::testing::SizeIs;

constexpr SimTime start{std::chrono::hours{470'000}};

wire::StopTarget target(const std::string& serial, bool latched = false) {
  const wire::VehicleId id{"CoSiVA", serial};
  return {to_string(id), id,  wire::vda_topic(id, "instantActions"), wire::vda_topic(id, "state"), "2.1.0",
          latched,       true};
}

std::string state(bool paused, const std::string& action_id = {}) {
  wire::State state;
  if (!action_id.empty()) state.action_states.push_back({action_id, "startPause", wire::ActionStatus::running, {}});
  state.header = {1, start, "2.1.0", "CoSiVA", "AIV1"};
  state.paused = paused;
  return wire::vda5050::encode(state);
}

wire::InstantActions read(const wire::Publish& message) {
  auto actions = wire::vda5050::decode_instant_actions(message.payload);
  EXPECT_TRUE(actions) << message.payload;
  return actions.value_or(wire::InstantActions{});
}

const std::array two{target("AIV1"), target("AIV2")};
const std::string aiv1_state = "uagv/v2/CoSiVA/AIV1/state";

TEST(PendingStops, publish_start_pause_to_each_vehicle_with_the_stops_id) {
  PendingStops stops;
  const auto messages = stops.begin("S1", two, start);
  ASSERT_THAT(messages, SizeIs(2));
  EXPECT_EQ(messages[0].topic, "uagv/v2/CoSiVA/AIV1/instantActions");
  EXPECT_EQ(messages[0].qos, 0);
  EXPECT_FALSE(messages[0].retained);
  const wire::InstantActions actions = read(messages[0]);
  EXPECT_EQ(actions.header.serial_number, "AIV1");
  EXPECT_EQ(actions.header.version, "2.1.0");
  EXPECT_EQ(actions.header.timestamp, start);
  ASSERT_THAT(actions.actions, SizeIs(1));
  EXPECT_EQ(actions.actions[0].action_type, "startPause");
  EXPECT_EQ(actions.actions[0].action_id, "S1");
}

TEST(PendingStops, use_the_version_that_the_vehicle_writes_and_our_own_where_it_is_not_known) {
  PendingStops stops;
  std::array vehicles{target("AIV1"), target("AIV2")};
  vehicles[0].version = "2.0.0";
  vehicles[1].version.clear();
  const auto messages = stops.begin("S1", vehicles, start);
  EXPECT_EQ(read(messages[0]).header.version, "2.0.0");
  EXPECT_EQ(read(messages[1]).header.version, "2.1.0");
}

TEST(PendingStops, count_the_header_ids_of_each_topic_in_the_half_that_the_core_does_not_use) {
  PendingStops stops;
  const auto first = stops.begin("S1", two, start);
  const auto second = stops.due(start + 100ms);
  for (const std::size_t i : {0U, 1U}) {
    EXPECT_EQ(read(first[i]).header.header_id, 0x8000'0000U);
    EXPECT_EQ(read(second[i]).header.header_id, 0x8000'0001U);
  }
}

TEST(PendingStops, are_due_every_100_ms_with_the_same_action) {
  PendingStops stops;
  (void)stops.begin("S1", two, start);
  EXPECT_THAT(stops.due(start + 99ms), IsEmpty());
  const auto again = stops.due(start + 100ms);
  ASSERT_THAT(again, SizeIs(2));
  EXPECT_EQ(read(again[0]).actions[0].action_id, "S1");
  EXPECT_THAT(stops.due(start + 199ms), IsEmpty());
  EXPECT_THAT(stops.due(start + 200ms), SizeIs(2));
}

TEST(PendingStops, are_due_less_often_once_the_vehicle_has_not_confirmed_for_long) {
  PendingStops stops;
  (void)stops.begin("S1", two, start);
  EXPECT_THAT(stops.due(start + 10s), SizeIs(2));
  EXPECT_THAT(stops.due(start + 10s + 999ms), IsEmpty());
  EXPECT_THAT(stops.due(start + 11s), SizeIs(2));
}

TEST(PendingStops, are_confirmed_by_a_state_that_shows_paused_and_by_nothing_else) {
  PendingStops stops;
  (void)stops.begin("S1", two, start);
  EXPECT_FALSE(stops.on_state(aiv1_state, state(false)));
  EXPECT_FALSE(stops.on_state(aiv1_state, "nonsense"));
  EXPECT_FALSE(stops.on_state("uagv/v2/CoSiVA/AIV9/state", state(true)));
  EXPECT_THAT(stops.unconfirmed(), ElementsAre(Pair("S1", ElementsAre("CoSiVA/AIV1", "CoSiVA/AIV2"))));
  EXPECT_TRUE(stops.on_state(aiv1_state, state(true)));
  EXPECT_THAT(stops.unconfirmed(), ElementsAre(Pair("S1", ElementsAre("CoSiVA/AIV2"))));
  EXPECT_THAT(stops.state_topics(), ElementsAre("uagv/v2/CoSiVA/AIV2/state"));
  const auto again = stops.due(start + 100ms);
  ASSERT_THAT(again, SizeIs(1));
  EXPECT_EQ(again[0].topic, "uagv/v2/CoSiVA/AIV2/instantActions");
}

TEST(PendingStops, are_all_due_over_a_new_connection) {
  PendingStops stops;
  (void)stops.begin("S1", two, start);
  EXPECT_THAT(stops.all(start + 1ms), SizeIs(2));
  EXPECT_THAT(stops.due(start + 100ms), IsEmpty()) << "sent 99 ms ago";
}

TEST(PendingStops, are_replaced_by_a_later_stop_of_the_same_vehicle) {
  PendingStops stops;
  (void)stops.begin("S1", two, start);
  (void)stops.begin("S2", std::array{target("AIV1")}, start + 50ms);
  EXPECT_THAT(stops.unconfirmed(),
              ElementsAre(Pair("S1", ElementsAre("CoSiVA/AIV2")), Pair("S2", ElementsAre("CoSiVA/AIV1"))));
}

TEST(PendingStops, raise_the_alarm_once_for_each_vehicle_after_500_ms) {
  PendingStops stops;
  (void)stops.begin("S1", two, start);
  (void)stops.on_state(aiv1_state, state(true));
  EXPECT_THAT(stops.take_overdue(start + 500ms), IsEmpty());
  const auto overdue = stops.take_overdue(start + 501ms);
  ASSERT_THAT(overdue, SizeIs(1));
  EXPECT_EQ(overdue[0].id, "S1");
  EXPECT_EQ(overdue[0].vehicle, "CoSiVA/AIV2");
  EXPECT_THAT(stops.take_overdue(start + 2s), IsEmpty());
}

TEST(PendingStops, end_for_the_vehicles_that_may_drive_again) {
  PendingStops stops;
  (void)stops.begin("S1", two, start);
  EXPECT_FALSE(stops.lift(std::array<std::string, 1>{"CoSiVA/AIV9"}, start));
  EXPECT_TRUE(stops.lift(std::array<std::string, 1>{"CoSiVA/AIV1"}, start));
  EXPECT_THAT(stops.unconfirmed(), ElementsAre(Pair("S1", ElementsAre("CoSiVA/AIV2"))));
  EXPECT_TRUE(stops.lift(std::array<std::string, 1>{"*"}, start));
  EXPECT_TRUE(stops.empty());
}

TEST(PendingStops, are_repeated_once_a_second_to_a_vehicle_that_may_perform_an_action_twice) {
  PendingStops stops;
  wire::StopTarget third_party = target("AIV1");
  third_party.is_cosiva = false;
  (void)stops.begin("S1", std::array{third_party, target("AIV2")}, start);
  EXPECT_THAT(stops.due(start + 100ms), SizeIs(1));
  EXPECT_THAT(stops.due(start + 999ms), SizeIs(1));
  const auto both = stops.due(start + 1'100ms);
  ASSERT_THAT(both, SizeIs(2));
  EXPECT_EQ(read(both[0]).actions[0].action_id, "S1");
}

TEST(PendingStops, soon_after_a_restart_are_confirmed_only_by_a_state_that_lists_the_action) {
  for (const std::string restarted : {"*", "CoSiVA/AIV1"}) {
    PendingStops stops;
    (void)stops.lift(std::array{restarted}, start);
    (void)stops.begin("S2", two, start + 10s);
    EXPECT_FALSE(stops.on_state(aiv1_state, state(true))) << "of the Stop before the restart";
    EXPECT_FALSE(stops.on_state(aiv1_state, state(true, "S1")));
    EXPECT_TRUE(stops.on_state(aiv1_state, state(true, "S2")));
    (void)stops.begin("S3", two, start + 10'001ms);
    EXPECT_TRUE(stops.on_state(aiv1_state, state(true))) << "the restart has arrived";
  }
  PendingStops stops;
  (void)stops.lift(std::array<std::string, 1>{"CoSiVA/AIV2"}, start);
  (void)stops.begin("S1", two, start);
  EXPECT_TRUE(stops.on_state(aiv1_state, state(true))) << "another vehicle was restarted";
}

TEST(PendingStops, end_once_the_core_that_had_them_has_lifted_them) {
  PendingStops stops;
  (void)stops.begin("S1", two, start);
  EXPECT_FALSE(stops.know(two)) << "the core does not have the Stop yet";
  EXPECT_FALSE(stops.know(std::array{target("AIV1", true), target("AIV2", true)}));
  EXPECT_TRUE(stops.know(std::array{target("AIV1", false), target("AIV2", true)}));
  EXPECT_THAT(stops.unconfirmed(), ElementsAre(Pair("S1", ElementsAre("CoSiVA/AIV2"))));
}

TEST(PendingStops, end_for_a_vehicle_that_the_core_does_not_know_any_more) {
  PendingStops stops;
  (void)stops.begin("S1", two, start);
  EXPECT_TRUE(stops.know(std::array{target("AIV2")}));
  EXPECT_THAT(stops.unconfirmed(), ElementsAre(Pair("S1", ElementsAre("CoSiVA/AIV2"))));
}

}  // namespace
}  // namespace cosiva::adapters
