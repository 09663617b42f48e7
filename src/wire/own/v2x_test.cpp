#include "cosiva/wire/own/v2x.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <limits>

#include "cosiva/base/math.h"
#include "cosiva/base/random.h"
#include "cosiva/wire/in_process/received_intents.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::wire {
namespace {

using std::chrono::milliseconds;
using ::testing::HasSubstr;
using ::testing::SizeIs;

const Intent shown{7,
                   parse_iso8601("2026-01-01T00:00:00.004Z").value(),
                   "lacet4",
                   {"CoSiVA", "AIV1"},
                   {0.125, -0.15, 0.0},
                   0.4,
                   false,
                   3,
                   Intent::OnLine{"east", 0.875},
                   {{"X1", 0.31, 0.71, 0.9, 1.9, true}},
                   {"loop_se", "north"}};
constexpr std::string_view shown_json =
    R"({"headerId":7,"timestamp":"2026-01-01T00:00:00.004Z","mapId":"lacet4","manufacturer":"CoSiVA",)"
    R"("serialNumber":"AIV1","x":0.125,"y":-0.15,"heading":0,"speed":0.4,"braking":false,"priority":3,)"
    R"("position":{"section":"east","s":0.875},)"
    R"("crossings":[{"name":"X1","entry":0.31,"exit":0.71,"arrival":0.9,"departure":1.9,"mayEnter":true}],)"
    R"("route":["loop_se","north"]})";

std::string word(Random& random) {
  static const std::string letters = "AZaz09_.:- \"\\\n/";
  std::string text;
  for (int i = 0; i < 12; ++i) text += letters[random.next() % letters.size()];
  return text;
}
std::string serial(Random& random) { return "AIV" + std::to_string(random.next() % 1000); }

Intent draw(Random& random) {
  const auto coin = [&] { return random.chance(0.5); };
  Intent intent;
  intent.header_id = static_cast<std::uint32_t>(random.next());
  intent.timestamp = virtual_epoch + milliseconds{static_cast<std::int64_t>(random.uniform(0, 1e12))};
  intent.map_id = word(random);
  intent.vehicle = {serial(random), serial(random)};
  intent.pose = {random.uniform(-1e5, 1e5), random.uniform(-1e5, 1e5), random.uniform(-3.14, 3.14)};
  intent.speed_mps = random.uniform(-2, 2);
  intent.braking = coin();
  intent.priority = static_cast<std::uint32_t>(random.next() % 1000);
  if (coin()) intent.position = Intent::OnLine{word(random), random.uniform(0, 100)};
  for (std::size_t i = random.next() % (Intent::crossings_max + 1); i > 0; --i) {
    const double entry_m = random.uniform(0, 10);
    const double arrival_s = random.uniform(0, 10);
    intent.crossings.push_back(
        {word(random), entry_m, entry_m + random.uniform(0, 1), arrival_s, arrival_s + random.uniform(0, 1), coin()});
  }
  for (std::size_t i = random.next() % (Intent::route_max + 1); i > 0; --i) intent.route.push_back(word(random));
  return intent;
}

TEST(ReceivedIntent, is_parsed_once_for_all_receivers_of_the_same_text) {
  const auto first = received_intent(shown_json);
  ASSERT_TRUE(first);
  EXPECT_EQ(**first, shown);
  EXPECT_EQ(received_intent(std::string(shown_json)).value(), *first) << "the same object";
  // Whatever is received meanwhile, each receiver gets the message that was sent.
  Random random{11, "heard"};
  std::vector<Intent> published;
  for (int i = 0; i < 500; ++i) published.push_back(draw(random));
  for (const Intent& intent : published) {
    const std::string json = to_json(intent);
    const auto received = received_intent(json);
    ASSERT_TRUE(received) << json;
    ASSERT_EQ(**received, intent_from_json(json).value());
  }
  EXPECT_EQ(*received_intent(shown_json).value(), shown);
}

TEST(ReceivedIntent, is_compared_to_the_last_byte_and_refused_each_time) {
  std::string other{shown_json};
  other.replace(other.find("north"), 5, "south");
  EXPECT_EQ(received_intent(shown_json).value()->route.back(), "north");
  EXPECT_EQ(received_intent(other).value()->route.back(), "south");
  EXPECT_EQ(received_intent(shown_json).value()->route.back(), "north");
  std::string bad{shown_json};
  bad.replace(bad.find("0.4"), 3, "1e9");
  for (int i = 0; i < 2; ++i) {
    const auto refused = received_intent(bad);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().location, "speed");
  }
  EXPECT_FALSE(received_intent(""));
}

TEST(Intent, is_written_as_its_document_shows) {
  EXPECT_EQ(to_json(shown), shown_json);
  EXPECT_EQ(intent_from_json(shown_json).value(), shown);
}

TEST(Intent, reads_back_what_it_writes) {
  EXPECT_TRUE(rc::check([](std::uint64_t seed) {
    Random random{seed, "intent"};
    const Intent intent = draw(random);
    const std::string json = to_json(intent);
    const auto back = intent_from_json(json);
    if (!back) RC_FAIL(to_string(back.error()) + " in " + json);
    RC_ASSERT(*back == intent);
    RC_ASSERT(to_json(*back) == json);
  }));
}

TEST(Intent, may_hold_fields_that_the_reader_does_not_know_and_no_position) {
  std::string json = to_json(shown);
  json.insert(1, R"("colour":{"deep":[1]},)");
  EXPECT_EQ(intent_from_json(json).value(), shown);
  Intent neighbour = shown;
  neighbour.position.reset();
  EXPECT_EQ(intent_from_json(to_json(neighbour)).value(), neighbour);
}

/// The shown intent with one part of its text replaced; returns the location that the reader reports.
std::string fault(std::string_view from, std::string_view to) {
  std::string json{shown_json};
  const std::size_t at = json.find(from);
  if (at == std::string::npos) return "the test's own text is not there";
  json.replace(at, from.size(), to);
  const auto back = intent_from_json(json);
  return back ? "none" : back.error().code + " " + back.error().location;
}

TEST(Intent, refuses_what_is_out_of_bounds_naming_the_field) {
  EXPECT_EQ(fault(R"("headerId":7)", R"("headerId":-1)"), "own.field headerId");
  EXPECT_EQ(fault(R"("mapId":"lacet4")", R"("mapId":4)"), "own.field mapId");
  EXPECT_EQ(fault(R"("manufacturer":"CoSiVA")", R"("manufacturer":"Co/SiVA")"), "own.field manufacturer");
  EXPECT_EQ(fault(R"("serialNumber":"AIV1")", R"("serialNumber":"")"), "own.field serialNumber");
  EXPECT_EQ(fault(R"("x":0.125)", R"("x":1e9)"), "own.field x");
  EXPECT_EQ(fault(R"("x":0.125)", R"("x":null)"), "own.field x");
  EXPECT_EQ(fault(R"("heading":0)", R"("heading":1e9)"), "own.field heading");
  EXPECT_EQ(fault(R"("speed":0.4)", R"("speed":-101)"), "own.field speed");
  EXPECT_EQ(fault(R"("braking":false)", R"("braking":0)"), "own.field braking");
  EXPECT_EQ(fault(R"("priority":3)", R"("priority":1000)"), "own.field priority");
  EXPECT_EQ(fault(R"("s":0.875)", R"("s":-1)"), "own.field position.s");
  EXPECT_EQ(fault(R"("entry":0.31)", R"("entry":-0.1)"), "own.field crossings.0.entry");
  EXPECT_EQ(fault(R"("exit":0.71)", R"("exit":0.3)"), "own.field crossings.0.exit");
  EXPECT_EQ(fault(R"("arrival":0.9)", R"("arrival":4000)"), "own.field crossings.0.arrival");
  EXPECT_EQ(fault(R"("departure":1.9)", R"("departure":0.8)"), "own.field crossings.0.departure");
  EXPECT_EQ(fault(R"("mayEnter":true)", R"("mayEnter":"yes")"), "own.field crossings.0.mayEnter");
  EXPECT_EQ(fault(R"(["loop_se","north"])", R"(["loop_se",7])"), "own.field route.1");
  EXPECT_EQ(fault(R"(["loop_se","north"])", "[\"" + std::string(129, 'x') + "\"]"), "own.field route.0");
  EXPECT_EQ(fault("2026-01-01T00:00:00.004Z", "yesterday"), "own.field timestamp");
}

TEST(Intent, refuses_lists_that_are_too_long_invalid_numbers_and_long_texts) {
  Intent crowd = shown;
  crowd.crossings.resize(Intent::crossings_max + 1, shown.crossings.front());
  EXPECT_THAT(intent_from_json(to_json(crowd)).error().message, HasSubstr("at most 8"));
  crowd = shown;
  crowd.route.resize(Intent::route_max + 1, "route");
  EXPECT_FALSE(intent_from_json(to_json(crowd)));
  Intent nan = shown;
  nan.speed_mps = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(intent_from_json(to_json(nan))) << "written as null";
  EXPECT_NE(fault(R"("x":0.125)", R"("x":1e999)"), "none");
  EXPECT_NE(fault(R"("x":0.125)", R"("x":NaN)"), "none");
  EXPECT_EQ(intent_from_json(std::string(shown_json) + std::string(16U << 10U, ' ')).error().code, "json.syntax");
  for (const char* text : {"", "null", "[]", "{", "{}", "\x00\xFF"}) EXPECT_FALSE(intent_from_json(text)) << text;
}

TEST(V2xTopic, is_below_the_cell_where_the_vehicle_is) {
  EXPECT_EQ(cell_of({0.1, 0.1}), (Cell{0, 0}));
  EXPECT_EQ(cell_of({-0.1, 3.0}), (Cell{-1, 1}));
  EXPECT_EQ(v2x_topic("lacet4", {-1, 1}, {"CoSiVA", "AIV1"}), "cosiva/v1/v2x/lacet4/-1_1/CoSiVA/AIV1");
  EXPECT_EQ(v2x_topic("a/b #+", {0, 0}, {"m", "s"}), "cosiva/v1/v2x/a_b___/0_0/m/s");
  const auto parsed = parse_v2x_topic("cosiva/v1/v2x/lacet4/-1_1/CoSiVA/AIV1");
  ASSERT_TRUE(parsed);
  EXPECT_EQ(parsed->cell, (Cell{-1, 1}));
  EXPECT_EQ(parsed->vehicle, (VehicleId{"CoSiVA", "AIV1"}));
  for (const char* no :
       {"cosiva/v1/v2x/lacet4/1/m/s", "cosiva/v1/v2x/lacet4/1_x/m/s", "cosiva/v1/v2x//1_1/m/s",
        "cosiva/v1/v2x/lacet4/1_1/m", "cosiva/v1/v2x/lacet4/1_1/m/s/t", "cosiva/v1/detected_obstacle/m/s"})
    EXPECT_FALSE(parse_v2x_topic(no)) << no;
}

TEST(V2xTopic, is_received_by_each_vehicle_within_a_cell_and_by_none_beyond_two) {
  EXPECT_TRUE(rc::check([](std::uint64_t seed) {
    Random random{seed, "cells"};
    const Point2 here{random.uniform(-50, 50), random.uniform(-50, 50)};
    const Point2 there{here.x_m + random.uniform(-7, 7), here.y_m + random.uniform(-7, 7)};
    const auto filters = v2x_filters("map", cell_of(here));
    RC_ASSERT(filters.size() == 9);
    const std::string topic = v2x_topic("map", cell_of(there), {"m", "s"});
    const bool received =
        std::ranges::any_of(filters, [&](const auto& filter) { return topic_matches(filter, topic); });
    const double apart_m = std::max(std::fabs(there.x_m - here.x_m), std::fabs(there.y_m - here.y_m));
    if (apart_m < v2x_cell_m) RC_ASSERT(received);
    if (apart_m > 2.0 * v2x_cell_m) RC_ASSERT(!received);
    RC_ASSERT(outside_cell_m(cell_of(here), here) == 0.0);
  }));
}

TEST(V2xTopic, gives_the_distance_of_a_point_from_a_cell) {
  EXPECT_DOUBLE_EQ(outside_cell_m({0, 0}, {3.25, 1.0}), 0.25);
  EXPECT_DOUBLE_EQ(outside_cell_m({0, 0}, {-0.5, 3.25}), 0.5);
}

}  // namespace
}  // namespace cosiva::wire
