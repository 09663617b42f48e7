// Files of the draft of LIF 2.0, as the tables of its chapter 8.3 define them.
#include <gmock/gmock.h>

#include <string>

#include "cosiva/zone/lif/lif_fixture.h"

namespace cosiva::zone::lif {
namespace {

using namespace testing;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

std::string node(const std::string& id, const std::string& at, const std::string& more = {}) {
  return "{'nodeId':'" + id + "','mapId':'facility','nodePosition':{" + at +
         "},'vehicleTypeNodeProperties':[{'vehicleTypeIds':['CoSiVA.AIV']" + more + "}]}";
}
std::string edge(const std::string& from, const std::string& to, const std::string& more = {}) {
  return "{'edgeId':'" + from + "-" + to + "','startNodeId':'" + from + "','endNodeId':'" + to +
         "','vehicleTypeEdgeProperties':[{'vehicleTypeIds':['CoSiVA.AIV']" + more + "}]}";
}
std::string layout(const std::string& nodes, const std::string& edges, const std::string& more = {},
                   const std::string& id = "L1") {
  return "{'layoutId':'" + id + "','layoutVersion':'1','nodes':[" + nodes + "],'edges':[" + edges + "]" + more + "}";
}
std::string origin(const std::string& id, const std::string& layouts) {
  return "{'originId':'" + id + "','layouts':[" + layouts + "]}";
}
std::string facility(const std::string& origins) {
  return json(
      "{'metaInformation':{'lifId':'facility','creator':'test','exportTimestamp':'2026-01-01T00:00:00.00Z','lifVersion'"
      ":"
      "'2.0.0'},'origins':[" +
      origins + "]}");
}
const std::string a = node("A", "'x':0,'y':0");
const std::string b = node("B", "'x':4,'y':3");

TrafficZone zone_of(const std::string& text, const std::string& sidecar = {}) {
  auto zone = read_text(text, sidecar);
  EXPECT_TRUE(zone) << to_string(zone.error());
  return std::move(*zone);
}
/// Of a two-way track, with these properties of its first edge.
TrafficZone zone_with(const std::string& edge_properties) {
  return zone_of(facility(origin("o", layout(a + "," + b, edge("A", "B", edge_properties) + "," + edge("B", "A")))));
}
TrafficZone zone_with_node(const std::string& node_properties) {
  return zone_of(facility(
      origin("o", layout(a + "," + node("B", "'x':4,'y':3", node_properties), edge("A", "B") + "," + edge("B", "A")))));
}

TEST(LifVersion2, is_read_without_a_diagnostic_where_nothing_is_lost) {
  const TrafficZone zone = zone_of(facility(origin(
      "o", layout(a + "," + b, edge("A", "B", ",'vehicleOrientations':[0.0],'maxSpeed':0.4") + "," + edge("B", "A"),
                  ",'layoutLevelId':'ground','stations':[{'stationId':'dock','interactionNodeIds':['B']}]"))));
  EXPECT_THAT(zone.diagnostics, IsEmpty());
  EXPECT_EQ(zone.name, "facility");
  EXPECT_EQ(zone.circuit.size(), 2U);
  EXPECT_EQ(zone.circuit.part(0).speed_mps_max, 0.4);
  ASSERT_THAT(zone.stations, SizeIs(1));
  EXPECT_EQ(zone.stations[0].name, "dock");
}

TEST(LifVersion2, needs_no_stations_and_names_the_missing_fields_of_its_own_meta_information) {
  const TrafficZone zone = zone_of(json("{'metaInformation':{'lifVersion':'2.1.0'},'origins':[" +
                                        origin("o", layout(a + "," + b, edge("A", "B"))) + "]}"));
  EXPECT_THAT(zone.diagnostics, SizeIs(4)) << "with the mapId, which is not the zone's name";
  for (const std::string key : {"lifId", "creator", "exportTimestamp"})
    EXPECT_NE(diagnostic_at(zone, "metaInformation." + key), nullptr) << key;
  EXPECT_EQ(zone.name, "lif");
}

TEST(LifVersion2, of_another_number_is_read_by_its_origins) {
  const TrafficZone zone =
      zone_of(json("{'metaInformation':{'lifId':'facility','creator':'c','exportTimestamp':'t','lifVersion':'0.11.0'},"
                   "'origins':[" +
                   origin("o", layout(a + "," + b, edge("A", "B"))) + "]}"));
  ASSERT_THAT(zone.diagnostics, SizeIs(1));
  EXPECT_EQ(zone.diagnostics[0].text, "the file has version '0.11.0'; read as 2.0.0");
}

TEST(LifVersion2, has_the_layouts_of_one_origin_as_positions_of_others_cannot_be_compared) {
  const std::string second =
      layout(node("C", "'x':0,'y':0") + "," + node("D", "'x':1,'y':0"), edge("C", "D"), {}, "L2");
  const std::string text =
      facility(origin("north", layout(a + "," + b, edge("A", "B"))) + "," + origin("south", second));
  const TrafficZone zone = zone_of(text);
  EXPECT_EQ(zone.circuit.size(), 1U);
  EXPECT_EQ(zone.circuit.part(0).name, "A-B");
  const Diagnostic* diagnostic = diagnostic_at(zone, "origins[1].layouts[0]");
  ASSERT_NE(diagnostic, nullptr);
  EXPECT_EQ(diagnostic->kind, Diagnostic::Kind::lost);
  EXPECT_THAT(diagnostic->text, HasSubstr("different origins cannot be compared"));
  for (const char* selected : {"L2", "south"})
    EXPECT_EQ(zone_of(text, "[import]\nlayout = \"" + std::string{selected} + "\"\n").circuit.part(0).name, "C-D");
  const auto none = read_text(text, "[import]\nlayout = \"west\"\n");
  ASSERT_FALSE(none);
  EXPECT_THAT(none.error().message, HasSubstr("this file has: L1, L2"));
}

TEST(LifVersion2, has_the_levels_of_an_origin_side_by_side_without_their_lifts) {
  const std::string upper = layout(node("C", "'x':4,'y':3") + "," + node("D", "'x':9,'y':3"), edge("C", "D"),
                                   ",'layoutLevelId':'upper'", "L2");
  const std::string ground = layout(a + "," + b, edge("A", "B") + "," + edge("B", "C"), ",'layoutLevelId':'ground'");
  const TrafficZone zone = zone_of(facility(origin("o", ground + "," + upper)));
  EXPECT_EQ(zone.circuit.size(), 2U);
  EXPECT_THAT(zone.circuit.next(0), IsEmpty()) << "B and C lie on different levels";
  EXPECT_THAT(diagnostic_at(zone, "origins[0].layouts[0].edges[1]")->text, HasSubstr("lifts are not taken"));
}

TEST(LifVersion2, is_driven_forwards_where_that_is_one_of_the_possible_orientations) {
  // The straight line from A to B has a heading of 0.6435 rad.
  struct Row {
    std::string members;
    bool is_lost;
  };
  for (const Row& row :
       {Row{",'vehicleOrientations':[3.1416,0.0]", false}, Row{",'vehicleOrientations':[]", false}, Row{"", false},
        Row{",'vehicleOrientations':[3.1416]", true}, Row{",'vehicleOrientations':[6.2832]", false},
        Row{",'vehicleOrientations':[0.64],'orientationType':'GLOBAL'", false},
        Row{",'vehicleOrientations':[0.0],'orientationType':'GLOBAL'", true}, Row{",'orientationType':'GLOBAL'", false},
        Row{",'vehicleOrientations':[0.0],'orientationType':'SIDEWAYS'", true}}) {
    const Diagnostic* diagnostic = diagnostic_with(zone_with(row.members), "vehicles drive forwards");
    EXPECT_EQ(diagnostic != nullptr, row.is_lost) << row.members;
  }
  const TrafficZone degrees = zone_with(",'vehicleOrientations':[180]");
  EXPECT_THAT(
      diagnostic_at(degrees, "origins[0].layouts[0].edges[0].vehicleTypeEdgeProperties[0].vehicleOrientations")->text,
      HasSubstr("in degrees"));
}

TEST(LifVersion2, has_no_edge_that_neither_loaded_nor_unloaded_vehicles_may_use) {
  const TrafficZone closed = zone_with(",'loadRestriction':{'loaded':false,'unloaded':false}");
  EXPECT_EQ(closed.circuit.size(), 1U);
  EXPECT_NE(diagnostic_with(closed, "neither loaded nor unloaded vehicles"), nullptr);
  EXPECT_THAT(zone_with(",'loadRestriction':{'loaded':true,'unloaded':true}").diagnostics, IsEmpty());
  EXPECT_NE(diagnostic_with(zone_with(",'loadRestriction':{'loaded':false,'unloaded':true}"), "with and without load"),
            nullptr);
  EXPECT_NE(diagnostic_with(zone_with(",'loadRestriction':{'loaded':true,'unloaded':true,'loadSetNames':['EUR']}"),
                            "with any load"),
            nullptr);
}

TEST(LifVersion2, has_no_track_to_a_node_that_no_vehicle_may_use) {
  const auto none = read_text(facility(
      origin("o", layout(a + "," + node("B", "'x':4,'y':3", ",'loadRestriction':{'loaded':false,'unloaded':false}"),
                         edge("A", "B") + "," + edge("B", "A")))));
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, "circuit.empty");
  EXPECT_THAT(none.error().message, HasSubstr("neither loaded nor unloaded vehicles may be here"));
}

TEST(LifVersion2, names_the_required_actions_that_orders_do_not_contain) {
  const TrafficZone edges = zone_with(
      ",'actions':[{'actionType':'beep','requirementType':'REQUIRED','blockingType':'NONE'},"
      "{'actionType':'blink','requirementType':'REQUIRED','blockingType':'NONE'}]");
  ASSERT_THAT(edges.diagnostics, SizeIs(1));
  EXPECT_EQ(edges.diagnostics[0].kind, Diagnostic::Kind::lost);
  EXPECT_EQ(edges.diagnostics[0].text,
            "orders do not contain the required action 'beep', 'blink': vehicles do nothing on edges but drive");
  const TrafficZone nodes = zone_with_node(
      ",'actions':[{'actionType':'startCharging','requirementType':'REQUIRED','blockingType':'HARD'},"
      "{'actionType':'pick','requirementType':'CONDITIONAL','blockingType':'HARD'}]");
  ASSERT_NE(nodes.find_station("B"), nullptr);
  EXPECT_EQ(nodes.find_station("B")->kind, StationKind::charger);
  EXPECT_EQ(diagnostic_with(nodes, "required"), nullptr);
  EXPECT_NE(diagnostic_with(nodes, "'actions' is not taken"), nullptr);
}

TEST(LifVersion2, turns_on_the_spot_as_its_rotations_allow) {
  const std::string c = node("C", "'x':0,'y':3");
  const auto successors = [&](const std::string& rotation) {
    const TrafficZone zone =
        zone_of(facility(origin("o", layout(a + "," + b + "," + c, edge("A", "B", rotation) + "," + edge("B", "A") +
                                                                       "," + edge("B", "C") + "," + edge("C", "B")))));
    return zone.circuit.next(0).size();
  };
  EXPECT_EQ(successors(""), 2U);
  EXPECT_EQ(successors(",'rotationAtEndNodeAllowed':'BOTH'"), 2U);
  const TrafficZone one_way = zone_with(",'rotationAtEndNodeAllowed':'CW'");
  EXPECT_NE(diagnostic_with(one_way, "in one direction only"), nullptr);
  const TrafficZone none = zone_with(",'rotationAtEndNodeAllowed':'NONE'");
  EXPECT_NE(diagnostic_with(none, "which its node forbids"), nullptr);
}

TEST(LifVersion2, names_each_property_that_a_zone_does_not_have) {
  for (const std::string key : {"minimumLoadHandlingDeviceHeight", "maximumMobileRobotHeight"})
    EXPECT_NE(diagnostic_with(zone_with(",'" + key + "':1"), "'" + key + "' is not taken: a zone is flat"), nullptr);
  EXPECT_NE(diagnostic_with(zone_with(",'physicalLineGuidedProperty':{'length':5}"), "follow the path"), nullptr);
  EXPECT_NE(diagnostic_with(zone_with(",'allowedDeviationXY':{'a':0.1,'b':0.1,'theta':0}"), "same deviation"), nullptr);
  EXPECT_NE(diagnostic_with(zone_with(",'corridor':{'maximumLeftWidth':1,'maximumRightWidth':1}"), "keep to the path"),
            nullptr);
  EXPECT_NE(diagnostic_with(zone_with_node(",'maximumAllowedDeviation':0.1"), "same deviation"), nullptr);
  EXPECT_NE(diagnostic_with(zone_with(",'colour':1"), "'colour' is no field of LIF 2.0"), nullptr);
  EXPECT_THAT(zone_with(",'reachOrientationBeforeEntering':true").diagnostics, IsEmpty());
}

TEST(LifVersion2, takes_the_properties_of_one_of_several_vehicle_types) {
  const std::string far =
      "{'nodeId':'B','nodePosition':{'x':4,'y':3},'vehicleTypeNodeProperties':[{'vehicleTypeIds':['CoSiVA.AIV','other']"
      "}]}";
  const std::string text = facility(origin("o", layout(a + "," + far, edge("A", "B"))));
  const TrafficZone zone = zone_of(text);
  EXPECT_EQ(zone.circuit.size(), 1U);
  EXPECT_NE(diagnostic_with(zone, "those of vehicle type 'CoSiVA.AIV', one of 2"), nullptr);
  const auto other = read_text(text, "[import]\nvehicle_type = \"other\"\n");
  ASSERT_FALSE(other) << "the edge is not for it";
  EXPECT_EQ(other.error().code, "circuit.empty");
}

TEST(LifVersion2, is_written_as_version_1_without_a_change_of_its_zone) {
  const TrafficZone zone = zone_of(
      facility(origin("o", layout(a + "," + b + "," + node("C", "'x':8,'y':3"),
                                  edge("A", "B") + "," + edge("B", "A") + "," + edge("B", "C") + "," + edge("C", "B"),
                                  ",'stations':[{'stationId':'dock','interactionNodeIds':['C']}]"))));
  std::vector<Diagnostic> lost;
  const auto written = LifCircuitFactory{}.written(zone, lost);
  ASSERT_TRUE(written) << to_string(written.error());
  EXPECT_THAT(written->text, HasSubstr("\"lifVersion\": \"1.0.0\""));
  const auto again = LifCircuitFactory{}.make_zone(*written);
  ASSERT_TRUE(again) << to_string(again.error());
  ASSERT_EQ(again->circuit.size(), zone.circuit.size());
  // The edges are in another order.
  for (SectionId id = 0; id < zone.circuit.size(); ++id) {
    const auto other = again->circuit.find(zone.circuit.part(id).name);
    ASSERT_TRUE(other);
    EXPECT_EQ(again->circuit.next(*other).size(), zone.circuit.next(id).size());
    EXPECT_LT(distance(again->circuit.section(*other).end(), zone.circuit.section(id).end()), 1e-6);
  }
  ASSERT_THAT(again->stations, SizeIs(1));
  EXPECT_EQ(again->stations[0].name, "dock");
}

}  // namespace
}  // namespace cosiva::zone::lif
