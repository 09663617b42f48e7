// Zones written as LIF, and read back.
#include <gmock/gmock.h>
#include <rapidcheck.h>

#include <cmath>

#include "cosiva/base/json_value.h"
#include "cosiva/zone/edit/edit.h"
#include "cosiva/zone/lif/lif_fixture.h"
#include "cosiva/zone/toml/toml_factory.h"

namespace cosiva::zone::lif {
namespace {

using namespace testing;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::Field;
using ::testing::HasSubstr;

TrafficZone native(const std::string& text) {
  auto zone = TomlCircuitFactory{}.make_zone({"toml", "yard.toml", text, {}});
  EXPECT_TRUE(zone) << to_string(zone.error());
  return std::move(*zone);
}

ZoneConfiguration written(const TrafficZone& zone, std::vector<Diagnostic>* lost = nullptr) {
  std::vector<Diagnostic> diagnostics;
  auto file = LifCircuitFactory{}.written(zone, diagnostics);
  EXPECT_TRUE(file) << to_string(file.error());
  if (lost != nullptr) *lost = diagnostics;
  return std::move(*file);
}

TrafficZone read(const ZoneConfiguration& file) {
  auto zone = LifCircuitFactory{}.make_zone(file);
  EXPECT_TRUE(zone) << to_string(zone.error());
  return std::move(*zone);
}

std::vector<std::string> names(const Circuit& circuit, std::span<const SectionId> sections) {
  std::vector<std::string> names;
  for (const SectionId id : sections) names.push_back(circuit.part(id).name);
  return names;
}

/// Same names, joints, limits, and nowhere more than a millimetre and a milliradian apart.
void expect_same_geometry(const Circuit& a, const Circuit& b) {
  ASSERT_EQ(a.size(), b.size());
  for (SectionId id = 0; id < a.size(); ++id) {
    const Circuit::Part& part = a.part(id);
    const auto other = b.find(part.name);
    ASSERT_TRUE(other) << part.name;
    EXPECT_EQ(names(a, part.next), names(b, b.next(*other))) << "after " << part.name;
    EXPECT_EQ(part.speed_mps_max, b.part(*other).speed_mps_max) << part.name;
    const Section& section = b.section(*other);
    EXPECT_NEAR(section.length_m(), part.section.length_m(), 1e-3) << part.name;
    for (int i = 0; i <= 20; ++i) {
      const Pose2 here = part.section.pose_at(part.section.length_m() * i / 20.0);
      const Pose2 there = section.pose_at(section.length_m() * i / 20.0);
      EXPECT_LT(distance(here, there), 1e-3) << part.name;
      EXPECT_LT(std::fabs(wrap_angle(here.heading_rad - there.heading_rad)), 1e-3) << part.name;
    }
  }
}

/// Likewise, and with the same tags, stations, starts, loops and other elements.
void expect_same(const TrafficZone& a, const TrafficZone& b) {
  EXPECT_EQ(a.name, b.name);
  expect_same_geometry(a.circuit, b.circuit);
  const auto expect_position = [&](TrackPosition here, TrackPosition there) {
    EXPECT_LT(distance(a.circuit.pose_at(here), b.circuit.pose_at(there)), 1e-3);
  };
  EXPECT_EQ(a.vehicle.length_m, b.vehicle.length_m);
  EXPECT_EQ(a.vehicle.width_m, b.vehicle.width_m);
  EXPECT_EQ(a.profiles.medium.speed_mps, b.profiles.medium.speed_mps);
  ASSERT_EQ(a.tags.size(), b.tags.size());
  for (std::size_t i = 0; i < a.tags.size(); ++i) {
    EXPECT_EQ(a.tags[i].number, b.tags[i].number);
    expect_position(a.tags[i].position, b.tags[i].position);
  }
  ASSERT_EQ(a.stations.size(), b.stations.size());
  for (const auto& station : a.stations) {
    ASSERT_NE(b.find_station(station.name), nullptr) << station.name;
    EXPECT_EQ(b.find_station(station.name)->kind, station.kind) << station.name;
    expect_position(station.position, b.find_station(station.name)->position);
  }
  ASSERT_EQ(a.starts.size(), b.starts.size());
  for (std::size_t i = 0; i < a.starts.size(); ++i) expect_position(a.starts[i], b.starts[i]);
  ASSERT_EQ(a.loops.size(), b.loops.size());
  for (std::size_t i = 0; i < a.loops.size(); ++i) {
    EXPECT_EQ(a.loops[i].name, b.loops[i].name);
    EXPECT_EQ(names(a.circuit, a.loops[i].sections), names(b.circuit, b.loops[i].sections));
  }
  EXPECT_EQ(names(a.circuit, a.closed), names(b.circuit, b.closed));
  EXPECT_EQ(a.priorities, b.priorities);
  ASSERT_EQ(a.beacons.has_value(), b.beacons.has_value());
  if (a.beacons) {
    EXPECT_EQ(a.beacons->columns, b.beacons->columns);
  }
  EXPECT_EQ(a.crossings.size(), b.crossings.size());
}

// A main track with a fork, a merge and a dead end; every kind of section; the successor of "in" is not in the file's
// order.
const char* const yard = R"(name = "yard"
format_version = 1
[[section]]
name = "in"
kind = "straight"
length_m = 1.0
speed_mps_max = 0.4
next = ["left", "ahead"]
[[section]]
name = "ahead"
kind = "straight"
length_m = 2.0
next = ["out"]
[[section]]
name = "out"
kind = "straight"
length_m = 1.0
next = []
[[section]]
name = "left"
kind = "clothoid"
length_m = 0.8
curvature_start_per_m = 0.0
curvature_end_per_m = 1.5
start = { x = 1.0, y = 0.0, heading_deg = 0.0 }
next = ["round"]
[[section]]
name = "round"
kind = "arc"
radius_m = 0.6666666666666666
angle_deg = 200
[[tag]]
number = 7
section = "round"
s_m = 0.5
[[station]]
name = "dock"
section = "round"
s_m = 1.0
[[station]]
name = "bench"
section = "left"
s_m = 0.3
[[station]]
name = "end"
section = "out"
s_m = 1.0
[priorities]
"CoSiVA/AIV2" = 5
)";

TEST(LifRoundTrip, keeps_forks_merges_dead_ends_limits_and_the_default_branch) {
  const TrafficZone zone = native(yard);
  std::vector<Diagnostic> lost;
  const TrafficZone again = read(written(zone, &lost));
  expect_same(zone, again);
  EXPECT_EQ(again.circuit.part(again.circuit.next(*again.circuit.find("in")).front()).name, "left");
  for (const Diagnostic& diagnostic : lost) EXPECT_FALSE(diagnostic.location.starts_with("section")) << diagnostic.text;
}

TEST(LifRoundTrip, keeps_the_ready_loop) {
  auto zone = TomlCircuitFactory{}.make_zone(ready_zone("toml", "lacet4.toml"));
  ASSERT_TRUE(zone) << to_string(zone.error());
  expect_same(*zone, read(written(*zone)));
}

TEST(LifRoundTrip, keeps_the_ready_net) {
  auto zone = TomlCircuitFactory{}.make_zone(ready_zone("toml", "indus8.toml"));
  ASSERT_TRUE(zone) << to_string(zone.error());
  expect_same(*zone, read(written(*zone)));
}

TEST(LifRoundTrip, keeps_a_factory_layout_that_was_read_from_it) {
  const TrafficZone zone = read(ready_zone("lif", "workshop.lif.json"));
  const ZoneConfiguration once = written(zone);
  const TrafficZone again = read(once);
  expect_same(zone, again);
  for (const char* node : {"S1", "P1", "EB2", "A1"})
    EXPECT_EQ(again.find_waypoints(node).size(), zone.find_waypoints(node).size()) << node;
  EXPECT_EQ(written(again).sidecar, once.sidecar);
}

TEST(LifWriter, cuts_a_section_at_its_stations_so_that_other_programs_read_them) {
  const ZoneConfiguration file = written(native(yard));
  const auto json = JsonValue::parse(file.text);
  ASSERT_TRUE(json);
  const JsonValue& layout = json->find("layouts")->array()->front();
  std::vector<std::string> edges;
  for (const JsonValue& edge : *layout.find("edges")->array()) edges.push_back(*edge.text("edgeId"));
  EXPECT_THAT(edges, ElementsAre("in", "out", "left", "left.2", "ahead", "round", "round.2"));
  const JsonValue& dock = layout.find("stations")->array()->front();
  EXPECT_EQ(dock.text("stationId"), "dock");
  const auto at = dock.find("interactionNodeIds")->array()->front().text();
  for (const JsonValue& node : *layout.find("nodes")->array()) {
    if (node.text("nodeId") != *at) continue;
    const Point2 p{*node.find("nodePosition")->number("x"), *node.find("nodePosition")->number("y")};
    const TrafficZone zone = native(yard);
    EXPECT_LT(distance(p, position(zone.circuit.pose_at(zone.find_station("dock")->position))), 1e-9);
  }
}

TEST(LifWriter, offers_charging_at_a_charger) {
  TrafficZone zone = native(yard);
  zone.stations[0].kind = StationKind::charger;
  const ZoneConfiguration file = written(zone);
  EXPECT_THAT(file.text, HasSubstr("startCharging"));
  EXPECT_EQ(read(file).find_station("dock")->kind, StationKind::charger);
  EXPECT_THAT(written(native(yard)).text, ::testing::Not(HasSubstr("startCharging")));
}

TEST(LifWriter, writes_the_approved_text) {
  // Regenerate with: COSIVA_APPROVE=1 zone_lif_test. scripts/validate_lif.py checks the file against the official
  // schema.
  const auto path = testdata() / "written" / "yard.lif.json";
  const ZoneConfiguration file = written(native(yard));
  if (std::getenv("COSIVA_APPROVE") != nullptr) {
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary) << file.text;
  }
  EXPECT_EQ(file.text, file_text(path));
}

TEST(LifWriter, reports_what_lif_cannot_express) {
  std::vector<Diagnostic> lost;
  (void)written(native(yard), &lost);
  EXPECT_THAT(lost, Contains(Field(&Diagnostic::text, HasSubstr("tags, priorities, the vehicle's measures"))));
  // A full circle begins and ends at one node, and a curve with so large a turn is read in pieces.
  const TrafficZone circle = native(R"(name = "circle"
format_version = 1
[circuit]
closed = true
[[section]]
name = "round"
kind = "arc"
radius_m = 1.0
angle_deg = 360
)");
  lost.clear();
  const TrafficZone again = read(written(circle, &lost));
  EXPECT_NEAR(again.circuit.total_length_m(), 2.0 * pi, 1e-6);
  EXPECT_THAT(lost, Contains(Field(&Diagnostic::text, HasSubstr("becomes several sections"))));
}

TEST(LifWriter, reports_where_nodes_join_sections_that_the_zone_keeps_apart) {
  // Two sections meet at a point where a vehicle may not change from one to the other.
  const TrafficZone zone = native(R"(name = "apart"
format_version = 1
[[section]]
name = "a"
kind = "straight"
length_m = 1.0
[[section]]
name = "b"
kind = "straight"
length_m = 1.0
next = []
[[section]]
name = "c"
kind = "straight"
length_m = 1.0
start = { x = 1.0, y = 0.0, heading_deg = 0.0 }
next = []
)");
  std::vector<Diagnostic> lost;
  (void)written(zone, &lost);
  EXPECT_THAT(lost,
              Contains(Field(&Diagnostic::text, HasSubstr("is followed by b, which LIF can only express as b, c"))));
}

/// "id end", by edge: its id, and whether vehicles may turn at its end node.
std::vector<std::string> edges_and_turns(const ZoneConfiguration& file) {
  const auto json = JsonValue::parse(file.text);
  EXPECT_TRUE(json);
  std::vector<std::string> all;
  for (const JsonValue& edge : *json->find("layouts")->array()->front().find("edges")->array()) {
    const JsonValue& properties = edge.find("vehicleTypeEdgeProperties")->array()->front();
    all.push_back(*edge.text("edgeId") + " " + *properties.text("rotationAtEndNodeAllowed"));
  }
  return all;
}

/// One section "a" of 1 m.
TrafficZone metre() {
  return native(
      "name = \"metre\"\nformat_version = 1\n[[section]]\nname = \"a\"\nkind = \"straight\"\nlength_m = 1.0\n");
}

/// The zone with these sections, and nothing else.
TrafficZone bare_zone(std::vector<Circuit::Part> parts) {
  TrafficZone zone = metre();
  zone.waypoints.clear();
  zone.circuit = *Circuit::make("metre", std::move(parts));
  return zone;
}

TEST(LifWriter, puts_stations_within_a_millimetre_on_one_node) {
  const auto edges = [](const std::vector<double>& stations_m) {
    TrafficZone zone = metre();
    for (const double s_m : stations_m) zone.stations.push_back({"s" + std::to_string(zone.stations.size()), {0, s_m}});
    return edges_and_turns(written(zone)).size();
  };
  EXPECT_EQ(edges({}), 1U);
  EXPECT_EQ(edges({0.0, 0.0009, 0.9991, 1.0}), 1U);
  EXPECT_EQ(edges({0.0015}), 2U);
  EXPECT_EQ(edges({0.9985}), 2U);
  EXPECT_EQ(edges({0.5, 0.5009, 0.4991}), 2U);
  EXPECT_EQ(edges({0.5, 0.5015}), 3U);
  EXPECT_EQ(edges({0.5, 0.4985}), 3U);
}

TEST(LifWriter, names_the_nodes_of_stations_by_their_millimetre) {
  TrafficZone zone = metre();
  zone.stations = {{"low", {0, 0.2504}}, {"high", {0, 0.7506}}};
  const std::string text = written(zone).text;
  EXPECT_THAT(text, HasSubstr("\"nodeId\": \"a@250\""));
  EXPECT_THAT(text, HasSubstr("\"nodeId\": \"a@751\""));
}

TEST(LifWriter, names_the_ends_of_sections_by_the_waypoints_within_a_millimetre_or_by_their_millimetre) {
  TrafficZone zone = metre();
  zone.waypoints = {{"start", {0, 0.0009}}, {"finish", {0, 0.9991}}};
  EXPECT_THAT(written(zone).text, HasSubstr("\"nodeId\": \"start\""));
  EXPECT_THAT(written(zone).text, HasSubstr("\"nodeId\": \"finish\""));
  zone.waypoints = {{"start", {0, 0.0011}}, {"finish", {0, 0.9989}}};
  EXPECT_THAT(written(zone).text, HasSubstr("\"nodeId\": \"a@0\""));
  EXPECT_THAT(written(zone).text, HasSubstr("\"nodeId\": \"a@1000\""));
  zone.waypoints = {{"twice", {0, 0.0}}, {"twice", {0, 1.0}}};
  EXPECT_THAT(written(zone).text, HasSubstr("\"nodeId\": \"twice\""));
  EXPECT_THAT(written(zone).text, HasSubstr("\"nodeId\": \"twice'\""));
  for (const auto& [length_m, id] : {std::pair{1.2344, "a@1234"}, {1.2346, "a@1235"}}) {
    const TrafficZone bare = bare_zone({Circuit::Part{"a", *Section::make({}, length_m), std::nullopt, {}, false}});
    EXPECT_THAT(written(bare).text, HasSubstr(std::string("\"nodeId\": \"") + id + "\""));
  }
}

TEST(LifWriter, limits_the_speed_on_every_edge_of_a_section_that_was_cut) {
  TrafficZone zone = bare_zone({Circuit::Part{"a", *Section::make({}, 1.0), 0.4, {}, false}});
  zone.stations = {{"one", {0, 0.25}}, {"two", {0, 0.75}}};
  const auto json = JsonValue::parse(written(zone).text);
  ASSERT_TRUE(json);
  const auto& edges = *json->find("layouts")->array()->front().find("edges")->array();
  EXPECT_EQ(edges.size(), 3U);
  for (const JsonValue& edge : edges) {
    EXPECT_EQ(edge.text("edgeName"), "a");
    EXPECT_EQ(edge.find("vehicleTypeEdgeProperties")->array()->front().number("maxSpeed"), 0.4);
  }
}

TEST(LifWriter, lets_vehicles_turn_only_at_the_end_of_a_section_that_was_cut) {
  Circuit::Part a{"a", *Section::make({}, 1.0), std::nullopt, {1}, true};
  Circuit::Part b{"b", *Section::make({1.0, 0.0, 0.5 * pi}, 1.0), std::nullopt, {}, false};
  TrafficZone zone = bare_zone({a, b});
  EXPECT_THAT(edges_and_turns(written(zone)), ElementsAre("a BOTH", "b NONE"));
  zone.stations = {{"halfway", {0, 0.5}}};
  EXPECT_THAT(edges_and_turns(written(zone)), ElementsAre("a NONE", "a.2 BOTH", "b NONE"));
}

TEST(LifWriter, keeps_the_zone_s_order_where_the_successors_of_two_sections_contradict_one_another) {
  const Section in = *Section::make({}, 1.0);
  TrafficZone zone = bare_zone({{"in1", in, std::nullopt, {2, 3}, false},
                                {"in2", in, std::nullopt, {3, 2}, false},
                                {"c", *Section::make({1.0, 0.0, 0.0}, 1.0), std::nullopt, {}, false},
                                {"d", *Section::make({1.0, 0.0, 0.0}, 1.0, 0.5), std::nullopt, {}, false}});
  std::vector<Diagnostic> lost;
  EXPECT_THAT(edges_and_turns(written(zone, &lost)), ElementsAre("in1 NONE", "in2 NONE", "c NONE", "d NONE"));
  EXPECT_THAT(lost,
              Contains(Field(&Diagnostic::text, HasSubstr("is followed by d, c, which LIF can only express as c, d"))));
  // Without the contradiction "d" comes first.
  std::vector<Circuit::Part> parts;
  for (SectionId id = 0; id < 4; ++id) parts.push_back(zone.circuit.part(id));
  parts[0].next = {3, 2};
  EXPECT_THAT(edges_and_turns(written(bare_zone(parts))), ElementsAre("in1 NONE", "in2 NONE", "d NONE", "c NONE"));
}

TEST(LifWriter, names_everything_that_only_the_sidecar_can_express) {
  TrafficZone zone = metre();
  const auto first = [&] {
    std::vector<Diagnostic> lost;
    (void)written(zone, &lost);
    EXPECT_GE(lost.size(), 2U);
    EXPECT_EQ(lost.at(0).kind, Diagnostic::Kind::lost);
    EXPECT_EQ(lost.at(0).location, "zone");
    EXPECT_EQ(lost.at(1).kind, Diagnostic::Kind::notice);
    EXPECT_EQ(lost.at(1).location, "metaInformation.exportTimestamp");
    EXPECT_EQ(lost.at(1).text, "is the same in every file written here");
    return lost.at(0).text;
  };
  EXPECT_EQ(first(), "LIF cannot express the vehicle's measures and profiles; the sidecar file can");
  zone.tags.push_back({1, {0, 0.5}});
  zone.beacons = BeaconGrid{0.5, {}, 3, 2};
  zone.loops = {Loop{"round", {0}}};
  zone.priorities = {{"a/b", 3}};
  zone.starts = {{0, 0.5}};
  zone.closed = {0};
  EXPECT_EQ(first(),
            "LIF cannot express tags, beacons, loops, priorities, starts, closed sections, the vehicle's measures and "
            "profiles; the sidecar file can");
}

TEST(LifRoundTrip, keeps_any_chain_of_sections_within_a_millimetre) {
  EXPECT_TRUE(rc::check([] {
    const auto shapes = *rc::gen::resize(
        10, rc::gen::container<std::vector<std::pair<int, int>>>(rc::gen::pair(
                rc::gen::resize(100, rc::gen::inRange(-15, 16)), rc::gen::resize(100, rc::gen::inRange(3, 30)))));
    RC_PRE(!shapes.empty());
    std::vector<Circuit::Part> parts;
    Pose2 at;
    double curvature = 0.0;
    for (const auto& [k, length] : shapes) {
      const double length_m = 0.1 * length;
      const double end = 0.1 * k;
      auto section = Section::make(at, length_m, curvature, (end - curvature) / length_m);
      RC_PRE(section.has_value());
      at = section->end();
      curvature = end;
      const auto id = static_cast<SectionId>(parts.size());
      std::vector<SectionId> next;
      if (parts.size() + 1 < shapes.size()) next.push_back(id + 1);
      std::string name = "s";
      parts.push_back({name + std::to_string(id), *section, std::nullopt, next});
    }
    TrafficZone zone = native(yard);
    zone.stations.clear();
    zone.tags.clear();
    zone.waypoints.clear();
    zone.circuit = *Circuit::make("chain", std::move(parts));
    const auto again = LifCircuitFactory{}.make_zone(written(zone));
    RC_ASSERT(again.has_value());
    RC_ASSERT(again->circuit.size() == zone.circuit.size());
    for (SectionId id = 0; id < zone.circuit.size(); ++id) {
      for (int i = 0; i <= 8; ++i) {
        const Pose2 here = zone.circuit.section(id).pose_at(zone.circuit.section(id).length_m() * i / 8.0);
        RC_ASSERT(again->circuit.section(id).nearest(position(here)).distance_m < 1e-3);
      }
    }
  }));
}

TEST(LifEdit, goes_into_the_sidecar) {
  const ZoneConfiguration file = ready_zone("lif", "workshop.lif.json");
  const TrafficZone zone = read(file);
  ZoneEdit edit;
  edit.set_tags.push_back({99, {*zone.circuit.find("A1-A2"), 0.5}});
  edit.set_priorities.emplace_back("CoSiVA/AIV1", 7);
  const auto edited = LifCircuitFactory{}.edited(file, edit);
  ASSERT_TRUE(edited) << to_string(edited.error());
  EXPECT_EQ(edited->text, file.text);
  const TrafficZone after = read(*edited);
  ASSERT_NE(after.find_tag(99), nullptr);
  EXPECT_EQ(after.priority_of("CoSiVA/AIV1"), 7);
  EXPECT_TRUE(same_geometry(zone, after));
}

TEST(LifPlant, is_complete) {
  const TrafficZone zone = read(ready_zone("lif", "workshop.lif.json"));
  for (const Diagnostic& diagnostic : zone.diagnostics)
    EXPECT_NE(diagnostic.kind, Diagnostic::Kind::mended) << diagnostic.location << ": " << diagnostic.text;
  EXPECT_EQ(zone.stations.size(), 7U);
  EXPECT_GE(zone.start_positions(12).size(), 12U);
  for (SectionId id = 0; id < zone.circuit.size(); ++id) {
    EXPECT_FALSE(zone.circuit.next(id).empty()) << zone.circuit.part(id).name;
    // From any station to any section and back.
    EXPECT_TRUE(zone.circuit.shortest_route({id, 0.0}, zone.find_station("charger_1")->position, 100.0));
    EXPECT_TRUE(zone.circuit.shortest_route(zone.find_station("goods_out")->position, {id, 0.1}, 100.0));
  }
}

}  // namespace
}  // namespace cosiva::zone::lif
