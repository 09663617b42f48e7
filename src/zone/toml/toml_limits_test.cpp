// The limits of every number of a native file, and its complete text as it is written.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "cosiva/zone/testing/test_zones.h"
#include "cosiva/zone/toml/sidecar.h"
#include "cosiva/zone/toml/toml_factory.h"
#include "cosiva/zone/toml/toml_write.h"

namespace cosiva::zone {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::read_zone;
using ::testing::StartsWith;

const std::string zone_head = "name = \"z\"\nformat_version = 1\n";
const std::string narrow_vehicle = "[vehicle]\nlength_m = 0.1\nwidth_m = 0.0000001\n";

std::string section_text(const std::string& name, const std::string& kind, const std::string& more) {
  return "[[section]]\nname = \"" + name + "\"\nkind = \"" + kind + "\"\n" + more;
}
std::string straight_text(const std::string& name, const std::string& more = {}) {
  return section_text(name, "straight", "length_m = 2.0\n" + more);
}
std::string refusal(const std::string& text) {
  const auto zone = read_zone(text);
  return zone ? "accepted" : zone.error().code + " " + to_string(zone.error());
}

TEST(TomlLimits, accept_each_number_up_to_its_limit_and_none_beyond) {
  const std::string a = straight_text("a");
  const auto on_a = [&](const std::string& more) { return zone_head + straight_text("a", more); };
  const auto start = [&](const std::string& x, const std::string& y, const std::string& heading) {
    return on_a("start = { x = " + x + ", y = " + y + ", heading_deg = " + heading + " }\n");
  };
  const auto profile = [&](const std::string& speed, const std::string& acceleration, const std::string& braking) {
    return zone_head + "[profiles.fast]\nspeed_mps = " + speed + "\nacceleration_mps2 = " + acceleration +
           "\nbraking_mps2 = " + braking + "\n" + a;
  };
  const struct {
    std::string text;  ///< with # for the number
    std::vector<const char*> good;
    std::vector<const char*> bad;
    const char* expected;
  } all[] = {
      {zone_head + section_text("a", "straight", "length_m = #\n"),
       {"0.01"},
       {"0", "-1", "100001"},
       "length_m: expected a positive number of metres, at most 100000"},
      {zone_head + narrow_vehicle + section_text("a", "arc", "radius_m = 0.1\nangle_deg = #\n"),
       {"360", "-360"},
       {"572958", "-572958"},
       "angle_deg: expected degrees to turn, positive to the left"},
      {zone_head + narrow_vehicle + section_text("a", "arc", "length_m = 0.1\ncurvature_per_m = #\n"),
       {"1000", "-1000"},
       {"1001", "-1001"},
       "curvature_per_m: expected a curvature per metre within ±1000"},
      {zone_head + narrow_vehicle +
           section_text("a", "clothoid", "length_m = 0.1\ncurvature_start_per_m = 0\ncurvature_end_per_m = #\n"),
       {"1000", "-1000"},
       {"1001", "-1001"},
       "curvature_end_per_m: expected a curvature per metre within ±1000"},
      {zone_head + narrow_vehicle +
           section_text("a", "clothoid", "length_m = 0.1\ncurvature_start_per_m = #\ncurvature_end_per_m = 0\n"),
       {"1000", "-1000"},
       {"1001", "-1001"},
       "curvature_start_per_m: expected a curvature per metre within ±1000"},
      {start("#", "0", "0"),
       {"1000000", "-1000000"},
       {"1000001", "-1000001"},
       "start.x: expected a number of metres within ±1000000"},
      {start("0", "#", "0"),
       {"1000000", "-1000000"},
       {"1000001", "-1000001"},
       "start.y: expected a number of metres within ±1000000"},
      {start("0", "0", "#"), {"360", "-360"}, {"361", "-361"}, "heading_deg: expected degrees within ±360"},
      {on_a("speed_mps_max = #\n"),
       {"0.01", "100"},
       {"0", "101"},
       "speed_mps_max: expected a positive speed in metres per second, at most 100"},
      {zone_head + "[vehicle]\nlength_m = #\nwidth_m = 0.1\n" + a,
       {"0.01", "100"},
       {"0", "101"},
       "vehicle.length_m: expected a positive number of metres, at most 100"},
      {zone_head + "[vehicle]\nlength_m = 0.1\nwidth_m = #\n" + a,
       {"0.01", "100"},
       {"0", "101"},
       "vehicle.width_m: expected a positive number of metres, at most 100"},
      {profile("#", "1", "1"), {"0.3", "100"}, {"101"}, "speed_mps: expected a positive speed"},
      {profile("1", "#", "1"), {"0.01", "100"}, {"0", "101"}, "acceleration_mps2: expected a positive acceleration"},
      {profile("1", "1", "#"), {"0.01", "100"}, {"0", "101"}, "braking_mps2: expected a positive acceleration"},
      {zone_head + "[crossings]\nclearance_m = #\n" + a,
       {"0", "10"},
       {"-0.01", "10.1"},
       "clearance_m: expected metres from 0 to 10"},
      {zone_head + "[waypoints]\nspacing_m = #\n" + a,
       {"0.05", "1000"},
       {"0.049", "1001"},
       "spacing_m: expected metres from 0.05 to 1000"},
      {zone_head + a + "[beacons]\npitch_m = 1\nrows = 1\ncolumns = #\n",
       {"1", "1000000"},
       {"0", "1000001"},
       "beacons.columns: expected"},
      {zone_head + a + "[beacons]\npitch_m = 1\ncolumns = 1\nrows = #\n",
       {"1", "1000000"},
       {"0", "1000001"},
       "beacons.rows: expected"},
      {zone_head + a + "[beacons]\npitch_m = 1\ncolumns = 1000\nrows = #\n",
       {"1000"},
       {"1001"},
       "beacons.rows: expected at most 1000000 beacons in all"},
      {zone_head + a + "[beacons]\npitch_m = 1\ncolumns = 1\nrows = 1\nfirst_number = #\n",
       {"1", "4000000000"},
       {"0", "4000000001"},
       "first_number: expected"},
      {zone_head + a + "[[tag]]\nsection = \"a\"\ns_m = 1\nnumber = #\n",
       {"1", "4000000000"},
       {"0", "4000000001"},
       "tag[1].number: expected"},
      {zone_head + a + "[[tag]]\nsection = \"a\"\nnumber = 1\ns_m = #\n",
       {"0", "2"},
       {"-0.01", "2.01"},
       "tag[1].s_m: expected metres along 'a' from 0 to its length, 2"},
      {zone_head + a + "[priorities]\n\"A/1\" = #\n", {"0", "999"}, {"-1", "1000"}, "expected"},
  };
  for (const auto& of : all) {
    const auto with = [&](const char* number) {
      std::string text = of.text;
      return text.replace(text.find('#'), 1, number);
    };
    for (const char* good : of.good) EXPECT_EQ(refusal(with(good)), "accepted") << with(good);
    for (const char* bad : of.bad) {
      EXPECT_THAT(refusal(with(bad)), StartsWith("zone.")) << with(bad);
      EXPECT_THAT(refusal(with(bad)), HasSubstr(of.expected)) << with(bad);
    }
  }
}

TEST(TomlLimits, of_all_sections_are_a_thousand_kilometres) {
  // A fault after them shows that they are accepted.
  const std::string fault = straight_text("more", "colour = 1\n");
  std::string text = zone_head;
  for (int i = 0; i < 10; ++i) text += section_text("s" + std::to_string(i), "straight", "length_m = 100000\n");
  EXPECT_THAT(refusal(text + fault), StartsWith("zone.unknown_key"));
  EXPECT_THAT(refusal(text + straight_text("more")), HasSubstr("section[11]: a zone's sections may be 1000 km long"));
}

TEST(TomlLimits, of_lists_are_named) {
  std::string forks = zone_head + straight_text("a", "next = []\n");
  const auto fork = [](int i) { return straight_text("f" + std::to_string(i), "from = \"a\"\n"); };
  for (int i = 0; i < 64; ++i) forks += fork(i);
  EXPECT_THAT(refusal(forks), ::testing::Not(HasSubstr("expected at most 64 sections after one")));
  EXPECT_THAT(refusal(forks + fork(64)), HasSubstr("section[66].from: expected at most 64 sections after one"));
  std::string circuits = zone_head;
  const auto circuit = [](int i) { return "[[circuit]]\nname = \"c" + std::to_string(i) + "\"\n"; };
  for (int i = 0; i < 100; ++i) circuits += circuit(i);
  EXPECT_EQ(refusal(circuits + straight_text("a")), "accepted");
  EXPECT_THAT(refusal(circuits + circuit(100) + straight_text("a")), HasSubstr("circuit: expected 1 to 100 circuits"));
  std::string loops = zone_head + straight_text("a");
  for (int i = 0; i < 1000; ++i) loops += "[[loop]]\n";
  EXPECT_THAT(refusal(loops), StartsWith("zone.missing"));
  EXPECT_THAT(refusal(loops + "[[loop]]\n"), HasSubstr("loop: expected at most 1000 of these, found 1001"));
}

TEST(TomlLimits, of_a_vehicle_are_the_diameter_of_the_tightest_bend) {
  const auto wide = [](const char* width, double radius_m, const std::string& table = "[vehicle]\nlength_m = 0.2\n") {
    const std::string vehicle = table.empty() ? table : table + "width_m = " + width + "\n";
    return refusal(zone_head + vehicle +
                   section_text("bend", "arc", "radius_m = " + std::to_string(radius_m) + "\nangle_deg = 90\n"));
  };
  EXPECT_EQ(wide("0.49", 0.25), "accepted");
  EXPECT_THAT(wide("0.5", 0.25), HasSubstr("vehicle.width_m: expected less than 0.5 m, because section 'bend' bends "
                                           "with a radius of 0.25 m, found 0.5"));
  EXPECT_THAT(wide("", 0.03125, ""), HasSubstr("vehicle: expected less than 0.0625 m"));
}

TEST(TomlLoops, end_where_a_path_comes_back_elsewhere_than_to_its_begin) {
  // A stem that leads into an oval and never comes back to itself.
  const std::string turn = "radius_m = 0.5\nangle_deg = 180\n";
  const std::string loop = straight_text("south") + section_text("east", "arc", turn) + straight_text("north") +
                           section_text("west", "arc", turn + "next = [\"south\"]\n");
  EXPECT_THAT(refusal(zone_head + "[circuit]\nname = \"r\"\nclosed = true\n" + straight_text("stem") + loop),
              HasSubstr("section[1]: the circuit 'r' is closed, but the path from its section 'stem' along"));
  // A loop of one section.
  const auto round = read_zone(zone_head + "[circuit]\nname = \"r\"\nclosed = true\n" +
                               section_text("round", "arc", "radius_m = 1\nangle_deg = 360\n"));
  ASSERT_TRUE(round) << to_string(round.error());
  ASSERT_EQ(round->loops.size(), 1U);
  EXPECT_THAT(round->loops[0].sections, ElementsAre(0U));
}

// Every element, each in the form in which the writer writes it.
const std::string yard_basics = R"(
[vehicle]
length_m = 0.25
width_m = 0.125

[profiles.slow]
speed_mps = 0.1
acceleration_mps2 = 0.2
braking_mps2 = 0.3

[profiles.medium]
speed_mps = 0.4
acceleration_mps2 = 0.5
braking_mps2 = 0.6

[profiles.fast]
speed_mps = 0.7
acceleration_mps2 = 0.8
braking_mps2 = 0.9

[crossings]
clearance_m = 0.03125

[waypoints]
spacing_m = 0.75
nodes_only = true
edges_are_sections = true
)";
const std::string yard_sections = R"(
[[section]]
name = "south"
kind = "straight"
length_m = 2
speed_mps_max = 0.5
start_node = "N1"
next = ["spur", "east"]

[[section]]
name = "east"
kind = "arc"
radius_m = 0.5
angle_deg = 180

[[section]]
name = "north"
kind = "straight"
length_m = 2
pivots = true

[[section]]
name = "west"
kind = "arc"
radius_m = 0.5
angle_deg = 180
next = ["south"]

[[section]]
name = "spur"
start = { x = 2, y = 0, heading_deg = 0 }
kind = "clothoid"
length_m = 0.75
curvature_start_per_m = 0
curvature_end_per_m = -1.5
speed_mps_max = 0.25
end_node = "N9"
)";
const std::string yard_limits = R"(
[[limit]]
section = "south"
speed_mps_max = 0.5

[[limit]]
section = "spur"
speed_mps_max = 0.25
)";
const std::string yard_beacons_and_tags = R"(
[beacons]
pitch_m = 0.5
origin = [1, -0.25]
rotation_deg = 90
columns = 3
rows = 2
first_number = 5000

[[tag]]
number = 7
section = "south"
s_m = 0.5

[[tag]]
number = 8
section = "spur"
s_m = 0.25
)";
const std::string yard_stations = R"(
[[station]]
name = "dock"
section = "north"
s_m = 1

[[station]]
name = "plug"
kind = "charger"
section = "spur"
s_m = 0.75
)";
const std::string yard_starts_and_loops = R"(
[[start]]
section = "north"
s_m = 1

[[loop]]
name = "oval"
sections = ["south", "east", "north", "west"]
)";
const std::string yard_closed_sections = "\n[closed]\nsections = [\"east\", \"spur\"]\n";
const std::string yard_priorities = "\n[priorities]\n\"A/1\" = 3\n\"B/2\" = 999\n";

TEST(TomlWriter, writes_every_element_as_it_was_written) {
  const std::string text = "name = \"yard\"\nformat_version = 1\n" + yard_basics + yard_sections +
                           yard_beacons_and_tags + yard_stations + yard_starts_and_loops + yard_closed_sections +
                           yard_priorities;
  const auto zone = read_zone(text);
  ASSERT_TRUE(zone) << to_string(zone.error());
  std::vector<Diagnostic> lost;
  const auto written = TomlCircuitFactory{}.written(*zone, lost);
  ASSERT_TRUE(written) << to_string(written.error());
  EXPECT_EQ(written->text, text);
  EXPECT_EQ(written->origin, "yard.toml");
  EXPECT_EQ(written->format, "toml");
  EXPECT_THAT(lost, IsEmpty());
  const std::string without_first = yard_basics.substr(1);
  EXPECT_EQ(sidecar_text(*zone, {.limits = true, .stations = true, .closed = true}),
            without_first + yard_limits + yard_beacons_and_tags + yard_stations + yard_starts_and_loops +
                yard_closed_sections + yard_priorities);
  EXPECT_EQ(sidecar_text(*zone, {.limits = false, .stations = false, .closed = false}),
            without_first + yard_beacons_and_tags + yard_starts_and_loops + yard_priorities);
}

TEST(TomlWriter, writes_no_table_for_what_is_not_there) {
  const std::string plain = "name = \"plain\"\nformat_version = 1\n" +
                            yard_basics.substr(0, yard_basics.find("nodes_only")) +
                            "\n[[section]]\nname = \"a\"\nkind = \"straight\"\nlength_m = 2\n";
  const auto zone = read_zone(plain);
  ASSERT_TRUE(zone) << to_string(zone.error());
  EXPECT_EQ(*native_text(*zone), plain);
}

TEST(TomlWriter, refuses_each_name_that_no_file_can_hold) {
  const auto zone =
      read_zone("name = \"yard\"\nformat_version = 1\n" + yard_sections + yard_stations + yard_starts_and_loops);
  ASSERT_TRUE(zone) << to_string(zone.error());
  const auto refused = [&](const auto& change) {
    TrafficZone changed = *zone;
    change(changed);
    const auto text = native_text(changed);
    EXPECT_FALSE(text);
    return text ? "" : text.error().location;
  };
  EXPECT_EQ(refused([](TrafficZone& changed) { changed.name = "a\tb"; }), "a\tb");
  EXPECT_EQ(refused([](TrafficZone& changed) { changed.stations[1].name = "\n"; }), "\n");
  EXPECT_EQ(refused([](TrafficZone& changed) { changed.loops[0].name = ""; }), "");
  EXPECT_EQ(refused([](TrafficZone& changed) { changed.name = std::string(257, 'n'); }), std::string(64, 'n'));
  EXPECT_TRUE(native_text(*zone));
}

}  // namespace
}  // namespace cosiva::zone
