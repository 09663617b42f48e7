#include "cosiva/wire/own/gvs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "cosiva/base/math.h"
#include "cosiva/wire/own/limits_fixture.h"

namespace cosiva::wire {
namespace {

using ::testing::HasSubstr;

SimTime time_of(const char* text) { return parse_iso8601(text).value(); }

const GvsDetections shown{7,
                          time_of("2026-01-01T00:00:00.100Z"),
                          0.25,
                          {{"CoSiVA/AIV1", 1, time_of("2026-01-01T00:00:00.102Z"), {0.125, -0.15, 0.5}, 0.001}},
                          {{-1.0, -1.0}, {1.0, -1.0}, {1.0, 1.0}}};
constexpr std::string_view shown_json =
    R"({"headerId":7,"timestamp":"2026-01-01T00:00:00.100Z","period":0.25,)"
    R"("detections":[{"vehicle":"CoSiVA/AIV1","tag":1,"at":"2026-01-01T00:00:00.102Z","x":0.125,"y":-0.15,"heading":0.5,)"
    R"("uncertainty":0.001}],"field":[[-1,-1],[1,-1],[1,1]]})";
constexpr std::string_view connected_json =
    R"({"connectionState":"ONLINE","timestamp":"2026-01-01T00:00:00.000Z","source":"the emulated world's camera",)"
    R"("trouble":""})";

std::string replaced(std::string_view text, std::string_view from, std::string_view to) {
  std::string changed{text};
  const std::size_t at = changed.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return changed.replace(at, from.size(), to);
}

TEST(GvsMessages, are_written_as_the_protocol_shows_and_read_back) {
  EXPECT_EQ(to_json(shown), shown_json);
  EXPECT_EQ(gvs_detections_from_json(shown_json).value(), shown);
  const GvsConnection connected{ConnectionState::online, time_of("2026-01-01T00:00:00.000Z"),
                                "the emulated world's camera", ""};
  EXPECT_EQ(to_json(connected), connected_json);
  EXPECT_EQ(gvs_connection_from_json(connected_json).value(), connected);
}

TEST(GvsMessages, without_detections_and_with_unknown_fields_are_read) {
  const auto read = gvs_detections_from_json(
      R"({"headerId":0,"timestamp":"2026-01-01T00:00:00Z","period":1,"detections":[],"field":[],"colour":"grey"})");
  ASSERT_TRUE(read);
  EXPECT_TRUE(read->detections.empty());
}

TEST(GvsMessages, bring_a_heading_into_one_turn) {
  const auto read = gvs_detections_from_json(replaced(shown_json, R"("heading":0.5)", R"("heading":7)"));
  EXPECT_NEAR(read->detections[0].pose.heading_rad, 7.0 - 2.0 * pi, 1e-12);
}

TEST(GvsMessages, that_are_wrong_are_refused_naming_the_field) {
  const auto refused = [](const char* from, const char* to, const char* location) {
    const auto read = gvs_detections_from_json(replaced(shown_json, from, to));
    ASSERT_FALSE(read) << to;
    EXPECT_EQ(read.error().code, "own.field");
    EXPECT_EQ(read.error().location, location);
  };
  refused(R"("x":0.125)", R"("x":"here")", "detections.0.x");
  refused(R"("x":0.125)", R"("x":1e9)", "detections.0.x");
  refused(R"("tag":1)", R"("tag":-1)", "detections.0.tag");
  refused(R"("at":"2026-01-01T00:00:00.102Z")", R"("at":"now")", "detections.0.at");
  refused(R"("period":0.25)", R"("period":-1)", "period");
  refused("[-1,-1]", "[-1]", "field.0");
  refused("[1,1]", R"([1,"1"])", "field.2");
  refused("[1,1]", "[1,1e7]", "field.2");
  EXPECT_FALSE(gvs_detections_from_json(replaced(shown_json, R"("tag":1,)", "")));
  EXPECT_FALSE(gvs_detections_from_json("[]"));
  EXPECT_FALSE(gvs_detections_from_json(""));
  const auto word = gvs_connection_from_json(replaced(connected_json, "ONLINE", "HERE"));
  ASSERT_FALSE(word);
  EXPECT_EQ(word.error().location, "connectionState");
  EXPECT_THAT(word.error().message, HasSubstr("CONNECTIONBROKEN"));
}

TEST(GvsMessages, cut_a_long_trouble_text_between_two_characters) {
  GvsConnection troubled{ConnectionState::online, time_of("2026-01-01T00:00:00.000Z"), "a folder", {}};
  for (int i = 0; i < 100; ++i) troubled.trouble += "é";
  troubled.trouble.insert(0, "x");  // so that the limit of 128 bytes falls into one
  const auto read = gvs_connection_from_json(to_json(troubled));
  ASSERT_TRUE(read);
  EXPECT_EQ(read->trouble.size(), 127U);
}

TEST(GvsMessages, with_more_detections_than_allowed_are_refused) {
  GvsDetections many = shown;
  many.detections.resize(GvsDetections::detections_max, shown.detections[0]);
  EXPECT_TRUE(gvs_detections_from_json(to_json(many)));
  many.detections.push_back(shown.detections[0]);
  EXPECT_FALSE(gvs_detections_from_json(to_json(many)));
  GvsDetections cornered = shown;
  cornered.field.resize(GvsDetections::corners_max + 1);
  EXPECT_FALSE(gvs_detections_from_json(to_json(cornered)));
}

TEST(GvsMessages, accept_each_number_within_its_range_only) {
  test::expect_ranges(std::string(shown_json), gvs_detections_from_json,
                      {{"headerId", 0, 4294967295, 1},
                       {"period", 0, 3600},
                       {"detections.0.tag", 0, 4294967295, 1},
                       {"detections.0.x", -1e5, 1e5},
                       {"detections.0.y", -1e5, 1e5},
                       {"detections.0.heading", -100, 100},
                       {"detections.0.uncertainty", 0, 1e5}});
}

TEST(GvsMessages, accept_a_corner_of_two_numbers_within_100_km) {
  const auto accepted = [](const char* corner) {
    return gvs_detections_from_json(replaced(shown_json, "[-1,-1]", corner)).has_value();
  };
  for (const char* good : {"[0,0]", "[-100000,0]", "[100000,0]", "[0,-100000]", "[0,100000]"})
    EXPECT_TRUE(accepted(good)) << good;
  for (const char* bad : {"[-100000.1,0]", "[100000.1,0]", "[0,-100000.1]", "[0,100000.1]", "[]", "[0]", "[0,0,0]",
                          "[null,0]", "[0,null]", "7", "null", "{}"})
    EXPECT_FALSE(accepted(bad)) << bad;
  const auto read = gvs_detections_from_json(replaced(shown_json, "[-1,-1]", "[2,3]"));
  EXPECT_EQ(read.value().field[0], (Point2{2.0, 3.0}));
}

TEST(GvsMessages, accept_at_most_64_corners) {
  GvsDetections cornered = shown;
  cornered.field.resize(64);
  EXPECT_TRUE(gvs_detections_from_json(to_json(cornered)));
  cornered.field.resize(65);
  EXPECT_FALSE(gvs_detections_from_json(to_json(cornered)));
}

TEST(GvsMessages, have_a_term_for_each_state_of_the_connection) {
  for (const auto& [state, term] :
       {std::pair{ConnectionState::online, "ONLINE"}, std::pair{ConnectionState::offline, "OFFLINE"},
        std::pair{ConnectionState::connection_broken, "CONNECTIONBROKEN"}}) {
    const std::string json = to_json(GvsConnection{state, virtual_epoch, "a folder", "no image"});
    EXPECT_THAT(json, HasSubstr("\"" + std::string(term) + "\""));
    EXPECT_EQ(gvs_connection_from_json(json).value().state, state);
  }
}

TEST(GvsMessages, require_every_field) {
  test::expect_required(
      std::string(shown_json), gvs_detections_from_json,
      {"headerId", "timestamp", "period", "detections", "field", "detections.0.vehicle", "detections.0.tag",
       "detections.0.at", "detections.0.x", "detections.0.y", "detections.0.heading", "detections.0.uncertainty"});
  test::expect_required(std::string(connected_json), gvs_connection_from_json,
                        {"connectionState", "timestamp", "source", "trouble"});
}

TEST(GvsMessages, keep_a_text_of_128_bytes_whole) {
  const GvsConnection connected{ConnectionState::online, virtual_epoch, std::string(128, 's'), std::string(129, 't')};
  const auto read = gvs_connection_from_json(to_json(connected));
  ASSERT_TRUE(read);
  EXPECT_EQ(read->source.size(), 128U);
  EXPECT_EQ(read->trouble.size(), 128U);
}

TEST(GvsMessages, name_the_second_detection_and_the_second_corner) {
  GvsDetections two = shown;
  two.detections.push_back(shown.detections[0]);
  two.detections[1].pose.x_m = 1e6;
  const auto far = gvs_detections_from_json(to_json(two));
  ASSERT_FALSE(far);
  EXPECT_EQ(far.error().location, "detections.1.x");
  const auto corner = gvs_detections_from_json(replaced(shown_json, "[1,-1]", "[1,null]"));
  ASSERT_FALSE(corner);
  EXPECT_EQ(corner.error().location, "field.1");
  EXPECT_EQ(corner.error().message, "expected a position [x, y] within 100 km");
}

}  // namespace
}  // namespace cosiva::wire
