#include "cosiva/virtual/server/core/report_follow_up.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string_view>
#include <vector>

#include "cosiva/virtual/server/testing/server_fixture.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;
using testing::IsEmpty;
using testing::SizeIs;

/// A vehicle that is stopped at 0.5 m on the south side of the oval. What it is sent, it ignores.
class FollowUp : public testing::Test {
 protected:
  FollowUp() {
    aiv.blocked = true;
    aiv.fakes = {"initPosition"};
  }
  [[nodiscard]] std::vector<wire::Action> sent(std::string_view type) const {
    std::vector<wire::Action> found;
    for (const wire::InstantActions& message : aiv.actions)
      for (const wire::Action& action : message.actions)
        if (action.action_type == type) found.push_back(action);
    return found;
  }
  void send_factsheet(const std::vector<wire::Factsheet::SupportedAction>& actions) {
    wire::Factsheet factsheet;
    factsheet.header = aiv.header(fixture.now, 0);
    factsheet.actions = actions;
    fixture.send(aiv, "factsheet", vda::encode(factsheet));
  }
  ServerFixture fixture;
  FixtureVehicle& aiv{fixture.add("AIV1", {0, 0.5})};
};

TEST_F(FollowUp, of_a_lost_position_begins_after_a_second_and_is_repeated_every_five) {
  fixture.run_for(3s);
  aiv.position_known = false;
  fixture.run_for(1s);
  EXPECT_THAT(sent("initPosition"), IsEmpty());
  fixture.run_for(300ms);
  ASSERT_THAT(sent("initPosition"), SizeIs(1));
  fixture.run_for(4700ms);
  EXPECT_THAT(sent("initPosition"), SizeIs(1));
  fixture.run_for(500ms);
  EXPECT_THAT(sent("initPosition"), SizeIs(2));
  const wire::Action action = sent("initPosition").front();
  EXPECT_NEAR(*action.number("x"), 0.5, 1e-9);
  EXPECT_NEAR(*action.number("y"), 0.0, 1e-9);
  EXPECT_NEAR(*action.number("theta"), 0.0, 1e-9);
  EXPECT_EQ(action.text("mapId"), "oval");
  EXPECT_EQ(action.text("lastNodeId"), fixture.zone->waypoints[fixture.zone->waypoint_behind({0, 0.5})].id);
  EXPECT_EQ(action.blocking_type, wire::BlockingType::hard);
  EXPECT_TRUE(fixture.logged("CoSiVA/AIV1: has lost its position; sent its last known position"));
}

TEST_F(FollowUp, of_a_lost_position_ends_when_the_vehicle_knows_it_again) {
  fixture.run_for(3s);
  aiv.position_known = false;
  fixture.run_for(500ms);
  aiv.position_known = true;
  fixture.run_for(500ms);
  aiv.position_known = false;
  fixture.run_for(900ms);
  EXPECT_THAT(sent("initPosition"), IsEmpty());
}

TEST_F(FollowUp, sends_no_position_to_a_vehicle_that_cannot_take_it) {
  send_factsheet({{"stopPause", "", true, false, false, {}}});
  fixture.run_for(3s);
  aiv.position_known = false;
  fixture.run_for(3s);
  EXPECT_THAT(sent("initPosition"), IsEmpty());
  send_factsheet({{"initPosition", "", true, false, false, {}}});
  fixture.run_for(200ms);
  EXPECT_THAT(sent("initPosition"), SizeIs(1));
}

TEST_F(FollowUp, sends_no_position_to_a_vehicle_that_is_offline) {
  fixture.run_for(3s);
  aiv.position_known = false;
  fixture.run_for(500ms);
  aiv.alive = false;
  fixture.connection(aiv, wire::ConnectionState::offline);
  fixture.run_for(700ms);
  EXPECT_FALSE(fixture.logged("has lost its position"));
}

TEST_F(FollowUp, requests_a_factsheet_after_a_second_and_only_where_it_is_missing) {
  fixture.run_for(900ms);
  EXPECT_THAT(sent("factsheetRequest"), IsEmpty()) << "a retained factsheet is received first";
  fixture.run_for(300ms);
  ASSERT_THAT(sent("factsheetRequest"), SizeIs(1));
  EXPECT_EQ(sent("factsheetRequest")[0].blocking_type, wire::BlockingType::none);
  FixtureVehicle& known = fixture.add("AIV2", {2, 0.5});
  wire::Factsheet factsheet;
  factsheet.header = known.header(fixture.now, 0);
  fixture.send(known, "factsheet", vda::encode(factsheet));
  fixture.run_for(3s);
  for (const wire::InstantActions& message : known.actions)
    EXPECT_NE(message.actions.front().action_type, "factsheetRequest");
}

TEST_F(FollowUp, requests_a_factsheet_exactly_a_second_after_the_first_message) {
  fixture.run_for(980ms);
  EXPECT_THAT(sent("factsheetRequest"), IsEmpty());
  fixture.run_for(20ms);
  EXPECT_THAT(sent("factsheetRequest"), SizeIs(1));
}

TEST_F(FollowUp, requests_no_factsheet_of_a_vehicle_that_is_absent_or_offline) {
  FixtureVehicle& absent = fixture.add("AIV2", {2, 0.5});
  absent.alive = false;
  absent.position_known = false;
  fixture.run_for(600ms);
  aiv.alive = false;
  fixture.connection(aiv, wire::ConnectionState::offline);
  fixture.run_for(2500ms);  // the startup synchronisation waits two seconds for the absent one
  EXPECT_THAT(fixture.published_on("uagv/v2/CoSiVA/AIV1/instantActions"), IsEmpty());
  EXPECT_THAT(fixture.published_on("uagv/v2/CoSiVA/AIV2/instantActions"), IsEmpty());
}

TEST_F(FollowUp, sends_no_position_to_a_vehicle_that_never_had_one) {
  FixtureVehicle& lost = fixture.add("AIV2", {2, 0.5});
  lost.position_known = false;
  fixture.run_for(4s);
  for (const wire::InstantActions& message : lost.actions)
    EXPECT_NE(message.actions.front().action_type, "initPosition");
  EXPECT_FALSE(fixture.logged("has lost its position"));
}

TEST_F(FollowUp, sends_the_position_again_for_two_seconds_where_the_vehicle_does_not_respond) {
  aiv.deaf_to = {"initPosition"};
  fixture.run_for(3s);
  aiv.position_known = false;
  fixture.run_for(5s);
  // At 0, 300, 600 … 1800 ms.
  EXPECT_THAT(sent("initPosition"), SizeIs(7));
}

}  // namespace
}  // namespace cosiva::virtual_side
