#include "cosiva/virtual/server/registry/reported_state.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace cosiva::virtual_side {
namespace {

using namespace std::chrono_literals;

wire::State state_at(SimDuration time, std::uint32_t header_id = 0) {
  wire::State state;
  state.header.timestamp = virtual_epoch + time;
  state.header.header_id = header_id;
  return state;
}

std::shared_ptr<const wire::State> received(wire::State state) {
  return std::make_shared<const wire::State>(std::move(state));
}

wire::State with_limit(SimDuration time, const std::string& profile,
                       wire::ActionStatus status = wire::ActionStatus::finished) {
  wire::State state = state_at(time);
  wire::ActionState action;
  action.action_type = "setSpeedLimit";
  action.status = status;
  action.result_description = profile;
  state.action_states.push_back(action);
  return state;
}

wire::State with_tag(SimDuration time, const std::string& tag, const std::string& distance_m) {
  wire::State state = state_at(time);
  wire::Information information;
  information.type = "lastTag";
  information.references = {{"tag", tag}, {"distance_m", distance_m}};
  state.information.push_back(information);
  return state;
}

TEST(ReportedState, is_nothing_before_the_first_state) {
  const ReportedState reported;
  EXPECT_EQ(reported.last(), nullptr);
  EXPECT_FALSE(reported.since_link());
  EXPECT_FALSE(reported.in_session());
  EXPECT_FALSE(reported.outdated(state_at(0s).header));
}

TEST(ReportedState, gives_the_state_before_the_new_one) {
  ReportedState reported;
  EXPECT_FALSE(reported.on_state(received(state_at(0s, 1)), true).before);
  const ReportedState::Change change = reported.on_state(received(state_at(1s, 2)), true);
  ASSERT_TRUE(change.before);
  EXPECT_EQ(change.before->header.header_id, 1U);
  EXPECT_EQ(reported.last()->header.header_id, 2U);
}

TEST(ReportedState, is_outdated_by_an_overtaken_state_and_by_the_same_state_again) {
  ReportedState reported;
  reported.on_state(received(state_at(10s, 7)), true);
  EXPECT_TRUE(reported.outdated(state_at(9s, 6).header));
  EXPECT_TRUE(reported.outdated(state_at(10s, 7).header));
  EXPECT_FALSE(reported.outdated(state_at(10s, 8).header)) << "another state of the same instant";
  EXPECT_FALSE(reported.outdated(state_at(11s, 8).header));
  EXPECT_FALSE(reported.outdated(state_at(5s, 8).header)) << "the vehicle's clock was set";
  EXPECT_DEATH(reported.on_state(received(state_at(9s, 6)), true), "outdated");
}

TEST(ReportedState, lets_time_stamps_start_again_in_a_new_session) {
  ReportedState reported;
  reported.on_state(received(state_at(10s, 7)), true);
  reported.on_session();
  EXPECT_FALSE(reported.in_session());
  EXPECT_NE(reported.last(), nullptr) << "still shown";
  EXPECT_FALSE(reported.outdated(state_at(9s, 0).header));
  reported.on_state(received(state_at(9s, 0)), true);
  EXPECT_TRUE(reported.in_session());
}

TEST(ReportedState, is_of_the_link_only_when_the_link_was_up) {
  ReportedState reported;
  reported.on_state(received(state_at(0s)), false);
  EXPECT_FALSE(reported.since_link());
  reported.on_state(received(state_at(1s)), true);
  EXPECT_TRUE(reported.since_link());
  reported.on_state(received(state_at(2s)), false);
  EXPECT_TRUE(reported.since_link());
  reported.on_link_up();
  EXPECT_FALSE(reported.since_link());
}

TEST(ReportedState, shows_the_limit_of_the_last_finished_action_until_the_session_ends) {
  ReportedState reported;
  reported.on_state(received(with_limit(0s, "slow", wire::ActionStatus::running)), true);
  EXPECT_FALSE(reported.imposed());
  reported.on_state(received(with_limit(1s, "slow")), true);
  EXPECT_EQ(reported.imposed(), aiv::Profile::slow);
  wire::State both = with_limit(2s, "slow");
  both.action_states.push_back(with_limit(2s, "fast").action_states.front());
  reported.on_state(received(both), true);
  EXPECT_EQ(reported.imposed(), aiv::Profile::fast) << "the later of two";
  reported.on_state(received(state_at(3s)), true);
  EXPECT_EQ(reported.imposed(), aiv::Profile::fast) << "a state need not list an action for ever";
  reported.on_state(received(with_limit(4s, "normal")), true);
  EXPECT_FALSE(reported.imposed());
  reported.on_state(received(with_limit(5s, "slow")), true);
  reported.on_session();
  EXPECT_FALSE(reported.imposed());
}

TEST(ReportedState, shows_the_last_tag_and_whether_it_is_new) {
  ReportedState reported;
  EXPECT_TRUE(reported.on_state(received(with_tag(0s, "7", "0.25")), true).new_tag);
  EXPECT_EQ(reported.last_tag(), 7U);
  EXPECT_DOUBLE_EQ(reported.since_tag_m(), 0.25);
  EXPECT_FALSE(reported.on_state(received(with_tag(1s, "7", "0.5")), true).new_tag);
  EXPECT_DOUBLE_EQ(reported.since_tag_m(), 0.5);
  EXPECT_FALSE(reported.on_state(received(state_at(2s)), true).new_tag);
  EXPECT_EQ(reported.last_tag(), 7U);
  EXPECT_TRUE(reported.on_state(received(with_tag(3s, "8", "")), true).new_tag);
  EXPECT_DOUBLE_EQ(reported.since_tag_m(), 0.0) << "the distance cannot be read";
}

TEST(ReportedState, ignores_a_tag_that_is_no_number) {
  ReportedState reported;
  EXPECT_FALSE(reported.on_state(received(with_tag(0s, "7a", "0.25")), true).new_tag);
  EXPECT_FALSE(reported.last_tag());
  EXPECT_DOUBLE_EQ(reported.since_tag_m(), 0.0);
}

wire::State with_information(SimDuration time, const std::string& type, std::vector<wire::Reference> references) {
  wire::State state = state_at(time);
  wire::Information information;
  information.type = type;
  information.references = std::move(references);
  state.information.push_back(information);
  return state;
}

TEST(ReportedState, is_not_outdated_by_a_header_id_that_is_used_again_later) {
  ReportedState reported;
  reported.on_state(received(state_at(10s, 7)), true);
  EXPECT_FALSE(reported.outdated(state_at(11s, 7).header));
  EXPECT_FALSE(reported.outdated(state_at(10s, 6).header));
}

TEST(ReportedState, takes_limits_from_no_other_action) {
  ReportedState reported;
  wire::State state = with_limit(0s, "slow");
  state.action_states.front().action_type = "pick";
  reported.on_state(received(state), true);
  EXPECT_FALSE(reported.imposed());
  wire::State both = with_limit(1s, "fast");
  both.action_states.push_back(with_limit(1s, "slow", wire::ActionStatus::failed).action_states.front());
  both.action_states.push_back(state.action_states.front());
  reported.on_state(received(both), true);
  EXPECT_EQ(reported.imposed(), aiv::Profile::fast) << "the last one that finished";
}

TEST(ReportedState, takes_tags_from_no_other_information_and_needs_their_number) {
  ReportedState reported;
  EXPECT_FALSE(reported.on_state(received(with_information(0s, "firstTag", {{"tag", "7"}})), true).new_tag);
  EXPECT_FALSE(reported.on_state(received(with_information(1s, "lastTag", {{"distance_m", "0.5"}})), true).new_tag);
  EXPECT_FALSE(reported.on_state(received(with_information(2s, "lastTag", {{"tag", ""}})), true).new_tag);
  EXPECT_FALSE(reported.on_state(received(with_information(3s, "lastTag", {{"tag", "-1"}})), true).new_tag);
  EXPECT_FALSE(reported.last_tag());
  EXPECT_TRUE(reported.on_state(received(with_information(4s, "lastTag", {{"tag", "0"}})), true).new_tag);
  EXPECT_EQ(reported.last_tag(), 0U);
  EXPECT_DOUBLE_EQ(reported.since_tag_m(), 0.0) << "no distance";
}

TEST(ReportedState, preserves_the_distance_where_the_tag_cannot_be_read) {
  ReportedState reported;
  reported.on_state(received(with_tag(0s, "7", "0.25")), true);
  reported.on_state(received(with_tag(1s, "x", "0.5")), true);
  EXPECT_EQ(reported.last_tag(), 7U);
  EXPECT_DOUBLE_EQ(reported.since_tag_m(), 0.25);
}

}  // namespace
}  // namespace cosiva::virtual_side
