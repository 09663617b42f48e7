#include "cosiva/virtual/server/exchange/traces.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "cosiva/base/json_value.h"

namespace cosiva::virtual_side {
namespace {

using namespace std::chrono_literals;
using ::testing::IsEmpty;
using ::testing::SizeIs;

void add(Traces& traces, const std::string& content, const std::string& raw = {}) {
  traces.add(virtual_epoch, "CoSiVA/AIV1", "AIV_Server", "state", content, "uagv/v2/CoSiVA/AIV1/state", raw);
}
JsonValue one(const Traces& traces, std::uint64_t n) {
  const auto json = traces.one_json(n);
  EXPECT_TRUE(json) << n;
  return json ? *JsonValue::parse(*json) : JsonValue{};
}
std::optional<std::string> raw(const Traces& traces, std::uint64_t n) { return one(traces, n).text("raw"); }

TEST(Traces, write_lengths_to_the_millimetre) {
  EXPECT_EQ(metres_text(1.02), "1.020");
  EXPECT_EQ(metres_text(-0.1234567), "-0.123");
  EXPECT_EQ(metres_text(123456.7891), "123456.789");
  EXPECT_EQ(metres_text(1e300), "1000000000.000");
}

TEST(Traces, state_their_time_as_milliseconds_of_unix_time) {
  Traces traces{10};
  traces.add(virtual_epoch + 1500us, "a", "b", "c", "d");
  const JsonValue all = *JsonValue::parse(traces.to_json(0, 10));
  ASSERT_THAT(*all.find("traces")->array(), SizeIs(1));
  const JsonValue& trace = all.find("traces")->array()->front();
  // A double resolves the nanoseconds since 1970 to a quarter of a microsecond.
  EXPECT_NEAR(trace.number("time_ms").value(), to_seconds(virtual_epoch.time_since_epoch()) * 1e3 + 1.5, 1e-3);
  EXPECT_EQ(trace.number("n"), 1.0);
  EXPECT_EQ(trace.text("content"), "d");
  EXPECT_EQ(trace.find("time"), nullptr);
}

TEST(Traces, report_the_oldest_number_that_is_stored) {
  Traces traces{3};
  EXPECT_EQ(traces.oldest(), 1U);
  for (int i = 1; i <= 5; ++i) add(traces, std::to_string(i));
  const JsonValue all = *JsonValue::parse(traces.to_json(0, 10));
  EXPECT_EQ(all.number("oldest"), 3.0);
  EXPECT_EQ(all.number("next"), 6.0);
  EXPECT_THAT(*all.find("traces")->array(), SizeIs(3));
  EXPECT_EQ(all.find("traces")->array()->front().text("content"), "3");
  const JsonValue later = *JsonValue::parse(traces.to_json(77, 10));
  EXPECT_THAT(*later.find("traces")->array(), IsEmpty());
  EXPECT_EQ(later.number("next"), 6.0);
}

TEST(Traces, store_a_message_with_its_topic_and_its_text_byte_for_byte) {
  Traces traces{10};
  const std::string text = R"({"headerId":1,"note":"a \"quoted\" ü"})";
  add(traces, "driving", text);
  const JsonValue trace = one(traces, 1);
  EXPECT_EQ(trace.text("raw"), text);
  EXPECT_EQ(trace.text("topic"), "uagv/v2/CoSiVA/AIV1/state");
  EXPECT_EQ(trace.text("content"), "driving");
  EXPECT_EQ(trace.text("from"), "CoSiVA/AIV1");
  EXPECT_EQ(trace.text("kind"), "state");
}

TEST(Traces, store_a_position_with_its_text) {
  Traces traces{10};
  traces.add_position(virtual_epoch, "a", "b", "visualization", {1.0, 2.0, 0.5}, 0.25, "t", "{}");
  const JsonValue trace = one(traces, 1);
  EXPECT_EQ(trace.text("content"), R"({"x":1,"y":2,"theta":0.5,"speed":0.25})");
  EXPECT_EQ(trace.text("raw"), "{}");
}

TEST(Traces, have_no_entry_for_a_future_or_overwritten_number) {
  Traces traces{2};
  EXPECT_FALSE(traces.one_json(0));
  EXPECT_FALSE(traces.one_json(1));
  for (int i = 1; i <= 3; ++i) add(traces, std::to_string(i));
  EXPECT_FALSE(traces.one_json(0));
  EXPECT_FALSE(traces.one_json(1));
  EXPECT_TRUE(traces.one_json(2));
  EXPECT_TRUE(traces.one_json(3));
  EXPECT_FALSE(traces.one_json(4));
  EXPECT_FALSE(traces.one_json(~std::uint64_t{0}));
}

TEST(Traces, have_no_text_where_there_was_no_message) {
  Traces traces{2};
  traces.add(virtual_epoch, "Simulator", "RTM", "request", "zone");
  EXPECT_EQ(one(traces, 1).text("topic"), "");
  EXPECT_TRUE(one(traces, 1).find("raw")->is_null());
}

TEST(Traces, store_the_newest_texts_within_their_budget) {
  Traces traces{100, 10};
  for (int i = 0; i < 8; ++i) add(traces, "", std::string(4, static_cast<char>('a' + i)));
  // Ten bytes hold two texts of four; the third last text has lost two of its bytes.
  EXPECT_EQ(raw(traces, 8), "hhhh");
  EXPECT_EQ(raw(traces, 7), "gggg");
  for (std::uint64_t n = 1; n <= 6; ++n) EXPECT_TRUE(one(traces, n).find("raw")->is_null()) << n;
}

TEST(Traces, store_texts_across_the_end_of_the_ring_buffer) {
  // For all lengths, a text that is reported as stored equals the given text.
  for (const std::size_t budget : {std::size_t{7}, std::size_t{64}, std::size_t{1000}}) {
    Traces traces{50, budget};
    std::vector<std::string> given;
    for (std::size_t i = 0; i < 150; ++i) {
      given.push_back(std::string(1 + i * 37 % budget, static_cast<char>('a' + i % 26)));
      add(traces, "", given.back());
      std::size_t bytes = 0;
      for (std::uint64_t n = i + 1; n >= traces.oldest(); --n) {
        bytes += given[n - 1].size();
        if (bytes <= budget)
          ASSERT_EQ(raw(traces, n), given[n - 1]);
        else
          ASSERT_EQ(raw(traces, n), std::nullopt);
      }
    }
  }
}

TEST(Traces, store_no_text_that_is_too_long_and_lose_no_other_text) {
  Traces traces{10};
  add(traces, "short", "{}");
  add(traces, std::string(1000, 'x'), std::string(Traces::raw_max + 1, 'x'));
  add(traces, "longest", std::string(Traces::raw_max, 'y'));
  EXPECT_EQ(raw(traces, 1), "{}");
  EXPECT_TRUE(one(traces, 2).find("raw")->is_null());
  EXPECT_EQ(one(traces, 2).text("content"), std::string(Traces::content_max, 'x'));
  EXPECT_EQ(raw(traces, 3), std::string(Traces::raw_max, 'y'));
}

TEST(Traces, without_a_budget_store_no_text) {
  Traces traces{10, 0};
  add(traces, "a", "{}");
  EXPECT_TRUE(one(traces, 1).find("raw")->is_null());
  EXPECT_EQ(one(traces, 1).text("content"), "a");
}

std::string content_shown(const std::string& content) {
  Traces traces{1};
  add(traces, content);
  return one(traces, 1).text("content").value_or("?");
}

TEST(Traces, cut_a_content_after_200_bytes) {
  EXPECT_EQ(content_shown(std::string(200, 'x')), std::string(200, 'x'));
  EXPECT_EQ(content_shown(std::string(201, 'x')), std::string(200, 'x'));
}

TEST(Traces, cut_no_character_in_two) {
  // "ü" has two bytes in UTF-8, "€" three.
  EXPECT_EQ(content_shown(std::string(199, 'x') + "üy"), std::string(199, 'x'));
  EXPECT_EQ(content_shown(std::string(198, 'x') + "üy"), std::string(198, 'x') + "ü");
  EXPECT_EQ(content_shown(std::string(199, 'x') + "€y"), std::string(199, 'x'));
  EXPECT_EQ(content_shown(std::string(198, 'x') + "€y"), std::string(198, 'x'));
  EXPECT_EQ(content_shown(std::string(197, 'x') + "€y"), std::string(197, 'x') + "€");
}

TEST(Traces, show_nothing_of_a_long_content_in_which_no_character_begins) {
  EXPECT_EQ(content_shown(std::string(300, '\x80')), "");
}

TEST(Traces, write_positions_to_the_thousandth) {
  Traces traces{10};
  traces.add_position(virtual_epoch, "a", "b", "visualization", {1.2344, -2.0006, 0.12351}, 0.3996);
  EXPECT_EQ(one(traces, 1).text("content"), R"({"x":1.234,"y":-2.001,"theta":0.124,"speed":0.4})");
  EXPECT_EQ(one(traces, 1).text("topic"), "");
  EXPECT_TRUE(one(traces, 1).find("raw")->is_null());
}

TEST(Traces, store_a_text_where_a_position_was_and_a_position_where_a_text_was) {
  Traces traces{1};
  traces.add_position(virtual_epoch, "a", "b", "visualization", {1.0, 2.0, 0.5}, 0.25, "t", "{}");
  add(traces, "driving");
  EXPECT_EQ(one(traces, 2).text("content"), "driving");
  EXPECT_TRUE(one(traces, 2).find("raw")->is_null());
  traces.add_position(virtual_epoch, "a", "b", "visualization", {3.0, 4.0, 0.5}, 0.25);
  EXPECT_EQ(one(traces, 3).text("content"), R"({"x":3,"y":4,"theta":0.5,"speed":0.25})");
}

TEST(Traces, store_at_least_one) {
  Traces traces{0};
  add(traces, "first");
  add(traces, "second");
  EXPECT_EQ(traces.oldest(), 2U);
  EXPECT_EQ(one(traces, 2).text("content"), "second");
}

TEST(Traces, list_nothing_before_the_first_one) {
  const Traces traces{3};
  EXPECT_EQ(traces.to_json(0, 10), R"({"next":1,"oldest":1,"traces":[]})");
}

TEST(Traces, list_as_many_as_are_requested_and_state_where_to_go_on) {
  Traces traces{10};
  for (int i = 1; i <= 5; ++i) add(traces, std::to_string(i));
  const auto listed = [&](std::uint64_t after, std::size_t limit) {
    const JsonValue all = *JsonValue::parse(traces.to_json(after, limit));
    std::string contents;
    for (const JsonValue& trace : *all.find("traces")->array()) contents += trace.text("content").value_or("?");
    return contents + " " + std::to_string(static_cast<int>(all.number("next").value()));
  };
  EXPECT_EQ(listed(2, 2), "23 4");
  EXPECT_EQ(listed(0, 3), "123 4");
  EXPECT_EQ(listed(4, 2), "45 6");
  EXPECT_EQ(listed(5, 2), "5 6");
  EXPECT_EQ(listed(6, 2), " 6");
  EXPECT_EQ(listed(1, 0), " 1");
}

TEST(Traces, list_sender_receiver_and_kind) {
  Traces traces{10};
  traces.add(virtual_epoch, "Simulator", "RTM", "request", "zone");
  const JsonValue all = *JsonValue::parse(traces.to_json(1, 1));
  const JsonValue& trace = all.find("traces")->array()->front();
  EXPECT_EQ(trace.text("from"), "Simulator");
  EXPECT_EQ(trace.text("to"), "RTM");
  EXPECT_EQ(trace.text("kind"), "request");
  EXPECT_EQ(one(traces, 1).text("to"), "RTM");
}

TEST(Traces, store_a_text_that_fills_the_budget_but_none_that_exceeds_it) {
  Traces traces{10, 10};
  add(traces, "", std::string(10, 'a'));
  EXPECT_EQ(raw(traces, 1), std::string(10, 'a'));
  add(traces, "", std::string(11, 'b'));
  EXPECT_EQ(raw(traces, 2), std::nullopt);
  EXPECT_EQ(raw(traces, 1), std::string(10, 'a')) << "nothing was overwritten";
  add(traces, "", "c");
  EXPECT_EQ(raw(traces, 1), std::nullopt) << "its first byte was overwritten";
  EXPECT_EQ(raw(traces, 3), "c");
}

}  // namespace
}  // namespace cosiva::virtual_side
