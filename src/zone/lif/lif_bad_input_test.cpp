// Faulty files, and the errors and diagnostics about them.
#include <gmock/gmock.h>

#include <cmath>

#include "cosiva/zone/lif/lif_fixture.h"

namespace cosiva::zone::lif {
namespace {

using namespace testing;
using ::testing::HasSubstr;
using ::testing::StartsWith;

std::string error_of(const std::string& text, std::string sidecar = {}) {
  const auto zone = read_text(text, std::move(sidecar));
  return zone ? "no error" : to_string(zone.error());
}
std::string code_of(const std::string& text) {
  const auto zone = read_text(text);
  return zone ? "none" : zone.error().code;
}
TrafficZone zone_of(const std::string& text, std::string sidecar = {}) {
  auto zone = read_text(text, std::move(sidecar));
  EXPECT_TRUE(zone) << to_string(zone.error());
  return std::move(*zone);
}
std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

const Plan two{{"A 0 0", "B 2 0"}, {"A B", "B A"}};

// Refused ---------------------------------------------------------------------------------------------------------

TEST(LifErrors, name_line_and_column_of_a_json_fault) {
  EXPECT_THAT(error_of("{\n \"layouts\": [\n  {\"nodes\" []}]}"),
              StartsWith("plant.lif.json: line 3, column 12: not JSON: expected ':', found '['"));
  EXPECT_THAT(error_of(two.text().substr(0, 200)), HasSubstr("not JSON"));
  EXPECT_EQ(code_of(two.text().substr(0, 200)), "zone.syntax");
  EXPECT_EQ(code_of(""), "zone.syntax");
  EXPECT_EQ(code_of("\xFF\xFE{"), "zone.syntax");
  EXPECT_THAT(error_of(replaced(two.text(), "\"x\":2", "\"x\":1e999")), HasSubstr("too large"));
  EXPECT_THAT(error_of(replaced(two.text(), "\"x\":2", "\"x\":NaN")), HasSubstr("expected a value, found 'N'"));
  EXPECT_THAT(error_of(replaced(two.text(), "plan",
                                "Fl\xE4"
                                "che")),
              HasSubstr("UTF-8"));
}

TEST(LifErrors, about_too_deep_nesting_come_quickly) {
  EXPECT_THAT(error_of(std::string(100'000, '[')), HasSubstr("nested deeper than 64"));
  std::string objects;
  for (int i = 0; i < 100'000; ++i) objects += "{\"a\":";
  EXPECT_EQ(code_of(objects), "zone.syntax");
}

TEST(LifErrors, about_too_large_files_come_before_they_are_read) {
  EXPECT_EQ(code_of(std::string((64U << 20U) + 1, ' ')), "zone.size");
  EXPECT_EQ(code_of("[" + std::string(13'000'000, ',') + "]"), "zone.size");
}

TEST(LifErrors, come_for_more_than_twelve_million_values_and_no_fewer) {
  // The bracket counts as one.
  EXPECT_EQ(code_of("[" + std::string(12'000'000, ',') + "]"), "zone.size");
  EXPECT_EQ(code_of("[" + std::string(11'999'999, ',') + "]"), "zone.syntax");
}

TEST(LifErrors, name_the_location_of_duplicate_ids) {
  EXPECT_EQ(error_of(Plan{{"A 0 0", "B 2 0", "A 3 0"}, {"A B"}}.text()),
            "plant.lif.json: layouts[0].nodes[2].nodeId: two nodes have the id 'A'");
  EXPECT_EQ(error_of(Plan{{"A 0 0", "B 2 0"}, {"A B", "A B"}}.text()),
            "plant.lif.json: layouts[0].edges[1].edgeId: two edges have the id 'A-B'");
}

TEST(LifErrors, name_the_origins_where_a_file_of_version_2_has_no_layout) {
  for (const char* origins : {"[{'originId':'o','layouts':[]}]", "[]", "[7]", "{}"})
    EXPECT_EQ(error_of(json("{'metaInformation':{'lifVersion':'2.0.0'},'origins':" + std::string{origins} + "}")),
              "plant.lif.json: origins: expected a list of at least one layout, found none");
}

TEST(LifErrors, about_layouts_with_common_ids_state_how_to_take_one) {
  const std::string layout = "{'layoutId':'L1','nodes':[{'nodeId':'A','nodePosition':{'x':0,'y':0}}],'edges':[]}";
  const std::string both = json("{'layouts':[" + layout + "," + layout + "]}");
  EXPECT_THAT(error_of(both), HasSubstr("layouts[1].nodes[0].nodeId: two nodes have the id 'A', as layouts may not"));
}

TEST(LifErrors, state_why_nothing_is_left) {
  EXPECT_EQ(code_of("{}"), "zone.missing");
  EXPECT_EQ(code_of("[]"), "zone.missing");
  EXPECT_EQ(code_of(json("{'layouts':[]}")), "zone.missing");
  EXPECT_EQ(code_of(Plan{{"A 0 0"}, {}}.text()), "circuit.empty");
  const std::string dangling = error_of(Plan{{"A 0 0", "B 2 0"}, {"A C"}}.text());
  EXPECT_THAT(dangling, HasSubstr("no edge is left"));
  EXPECT_THAT(dangling, HasSubstr("layouts[0].edges[0].endNodeId: there is no node 'C'"));
  // An ignored field is no reason; nodes without a position are.
  const std::string flat =
      json("{'layouts':[{'layoutId':'L','layoutName':'yard','nodes':[{'nodeId':'A','x':0,'y':0}],'edges':[]}]}");
  EXPECT_THAT(error_of(flat), HasSubstr("layouts[0].nodes[0].nodePosition: a node without a position"));
}

TEST(LifErrors, come_where_a_node_joins_too_many_edges) {
  Plan star;
  star.nodes.push_back("M 0 0");
  for (int i = 0; i < 1100; ++i) {
    const std::string id = "N" + std::to_string(i);
    star.nodes.push_back(id + " " + std::to_string(0.01 * i + 0.01) + " 1");
    star.edges.push_back("M " + id);
    star.edges.push_back(id + " M");
  }
  EXPECT_EQ(code_of(star.text()), "zone.size");
}

TEST(LifErrors, come_where_a_zone_is_too_long) {
  EXPECT_THAT(error_of(Plan{{"A 0 0", "B 99000 0"}, {"A B", "B A"}}.text()),
              HasSubstr("layouts[0].edges[1]: a zone may"));
  EXPECT_NEAR(zone_of(Plan{{"A 0 0", "B 99000 0"}, {"A B", "B A"}}.text(), "[import]\nscale = 0.001\n")
                  .circuit.total_length_m(),
              198.0, 1e-6);
}

// Lost ------------------------------------------------------------------------------------------------------------

TEST(LifLosses, edges_to_nowhere_are_lost_and_named) {
  const TrafficZone zone = zone_of(Plan{{"A 0 0", "B 2 0"}, {"A B", "B C", "D A"}}.text());
  EXPECT_EQ(zone.circuit.size(), 1U);
  EXPECT_EQ(diagnostic_at(zone, "layouts[0].edges[1].endNodeId")->kind, Diagnostic::Kind::lost);
  EXPECT_EQ(diagnostic_at(zone, "layouts[0].edges[2].startNodeId")->kind, Diagnostic::Kind::lost);
}

TEST(LifLosses, nodes_without_a_position_are_lost_with_their_edges) {
  const std::string text =
      replaced(Plan{{"A 0 0", "B 2 0", "C 3 0"}, {"A B", "B C"}}.text(), "\"x\":3", "\"x\":\"far\"");
  const TrafficZone zone = zone_of(text);
  EXPECT_EQ(zone.circuit.size(), 1U);
  EXPECT_EQ(diagnostic_at(zone, "layouts[0].nodes[2].nodePosition.x")->kind, Diagnostic::Kind::mended);
  EXPECT_EQ(diagnostic_at(zone, "layouts[0].nodes[2].nodePosition")->kind, Diagnostic::Kind::lost);
}

TEST(LifLosses, stations_that_no_edge_leads_to_are_lost) {
  Plan plan{{"A 0 0", "B 2 0", "C 9 9"}, {"A B"}};
  plan.stations = "[{'stationId':'S','interactionNodeIds':['C','X']}]";
  const TrafficZone zone = zone_of(plan.text());
  EXPECT_TRUE(zone.stations.empty());
  EXPECT_EQ(diagnostic_at(zone, "layouts[0].stations[0]")->kind, Diagnostic::Kind::lost);
  EXPECT_EQ(diagnostic_at(zone, "layouts[0].stations[0].interactionNodeIds[1]")->kind, Diagnostic::Kind::lost);
}

TEST(LifLosses, fields_unknown_to_lif_are_named) {
  const TrafficZone zone = zone_of(replaced(two.text(), "\"edgeId\":\"A-B\"", "\"edgeId\":\"A-B\",\"colour\":\"red\""));
  ASSERT_NE(diagnostic_at(zone, "layouts[0].edges[0].colour"), nullptr);
  EXPECT_EQ(diagnostic_at(zone, "layouts[0].edges[0].colour")->kind, Diagnostic::Kind::lost);
}

TEST(LifLosses, a_thousand_kinds_of_diagnostics_are_no_more_than_two_hundred) {
  std::string fields;
  for (int i = 0; i < 1000; ++i) fields += "\"f" + std::to_string(i) + "\":1,";
  const TrafficZone zone = zone_of(replaced(two.text(), "\"edgeId\":\"A-B\"", fields + "\"edgeId\":\"A-B\""));
  EXPECT_LE(zone.diagnostics.size(), 203U);
  EXPECT_NE(diagnostic_with(zone, "further diagnostics"), nullptr);
}

// Mended ----------------------------------------------------------------------------------------------------------

TEST(LifMendings, numbers_as_texts_and_texts_as_numbers_are_accepted) {
  std::string text = two.text();
  text = replaced(text, "\"x\":2", "\"x\":\"2,5\"");
  text = replaced(text, "\"lifVersion\":\"1.0.0\"", "\"lifVersion\":1");
  const TrafficZone zone = zone_of(text);
  EXPECT_NEAR(zone.circuit.total_length_m(), 5.0, 1e-12);
  EXPECT_EQ(diagnostic_at(zone, "layouts[0].nodes[1].nodePosition.x")->kind, Diagnostic::Kind::mended);
}

TEST(LifMendings, a_project_s_name_is_cut_to_64_bytes_between_two_characters) {
  const auto name = [](const std::string& project) { return zone_of(replaced(two.text(), "plan", project)).name; };
  EXPECT_EQ(name(std::string(64, 'a')), std::string(64, 'a'));
  EXPECT_EQ(name(std::string(65, 'a')), std::string(64, 'a'));
  EXPECT_EQ(name(std::string(62, 'a') + "ä"), std::string(62, 'a') + "ä");
  EXPECT_EQ(name(std::string(63, 'a') + "ä"), std::string(63, 'a'));
  EXPECT_EQ(name(std::string(62, 'a') + "€"), std::string(62, 'a'));
  EXPECT_EQ(name(""), "lif");
  EXPECT_EQ(name("  "), "lif");
}

TEST(LifMendings, ids_may_be_numbers) {
  std::string text = Plan{{"1 0 0", "2 2 0"}, {"1 2"}}.text();
  for (const std::string id : {"1", "2"}) {
    text = replaced(text, "\"nodeId\":\"" + id + "\"", "\"nodeId\":" + id);
  }
  text = replaced(text, "\"startNodeId\":\"1\"", "\"startNodeId\":1");
  EXPECT_EQ(zone_of(text).find_waypoints("2").size(), 1U);
}

TEST(LifMendings, a_byte_order_mark_and_nulls_are_harmless) {
  std::string text = replaced(two.text(), "\"stations\":[]", "\"stations\":null,\"layoutName\":null");
  text = replaced(text, "\"rotationAllowed\":false", "\"rotationAllowed\":null,\"trajectory\":null,\"maxSpeed\":null");
  EXPECT_EQ(zone_of("\xEF\xBB\xBF" + text).circuit.size(), 2U);
}

TEST(LifMendings, missing_vehicle_types_mean_all) {
  std::string text = two.text();
  const std::string open = "[{\"vehicleTypeId\":\"T\"}]";
  text = replaced(text, "\"vehicleTypeNodeProperties\":" + open, "\"vehicleTypeNodeProperties\":[]");
  text = replaced(text, ",\"vehicleTypeNodeProperties\":" + open, "");
  EXPECT_EQ(zone_of(text).circuit.size(), 2U);
  text = replaced(text, "\"vehicleTypeEdgeProperties\"", "\"x\"");
  text = replaced(text, "\"vehicleTypeEdgeProperties\"", "\"x\"");
  EXPECT_EQ(zone_of(text).circuit.size(), 2U);
}

TEST(LifMendings, speeds_must_be_positive) {
  for (const std::string speed : {"0", "-1.5", "1000"}) {
    const TrafficZone zone = zone_of(Plan{{"A 0 0", "B 2 0"}, {"A B 'maxSpeed':" + speed}}.text());
    EXPECT_FALSE(zone.circuit.part(0).speed_mps_max);
    EXPECT_EQ(diagnostic_at(zone, "layouts[0].edges[0].vehicleTypeEdgeProperties[0].maxSpeed")->kind,
              Diagnostic::Kind::mended);
  }
  EXPECT_EQ(zone_of(Plan{{"A 0 0", "B 2 0"}, {"A B 'maxSpeed':0.4"}}.text()).circuit.part(0).speed_mps_max, 0.4);
}

TEST(LifMendings, a_far_away_origin_is_moved_by_whole_kilometres) {
  const TrafficZone zone = zone_of(Plan{{"A 3500000.25 5400000", "B 3500002.25 5400000"}, {"A B"}}.text());
  EXPECT_NEAR(zone.circuit.total_length_m(), 2.0, 1e-9);
  EXPECT_NEAR(zone.circuit.section(0).start().x_m, 0.25, 1e-9);
  EXPECT_NE(diagnostic_with(zone, "(3500000 m, 5400000 m)"), nullptr);
  EXPECT_EQ(diagnostic_with(zone_of(Plan{{"A 3000 1000", "B 3002 1000"}, {"A B"}}.text()), "origin"), nullptr);
}

// Joints ----------------------------------------------------------------------------------------------------------

std::vector<std::string> after(const TrafficZone& zone, std::string_view edge) {
  std::vector<std::string> names;
  for (const SectionId id : zone.circuit.next(*zone.circuit.find(edge))) names.push_back(zone.circuit.part(id).name);
  return names;
}

TEST(LifJoints, the_straightest_branch_is_the_default_and_turning_back_the_last) {
  const TrafficZone zone =
      zone_of(Plan{{"A 0 0", "B 1 0", "C 2 0.1", "D 1 1", "E 0.5 1"}, {"A B", "B A", "B D", "B E", "B C"}}.text());
  EXPECT_THAT(after(zone, "A-B"), ::testing::ElementsAre("B-C", "B-D", "B-E", "B-A"));
  EXPECT_TRUE(zone.circuit.part(*zone.circuit.find("A-B")).pivots);
}

TEST(LifJoints, a_node_that_forbids_turning_lets_vehicles_go_straight_on_only) {
  const Plan plan{{"A 0 0", "B 1 0", "C 2 0", "D 1 1"}, {"A B 'rotationAtEndNodeAllowed':'NONE'", "B C", "B D", "B A"}};
  const TrafficZone zone = zone_of(plan.text());
  EXPECT_THAT(after(zone, "A-B"), ::testing::ElementsAre("B-C"));
  EXPECT_FALSE(zone.circuit.part(*zone.circuit.find("A-B")).pivots);

  const Plan leaving{{"A 0 0", "B 1 0", "C 2 0", "D 1 1"},
                     {"A B", "B C", "B D 'rotationAtStartNodeAllowed':'NONE'", "B A"}};
  EXPECT_THAT(after(zone_of(leaving.text()), "A-B"), ::testing::ElementsAre("B-C", "B-A"));
}

TEST(LifJoints, a_node_that_would_be_the_end_allows_turning_all_the_same) {
  const TrafficZone zone =
      zone_of(Plan{{"A 0 0", "B 1 0", "D 1 1"}, {"A B 'rotationAtEndNodeAllowed':'NONE'", "B D"}}.text());
  EXPECT_THAT(after(zone, "A-B"), ::testing::ElementsAre("B-D"));
  EXPECT_EQ(diagnostic_at(zone, "layouts[0].edges[0]")->kind, Diagnostic::Kind::mended);
}

TEST(LifJoints, nodes_of_different_levels_are_apart_even_at_one_point) {
  std::string text = Plan{{"A 0 0", "B 2 0"}, {"A B"}}.text();
  text = replaced(text, "\"layoutId\":\"L\"", "\"layoutLevelId\":\"0\",\"layoutId\":\"L\"");
  std::string upper = Plan{{"C 2 0", "D 4 0"}, {"C D"}}.text();
  upper = replaced(upper, "\"layoutId\":\"L\"", "\"layoutLevelId\":\"1\",\"layoutId\":\"U\"");
  const auto from = upper.find("{\"layoutLevelId\"");
  text.insert(text.size() - 2, "," + upper.substr(from, upper.size() - 2 - from));
  EXPECT_TRUE(after(zone_of(text), "A-B").empty());
  EXPECT_THAT(after(zone_of(replaced(text, "\"layoutLevelId\":\"1\"", "\"layoutLevelId\":\"0\"")), "A-B"),
              ::testing::ElementsAre("C-D"));
}

// Trajectories ----------------------------------------------------------------------------------------------------

TrafficZone with_trajectory(const std::string& trajectory) {
  return zone_of(Plan{{"A 0 0", "B 4 0"}, {"A B 'trajectory':" + trajectory}}.text());
}
const std::string trajectory_location = "layouts[0].edges[0].vehicleTypeEdgeProperties[0].trajectory";

TEST(LifTrajectories, of_degree_one_are_straight_lines_with_corners_to_turn_at) {
  const TrafficZone zone = with_trajectory(
      "{'knotVector':[0,0,0.3,0.7,1,1],'controlPoints':[{'x':0,'y':0},{'x':0,'y':3},{'x':4,'y':3},{'x':4,'y':0}]}");
  ASSERT_EQ(zone.circuit.size(), 3U);
  EXPECT_NEAR(zone.circuit.total_length_m(), 10.0, 1e-6);
  EXPECT_EQ(zone.circuit.part(1).name, "A-B.2");
  EXPECT_TRUE(zone.circuit.part(0).pivots);
  EXPECT_NEAR(zone.circuit.turn_at(0, 1), -pi / 2.0, 1e-9);
  EXPECT_NE(diagnostic_with(zone, "corners"), nullptr);
}

TEST(LifTrajectories, that_are_straight_become_one_straight_section) {
  const TrafficZone zone = with_trajectory(
      "{'degree':2,'knotVector':[0,0,0,0.5,1,1,1],'controlPoints':[{'x':0,'y':0},{'x':1,'y':0},{'x':3,'y':0},{'x':4,'y'"
      ":0}]}");
  ASSERT_EQ(zone.circuit.size(), 1U);
  EXPECT_EQ(zone.circuit.section(0).kind(), SectionKind::straight);
}

TEST(LifTrajectories, with_wrong_knots_get_even_ones) {
  for (const std::string knots : {"[]", "[0,1]", "[0,0,0,1,0.5,1]", "[0.5,0.5,0.5,0.5,0.5,0.5]", "[0,0,0,0,0,1]"}) {
    const TrafficZone zone = with_trajectory("{'degree':2,'knotVector':" + knots +
                                             ",'controlPoints':[{'x':0,'y':0},{'x':2,'y':1},{'x':4,'y':0}]}");
    EXPECT_EQ(diagnostic_at(zone, trajectory_location + ".knotVector")->kind, Diagnostic::Kind::mended) << knots;
    EXPECT_LT(zone.circuit.locate({2.0, 0.5}).distance_m, 1e-3);
  }
  // Without the outermost ones, as some programs write them, they are valid.
  const TrafficZone zone = with_trajectory(
      "{'degree':2,'knotVector':[0,0,1,1],'controlPoints':[{'x':0,'y':0},{'x':2,'y':1},{'x':4,'y':0}]}");
  EXPECT_THAT(diagnostic_at(zone, trajectory_location + ".knotVector")->text, HasSubstr("doubled"));
}

TEST(LifTrajectories, that_are_invalid_become_straight_lines) {
  const std::string none[] = {
      "{'knotVector':[0,1],'controlPoints':[{'x':0,'y':0}]}",
      "{'controlPoints':[{'x':0,'y':0},{'x':'a','y':1},{'x':4,'y':0}]}",
      // The ends meet, but the nodes do not.
      "{'degree':2,'knotVector':[0,0,0,1,1,1],'controlPoints':[{'x':0,'y':0},{'x':2,'y':1},{'x':0,'y':0}]}",
      // A trajectory that is tiny and would have to be enlarged.
      "{'degree':2,'knotVector':[0,0,0,1,1,1],'controlPoints':[{'x':0,'y':0},{'x':0.01,'y':0.01},{'x':0.02,'y':0}]}",
  };
  for (const std::string& trajectory : none) {
    const TrafficZone zone = with_trajectory(trajectory);
    ASSERT_EQ(zone.circuit.size(), 1U) << trajectory;
    EXPECT_NEAR(zone.circuit.total_length_m(), 4.0, 1e-9);
    EXPECT_NE(diagnostic_with(zone, "a straight line"), nullptr) << trajectory;
  }
}

TEST(LifTrajectories, with_huge_coordinates_knots_and_weights_do_no_harm) {
  (void)with_trajectory(
      "{'degree':1e300,'knotVector':[-1e300,1e300],'controlPoints':[{'x':1e300,'y':-1e300,'weight':0},"
      "{'x':-1e300,'y':1e300,'weight':-5},{'x':4,'y':0,'weight':1e300}]}");
  std::string knots = "[0";
  for (int i = 0; i < 50'000; ++i) knots += ",0.5";
  (void)with_trajectory("{'degree':3,'knotVector':" + knots +
                        "],'controlPoints':[{'x':0,'y':0},{'x':1,'y':1},{'x':2,'y':1},{'x':4,'y':0}]}");
}

TEST(LifTrajectories, that_meet_their_nodes_to_a_millimetre_are_moved_without_a_diagnostic) {
  const TrafficZone zone = with_trajectory(
      "{'degree':2,'knotVector':[0,0,0,1,1,1],'controlPoints':[{'x':0.0005,'y':0},{'x':2,'y':1},{'x':4,'y':0.0005}]}");
  EXPECT_EQ(diagnostic_at(zone, trajectory_location), nullptr);
  EXPECT_LT(distance(zone.circuit.section(0).start(), Pose2{}), 1e-12);
}

}  // namespace
}  // namespace cosiva::zone::lif
