// The zones that the standard's own examples and third-party files become.
#include <gmock/gmock.h>

#include <cmath>

#include "cosiva/zone/edit/edit.h"
#include "cosiva/zone/lif/lif_fixture.h"

namespace cosiva::zone::lif {
namespace {

using namespace testing;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// The expected zone of a file; lengths are sums of distances between its nodes.
struct Expected {
  const char* file;
  std::size_t sections;
  double length_m;
  std::size_t stations;
};

std::ostream& operator<<(std::ostream& out, const Expected& expected) { return out << expected.file; }

const Expected all_files[] = {
    {"10.01-forward-edge.lif.json", 1, 11.0, 0},
    {"10.02-bidirectional-edge.lif.json", 2, 22.0, 0},
    {"10.03-counter-clockwise-rotation-on-node.lif.json", 2, 22.0, 0},
    {"10.04-omnidirectional-edge.lif.json", 2, 22.0, 0},
    {"10.05-multiple-layouts-in-one-lif.lif.json", 2, 11.4, 0},
    {"10.06-station-with-one-node.lif.json", 2, 22.0, 1},
    {"10.07-station-with-two-nodes.lif.json", 6,
     9.2 + 3.4 + std::sqrt(9.2 * 9.2 + 3.4 * 3.4) + 9.2 + std::sqrt(0.2 * 0.2 + 3.2 * 3.2) +
         std::sqrt(9.4 * 9.4 + 3.2 * 3.2),
     2},
    {"10.08-station-with-two-nodes-restricted-for-different-vehicle-type.lif.json", 2, 4.0, 1},
    {"10.09-rotation-station.lif.json", 2, 7.0, 1},
    {"10.10-station-with-three-nodes-restricted-to-different-vehicle-typ.lif.json", 4, 13.0, 2},
    {"10.11-multiple-edges-with-load-restrictions.lif.json", 8, 70.0, 1},
    {"10.12-multiple-edges-between-same-two-nodes-for-different-vehiclet.lif.json", 3, 15.0, 1},
    {"10.13-battery-charging-station.lif.json", 2, 10.0, 1},
    {"10.14-two-levels-of-a-facility-in-one-lif-file.lif.json", 3, 11.8, 0},
    {"10.15-rack-station-modelled-by-three-stations.lif.json", 2, 4.0, 3},
    {"10.16-rack-station-modelled-by-three-nodes.lif.json", 6, 12.0, 3},
    {"10.18-manufacturer-specific-action-on-an-edge.lif.json", 2, 22.0, 0},
    {"10.19-forward-edge-with-two-vehicle-types-with-differing-orientati.lif.json", 1, 11.0, 0},
    {"continua-example.lif.json", 1, 1000.0 * std::sqrt(2.0), 3},
    {"vda5050-core-sample.lif.json", 1, 5.0, 1},
};

class LifFile : public ::testing::TestWithParam<Expected> {};

TEST_P(LifFile, becomes_a_zone_with_all_its_sections) {
  const Expected& expected = GetParam();
  const TrafficZone zone = read_file(expected.file);
  EXPECT_EQ(zone.circuit.size(), expected.sections);
  EXPECT_NEAR(zone.circuit.total_length_m(), expected.length_m, 1e-9);
  EXPECT_EQ(zone.stations.size(), expected.stations);
  EXPECT_TRUE(zone.edges_are_sections);
  EXPECT_FALSE(zone.waypoints.empty());
}

INSTANTIATE_TEST_SUITE_P(OfOthers, LifFile, ::testing::ValuesIn(all_files));

TEST(LifFiles, are_22_and_all_are_read) {
  std::size_t count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(testdata())) {
    if (entry.path().extension() != ".json") continue;
    ++count;
    const auto zone = read_text(file_text(entry.path()));
    EXPECT_TRUE(zone) << entry.path() << ": " << to_string(zone.error());
  }
  EXPECT_EQ(count, 22U);
}

/// The first file of a folder whose name begins so.
std::string name_of(const std::filesystem::path& folder, const std::string& begin) {
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (entry.path().filename().string().starts_with(begin)) return entry.path().filename().string();
  ADD_FAILURE() << folder << " has no " << begin;
  return {};
}

// The draft of 2.0 has the examples of 1.0 with its own properties.
TEST(LifFiles, of_the_draft_of_version_2_become_the_same_zones_as_their_counterparts) {
  for (int number = 1; number <= 19; ++number) {
    const std::string digits = (number < 10 ? "0" : "") + std::to_string(number);
    const TrafficZone first = read_file(name_of(testdata(), "10." + digits));
    const TrafficZone second = read_file("2.0-draft/" + name_of(testdata() / "2.0-draft", "11." + digits));
    EXPECT_EQ(second.stations.size(), first.stations.size()) << number;
    EXPECT_EQ(second.circuit.size(), first.circuit.size()) << number;
    EXPECT_TRUE(same_geometry(second, first)) << number;
    for (std::size_t i = 0; i < first.stations.size(); ++i)
      EXPECT_EQ(second.stations[i].name, first.stations[i].name) << number;
    EXPECT_EQ(diagnostic_with(second, "is no field of LIF"), nullptr) << number;
  }
}

TEST(LifFiles, report_what_was_repaired) {
  const TrafficZone zone = read_file("10.06-station-with-one-node.lif.json");
  const Diagnostic* version = diagnostic_at(zone, "metaInformation.lifVersion");
  ASSERT_NE(version, nullptr);
  EXPECT_EQ(version->kind, Diagnostic::Kind::mended);
  EXPECT_THAT(version->text, HasSubstr("'0.11.0'"));
  const Diagnostic* height = diagnostic_at(zone, "layouts[0].stations[0].stationHeight");
  ASSERT_NE(height, nullptr);
  EXPECT_EQ(height->kind, Diagnostic::Kind::mended);

  EXPECT_EQ(diagnostic_at(read_file("10.01-forward-edge.lif.json"), "layouts[0].stations")->kind,
            Diagnostic::Kind::mended);
}

TEST(LifFiles, report_what_is_lost) {
  const TrafficZone orientation = read_file("10.02-bidirectional-edge.lif.json");
  const Diagnostic* diagnostic =
      diagnostic_at(orientation, "layouts[0].edges[1].vehicleTypeEdgeProperties[0].vehicleOrientation");
  ASSERT_NE(diagnostic, nullptr);
  EXPECT_EQ(diagnostic->kind, Diagnostic::Kind::lost);
  EXPECT_THAT(diagnostic->text, HasSubstr("forwards"));

  EXPECT_NE(diagnostic_with(read_file("10.11-multiple-edges-with-load-restrictions.lif.json"), "'loadRestriction'"),
            nullptr);
  EXPECT_NE(diagnostic_with(read_file("10.18-manufacturer-specific-action-on-an-edge.lif.json"), "on edges but drive"),
            nullptr);
  EXPECT_NE(diagnostic_with(read_file("10.03-counter-clockwise-rotation-on-node.lif.json"), "in one direction only"),
            nullptr);
}

TEST(LifFiles, one_diagnostic_covers_all_of_its_kind) {
  const TrafficZone zone = read_file("kit-ifl-lab.lif.json");
  const Diagnostic* diagnostic = diagnostic_at(zone, "layouts[0].nodes[0].mapId");
  ASSERT_NE(diagnostic, nullptr);
  EXPECT_THAT(diagnostic->text,
              HasSubstr("(10 times, also at layouts[0].nodes[1].mapId, layouts[0].nodes[2].mapId, …)"));
}

TEST(LifFiles, a_real_laboratory_has_its_stations_and_chargers) {
  const TrafficZone zone = read_file("kit-ifl-lab.lif.json");
  EXPECT_EQ(zone.name, "IndustrialMobileRoboticsLab_ExampleLayout");
  EXPECT_EQ(zone.circuit.size(), 16U);
  ASSERT_EQ(zone.stations.size(), 6U);
  for (const auto& station : zone.stations)
    EXPECT_EQ(station.kind, station.name.starts_with("C") ? StationKind::charger : StationKind::stop) << station.name;
  const Point2 at = position(zone.circuit.pose_at(zone.find_station("S2")->position));
  EXPECT_LT(distance(at, Point2{1.49, -1.86}), 1e-9);
  EXPECT_NE(diagnostic_with(zone, "'stationType'"), nullptr);
}

TEST(LifFiles, waypoints_have_the_ids_of_nodes_common_to_several_sections) {
  const TrafficZone zone = read_file("kit-ifl-lab.lif.json");
  const auto at_n9 = zone.find_waypoints("N9");
  ASSERT_EQ(at_n9.size(), 3U);  // E5, E6 and E15 leave there
  for (const std::size_t index : at_n9) {
    EXPECT_LT(distance(position(zone.circuit.pose_at(zone.waypoints[index].position)), Point2{-3.0, 0.0}), 1e-9);
  }
  // No edge leaves N2: the ends of both edges have its id.
  EXPECT_EQ(zone.find_waypoints("N2").size(), 2U);
}

TEST(LifFiles, nodes_at_one_point_are_one) {
  const TrafficZone rotation = read_file("10.09-rotation-station.lif.json");
  const auto in = rotation.circuit.find("N1-N11");
  const auto out = rotation.circuit.find("N21-N2");
  ASSERT_TRUE(in && out);
  EXPECT_THAT(rotation.circuit.part(*in).next, ElementsAre(*out));
  EXPECT_NEAR(rotation.circuit.turn_at(*in, *out), -pi / 2.0, 1e-12);
  EXPECT_FALSE(rotation.circuit.find("N11-N21"));
  EXPECT_NE(diagnostic_with(rotation, "has no length"), nullptr);

  const TrafficZone rack = read_file("10.16-rack-station-modelled-by-three-nodes.lif.json");
  for (const char* into : {"N2-NA", "N2-NB", "N2-NC"})
    EXPECT_EQ(rack.circuit.next(*rack.circuit.find(into)).size(), 3U);
  EXPECT_EQ(rack.circuit.part(rack.find_station("Shelf on Level B")->position.section).name, "N2-NB");
}

TEST(LifFiles, lifts_are_lost) {
  const TrafficZone zone = read_file("10.14-two-levels-of-a-facility-in-one-lif-file.lif.json");
  EXPECT_FALSE(zone.circuit.find("N2-N102"));
  const Diagnostic* diagnostic = diagnostic_at(zone, "layouts[0].edges[1]");
  ASSERT_NE(diagnostic, nullptr);
  EXPECT_EQ(diagnostic->kind, Diagnostic::Kind::lost);
  EXPECT_THAT(diagnostic->text, HasSubstr("level"));
}

TEST(LifFiles, chargers_are_where_charging_is_offered) {
  EXPECT_EQ(read_file("10.13-battery-charging-station.lif.json").stations[0].kind, StationKind::charger);
  EXPECT_EQ(read_file("10.06-station-with-one-node.lif.json").stations[0].kind, StationKind::stop);
  // 10.11 offers it at N0, but has no stations at all.
  const TrafficZone lonely = read_file("10.11-multiple-edges-with-load-restrictions.lif.json");
  ASSERT_NE(lonely.find_station("N0"), nullptr);
  EXPECT_EQ(lonely.find_station("N0")->kind, StationKind::charger);
}

TEST(LifFiles, several_interaction_nodes_are_several_stations) {
  const TrafficZone zone = read_file("10.07-station-with-two-nodes.lif.json");
  EXPECT_LT(distance(position(zone.circuit.pose_at(zone.find_station("SOURCE_01")->position)), Point2{9.2, 3.4}), 1e-9);
  EXPECT_LT(distance(position(zone.circuit.pose_at(zone.find_station("SOURCE_01.2")->position)), Point2{9.4, 3.2}),
            1e-9);
}

TEST(LifFiles, the_vehicle_type_with_most_edges_is_taken_unless_the_sidecar_names_another) {
  const std::string file = "10.08-station-with-two-nodes-restricted-for-different-vehicle-type.lif.json";
  EXPECT_TRUE(read_file(file).circuit.find("N1-N2"));
  const TrafficZone other = read_file(file, "[import]\nvehicle_type = \"Vehicle_Type_2\"\n");
  EXPECT_TRUE(other.circuit.find("N4-N3"));
  EXPECT_FALSE(other.circuit.find("N1-N2"));
  EXPECT_NE(diagnostic_with(other, "2 of 4 edges and 2 of 4 nodes are closed to vehicle type 'Vehicle_Type_2'"),
            nullptr);

  const auto wrong = read_text(file_text(testdata() / file), "[import]\nvehicle_type = \"Truck\"\n");
  ASSERT_FALSE(wrong);
  EXPECT_EQ(wrong.error().code, "zone.field");
  EXPECT_THAT(wrong.error().message, HasSubstr("Vehicle_Type_1, Vehicle_Type_2"));
}

TEST(LifFiles, one_of_several_layouts_can_be_taken_alone) {
  const std::string file = "10.05-multiple-layouts-in-one-lif.lif.json";
  EXPECT_NEAR(read_file(file, "[import]\nlayout = \"Layout_Upper_Level\"\n").circuit.total_length_m(), 0.4, 1e-9);
  const auto wrong = read_text(file_text(testdata() / file), "[import]\nlayout = \"Cellar\"\n");
  ASSERT_FALSE(wrong);
  EXPECT_THAT(wrong.error().message, HasSubstr("Layout_Ground_Level, Layout_Upper_Level"));
}

TEST(LifFiles, a_file_can_be_scaled_to_a_laboratory) {
  const TrafficZone zone = read_file("10.02-bidirectional-edge.lif.json", "[import]\nscale = 0.1\n");
  EXPECT_NEAR(zone.circuit.total_length_m(), 2.2, 1e-9);
}

/// Length of a quadratic Bézier curve by a sum of many chords.
double bezier_length(Point2 a, Point2 b, Point2 c) {
  double length = 0.0;
  Point2 before = a;
  for (int i = 1; i <= 20000; ++i) {
    const double t = i / 20000.0;
    const double u = 1.0 - t;
    const Point2 here{u * u * a.x_m + 2.0 * u * t * b.x_m + t * t * c.x_m,
                      u * u * a.y_m + 2.0 * u * t * b.y_m + t * t * c.y_m};
    length += distance(before, here);
    before = here;
  }
  return length;
}

// 10.17: control points (0,0) (0,1.8) (3.6,1.8) (3.6,0), knots 0 0 0 ½ 1 1 1: two parabolas that meet in (1.8, 1.8).
// From (0,0)–(3.6,0) to its nodes (5,0)–(15,0) it is moved by 5 m and stretched by 10/3.6.
TEST(LifFiles, a_trajectory_that_misses_its_nodes_is_moved_and_stretched) {
  const TrafficZone zone = read_file("10.17-edge-with-trajectory-definition.lif.json");
  const double one = bezier_length({0.0, 0.0}, {0.0, 1.8}, {1.8, 1.8}) * 10.0 / 3.6;
  EXPECT_NEAR(zone.circuit.total_length_m(), 4.0 * one, 4.0 * one * 1e-4);
  EXPECT_EQ(zone.circuit.section(*zone.circuit.find("N1-N2")).start().x_m, 5.0);
  EXPECT_NEAR(zone.circuit.section(*zone.circuit.find("N1-N2")).start().heading_rad, pi / 2.0, 1e-9);
  EXPECT_LT(zone.circuit.locate({10.0, 5.0}).distance_m, 1e-3);
  EXPECT_LT(zone.circuit.locate({10.0, -5.0}).distance_m, 1e-3);
  const Diagnostic* diagnostic = diagnostic_at(zone, "layouts[0].edges[0].trajectory");
  ASSERT_NE(diagnostic, nullptr);
  EXPECT_EQ(diagnostic->kind, Diagnostic::Kind::mended);
  EXPECT_THAT(diagnostic->text, HasSubstr("misses its nodes by 11.400 m"));
  EXPECT_THAT(diagnostic->text, HasSubstr("stretched by 2.778"));
  EXPECT_NE(diagnostic_with(zone, "followed within"), nullptr);
}

TEST(LifFiles, a_third_party_fixture_of_faults_is_read_too) {
  const TrafficZone zone = read_file("continua-example.lif.json", "[import]\nvehicle_type = \"vehicle-001\"\n");
  const auto edge = zone.circuit.find("edge-001");
  ASSERT_TRUE(edge);
  EXPECT_EQ(zone.circuit.part(*edge).speed_mps_max, 1.5);
  EXPECT_EQ(diagnostic_at(zone, "layouts[0].nodes[0].vehicleTypeNodeProperties[0].theta")->kind,
            Diagnostic::Kind::mended);
  const std::string trajectory = "layouts[0].edges[0].vehicleTypeEdgeProperties[0].trajectory";
  EXPECT_EQ(diagnostic_at(zone, trajectory + ".degree")->kind, Diagnostic::Kind::mended);
  EXPECT_EQ(diagnostic_at(zone, trajectory + ".knotVector")->kind, Diagnostic::Kind::mended);
  EXPECT_EQ(diagnostic_at(zone, trajectory + ".controlPoints[1].weight")->kind, Diagnostic::Kind::mended);
  // Its one edge leads to a node that is closed to it.
  EXPECT_NE(diagnostic_with(zone, "all nodes are open"), nullptr);
}

}  // namespace
}  // namespace cosiva::zone::lif
