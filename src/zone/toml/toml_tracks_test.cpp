// Circuits, branches, pivots, loops, closed sections, stations by kind: the elements that turn a single loop into a
// factory.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cosiva/zone/testing/test_zones.h"
#include "cosiva/zone/toml/toml_factory.h"

namespace cosiva::zone {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::read_zone;
using ::testing::SizeIs;
using ::testing::StartsWith;

const std::string head = "name = \"z\"\nformat_version = 1\n";

std::string straight(const std::string& name, const std::string& more = {}) {
  return "[[section]]\nname = \"" + name + "\"\nkind = \"straight\"\nlength_m = 2.0\n" + more;
}
std::string half_turn(const std::string& name, const std::string& more = {}) {
  return "[[section]]\nname = \"" + name + "\"\nkind = \"arc\"\nradius_m = 0.5\nangle_deg = 180\n" + more;
}
std::string error_of(const std::string& text) {
  const auto zone = read_zone(text);
  return zone ? "no error" : zone.error().code + " " + to_string(zone.error());
}

const std::string oval = straight("south") + half_turn("east") + straight("north") + half_turn("west");

// Circuits
// ---------------------------------------------------------------------------------------------------------

TEST(TomlTracks, of_several_circuits_chain_each_by_itself) {
  const auto zone = read_zone(head + R"([[circuit]]
name = "inner"
closed = true
[[circuit]]
name = "outer"
start = { x = 0, y = -5, heading_deg = 0 }
)" + straight("a", "circuit = \"inner\"\n") +
                              half_turn("b") + straight("p", "circuit = \"outer\"\n") + straight("q") +
                              straight("c", "circuit = \"inner\"\n") + half_turn("d"));
  ASSERT_TRUE(zone) << to_string(zone.error());
  const Circuit& circuit = zone->circuit;
  const auto id = [&](std::string_view name) { return circuit.find(name).value(); };
  EXPECT_THAT(circuit.next(id("b")), ElementsAre(id("c")));
  EXPECT_THAT(circuit.next(id("d")), ElementsAre(id("a")));
  EXPECT_THAT(circuit.next(id("p")), ElementsAre(id("q")));
  EXPECT_THAT(circuit.next(id("q")), IsEmpty());
  EXPECT_EQ(circuit.section(id("p")).start(), (Pose2{0.0, -5.0, 0.0}));
  // The closed one is a loop; the open one is none.
  ASSERT_THAT(zone->loops, SizeIs(1));
  EXPECT_EQ(zone->loops[0].name, "inner");
  EXPECT_THAT(zone->loops[0].sections, ElementsAre(id("a"), id("b"), id("c"), id("d")));
}

TEST(TomlTracks, of_one_closed_circuit_are_a_loop_only_with_a_name) {
  EXPECT_THAT(read_zone(head + "[circuit]\nclosed = true\n" + oval)->loops, IsEmpty());
  EXPECT_THAT(read_zone(head + "[circuit]\nname = \"r\"\nclosed = true\n" + oval)->loops, SizeIs(1));
  EXPECT_THAT(read_zone(head + "[circuit]\nname = \"r\"\n" + oval)->loops, IsEmpty());
}

TEST(TomlTracks, that_name_no_circuit_or_one_twice_are_refused) {
  EXPECT_THAT(error_of(head + "[[circuit]]\nname = \"r\"\n" + straight("a", "circuit = \"q\"\n")),
              StartsWith("zone.reference test.toml:9: section[1].circuit: expected the name of a circuit"));
  EXPECT_THAT(error_of(head + "[[circuit]]\nname = \"r\"\n[[circuit]]\nname = \"r\"\n" + straight("a")),
              StartsWith("zone.duplicate test.toml:6: circuit[2].name"));
  EXPECT_THAT(error_of(head + "[[circuit]]\nclosed = true\n" + oval), StartsWith("zone.missing"));
  EXPECT_THAT(error_of("circuit = []\n" + head + oval), StartsWith("zone.size"));
  EXPECT_THAT(error_of("circuit = 3\n" + head + oval), StartsWith("zone.field"));
}

TEST(TomlTracks, of_a_closed_circuit_that_leads_elsewhere_are_refused) {
  EXPECT_THAT(
      error_of(head + "[circuit]\nname = \"r\"\nclosed = true\n" + straight("a") + straight("b", "next = []\n")),
      HasSubstr("zone.loop test.toml:6: section[1]: the circuit 'r' is closed, but"));
}

// Branches and pivots
// ---------------------------------------------------------------------------------------------------------

TEST(TomlTracks, branch_off_from_the_end_of_another) {
  const auto zone = read_zone(head + straight("stem") + straight("on") + half_turn("left", "from = \"stem\"\n") +
                              straight("far") + half_turn("other", "from = \"stem\"\n"));
  ASSERT_TRUE(zone) << to_string(zone.error());
  const Circuit& circuit = zone->circuit;
  EXPECT_THAT(circuit.next(0), ElementsAre(1, 2, 4));  // the default first, branches in the file's order
  EXPECT_THAT(circuit.next(1), IsEmpty());             // "left" does not follow "on"
  EXPECT_THAT(circuit.next(2), ElementsAre(3));
  EXPECT_THAT(circuit.next(3), IsEmpty());
  EXPECT_EQ(circuit.section(2).start(), circuit.section(0).end());
}

TEST(TomlTracks, that_branch_off_from_a_later_or_missing_section_are_refused) {
  EXPECT_THAT(error_of(head + straight("a", "from = \"b\"\n") + straight("b")),
              StartsWith("zone.reference test.toml:7: section[1].from: expected the name of a section further up"));
  EXPECT_THAT(error_of(head + straight("a", "from = \"a\"\n")), StartsWith("zone.reference"));
  EXPECT_THAT(
      error_of(head + straight("a") + straight("b", "from = \"a\"\nstart = { x = 0, y = 0, heading_deg = 0 }\n")),
      StartsWith("zone.field test.toml:11: section[2].from: a section begins at"));
  EXPECT_THAT(error_of(head + straight("a", "next = [\"b\"]\n") + straight("b", "from = \"a\"\n")),
              StartsWith("zone.duplicate"));
}

TEST(TomlTracks, merge_where_two_lead_to_one) {
  const auto zone = read_zone(head + straight("a", "next = [\"c\"]\n") +
                              straight("b", "start = { x = 0, y = 0, heading_deg = 0 }\nnext = [\"c\"]\n") +
                              straight("c", "start = { x = 2, y = 0, heading_deg = 0 }\n"));
  ASSERT_TRUE(zone) << to_string(zone.error());
  EXPECT_THAT(zone->circuit.previous(2), ElementsAre(0, 1));
}

TEST(TomlTracks, turn_at_once_only_where_they_pivot) {
  const std::string after = straight("b", "start = { x = 2, y = 0, heading_deg = 90 }\n");
  EXPECT_THAT(error_of(head + straight("a") + after), StartsWith("circuit.kink"));
  const auto zone = read_zone(head + straight("a", "pivots = true\n") + after);
  ASSERT_TRUE(zone) << to_string(zone.error());
  EXPECT_TRUE(zone->circuit.part(0).pivots);
  EXPECT_NEAR(zone->circuit.turn_at(0, 1), pi / 2.0, 1e-12);
}

TEST(TomlTracks, that_fork_into_more_branches_than_allowed_are_refused) {
  std::string text = head + straight("a");
  for (int i = 0; i < 65; ++i) text += straight("b" + std::to_string(i), "from = \"a\"\n");
  EXPECT_THAT(error_of(text), StartsWith("zone.size"));
}

// Shapes and angles in other forms
// ------------------------------------------------------------------------------------------------------------

TEST(TomlTracks, define_arcs_and_clothoids_in_two_forms_but_not_in_both) {
  const auto zone = read_zone(head + R"([[section]]
name = "a"
kind = "arc"
length_m = 1.5
curvature_per_m = -2.0
[[section]]
name = "b"
kind = "clothoid"
length_m = 0.5
curvature_start_per_m = -2.0
curvature_rate_per_m2 = 4.0
[circuit]
start = { x = 0, y = 0, heading_rad = 0.5 }
)");
  ASSERT_TRUE(zone) << to_string(zone.error());
  EXPECT_EQ(zone->circuit.section(0).curvature_at(0.0), -2.0);
  EXPECT_EQ(zone->circuit.section(0).length_m(), 1.5);
  EXPECT_EQ(zone->circuit.section(1).curvature_at(0.5), 0.0);
  EXPECT_EQ(zone->circuit.section(0).start().heading_rad, 0.5);
  EXPECT_THAT(error_of(head + half_turn("a", "length_m = 1.0\ncurvature_per_m = 1.0\n")),
              HasSubstr("section[1].radius_m: give an arc either"));
  EXPECT_THAT(error_of(head + straight("a", "start = { x = 0, y = 0, heading_deg = 0, heading_rad = 0 }\n")),
              HasSubstr("either in degrees or in radians"));
  EXPECT_THAT(error_of(head + straight("a", "start = { x = 0, y = 0, heading_rad = 7.0 }\n")),
              HasSubstr("expected radians within ±6.28"));
}

// Elements on the sections --------------------------------------------------------------------------------------------

TEST(TomlTables, distinguish_stations_from_chargers_and_lay_a_waypoint_at_each) {
  const auto zone = read_zone(head + straight("a") +
                              "[[station]]\nname = \"dock\"\nsection = \"a\"\ns_m = 0.73\n"
                              "[[station]]\nname = \"plug\"\nkind = \"charger\"\nsection = \"a\"\ns_m = 1.11\n"
                              "[[station]]\nname = \"stop\"\nkind = \"stop\"\nsection = \"a\"\ns_m = 1.5\n");
  ASSERT_TRUE(zone) << to_string(zone.error());
  EXPECT_EQ(zone->find_station("dock")->kind, StationKind::stop);
  EXPECT_EQ(zone->find_station("plug")->kind, StationKind::charger);
  for (const Station& station : zone->stations)
    EXPECT_NEAR(zone->waypoints[zone->waypoint_ahead(station.position)].position.s_m, station.position.s_m, 1e-9);
  EXPECT_THAT(
      error_of(head + straight("a") + "[[station]]\nname = \"dock\"\nkind = \"bar\"\nsection = \"a\"\ns_m = 0.73\n"),
      HasSubstr("station[1].kind: expected \"stop\" or \"charger\", found \"bar\""));
}

TEST(TomlTables, take_a_loop_only_where_each_section_follows_the_one_before_and_the_first_the_last) {
  const std::string closed = head + "[circuit]\nclosed = true\n" + oval;
  const auto zone =
      read_zone(closed + "[[loop]]\nname = \"l\"\nsections = [\"north\", \"west\", \"south\", \"east\"]\n");
  ASSERT_TRUE(zone) << to_string(zone.error());
  EXPECT_THAT(zone->find_loop("l")->sections, ElementsAre(2, 3, 0, 1));
  const auto loop = [&](const std::string& sections) {
    return error_of(closed + "[[loop]]\nname = \"l\"\n" + sections);
  };
  EXPECT_THAT(loop("sections = [\"north\", \"south\"]\n"), HasSubstr("zone.loop"));
  EXPECT_THAT(loop("sections = [\"north\", \"south\"]\n"), HasSubstr("'south' does not follow 'north'"));
  EXPECT_THAT(loop("sections = [\"south\", \"east\", \"north\"]\n"), HasSubstr("'south' does not follow 'north'"));
  EXPECT_THAT(loop("sections = []\n"), StartsWith("zone.missing"));
  EXPECT_THAT(loop(""), StartsWith("zone.missing"));
  EXPECT_THAT(loop("sections = [\"nowhere\"]\n"), StartsWith("zone.reference"));
  EXPECT_THAT(error_of(head + "[circuit]\nname = \"l\"\nclosed = true\n" + oval +
                       "[[loop]]\nname = \"l\"\nsections = [\"south\"]\n"),
              StartsWith("zone.duplicate"));
}

TEST(TomlTables, close_sections_from_the_beginning_each_once_and_sorted) {
  const auto zone = read_zone(head + "[closed]\nsections = [\"north\", \"south\", \"north\"]\n" + oval);
  ASSERT_TRUE(zone) << to_string(zone.error());
  EXPECT_THAT(zone->closed, ElementsAre(0, 2));
  EXPECT_THAT(error_of(head + "[closed]\nsections = [\"up\"]\n" + oval),
              StartsWith("zone.reference test.toml:4: closed.sections"));
  EXPECT_THAT(error_of(head + "[closed]\nsection = [\"south\"]\n" + oval), HasSubstr("did you mean \"sections\"?"));
}

TEST(TomlTables, lay_no_waypoint_between_nodes_with_nodes_only) {
  const auto zone = read_zone(head + "[waypoints]\nnodes_only = true\n" + straight("a") + straight("b"));
  ASSERT_TRUE(zone) << to_string(zone.error());
  EXPECT_TRUE(zone->nodes_only);
  EXPECT_THAT(zone->waypoints, SizeIs(3));  // both starts and the dead end
}

TEST(TomlTables, name_waypoints_after_the_nodes_that_sections_name) {
  const auto zone = read_zone(head + straight("a", "start_node = \"N1\"\n") + straight("b", "end_node = \"N9\"\n"));
  ASSERT_TRUE(zone) << to_string(zone.error());
  EXPECT_EQ(zone->waypoints.front().id, "N1");
  EXPECT_EQ(zone->waypoints.back().id, "N9");
}

TEST(TomlTables, turn_the_beacons) {
  const auto zone =
      read_zone(head + straight("a") +
                "[beacons]\npitch_m = 0.5\norigin = [1.0, 0.0]\nrotation_deg = 90\ncolumns = 3\nrows = 2\n");
  ASSERT_TRUE(zone) << to_string(zone.error());
  EXPECT_NEAR(zone->beacons->rotation_rad, pi / 2.0, 1e-15);
  EXPECT_NEAR(zone->beacons->at(2, 0).y_m, 1.0, 1e-12);
  const auto covering =
      read_zone(head + straight("a") + "[beacons]\npitch_m = 0.5\nrotation_deg = 30\ncover = \"zone\"\n");
  ASSERT_TRUE(covering) << to_string(covering.error());
  for (double s = 0.0; s <= 2.0; s += 0.1) EXPECT_TRUE(covering->beacons->nearest({s, 0.0}));
  EXPECT_THAT(error_of(head + straight("a") + "[beacons]\npitch_m = 1\ncover = \"zone\"\nrotation_deg = 400\n"),
              HasSubstr("beacons.rotation_deg: expected degrees within ±360, found 400"));
}

TEST(TomlTables, of_more_than_the_limit_are_refused) {
  std::string text = head + straight("a");
  for (int i = 0; i <= 10'000; ++i) text += "[[start]]\nsection = \"a\"\ns_m = 1\n";
  EXPECT_THAT(error_of(text), StartsWith("zone.size"));
}

// All faults
// ------------------------------------------------------------------------------------------------------------

TEST(TomlFaults, list_every_gap_and_kink_and_bend_that_is_too_tight) {
  const std::string text = head + straight("a") + straight("b", "start = { x = 2.5, y = 0, heading_deg = 0 }\n") +
                           straight("c", "start = { x = 4.5, y = 0, heading_deg = 10 }\n") +
                           "[[section]]\nname = \"d\"\nkind = \"arc\"\nradius_m = 0.05\nangle_deg = 90\n";
  const ZoneConfiguration configuration{"toml", "test.toml", text};
  const auto all = faults(configuration);
  ASSERT_THAT(all, SizeIs(3));
  EXPECT_EQ(all[0].code, "zone.vehicle");
  EXPECT_EQ(all[1].code, "circuit.gap");
  EXPECT_THAT(all[1].location, StartsWith("test.toml:3: section[1].next"));
  EXPECT_EQ(all[2].code, "circuit.kink");
  EXPECT_THAT(all[2].location, StartsWith("test.toml:7: section[2].next"));
  EXPECT_EQ(Rtm::initialise(configuration).error(), all[0]);
}

TEST(TomlFaults, are_none_for_a_good_file_and_one_for_an_unknown_format) {
  EXPECT_THAT(faults({"toml", "test.toml", head + straight("a")}), IsEmpty());
  EXPECT_THAT(faults({"toml", "test.toml", "name ="}), SizeIs(1));
  ASSERT_THAT(faults({"cad", "test.cad", ""}), SizeIs(1));
  EXPECT_EQ(faults({"cad", "test.cad", ""})[0].location, "test.cad");
}

TEST(TomlFaults, are_a_hundred_at_most) {
  std::string text = head;
  for (int i = 0; i < 300; ++i)
    text +=
        straight("s" + std::to_string(i), "start = { x = 0, y = " + std::to_string(10 * i) + ", heading_deg = 0 }\n");
  EXPECT_THAT(faults({"toml", "test.toml", text}), SizeIs(100));
}

}  // namespace
}  // namespace cosiva::zone
