// Values of the wrong kind, and what the messages show of them; values that a file can hold in one form alone.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "cosiva/zone/layout/rounding.h"
#include "cosiva/zone/testing/test_zones.h"
#include "cosiva/zone/toml/sidecar.h"
#include "cosiva/zone/toml/toml_factory.h"
#include "cosiva/zone/toml/toml_write.h"

namespace cosiva::zone {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using testing::read_zone;
using ::testing::StartsWith;

const std::string file_head = "name = \"z\"\nformat_version = 1\n";
const std::string section_a = "[[section]]\nname = \"a\"\nkind = \"straight\"\nlength_m = 2.0\n";

/// "code location: message", or "accepted".
std::string fault_in(const std::string& text) {
  const auto zone = read_zone(text);
  return zone ? "accepted" : zone.error().code + " " + to_string(zone.error());
}
std::string fault_of_shape(const std::string& shape) {
  return fault_in(file_head + "[[section]]\nname = \"a\"\n" + shape);
}

TEST(TomlValues, of_every_kind_are_shown_as_what_they_are) {
  const std::string forty(40, 'q');
  const std::pair<std::string, std::string> all[] = {{"true", "true"},
                                                     {"false", "false"},
                                                     {"[2.0, 3.0]", "an array of 2"},
                                                     {"{ m = 2.0 }", "a table"},
                                                     {"1979-05-27", "a date or time"},
                                                     {"-1.5", "-1.5"},
                                                     {"-3", "-3"},
                                                     {"\"x y\"", "\"x y\""},
                                                     {"\"a\\tb\\u007Fc\\u001Fd\"", "\"a?b?c?d\""},
                                                     {"\"" + forty + "\"", "\"" + forty + "\""},
                                                     {"\"" + forty + "q\"", "\"" + forty + "…\""}};
  for (const auto& [value, shown] : all)
    EXPECT_EQ(fault_of_shape("kind = \"straight\"\nlength_m = " + value + "\n"),
              "zone.field test.toml:6: section[1].length_m: expected a positive number of metres, at most 100000, "
              "found " +
                  shown);
}

TEST(TomlValues, of_another_kind_than_expected_are_refused_field_by_field) {
  const std::string names = "expected an array of names, such as [\"east\"], found ";
  const std::string point = "expected two numbers of metres [x, y] within ±1000000, found ";
  const auto beacons = [](const std::string& origin) {
    return section_a + "[beacons]\npitch_m = 1\ncolumns = 1\nrows = 1\norigin = " + origin + "\n";
  };
  const std::pair<std::string, std::string> all[] = {
      {section_a + "[closed]\nsections = \"a\"\n", "closed.sections: " + names + "\"a\""},
      {section_a + "[closed]\nsections = [1]\n", "closed.sections: " + names + "1"},
      {section_a + "[closed]\nsections = [\"a\", 2.5]\n", "closed.sections: " + names + "2.5"},
      {section_a + "[closed]\nsections = { a = 1 }\n", "closed.sections: " + names + "a table"},
      {beacons("1"), "beacons.origin: " + point + "1"},
      {beacons("[1]"), "beacons.origin: " + point + "an array of 1"},
      {beacons("[1, 2, 3]"), "beacons.origin: " + point + "an array of 3"},
      {beacons("[1, \"n\"]"), "beacons.origin: " + point + "\"n\""},
      {beacons("[1000001, 0]"), "beacons.origin: " + point + "1000001"},
      {beacons("[0, -1000001.5]"), "beacons.origin: " + point + "-1000001.5"},
      {section_a + "[circuit]\nclosed = 1\n", "circuit.closed: expected true or false, found 1"},
      {section_a + "[circuit]\nname = 7\n",
       "circuit.name: expected a name of 1 to 256 bytes without control characters, found 7"},
      {section_a + "[[vehicle]]\nlength_m = 1\n", "vehicle: expected a table, found an array of 1"},
      {section_a + "[station]\nname = \"s\"\n", "station: expected tables, each under [[station]], found a table"},
      {"tag = [1]\n" + section_a, "tag: expected tables, each under [[tag]], found 1"},
  };
  for (const auto& [text, message] : all) {
    EXPECT_THAT(fault_in(file_head + text), StartsWith("zone.field test.toml:")) << text;
    EXPECT_THAT(fault_in(file_head + text), ::testing::EndsWith(": " + message)) << text;
  }
  EXPECT_EQ(fault_in(file_head + beacons("[1000000, -1000000]")), "accepted");
  EXPECT_THAT(fault_in("name = \"z\"\nformat_version = 1.0\n" + section_a),
              HasSubstr("format_version: expected a whole number from 1 to 4000000000, found 1"));
}

TEST(TomlValues, that_are_names_have_1_to_256_bytes_without_control_characters) {
  const auto named = [](const std::string& name) {
    return fault_in("name = \"" + name + "\"\nformat_version = 1\n" + section_a);
  };
  for (const std::string& good : {std::string("n"), std::string(256, 'n'), std::string(" "), std::string("é~")})
    EXPECT_EQ(named(good), "accepted") << good;
  for (const std::string& bad : {std::string(), std::string(257, 'n'), std::string("\\u001F"), std::string("a\\u007F")})
    EXPECT_THAT(named(bad), HasSubstr("name: expected a name of 1 to 256 bytes without control characters")) << bad;
}

TEST(TomlKeys, that_are_unknown_are_likened_to_known_ones_that_are_half_the_same) {
  const auto unknown = [](const std::string& key) { return fault_in(key + " = 1\n" + file_head + section_a); };
  EXPECT_THAT(unknown("nxxe"), HasSubstr("test.toml:1: nxxe: unknown key; did you mean \"name\"? Known here: name, "));
  EXPECT_THAT(unknown("xxxe"),
              HasSubstr("xxxe: unknown key; Known here: name, format_version, travel_direction, vehicle, "));
  EXPECT_THAT(unknown("sectxxxx"), HasSubstr("did you mean \"section\"?"));
  EXPECT_THAT(unknown("secxxxxx"), Not(HasSubstr("did you mean")));
  EXPECT_THAT(unknown("\"a\\u0001b\\u007Fc\""), HasSubstr("test.toml:1: a?b?c: unknown key"));
  EXPECT_THAT(unknown(std::string(65, 'k')), HasSubstr("test.toml:1: " + std::string(64, 'k') + ": unknown key"));
}

// Shapes --------------------------------------------------------------------------------------------------------------

TEST(TomlShapes, are_of_three_kinds_with_the_fields_of_one_form) {
  const std::string arc = "kind = \"arc\"\n";
  const std::string clothoid = "kind = \"clothoid\"\nlength_m = 1\ncurvature_start_per_m = 0\n";
  const std::string both = "give an arc either radius_m and angle_deg or length_m and curvature_per_m";
  const std::pair<std::string, std::string> all[] = {
      {"kind = \"curve\"\n", "section[1].kind: expected \"straight\" or \"arc\" or \"clothoid\", found \"curve\""},
      {"length_m = 1\n", "section[1].kind: expected \"straight\" or \"arc\" or \"clothoid\", found nothing"},
      {arc + "length_m = 1\ncurvature_per_m = 1\nangle_deg = 90\n", "section[1].angle_deg: " + both},
      {arc + "length_m = 1\ncurvature_per_m = 1\nradius_m = 1\n", "section[1].radius_m: " + both},
      {arc + "curvature_per_m = 1\n", "section[1].length_m: expected a positive number of metres, at most 100000"},
      {arc + "length_m = 1\n", "section[1].curvature_per_m: expected a curvature per metre within ±1000"},
      {arc + "radius_m = 1\n", "section[1].angle_deg: expected degrees to turn, positive to the left, found nothing"},
      {arc + "angle_deg = 90\n", "section[1].radius_m: expected a positive number of metres, at most 100000"},
      {clothoid, "section[1].curvature_end_per_m: expected a curvature per metre within ±1000"},
      {clothoid + "curvature_rate_per_m2 = 1000000001\n",
       "section[1].curvature_rate_per_m2: expected a change of curvature per metre within ±1e9"},
      {clothoid + "curvature_rate_per_m2 = -1000000001\n",
       "section[1].curvature_rate_per_m2: expected a change of curvature per metre within ±1e9"},
      {clothoid + "curvature_rate_per_m2 = 1\ncurvature_end_per_m = 1\n",
       "section[1].curvature_rate_per_m2: give a clothoid's curvature at its end or its rate, not both"},
      {"kind = \"straight\"\nlength_m = 1\nangle_deg = 90\n", "section[1].angle_deg: unknown key"},
      {arc + "radius_m = 1\nangle_deg = 90\ncurvature_rate_per_m2 = 1\n",
       "section[1].curvature_rate_per_m2: unknown key"},
      {clothoid + "curvature_end_per_m = 1\nradius_m = 1\n", "section[1].radius_m: unknown key"},
  };
  for (const auto& [shape, message] : all) EXPECT_THAT(fault_of_shape(shape), HasSubstr(message)) << shape;
}

TEST(TomlShapes, turn_to_the_side_of_their_angle) {
  const auto turned = [](const std::string& angle_deg) {
    const auto zone = read_zone(
        file_head + "[[section]]\nname = \"a\"\nkind = \"arc\"\nradius_m = 0.5\nangle_deg = " + angle_deg + "\n");
    EXPECT_TRUE(zone) << to_string(zone.error());
    return std::pair{zone->circuit.section(0).length_m(), zone->circuit.section(0).curvature_at(0.0)};
  };
  EXPECT_EQ(turned("90"), (std::pair{0.5 * (90.0 * rad_per_deg), 2.0}));
  EXPECT_EQ(turned("-90"), (std::pair{0.5 * (90.0 * rad_per_deg), -2.0}));
  EXPECT_EQ(turned("0.5"), (std::pair{0.5 * (0.5 * rad_per_deg), 2.0}));
}

TEST(TomlShapes, name_the_node_at_either_end_of_any_section) {
  const auto zone = read_zone(
      file_head + section_a +
      "[[section]]\nname = \"b\"\nkind = \"straight\"\nlength_m = 2.0\nstart_node = \"M\"\nend_node = \"E\"\n" +
      "[waypoints]\nnodes_only = true\n");
  ASSERT_TRUE(zone) << to_string(zone.error());
  std::vector<std::string> ids;
  for (const Waypoint& waypoint : zone->waypoints) ids.push_back(waypoint.id);
  EXPECT_THAT(ids, ElementsAre("a@0", "M", "E"));
}

// Starts --------------------------------------------------------------------------------------------------------------

std::string crossed_at(const std::string& name, const std::string& x_m) {
  return "[[section]]\nname = \"" + name + "\"\nkind = \"straight\"\nlength_m = 2\nnext = []\nstart = { x = " + x_m +
         ", y = -1, heading_deg = 90 }\n";
}
std::string start_at(const std::string& s_m) { return "[[start]]\nsection = \"a\"\ns_m = " + s_m + "\n"; }

TEST(TomlStarts, lie_inside_a_crossing_within_two_centimetres_of_a_station) {
  const std::string crossed = file_head + section_a + "next = []\n" + crossed_at("b", "1");
  const std::string with_station = crossed + "[[station]]\nname = \"s\"\nsection = \"a\"\ns_m = 1.0\n";
  for (const char* good : {"1.0", "1.019", "0.981"}) EXPECT_EQ(fault_in(with_station + start_at(good)), "accepted");
  for (const char* bad : {"1.021", "0.979"})
    EXPECT_THAT(fault_in(with_station + start_at(bad)),
                HasSubstr("start[1].s_m: expected a position outside every crossing, found one inside X1"));
  EXPECT_THAT(fault_in(crossed + start_at("1.019")), StartsWith("zone.start "));
}

TEST(TomlStarts, lie_between_crossings_only_where_a_vehicle_may_stop) {
  // Spans reach 0.2 m to either side, and a vehicle needs 0.3 m: 0.2 m are free, or 0.6 m.
  const auto between = [](const std::string& x_m, const std::string& s_m) {
    return fault_in(file_head + section_a + "next = []\n" + crossed_at("b", "0.6") + crossed_at("c", x_m) +
                    start_at(s_m));
  };
  EXPECT_THAT(between("1.2", "0.9"),
              HasSubstr("start[1].s_m: expected a position where a vehicle may stop, found one between crossings too "
                        "close together"));
  EXPECT_EQ(between("1.6", "1.1"), "accepted");
}

// Writing -------------------------------------------------------------------------------------------------------------

TrafficZone zone_with(Section only) {
  return {"z", testing::circuit({testing::part("a", std::move(only))}), {}, default_profiles, {}, {}, {}, {}, {}, {}};
}

TEST(TomlWriter, writes_an_arc_by_its_radius_up_to_a_hundred_kilometres) {
  const auto arc = [](double radius_m) {
    return *native_text(zone_with(testing::section({}, radius_m * rad_per_deg, 1.0 / radius_m)));
  };
  EXPECT_THAT(arc(65536.0), HasSubstr("kind = \"arc\"\nradius_m = 65536\nangle_deg = 1\n"));
  EXPECT_THAT(arc(131072.0), HasSubstr("\ncurvature_per_m = 7.62939453125e-06\n"));
  EXPECT_THAT(arc(131072.0), Not(HasSubstr("radius_m")));
}

TEST(TomlWriter, refuses_the_names_of_sections_and_waypoints_that_no_file_can_hold) {
  TrafficZone zone = zone_with(testing::section({}, 2.0));
  EXPECT_TRUE(native_text(zone));
  zone.waypoints = {{"n", {0, 0.0}}, {"\x01", {0, 1.0}}};
  const auto bad_waypoint = native_text(zone);
  ASSERT_FALSE(bad_waypoint);
  EXPECT_EQ(bad_waypoint.error().code, "zone.write");
  EXPECT_EQ(bad_waypoint.error().location, "\x01");
  EXPECT_EQ(bad_waypoint.error().message,
            "a name must have 1 to 256 bytes without control characters; this one has not");
  zone = zone_with(testing::section({}, 2.0));
  zone.circuit = testing::circuit(
      {testing::part("a", testing::section({}, 2.0)), testing::part("b\n", testing::section({}, 1.0))});
  EXPECT_EQ(native_text(zone).error().location, "b\n");
}

TEST(TomlWriter, reports_what_does_not_read_back_as_it_was) {
  std::vector<Diagnostic> lost;
  TrafficZone zone = testing::lacet4();
  zone.crossings = {};  // which follow from the sections
  const auto other = TomlCircuitFactory{}.written(zone, lost);
  EXPECT_TRUE(other);
  ASSERT_EQ(lost.size(), 1U);
  EXPECT_EQ(lost[0].kind, Diagnostic::Kind::lost);
  EXPECT_EQ(lost[0].location, "lacet4");
  EXPECT_EQ(lost[0].text, "what was written is not quite the zone: its sections differ");
  lost.clear();
  zone.vehicle.width_m = 0.0;
  const auto refused = TomlCircuitFactory{}.written(zone, lost);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, "zone.write");
  EXPECT_EQ(refused.error().location, "lacet4");
  EXPECT_EQ(refused.error().message,
            "what was written is refused: expected a positive number of metres, at most 100, found 0");
  EXPECT_THAT(lost, IsEmpty());
}

}  // namespace
}  // namespace cosiva::zone
