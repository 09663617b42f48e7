#include "cosiva/wire/own/v2x.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <limits>

#include "cosiva/base/math.h"
#include "cosiva/base/random.h"
#include "cosiva/wire/in_process/received_intents.h"
#include "cosiva/wire/own/limits_fixture.h"
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

TEST(Intent, is_accepted_with_each_number_within_its_range_only) {
  Intent wide = shown;
  wide.crossings = {{"X1", 0.0, 1e5, 0.0, 3600.0, true}};  // so that neither limit is behind the other
  test::expect_ranges(to_json(wide), intent_from_json,
                      {{"headerId", 0, 4294967295, 1},
                       {"x", -1e5, 1e5},
                       {"y", -1e5, 1e5},
                       {"heading", -100, 100},
                       {"speed", -100, 100},
                       {"priority", 0, 999, 1},
                       {"position.s", 0, 1e5},
                       {"crossings.0.entry", 0, 1e5},
                       {"crossings.0.exit", 0, 1e5},
                       {"crossings.0.arrival", 0, 3600},
                       {"crossings.0.departure", 0, 3600}});
}

TEST(Intent, requires_every_field_except_the_position) {
  Intent off_path = shown;
  off_path.position.reset();
  test::expect_required(to_json(off_path), intent_from_json,
                        {"headerId", "timestamp", "mapId", "manufacturer", "serialNumber", "x", "y", "heading", "speed",
                         "braking", "priority", "crossings", "route", "crossings.0.name", "crossings.0.entry",
                         "crossings.0.exit", "crossings.0.arrival", "crossings.0.departure", "crossings.0.mayEnter"});
  test::expect_required(std::string(shown_json), intent_from_json, {"position.section", "position.s"});
}

TEST(Intent, may_name_a_crossing_without_length_or_duration) {
  Intent touching = shown;
  touching.crossings = {{"X1", 0.5, 0.5, 2.0, 2.0, false}};
  EXPECT_EQ(intent_from_json(to_json(touching)).value(), touching);
}

TEST(Intent, accepts_lists_and_names_up_to_their_longest) {
  Intent longest = shown;
  longest.crossings.resize(8, shown.crossings.front());
  longest.route.resize(8, std::string(128, 'r'));
  EXPECT_EQ(intent_from_json(to_json(longest)).value(), longest);
  longest.crossings.push_back(shown.crossings.front());
  EXPECT_EQ(intent_from_json(to_json(longest)).error().location, "crossings");
  longest.crossings.clear();
  longest.route.emplace_back("r");
  EXPECT_EQ(intent_from_json(to_json(longest)).error().location, "route");
}

TEST(Intent, brings_the_heading_into_one_turn) {
  EXPECT_NEAR(intent_from_json(test::with_value(std::string(shown_json), "heading", "7"))->pose.heading_rad,
              7.0 - 2.0 * pi, 1e-12);
}

TEST(V2xTopic, has_an_underscore_for_each_character_that_it_may_not_have) {
  const std::string plain = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789.-_";
  for (int code = 1; code < 256; ++code) {
    const char c = static_cast<char>(code);
    const char expected = plain.find(c) == std::string::npos ? '_' : c;
    const auto parsed = parse_v2x_topic(v2x_topic(std::string{'a', c}, {0, 0}, {"m", "s"}));
    ASSERT_TRUE(parsed) << code;
    EXPECT_EQ(parsed->map_level, (std::string{'a', expected})) << code;
  }
}

TEST(V2xTopic, has_at_most_64_bytes_of_the_map_and_never_none) {
  EXPECT_EQ(v2x_topic(std::string(64, 'a'), {0, 0}, {"m", "s"}), "cosiva/v1/v2x/" + std::string(64, 'a') + "/0_0/m/s");
  EXPECT_EQ(v2x_topic(std::string(65, 'a'), {0, 0}, {"m", "s"}), "cosiva/v1/v2x/" + std::string(64, 'a') + "/0_0/m/s");
  EXPECT_EQ(v2x_topic("", {0, 0}, {"m", "s"}), "cosiva/v1/v2x/_/0_0/m/s");
}

TEST(V2xTopic, is_read_back_for_any_cell) {
  EXPECT_TRUE(rc::check([](std::int32_t x, std::int32_t y) {
    const auto parsed = parse_v2x_topic(v2x_topic("lacet4", {x, y}, {"CoSiVA", "AIV1"}));
    RC_ASSERT(parsed.has_value());
    RC_ASSERT(parsed->map_level == "lacet4");
    RC_ASSERT(parsed->cell == (Cell{x, y}));
    RC_ASSERT(parsed->vehicle == (VehicleId{"CoSiVA", "AIV1"}));
  }));
}

TEST(V2xTopic, with_a_cell_of_other_than_two_whole_numbers_is_none) {
  for (const char* cell : {"", "_", "1_", "_1", "1", "x_1", "1_x", "1x_1", "1_1x", "1.5_1", "1_1_1", "99999999999_1",
                           "1_99999999999", " 1_1"})
    EXPECT_FALSE(parse_v2x_topic("cosiva/v1/v2x/m/" + std::string(cell) + "/a/b")) << cell;
  for (const char* topic :
       {"", "cosiva/v1/v2x/", "cosiva/v1/v2x/m", "cosiva/v1/v2x/m/", "cosiva/v1/v2x/m/1_1", "cosiva/v1/v2x/m/1_1/",
        "cosiva/v1/v2x/m/1_1/a", "cosiva/v1/v2x/m/1_1/a/", "cosiva/v1/v2x/m/1_1//b", "cosiva/v1/v2x//1_1/a/b"})
    EXPECT_FALSE(parse_v2x_topic(topic)) << topic;
}

TEST(V2xTopic, filters_name_the_cell_and_the_eight_around_it) {
  EXPECT_THAT(v2x_filters("a b", {5, -1}),
              ::testing::UnorderedElementsAre(
                  "cosiva/v1/v2x/a_b/4_-2/+/+", "cosiva/v1/v2x/a_b/5_-2/+/+", "cosiva/v1/v2x/a_b/6_-2/+/+",
                  "cosiva/v1/v2x/a_b/4_-1/+/+", "cosiva/v1/v2x/a_b/5_-1/+/+", "cosiva/v1/v2x/a_b/6_-1/+/+",
                  "cosiva/v1/v2x/a_b/4_0/+/+", "cosiva/v1/v2x/a_b/5_0/+/+", "cosiva/v1/v2x/a_b/6_0/+/+"));
}

TEST(Cell, is_a_square_of_3_m_and_ends_at_100_km) {
  EXPECT_EQ(cell_of({2.999, -3.0}), (Cell{0, -1}));
  EXPECT_EQ(cell_of({3.0, -3.001}), (Cell{1, -2}));
  EXPECT_EQ(cell_of({99'999.0, -99'999.0}), (Cell{33'333, -33'333}));
  EXPECT_EQ(cell_of({1e300, -1e300}), cell_of({1e5, -1e5}));
  EXPECT_EQ(cell_of({1e300, -1e300}), (Cell{33'333, -33'334}));
}

TEST(Cell, is_0_m_away_from_its_own_points_and_farther_from_those_on_each_side) {
  const Cell cell{2, -1};  // from 6 m to 9 m, and from -3 m to 0 m
  for (const Point2 inside : {Point2{6.0, -3.0}, Point2{9.0, 0.0}, Point2{7.5, -1.5}})
    EXPECT_EQ(outside_cell_m(cell, inside), 0.0);
  EXPECT_DOUBLE_EQ(outside_cell_m(cell, {5.5, -1.5}), 0.5);
  EXPECT_DOUBLE_EQ(outside_cell_m(cell, {9.25, -1.5}), 0.25);
  EXPECT_DOUBLE_EQ(outside_cell_m(cell, {7.5, -3.75}), 0.75);
  EXPECT_DOUBLE_EQ(outside_cell_m(cell, {7.5, 1.25}), 1.25);
  EXPECT_DOUBLE_EQ(outside_cell_m(cell, {5.5, 0.125}), 0.5) << "the larger of both";
}

}  // namespace
}  // namespace cosiva::wire
