#include "cosiva/wire/in_process/received_intents.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/wire/in_process/typed_message.h"

namespace cosiva::wire {
namespace {

Intent intent_numbered(std::uint32_t header_id) {
  Intent intent;
  intent.header_id = header_id;
  intent.timestamp = virtual_epoch;
  intent.map_id = "oval";
  intent.vehicle = {"CoSiVA", "AIV1"};
  return intent;
}

Input intent_input(std::string payload, std::shared_ptr<const InProcessMessage> values = {}) {
  return {virtual_epoch, InputKind::message, "topic", std::move(payload), false, std::move(values)};
}

TEST(ReceivedIntents, are_cached_side_by_side_where_their_first_bytes_differ) {
  std::vector<std::shared_ptr<const Intent>> first;
  for (std::uint32_t n = 1; n <= 8; ++n) first.push_back(received_intent(to_json(intent_numbered(n))).value());
  int cached = 0;
  for (std::uint32_t n = 1; n <= 8; ++n)
    if (received_intent(to_json(intent_numbered(n))).value() == first[n - 1]) ++cached;
  EXPECT_GE(cached, 4) << "two of them may need the same one of the 64 slots";
}

TEST(ReceivedIntents, replaced_in_their_slot_stay_valid_for_their_receivers) {
  Intent longer = intent_numbered(1);
  longer.route = {"north"};
  const auto held = received_intent(to_json(intent_numbered(1))).value();
  EXPECT_EQ(*received_intent(to_json(longer)).value(), longer);
  EXPECT_EQ(*held, intent_numbered(1));
}

TEST(ReceivedIntents, are_not_displaced_by_a_text_that_cannot_be_read) {
  const std::string text = to_json(intent_numbered(1));
  const auto first = received_intent(text).value();
  EXPECT_FALSE(received_intent(text + "x")) << "the same first bytes, so the same slot";
  EXPECT_EQ(received_intent(text).value(), first);
}

TEST(ReceivedIntents, passed_on_as_values_are_those_values_themselves) {
  const std::shared_ptr<const InProcessMessage> passed = typed(intent_numbered(5));
  const auto received = received_intent(intent_input("", passed)).value();
  EXPECT_EQ(received.get(), value_as<Intent>(passed));
  EXPECT_EQ(*received, intent_numbered(5));
}

TEST(ReceivedIntents, passed_on_as_text_are_read) {
  EXPECT_EQ(*received_intent(intent_input(to_json(intent_numbered(6)))).value(), intent_numbered(6));
  EXPECT_FALSE(received_intent(intent_input("{}")));
}

TEST(ReceivedIntents, are_read_from_the_text_where_the_value_is_another_message) {
  const auto received = received_intent(intent_input(to_json(intent_numbered(6)), typed(State{})));
  EXPECT_EQ(*received.value(), intent_numbered(6));
}

TEST(ReceivedV2xTopic, is_that_of_the_text_also_the_second_time_and_in_turn_with_others) {
  const VehicleId vehicle{"CoSiVA", "AIV1"};
  for (int round = 0; round < 2; ++round) {
    for (std::int32_t x = -40; x <= 40; ++x) {  // more than are cached
      const std::string text = v2x_topic("oval", Cell{x, 2}, vehicle);
      const V2xTopic* topic = received_v2x_topic(text);
      ASSERT_NE(topic, nullptr) << text;
      EXPECT_EQ(topic->map_level, "oval");
      EXPECT_EQ(topic->cell, (Cell{x, 2}));
      EXPECT_EQ(topic->vehicle, vehicle);
    }
  }
}

TEST(ReceivedV2xTopic, is_null_for_another_text) {
  EXPECT_EQ(received_v2x_topic("cosiva/v1/v2x/oval"), nullptr);
  EXPECT_EQ(received_v2x_topic("cosiva/v1/v2x/oval"), nullptr) << "again";
  EXPECT_EQ(received_v2x_topic(""), nullptr);
}

}  // namespace
}  // namespace cosiva::wire
