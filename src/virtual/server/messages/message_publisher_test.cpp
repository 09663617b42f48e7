#include "cosiva/virtual/server/messages/message_publisher.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstddef>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "cosiva/base/json_value.h"
#include "cosiva/wire/vda5050/codec.h"

namespace cosiva::virtual_side {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::SizeIs;
namespace vda = wire::vda5050;

/// A publisher, and two vehicles, CoSiVA/AIV1 and CoSiVA/AIV2.
class Published : public testing::Test {
 protected:
  Published() {
    publisher.open(now, effects);
    for (const char* serial : {"AIV1", "AIV2"}) registry.add({"CoSiVA", serial}, now);
  }
  void pass(SimDuration duration) {
    now += duration;
    publisher.open(now, effects);
  }
  [[nodiscard]] std::vector<wire::Publish> messages() const {
    std::vector<wire::Publish> found;
    for (const wire::Effect& effect : effects)
      if (const auto* message = std::get_if<wire::Publish>(&effect)) found.push_back(*message);
    return found;
  }
  [[nodiscard]] std::vector<wire::InstantActions> actions() const {
    std::vector<wire::InstantActions> found;
    for (const wire::Publish& message : messages())
      if (message.topic.ends_with("instantActions")) found.push_back(*vda::decode_instant_actions(message.payload));
    return found;
  }
  [[nodiscard]] JsonValue last_trace() const { return *JsonValue::parse(*traces.one_json(traces.next() - 1)); }
  static wire::Action action(const std::string& type) { return {type, {}, {}, wire::BlockingType::hard, {}}; }
  /// A state of the vehicle that lists these actions.
  static wire::State with(std::vector<wire::ActionState> states) {
    wire::State state;
    state.action_states = std::move(states);
    return state;
  }
  InstantActionSender::ActionHandle send(VehicleIndex vehicle, std::vector<wire::Action> list, SimDuration timeout = 2s,
                                         bool keep = false) {
    return sender.send(registry[vehicle], vehicle, std::move(list), timeout, keep);
  }
  SimTime now{virtual_epoch};
  wire::Effects effects;
  Traces traces{100};
  MessagePublisher publisher{traces};
  Registry registry{"uagv"};
  InstantActionSender sender{publisher};
};

TEST_F(Published, order_has_the_vehicle_s_header_and_the_next_header_id) {
  wire::Order order;
  order.order_id = "O-1";
  auto sent = publisher.send(registry[0], wire::Order{order}, "a summary");
  pass(300ms);
  publisher.send_again(registry[0], sent);
  ASSERT_THAT(messages(), SizeIs(2));
  for (std::uint32_t i = 0; i < 2; ++i) {
    EXPECT_EQ(messages()[i].topic, "uagv/v2/CoSiVA/AIV1/order");
    EXPECT_EQ(messages()[i].qos, 0);
    EXPECT_FALSE(messages()[i].retained);
    const wire::Order read = *vda::decode_order(messages()[i].payload);
    EXPECT_EQ(read.order_id, "O-1");
    EXPECT_EQ(read.header, (wire::Header{i, virtual_epoch + i * 300ms, std::string(vda::version), "CoSiVA", "AIV1"}));
  }
  EXPECT_EQ(last_trace().text("content"), "repeated: not acknowledged within 300 ms");
  const auto trace = JsonValue::parse(*traces.one_json(1));
  EXPECT_EQ(trace->text("content"), "a summary");
  EXPECT_EQ(JsonValue::parse(*traces.one_json(1))->text("kind"), "order");
}

TEST_F(Published, order_is_passed_on_as_a_value_where_all_programs_are_in_one_process) {
  MessagePublisher in_process{traces, true};
  in_process.open(now, effects);
  wire::Order order;
  order.order_id = "O-1";
  (void)in_process.send(registry[0], std::move(order), "");
  ASSERT_THAT(messages(), SizeIs(1));
  EXPECT_TRUE(messages().front().payload.empty());
  EXPECT_NE(messages().front().typed, nullptr);
}

TEST_F(Published, actions_have_ids_of_their_own_and_a_summary) {
  wire::Action limit = action("setSpeedLimit");
  limit.parameters = {{"profile", std::string("slow")}};
  send(0, {action("stopPause"), limit});
  send(0, {action("startPause")});
  ASSERT_THAT(actions(), SizeIs(2));
  const wire::InstantActions first = actions()[0];
  ASSERT_THAT(first.actions, SizeIs(2));
  const std::string id = first.actions[0].action_id;
  EXPECT_EQ(id, unique_id("A", now) + "-1");
  EXPECT_EQ(first.actions[1].action_id, id + ".1");
  EXPECT_EQ(actions()[1].actions[0].action_id, unique_id("A", now) + "-2");
  EXPECT_EQ(actions()[1].header.header_id, 1U);
  const auto trace = JsonValue::parse(*traces.one_json(1));
  EXPECT_EQ(trace->text("content"), "stopPause (" + id + "), setSpeedLimit slow (" + id + ".1)");
}

TEST_F(Published, actions_are_repeated_every_300_ms_until_the_vehicle_lists_all_of_them) {
  const auto handle = send(0, {action("startPause"), action("stopPause")}, 2s, true);
  pass(299ms);
  sender.tick(registry, true);
  EXPECT_THAT(actions(), SizeIs(1));
  pass(1ms);
  sender.tick(registry, false);
  EXPECT_THAT(actions(), SizeIs(1)) << "the link is down";
  sender.tick(registry, true);
  sender.tick(registry, true);
  ASSERT_THAT(actions(), SizeIs(2));
  EXPECT_EQ(actions()[1].actions, actions()[0].actions);
  EXPECT_EQ(last_trace().text("content"), "repeated: not acknowledged within 300 ms");
  const std::string id = actions()[0].actions[0].action_id;
  sender.on_state(1, with({{id, "startPause", wire::ActionStatus::finished, ""}}));
  sender.on_state(0, with({{id, "startPause", wire::ActionStatus::running, "soon"}}));
  const auto* pending = sender.find(handle);
  ASSERT_NE(pending, nullptr);
  EXPECT_FALSE(pending->acknowledged());
  EXPECT_EQ(pending->actions[0].status, wire::ActionStatus::running);
  EXPECT_EQ(pending->actions[0].result, "soon");
  pass(300ms);
  sender.tick(registry, true);
  EXPECT_THAT(actions(), SizeIs(3));
  sender.on_state(0, with({{id + ".1", "stopPause", wire::ActionStatus::finished, ""}}));
  EXPECT_TRUE(sender.find(handle)->acknowledged());
  pass(300ms);
  sender.tick(registry, true);
  EXPECT_THAT(actions(), SizeIs(3));
}

TEST_F(Published, actions_are_repeated_until_their_timeout) {
  send(0, {action("startPause")}, 600ms);
  send(1, {action("startPause")}, SimDuration::zero());
  pass(300ms);
  sender.tick(registry, true);
  pass(299ms);
  sender.tick(registry, true);
  EXPECT_THAT(actions(), SizeIs(3)) << "the one without a timeout is sent once";
  pass(1ms);
  sender.tick(registry, true);
  EXPECT_THAT(actions(), SizeIs(3));
}

TEST_F(Published, action_is_forgotten_when_acknowledged_or_timed_out_unless_its_sender_follows_it) {
  const auto followed = send(0, {action("backUp")}, 1s, true);
  const auto other = send(0, {action("startPause")}, 1s);
  const auto late = send(0, {action("stopPause")}, 1s);
  const std::string followed_id = actions()[0].actions[0].action_id;
  const std::string other_id = actions()[1].actions[0].action_id;
  sender.on_state(0, with({{followed_id, "backUp", wire::ActionStatus::finished, ""},
                           {other_id, "startPause", wire::ActionStatus::finished, ""}}));
  EXPECT_NE(sender.find(followed), nullptr);
  EXPECT_EQ(sender.find(other), nullptr);
  pass(999ms);
  sender.tick(registry, true);
  EXPECT_NE(sender.find(late), nullptr);
  pass(1ms);
  sender.tick(registry, true);
  EXPECT_EQ(sender.find(late), nullptr);
  EXPECT_NE(sender.find(followed), nullptr);
  sender.drop(followed);
  EXPECT_EQ(sender.find(followed), nullptr);
}

TEST_F(Published, actions_to_a_vehicle_that_was_removed_are_forgotten) {
  const auto first = send(0, {action("startPause")}, 2s, true);
  const auto second = send(1, {action("startPause")}, 2s, true);
  sender.forget(0);
  EXPECT_EQ(sender.find(first), nullptr);
  EXPECT_NE(sender.find(second), nullptr);
}

TEST_F(Published, log_message_and_state_file_are_effects_of_which_the_state_file_comes_first) {
  effects.clear();
  effects.emplace_back(wire::Log{'i', "of an earlier input"});
  publisher.open(virtual_epoch, effects);
  publisher.log('w', "attention");
  publisher.publish("a/topic", "text", 1, true);
  publisher.persist("bytes");
  EXPECT_THAT(effects, ElementsAre(wire::Effect{wire::Log{'i', "of an earlier input"}},
                                   wire::Effect{wire::Persist{"bytes"}}, wire::Effect{wire::Log{'w', "attention"}},
                                   wire::Effect{wire::Publish{"a/topic", "text", 1, true}}));
}

TEST_F(Published, messages_state_the_version_that_the_vehicle_uses) {
  wire::Header received;
  received.version = "2.0.0";
  EXPECT_EQ(registry[0].received.on_header(VehicleTopic::state, received).missing, 0U);
  wire::Order order;
  order.order_id = "O-1";
  (void)publisher.send(registry[0], std::move(order), "");
  send(0, {action("startPause")});
  ASSERT_THAT(messages(), SizeIs(2));
  EXPECT_EQ(vda::decode_order(messages()[0].payload)->header.version, "2.0.0");
  EXPECT_EQ(actions()[0].header, (wire::Header{0, now, "2.0.0", "CoSiVA", "AIV1"}));
}

TEST_F(Published, messages_of_each_vehicle_and_topic_are_counted_by_themselves) {
  (void)publisher.send(registry[0], wire::Order{}, "");
  (void)publisher.send(registry[0], wire::Order{}, "");
  send(0, {action("startPause")});
  send(1, {action("startPause")});
  EXPECT_EQ(registry[0].sent.order, 2U);
  EXPECT_EQ(registry[0].sent.actions, 1U);
  EXPECT_EQ(registry[1].sent.order, 0U);
  EXPECT_EQ(registry[1].sent.actions, 1U);
}

TEST_F(Published, nothing_goes_to_a_vehicle_that_was_handed_over) {
  registry[0].membership.on_handed_over(now);
  (void)publisher.send(registry[0], wire::Order{}, "");
  send(0, {action("startPause")});
  EXPECT_THAT(messages(), SizeIs(0));
  EXPECT_EQ(registry[0].sent.order, 0U);
  EXPECT_EQ(registry[0].sent.actions, 0U);
  send(1, {action("startPause")});
  EXPECT_THAT(messages(), SizeIs(1));
}

TEST_F(Published, messages_are_traced_from_the_server_to_the_vehicle_with_their_text) {
  (void)publisher.send(registry[0], wire::Order{}, "an order");
  send(1, {action("startPause")});
  ASSERT_THAT(messages(), SizeIs(2));
  const std::vector<std::string> names{"CoSiVA/AIV1", "CoSiVA/AIV2"};
  const std::vector<std::string> kinds{"order", "instantActions"};
  for (std::size_t i = 0; i < 2; ++i) {
    const JsonValue trace = *JsonValue::parse(*traces.one_json(i + 1));
    EXPECT_EQ(trace.text("from"), "AIV_Server");
    EXPECT_EQ(trace.text("to"), names[i]);
    EXPECT_EQ(trace.text("kind"), kinds[i]);
    EXPECT_EQ(trace.text("topic"), messages()[i].topic);
    EXPECT_EQ(trace.text("raw"), messages()[i].payload);
  }
  EXPECT_EQ(messages()[1].topic, "uagv/v2/CoSiVA/AIV2/instantActions");
  EXPECT_EQ(messages()[1].qos, 0);
  EXPECT_FALSE(messages()[1].retained);
}

TEST_F(Published, decisions_are_traced_without_a_message) {
  publisher.explain(registry[1], "wait", "waits for another vehicle");
  EXPECT_THAT(effects, SizeIs(0));
  EXPECT_EQ(last_trace().text("from"), "AIV_Server");
  EXPECT_EQ(last_trace().text("to"), "CoSiVA/AIV2");
  EXPECT_EQ(last_trace().text("kind"), "wait");
  EXPECT_EQ(last_trace().text("content"), "waits for another vehicle");
  EXPECT_EQ(last_trace().text("topic"), "");
}

TEST_F(Published, orders_passed_on_as_values_are_repeated_as_values_with_the_next_header_id) {
  MessagePublisher in_process{traces, true};
  in_process.open(now, effects);
  wire::Order order;
  order.order_id = "O-1";
  auto sent = in_process.send(registry[0], std::move(order), "");
  in_process.send_again(registry[0], sent);
  ASSERT_THAT(messages(), SizeIs(2));
  const auto* repeated = wire::value_as<wire::Order>(messages()[1].typed);
  ASSERT_NE(repeated, nullptr);
  EXPECT_EQ(repeated->order_id, "O-1");
  EXPECT_EQ(repeated->header.header_id, 1U);
  EXPECT_EQ(wire::value_as<wire::Order>(sent), repeated) << "the last one that was sent";
  EXPECT_TRUE(last_trace().find("raw")->is_null());
}

TEST_F(Published, actions_that_a_vehicle_lists_are_followed_by_their_id) {
  const auto handle = send(0, {action("startPause"), action("stopPause")}, 2s, true);
  const std::string id = actions()[0].actions[0].action_id;
  sender.on_state(0, with({{id + ".1", "stopPause", wire::ActionStatus::failed, "no"}}));
  const auto* pending = sender.find(handle);
  ASSERT_NE(pending, nullptr);
  EXPECT_FALSE(pending->actions[0].detected);
  EXPECT_EQ(pending->actions[0].status, wire::ActionStatus::waiting);
  EXPECT_TRUE(pending->actions[1].detected);
  EXPECT_EQ(pending->actions[1].status, wire::ActionStatus::failed);
  EXPECT_EQ(pending->actions[1].result, "no");
  EXPECT_EQ(pending->vehicle, 0U);
}

TEST_F(Published, action_of_one_vehicle_is_not_forgotten_by_a_state_of_another) {
  const auto handle = send(0, {action("startPause")}, 2s);
  const std::string id = actions()[0].actions[0].action_id;
  sender.on_state(1, with({{id, "startPause", wire::ActionStatus::finished, ""}}));
  EXPECT_NE(sender.find(handle), nullptr);
  sender.on_state(0, with({{id, "startPause", wire::ActionStatus::finished, ""}}));
  EXPECT_EQ(sender.find(handle), nullptr);
}

TEST_F(Published, actions_dropped_are_not_repeated_while_the_others_are) {
  const auto first = send(0, {action("startPause")}, 2s, true);
  const auto second = send(0, {action("stopPause")}, 2s, true);
  sender.drop(first);
  EXPECT_NE(sender.find(second), nullptr);
  pass(300ms);
  sender.tick(registry, true);
  ASSERT_THAT(actions(), SizeIs(3));
  EXPECT_EQ(actions()[2].actions[0].action_type, "stopPause");
}

TEST_F(Published, stop_pause_that_no_caller_follows_ends_before_a_stop) {
  const auto other = send(0, {action("startPause")}, 2s);
  const auto lifts = send(0, {action("stopPause")}, 2s);
  const auto followed = send(0, {action("stopPause")}, 2s, true);
  const auto of_another = send(1, {action("stopPause")}, 2s);
  sender.drop_stop_pause(0);
  EXPECT_EQ(sender.find(lifts), nullptr);
  EXPECT_NE(sender.find(other), nullptr);
  EXPECT_NE(sender.find(followed), nullptr);
  EXPECT_NE(sender.find(of_another), nullptr);
}

TEST_F(Published, repetition_of_an_action_has_the_header_of_its_own_time) {
  send(0, {action("startPause")});
  pass(300ms);
  sender.tick(registry, true);
  ASSERT_THAT(actions(), SizeIs(2));
  EXPECT_EQ(actions()[1].header.header_id, 1U);
  EXPECT_EQ(actions()[1].header.timestamp, virtual_epoch + 300ms);
}

TEST_F(Published, actions_are_at_least_one) { EXPECT_DEATH(send(0, {}), "actions.empty"); }

TEST_F(Published, messages_need_an_input_to_which_they_belong) {
  MessagePublisher unopened{traces};
  EXPECT_DEATH(unopened.log('i', "too early"), "effects_ != nullptr");
}

TEST(UniqueId, is_the_time_in_milliseconds_to_base_36) {
  EXPECT_EQ(unique_id("AIV1", SimTime{35ms}), "AIV1-z");
  EXPECT_EQ(unique_id("AIV1", SimTime{36ms + 900us}), "AIV1-10");
}

}  // namespace
}  // namespace cosiva::virtual_side
