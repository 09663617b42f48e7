#include "cosiva/zone/toml/toml_factory.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "cosiva/base/random.h"
#include "cosiva/base/test_paths.h"
#include "cosiva/zone/testing/test_zones.h"

namespace cosiva::zone {
namespace {

using ::testing::HasSubstr;
using testing::read_zone;
using ::testing::SizeIs;
using ::testing::StartsWith;
using testing::straight;

/// The error of a file that must be refused, as the command line prints it.
std::string error_of(const std::string& text) {
  const auto zone = read_zone(text);
  return zone ? "no error" : to_string(zone.error());
}
std::string code_of(const std::string& text) {
  const auto zone = read_zone(text);
  return zone ? "none" : zone.error().code;
}
std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

// What the factory reads
// ------------------------------------------------------------------------------------------------

TEST(TomlZone, needs_no_more_than_a_name_and_a_section) {
  const auto zone = read_zone(straight);
  ASSERT_TRUE(zone) << to_string(zone.error());
  EXPECT_EQ(zone->name, "z");
  EXPECT_EQ(zone->circuit.size(), 1U);
  EXPECT_EQ(zone->circuit.section(0).start(), Pose2{});
  EXPECT_TRUE(zone->circuit.next(0).empty());
  EXPECT_EQ(zone->vehicle.length_m, 0.20);
  EXPECT_EQ(zone->profiles.fast.speed_mps, 0.50);
  EXPECT_FALSE(zone->beacons);
}

TEST(TomlZone, reads_every_kind_of_section_end_to_end) {
  const auto zone = read_zone(R"(
name = "kinds"
format_version = 1
[circuit]
start = { x = 1, y = -2.5, heading_deg = 90 }
[[section]]
name = "in"
kind = "straight"
length_m = 1
speed_mps_max = 0.2
[[section]]
name = "ease"
kind = "clothoid"
length_m = 0.5
curvature_start_per_m = 0
curvature_end_per_m = -2.0
[[section]]
name = "bend"
kind = "arc"
radius_m = 0.5
angle_deg = -90
)");
  ASSERT_TRUE(zone) << to_string(zone.error());
  const Circuit& circuit = zone->circuit;
  EXPECT_EQ(circuit.section(0).start(), (Pose2{1.0, -2.5, pi / 2.0}));
  EXPECT_EQ(circuit.part(0).speed_mps_max, 0.2);
  EXPECT_EQ(circuit.section(1).start(), circuit.section(0).end());
  EXPECT_EQ(circuit.section(1).kind(), SectionKind::clothoid);
  EXPECT_EQ(circuit.section(1).curvature_at(0.5), -2.0);
  EXPECT_NEAR(circuit.section(2).length_m(), 0.25 * pi, 1e-15);
  // Right by half of 2.0/m · 0.5 m, then by a quarter turn.
  EXPECT_NEAR(circuit.section(2).end().heading_rad, pi / 2.0 - 0.5 - pi / 2.0, 1e-12);
  EXPECT_THAT(circuit.next(1), ::testing::ElementsAre(2));
  EXPECT_TRUE(circuit.next(2).empty());
}

TEST(TomlZone, reads_forks_and_sections_that_start_elsewhere) {
  const auto zone = read_zone(R"(
name = "fork"
format_version = 1
[[section]]
name = "stem"
kind = "straight"
length_m = 1.0
next = ["left", "right"]
[[section]]
name = "left"
kind = "arc"
radius_m = 1.0
angle_deg = 90
next = []
[[section]]
name = "right"
start = { x = 1.0, y = 0.0, heading_deg = 0.0 }
kind = "arc"
radius_m = 1.0
angle_deg = -90
)");
  ASSERT_TRUE(zone) << to_string(zone.error());
  EXPECT_THAT(zone->circuit.next(0), ::testing::ElementsAre(1, 2));
  EXPECT_TRUE(zone->circuit.next(1).empty());
  EXPECT_THAT(zone->crossings, SizeIs(1));
}

TEST(TomlZone, reads_vehicle_profiles_tags_stations_starts_and_beacons) {
  const auto zone = read_zone(straight + R"(
[vehicle]
length_m = 0.3
width_m = 0.2
[profiles.slow]
speed_mps = 0.1
acceleration_mps2 = 0.2
braking_mps2 = 0.4
[[tag]]
number = 5
section = "a"
s_m = 0.5
[[station]]
name = "dock"
section = "a"
s_m = 1
[[start]]
section = "a"
s_m = 0.25
[beacons]
pitch_m = 0.5
origin = [0, -0.5]
columns = 5
rows = 3
first_number = 500
[crossings]
clearance_m = 0.1
[waypoints]
spacing_m = 1.0
)");
  ASSERT_TRUE(zone) << to_string(zone.error());
  EXPECT_EQ(zone->vehicle.width_m, 0.2);
  EXPECT_EQ(zone->profiles.slow.braking_mps2, 0.4);
  EXPECT_EQ(zone->find_tag(5)->position, (TrackPosition{0, 0.5}));
  ASSERT_THAT(zone->stations, SizeIs(1));
  EXPECT_EQ(zone->stations[0].name, "dock");
  ASSERT_THAT(zone->starts, SizeIs(1));
  EXPECT_EQ(zone->beacons->find(514), (Point2{2.0, 0.5}));
  EXPECT_THAT(zone->waypoints, SizeIs(3));  // 0, 1 and 2 m
}

TEST(TomlZone, covers_the_zone_with_beacons_of_any_pitch) {
  for (const char* pitch : {"0.1", "0.25", "0.7", "3.0"}) {
    const auto zone = read_zone(straight + "[beacons]\npitch_m = " + pitch + "\ncover = \"zone\"\n");
    ASSERT_TRUE(zone) << to_string(zone.error());
    for (double s = 0.0; s <= 2.0; s += 0.05)
      EXPECT_TRUE(zone->beacons->nearest(position(zone->circuit.pose_at({0, s})))) << pitch << " " << s;
  }
}

TEST(TomlZone, in_the_guide_is_a_zone_with_all_elements) {
  std::ifstream file(source_dir() + "/docs/guide/zones.md");
  std::stringstream guide;
  guide << file.rdbuf();
  const std::string text = guide.str();
  const auto begin = text.find("```toml\n") + 8;
  const auto zone = read_zone(text.substr(begin, text.find("```", begin) - begin));
  ASSERT_TRUE(zone) << to_string(zone.error());
  EXPECT_EQ(zone->circuit.size(), 6U);
  EXPECT_THAT(zone->tags, SizeIs(1));
  EXPECT_THAT(zone->stations, SizeIs(1));
  EXPECT_THAT(zone->starts, SizeIs(1));
  EXPECT_TRUE(zone->beacons);
  EXPECT_EQ(zone->priority_of("CoSiVA/AIV1"), 3);
  // The bend and its two clothoids make half a turn, so that north runs west.
  EXPECT_NEAR(std::fabs(zone->circuit.section(4).start().heading_rad), pi, 1e-6);
}

// Refusals and their messages
// ---------------------------------------------------------------------------------------------

TEST(TomlZone, reports_file_line_field_expected_and_found_value) {
  EXPECT_EQ(error_of(replaced(straight, "2.0", "\"abc\"")),
            "test.toml:6: section[1].length_m: expected a positive number of metres, at most 100000, found \"abc\"");
}

TEST(TomlZone, with_a_syntax_error_names_its_line) {
  EXPECT_THAT(error_of(straight + "[[section]\n"), StartsWith("test.toml:7: "));
  EXPECT_EQ(code_of(straight + "[[section]\n"), "zone.syntax");
  EXPECT_EQ(code_of(straight + "name = \"twice\"\nname = \"twice\"\n"), "zone.syntax");
  EXPECT_EQ(code_of("name = \"\xFF\xFE\"\n"), "zone.syntax");
  EXPECT_EQ(code_of(std::string("name = \"\0\"", 10)), "zone.syntax");
}

TEST(TomlZone, with_a_field_missing_names_it_and_the_table_it_is_missing_from) {
  EXPECT_THAT(error_of(replaced(straight, "length_m = 2.0\n", "")),
              StartsWith("test.toml:3: section[1].length_m: expected a positive number of metres"));
  EXPECT_THAT(error_of(replaced(straight, "name = \"z\"\n", "")), HasSubstr("name: expected a name"));
  EXPECT_THAT(error_of(replaced(straight, "format_version = 1\n", "")), HasSubstr("format_version: expected"));
  EXPECT_THAT(error_of(straight + "[[tag]]\nnumber = 1\ns_m = 0.5\n"), StartsWith("test.toml:7: tag[1].section: "));
}

TEST(TomlZone, with_an_unknown_key_names_the_nearest_known_one) {
  EXPECT_THAT(error_of(replaced(straight, "length_m", "lenght_m")),
              StartsWith("test.toml:6: section[1].lenght_m: unknown key; did you mean \"length_m\"?"));
  EXPECT_THAT(error_of("nmae = \"z\"\n" + straight), HasSubstr("did you mean \"name\"?"));
  EXPECT_THAT(error_of(straight + "[vehicle]\nlength_m = 1\nwidth = 1\n"),
              StartsWith("test.toml:9: vehicle.width: unknown key; did you mean \"width_m\"?"));
  // Known, but of another kind of section.
  EXPECT_THAT(error_of(straight + "radius_m = 1.0\n"), HasSubstr("section[1].radius_m: unknown key"));
}

TEST(TomlZone, with_invalid_or_out_of_range_numbers_is_refused) {
  for (const char* bad : {"nan", "inf", "-inf", "0.0", "-2.0", "1e9", "true", "[2.0]", "{ m = 2.0 }", "1979-05-27"})
    EXPECT_THAT(error_of(replaced(straight, "2.0", bad)), StartsWith("test.toml:6: section[1].length_m: expected"))
        << bad;
  EXPECT_THAT(error_of(straight + "speed_mps_max = -1\n"), HasSubstr("found -1"));
  EXPECT_EQ(code_of(straight + "[circuit]\nstart = { x = nan, y = 0, heading_deg = 0 }\n"), "zone.field");
}

TEST(TomlZone, of_another_version_is_refused) {
  EXPECT_EQ(code_of(replaced(straight, "format_version = 1", "format_version = 2")), "zone.version");
}

TEST(TomlZone, without_sections_is_refused) {
  EXPECT_EQ(code_of("name = \"z\"\nformat_version = 1\n"), "circuit.empty");
  EXPECT_EQ(code_of("name = \"z\"\nformat_version = 1\nsection = 3\n"), "zone.field");
  EXPECT_EQ(code_of("name = \"z\"\nformat_version = 1\nsection = [1]\n"), "zone.field");
}

TEST(TomlZone, with_names_or_numbers_twice_is_refused_at_the_second) {
  const std::string again = straight + "[[section]]\nname = \"a\"\nkind = \"straight\"\nlength_m = 1\n";
  EXPECT_THAT(error_of(again), StartsWith("test.toml:8: section[2].name: "));
  EXPECT_EQ(code_of(again), "circuit.duplicate");
  const std::string tag = "[[tag]]\nnumber = 1\nsection = \"a\"\ns_m = 0.5\n";
  EXPECT_THAT(error_of(straight + tag + tag), StartsWith("test.toml:12: tag[2].number: "));
  EXPECT_EQ(code_of(straight + tag + "[beacons]\npitch_m = 1\ncolumns = 1\nrows = 1\nfirst_number = 1\n"),
            "zone.duplicate");
  const std::string station = "[[station]]\nname = \"d\"\nsection = \"a\"\ns_m = 0.5\n";
  EXPECT_EQ(code_of(straight + station + station), "zone.duplicate");
  EXPECT_EQ(code_of(straight + "next = [\"a\", \"a\"]\n"), "zone.duplicate");
}

TEST(TomlZone, that_refers_to_a_missing_section_is_refused) {
  EXPECT_THAT(error_of(straight + "next = [\"b\"]\n"),
              StartsWith("test.toml:7: section[1].next: expected names of sections, found \"b\""));
  EXPECT_THAT(error_of(straight + "[[tag]]\nnumber = 1\nsection = \"b\"\ns_m = 0\n"),
              StartsWith("test.toml:9: tag[1].section: "));
}

TEST(TomlZone, with_a_gap_or_a_kink_is_refused_at_the_section_before_it) {
  const std::string second = "[[section]]\nname = \"b\"\nkind = \"straight\"\nlength_m = 1\n";
  const auto gap = straight + second + "start = { x = 2.5, y = 0, heading_deg = 0 }\n";
  EXPECT_THAT(error_of(gap), StartsWith("test.toml:3: section[1].next: 'a' ends at"));
  EXPECT_EQ(code_of(gap), "circuit.gap");
  EXPECT_EQ(code_of(straight + second + "start = { x = 2, y = 0, heading_deg = 5 }\n"), "circuit.kink");
  EXPECT_EQ(code_of(straight + "[circuit]\nclosed = true\n"), "circuit.gap");
}

TEST(TomlZone, with_a_position_beyond_its_section_is_refused) {
  EXPECT_EQ(error_of(straight + "[[tag]]\nnumber = 1\nsection = \"a\"\ns_m = 2.1\n"),
            "test.toml:10: tag[1].s_m: expected metres along 'a' from 0 to its length, 2, found 2.1");
  EXPECT_EQ(code_of(straight + "[[station]]\nname = \"d\"\nsection = \"a\"\ns_m = -0.1\n"), "zone.field");
}

TEST(TomlZone, with_a_vehicle_wider_than_its_bends_is_refused) {
  const std::string bend =
      replaced(replaced(straight, "straight", "arc"), "length_m = 2.0", "radius_m = 0.2\nangle_deg = 90");
  EXPECT_EQ(code_of(bend), "none");
  EXPECT_EQ(code_of(bend + "[vehicle]\nlength_m = 0.2\nwidth_m = 0.45\n"), "zone.vehicle");
  EXPECT_THAT(error_of(bend + "[vehicle]\nlength_m = 0.2\nwidth_m = 0.45\n"),
              HasSubstr("vehicle.width_m: expected less than 0.4 m"));
  EXPECT_EQ(code_of(straight + "[vehicle]\nlength_m = 0\nwidth_m = 0.1\n"), "zone.field");
}

TEST(TomlZone, with_an_arc_that_does_not_turn_is_refused) {
  EXPECT_THAT(
      error_of(replaced(replaced(straight, "straight", "arc"), "length_m = 2.0", "radius_m = 0.2\nangle_deg = 0")),
      HasSubstr("angle_deg: expected degrees to turn"));
}

TEST(TomlZone, with_profiles_in_the_wrong_order_is_refused) {
  const auto profile = [](const std::string& name, const std::string& speed) {
    return "[profiles." + name + "]\nspeed_mps = " + speed + "\nacceleration_mps2 = 1\nbraking_mps2 = 1\n";
  };
  EXPECT_EQ(code_of(straight + profile("slow", "0.4") + profile("medium", "0.3")), "zone.field");
  EXPECT_EQ(code_of(straight + profile("slow", "0.2") + profile("medium", "0.3")), "none");
}

TEST(TomlZone, that_starts_a_vehicle_in_a_crossing_is_refused) {
  const std::string cross = straight + "next = []\n[[section]]\nname = \"b\"\nkind = \"straight\"\nlength_m = 2\n" +
                            "start = { x = 1, y = -1, heading_deg = 90 }\n";
  EXPECT_EQ(code_of(cross + "[[start]]\nsection = \"a\"\ns_m = 0.2\n"), "none");
  EXPECT_THAT(error_of(cross + "[[start]]\nsection = \"a\"\ns_m = 1.0\n"),
              HasSubstr("start[1].s_m: expected a position outside"));
}

TEST(TomlZone, that_is_too_large_is_refused_before_it_is_read) {
  EXPECT_EQ(code_of(straight + "#" + std::string(toml_bytes_max, 'x')), "zone.size");
  std::string many = "name = \"z\"\nformat_version = 1\nsection = [";
  for (std::size_t i = 0; i <= toml_sections_max; ++i) many += "{},";
  EXPECT_EQ(code_of(many + "]\n"), "zone.size");
}

TEST(TomlZone, that_requests_more_memory_than_it_needs_is_refused) {
  const std::string arc = R"([[section]]
name = "@"
kind = "arc"
radius_m = 0.1
angle_deg = 500000
)";
  std::string text = "name = \"z\"\nformat_version = 1\n[vehicle]\nlength_m = 0.1\nwidth_m = 0.1\n";
  for (int i = 0; i < 46; ++i) text += replaced(arc, "@", std::to_string(i));
  EXPECT_EQ(code_of(text), "zone.size");
  EXPECT_EQ(code_of(straight + "[beacons]\npitch_m = 0.0001\ncover = \"zone\"\n"), "zone.size");
  EXPECT_EQ(code_of(straight + "[beacons]\npitch_m = 1\ncolumns = 100000\nrows = 100000\n"), "zone.size");
}

TEST(TomlZone, with_many_overlapping_sections_is_refused) {
  std::string text = "name = \"z\"\nformat_version = 1\n";
  for (int i = 0; i < 3000; ++i)
    text += "[[section]]\nname = \"" + std::to_string(i) + "\"\nkind = \"straight\"\nlength_m = 1\nnext = []\n" +
            "start = { x = 0, y = 0, heading_deg = 0 }\n";
  EXPECT_EQ(code_of(text), "zone.size");
}

TEST(TomlZone, survives_any_damage_to_a_good_file) {
  const std::string good =
      straight + "[[tag]]\nnumber = 1\nsection = \"a\"\ns_m = 0.5\n[beacons]\npitch_m = 1\ncover = \"zone\"\n";
  EXPECT_TRUE(rc::check([&] {
    Random random{*rc::gen::arbitrary<std::uint64_t>(), "toml_factory_test"};
    std::string text = good;
    for (std::uint64_t i = 0; i <= random.below(4); ++i) {
      const std::size_t at = random.below(text.size());
      switch (random.below(3)) {
        case 0: text[at] = static_cast<char>(random.below(256)); break;
        case 1: text.erase(at, random.below(8)); break;
        default: text.insert(at, 1, static_cast<char>(random.below(128))); break;
      }
      if (text.empty()) return;
    }
    const auto zone = read_zone(text);
    if (!zone) RC_ASSERT(zone.error().location.rfind("test.toml", 0) == 0);
  }));
}

// RTM
// -------------------------------------------------------------------------------------------------------------------

TEST(Rtm, keeps_the_configuration_and_names_its_factory) {
  const auto rtm = Rtm::initialise({"toml", "test.toml", straight});
  ASSERT_TRUE(rtm);
  EXPECT_EQ(rtm->circuit_factory().format(), "toml");
  EXPECT_EQ(rtm->configuration().text, straight);
  EXPECT_EQ(rtm->zone().circuit.size(), 1U);
  EXPECT_EQ(rtm->shared_zone().get(), &rtm->zone());
}

TEST(Rtm, of_an_unknown_format_names_the_known_ones) {
  const auto rtm = Rtm::initialise({"cad", "test.xodr", "<xml/>"});
  ASSERT_FALSE(rtm);
  EXPECT_EQ(rtm.error().code, "zone.format");
  EXPECT_EQ(rtm.error().location, "test.xodr");
  EXPECT_THAT(rtm.error().message, HasSubstr("known formats: toml, lif, opendrive, movingai"));
}

}  // namespace
}  // namespace cosiva::zone
