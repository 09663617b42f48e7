#include "cosiva/wire/vda5050/typed_messages.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include "cosiva/wire/vda5050/codec.h"
#include "cosiva/wire/vda5050/sample_messages.h"

namespace cosiva::wire::vda5050 {
namespace {

constexpr auto within_a_millisecond = std::chrono::nanoseconds{123'456};

Input input_of(std::string payload) { return {virtual_epoch, InputKind::message, "topic", std::move(payload), false}; }
Input input_of(std::shared_ptr<const TypedMessage> typed) {
  return {virtual_epoch, InputKind::message, "topic", {}, false, std::move(typed)};
}

/// The values received of a message that was passed on as values equal those read from its text.
template <typename Message>
void expect_received_as_read(const std::shared_ptr<const TypedMessage>& passed,
                             Result<Message> (*received)(const Input&)) {
  const auto as_values = received(input_of(passed));
  const auto as_text = received(input_of(text_of(*passed)));
  ASSERT_TRUE(as_values && as_text) << to_string(as_text.error());
  EXPECT_EQ(*as_values, *as_text);
  EXPECT_EQ(text_of(*typed(Message{*as_text})), text_of(*passed));
}

/// Of a reader that gives the message that was passed on, not a copy.
template <typename Message>
void expect_passed_and_as_read(const std::shared_ptr<const TypedMessage>& passed,
                               Result<std::shared_ptr<const Message>> (*read)(const Input&)) {
  const auto as_values = read(input_of(passed));
  const auto as_text = read(input_of(text_of(*passed)));
  ASSERT_TRUE(as_values && as_text) << to_string(as_text.error());
  EXPECT_EQ(as_values->get(), value_as<Message>(passed));
  EXPECT_EQ(**as_values, **as_text);
  EXPECT_EQ(text_of(*typed(Message{**as_text})), text_of(*passed));
}

DetectedObstacleReport detected() {
  DetectedObstacleReport message{7, virtual_epoch + within_a_millisecond, "lacet4",
                                 DetectedObstacleReport::Obstacle{0.1, -2.0 / 3.0, 0.03, 0.4}, 0.37};
  return message;
}

BoardsReport boards_report() {
  BoardsReport report;
  report.header_id = 3;
  report.timestamp = virtual_epoch + within_a_millisecond;
  report.boards = {{Board::PILS, "ok", 0xdeadbeef, 1234, 99, 1, 2, 0}, {Board::DOBS, "lost", 1, 0, 0, 0, 0, 4}};
  report.power = Power{7412, -430, 225, 871, Power::Gauge{871'234, 135}};
  report.ranges = Ranges{4711, -84, 14, {350, no_echo, 2000}};
  return report;
}

Intent intent() {
  Intent message;
  message.header_id = 12;
  message.timestamp = virtual_epoch + within_a_millisecond;
  message.map_id = "lacet4";
  message.vehicle = {"CoSiVA", "AIV1"};
  message.pose = {1.0 / 3.0, -0.1, 2.5};
  message.speed_mps = 0.4;
  message.priority = 5;
  message.position = Intent::OnLine{"S1", 0.3};
  message.crossings = {{"X1", 0.1, 0.7, 0.25, 1.5, true}};
  message.route = {"S2", "S3"};
  return message;
}

TEST(TypedMessage, states_orders_and_visualizations_are_received_as_read_from_their_texts) {
  EXPECT_TRUE(rc::check([](std::uint64_t seed) {
    Random random{seed, "said"};
    State state = sample::state(random);
    state.header.timestamp += within_a_millisecond;
    expect_passed_and_as_read<State>(typed(std::move(state)), state_from);
    Order order = sample::order(random);
    order.header.timestamp += within_a_millisecond;
    expect_passed_and_as_read<Order>(typed(std::move(order)), order_from);
    Visualization visualization = sample::visualization(random);
    visualization.header.timestamp += within_a_millisecond;
    expect_passed_and_as_read<Visualization>(typed(std::move(visualization)), visualization_from);
    RC_ASSERT(!::testing::Test::HasFailure());
  }));
}

TEST(TypedMessage, own_messages_are_received_as_read_from_their_texts) {
  expect_received_as_read<DetectedObstacleReport>(typed(detected()), detected_obstacle_from);
  expect_received_as_read<BoardsReport>(typed(boards_report()), boards_report_from);
  const auto passed = typed(intent());
  const auto as_text = intent_from_json(text_of(*passed));
  ASSERT_TRUE(as_text) << to_string(as_text.error());
  ASSERT_NE(value_as<Intent>(passed), nullptr);
  EXPECT_EQ(*value_as<Intent>(passed), *as_text);
}

TEST(TypedMessage, no_more_is_received_than_the_text_would_carry) {
  const BoardsReport whole = boards_report();
  const auto passed = typed(boards_report());
  const auto* received = value_as<BoardsReport>(passed);
  ASSERT_NE(received, nullptr);
  EXPECT_EQ(received->timestamp, virtual_epoch);
  EXPECT_EQ(received->ranges->board_ms, 0U);
  // Without this the message would differ from the one read from the text.
  EXPECT_NE(*boards_report_from_json(to_json(whole)), whole);
}

TEST(TypedMessage, one_message_is_not_taken_for_another) {
  const auto passed = typed(detected());
  EXPECT_EQ(value_as<Visualization>(passed), nullptr);
  EXPECT_EQ(value_as<DetectedObstacleReport>(std::shared_ptr<const TypedMessage>{}), nullptr);
  EXPECT_FALSE(state_from(input_of(passed)));
}

TEST(TypedMessage, folds_its_kind_and_its_number) {
  const auto digest_of = [](const TypedMessage& message) {
    Digest digest;
    message.fold(digest);
    return digest.hex();
  };
  const auto expected = [](std::uint64_t kind) {
    Digest digest;
    digest.add(kind);
    digest.add(std::uint64_t{42});
    return digest.hex();
  };
  const auto with_header = [](auto message) {
    message.header.header_id = 42;
    return typed(std::move(message));
  };
  const auto with_number = [](auto message) {
    message.header_id = 42;
    return typed(std::move(message));
  };
  EXPECT_EQ(digest_of(*with_header(State{})), expected(0));
  EXPECT_EQ(digest_of(*with_header(Visualization{})), expected(1));
  EXPECT_EQ(digest_of(*with_number(intent())), expected(2));
  EXPECT_EQ(digest_of(*with_number(detected())), expected(3));
  EXPECT_EQ(digest_of(*with_number(boards_report())), expected(4));
  EXPECT_EQ(digest_of(*with_header(Order{})), expected(5));
}

TEST(TypedMessage, a_bad_text_is_refused_as_usual) {
  const auto received = state_from(input_of(std::string{"{\"headerId\":"}));
  ASSERT_FALSE(received);
  EXPECT_EQ(received.error().code, "vda.json");
}

}  // namespace
}  // namespace cosiva::wire::vda5050
