// The sections, joints and stations of documents that are made by hand.
#include "cosiva/zone/lif/lif_circuit.h"

#include <gmock/gmock.h>

#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace cosiva::zone::lif {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

/// A document of one layout, its nodes named N0, N1 …, and the diagnostics about its tracks.
struct Drawn {
  Document document{"plan", std::vector<Layout>{Layout{"L", std::nullopt}}, {}, {}, {}};
  LifDiagnostics diagnostics{};

  std::size_t node(Point2 at, std::size_t layout = 0) {
    const std::string number = std::to_string(document.nodes.size());
    document.nodes.push_back({"N" + number, "nodes[" + number + "]", layout, at, false});
    return document.nodes.size() - 1;
  }
  Edge& edge(std::string id, std::size_t from, std::size_t to) {
    std::string location = "edges[" + std::to_string(document.edges.size()) + "]";
    document.edges.push_back({std::move(id), std::move(location), from, to});
    return document.edges.back();
  }
  void piece(std::string id, std::size_t from, std::size_t to) { edge(std::move(id), from, to).section = "X"; }
  Station& station(std::string id, std::vector<std::size_t> nodes) {
    std::string location = "stations[" + std::to_string(document.stations.size()) + "]";
    document.stations.push_back({id, id, std::move(location), std::move(nodes), false});
    return document.stations.back();
  }
  [[nodiscard]] Tracks made() {
    auto tracks = make_tracks(document, FitTolerance{}, diagnostics);
    EXPECT_TRUE(tracks) << to_string(tracks.error());
    return std::move(*tracks);
  }
  /// Code and location; empty where there is none.
  [[nodiscard]] std::string error() {
    const auto tracks = make_tracks(document, FitTolerance{}, diagnostics);
    return tracks ? std::string() : tracks.error().code + " at " + tracks.error().location;
  }
  [[nodiscard]] std::vector<std::string> texts() const {
    std::vector<std::string> all;
    for (const Diagnostic& diagnostic : diagnostics.take())
      all.push_back(std::string(to_string(diagnostic.kind)) + '|' + diagnostic.location + '|' + diagnostic.text);
    return all;
  }
};

std::vector<std::string> names_of(const Tracks& tracks) {
  std::vector<std::string> names;
  for (const Circuit::Part& part : tracks.parts) names.push_back(part.name);
  return names;
}

Point2 metre_on(Point2 p, double heading_rad) { return {p.x_m + std::cos(heading_rad), p.y_m + std::sin(heading_rad)}; }

// Nodes -----------------------------------------------------------------------------------------------------------

/// Whether an edge to a node goes on with an edge from a node `off` away.
bool is_one_point(Point2 at, Point2 off) {
  Drawn drawn;
  const auto from = drawn.node({at.x_m - 1.0, at.y_m});
  const auto end = drawn.node(at);
  const auto start = drawn.node({at.x_m + off.x_m, at.y_m + off.y_m});
  const auto to = drawn.node({at.x_m + 1.0, at.y_m});
  drawn.edge("in", from, end);
  drawn.edge("out", start, to);
  return drawn.made().parts.at(0).next == std::vector<SectionId>{1};
}

TEST(LifNodes, within_a_millimetre_of_each_other_are_one_in_every_direction) {
  for (const double x_m : {-0.0007, 0.0, 0.0007}) {
    for (const double y_m : {-0.0007, 0.0, 0.0007}) {
      EXPECT_TRUE(is_one_point({0.0005, 0.0005}, {x_m, y_m})) << x_m << ' ' << y_m;
      EXPECT_TRUE(is_one_point({-7.0005, 3.0005}, {x_m, y_m})) << x_m << ' ' << y_m;
    }
  }
  EXPECT_TRUE(is_one_point({0.0, 0.0}, {0.001, 0.0})) << "exactly a millimetre";
  for (const Point2 off : {Point2{0.0011, 0.0}, Point2{-0.0011, 0.0}, Point2{0.0, 0.0011}, Point2{0.0008, -0.0008}})
    EXPECT_FALSE(is_one_point({0.0005, 0.0005}, off)) << off.x_m << ' ' << off.y_m;
}

TEST(LifNodes, at_one_point_are_reported_with_the_first_id) {
  Drawn drawn;
  const auto from = drawn.node({0.0, 0.0});
  const auto to = drawn.node({1.0, 0.0});
  drawn.node({1.0, 0.0});
  drawn.edge("e", from, to);
  (void)drawn.made();
  EXPECT_THAT(drawn.texts(),
              ElementsAre("notice|nodes[2]|node 'N2' lies where 'N1' lies; they are one point with several ids"));
}

TEST(LifNodes, of_two_layouts_are_one_point_only_on_a_common_level) {
  const auto joined = [](const std::optional<std::string>& lower, const std::optional<std::string>& upper) {
    Drawn drawn;
    drawn.document.layouts = {Layout{"L", lower}, Layout{"M", upper}};
    const auto from = drawn.node({0.0, 0.0}, 0);
    const auto end = drawn.node({1.0, 0.0}, 0);
    const auto start = drawn.node({1.0, 0.0}, 1);
    const auto to = drawn.node({2.0, 0.0}, 1);
    drawn.edge("in", from, end);
    drawn.edge("out", start, to);
    return !drawn.made().parts.at(0).next.empty();
  };
  EXPECT_TRUE(joined("0", "0"));
  EXPECT_FALSE(joined("0", "1"));
  EXPECT_FALSE(joined(std::nullopt, std::nullopt));
  EXPECT_FALSE(joined("1", std::nullopt)) << "a level called as the other layout's number";
}

TEST(LifEdges, between_levels_are_lifts_only_where_both_levels_are_named) {
  const auto texts = [](const std::optional<std::string>& lower, const std::optional<std::string>& upper) {
    Drawn drawn;
    drawn.document.layouts = {Layout{"L", lower}, Layout{"M", upper}};
    const auto from = drawn.node({0.0, 0.0}, 0);
    const auto to = drawn.node({1.0, 0.0}, 1);
    drawn.edge("up", from, to);
    drawn.edge("flat", from, drawn.node({0.0, 1.0}, 0));
    const Tracks tracks = drawn.made();
    EXPECT_EQ(tracks.parts.size() + drawn.texts().size(), 2U);
    return drawn.texts();
  };
  EXPECT_THAT(texts("0", "1"), ElementsAre("lost|edges[0]|edge 'up' leads to another level; lifts are not taken"));
  EXPECT_THAT(texts("0", "0"), IsEmpty());
  EXPECT_THAT(texts("0", std::nullopt), IsEmpty());
  EXPECT_THAT(texts(std::nullopt, "0"), IsEmpty());
  EXPECT_THAT(texts(std::nullopt, std::nullopt), IsEmpty());
}

TEST(LifEdges, without_length_are_reported_as_points_to_turn_at) {
  const std::string same =
      "mended|edges[0]|edge 'e' has no length: its nodes are one point, where vehicles turn on the spot";
  Drawn itself;
  const auto a = itself.node({0.0, 0.0});
  itself.edge("e", a, a);
  itself.edge("f", a, itself.node({1.0, 0.0}));
  EXPECT_THAT(names_of(itself.made()), ElementsAre("f"));
  EXPECT_THAT(itself.texts(), ElementsAre(same));
  // The same point twice: one of them is on no level.
  Drawn above;
  above.document.layouts = {Layout{"L", "0"}, Layout{"M", std::nullopt}};
  const auto low = above.node({0.0, 0.0}, 0);
  above.edge("e", low, above.node({0.0, 0.0}, 1));
  above.edge("f", low, above.node({1.0, 0.0}, 0));
  EXPECT_THAT(names_of(above.made()), ElementsAre("f"));
  EXPECT_THAT(above.texts(), ElementsAre(same));
}

// Sections that were cut ------------------------------------------------------------------------------------------

/// X from 0 to 1 m, X.2 on to 3 m, and X.3 on to 6 m, along N0 to N3.
Drawn cut_line() {
  Drawn drawn;
  for (const double x_m : {0.0, 1.0, 3.0, 6.0}) drawn.node({x_m, 0.0});
  drawn.piece("X", 0, 1);
  drawn.piece("X.2", 1, 2);
  drawn.piece("X.3", 2, 3);
  return drawn;
}

TEST(LifPieces, become_one_section_with_their_stations_inside) {
  Drawn drawn = cut_line();
  drawn.edge("Y", 3, drawn.node({8.0, 0.0}));
  drawn.station("one", {1});
  drawn.station("three", {2});
  drawn.station("six", {3});
  const Tracks tracks = drawn.made();
  EXPECT_THAT(names_of(tracks), ElementsAre("X", "Y"));
  EXPECT_NEAR(tracks.parts[0].section.length_m(), 6.0, 1e-9);
  EXPECT_THAT(tracks.parts[0].next, ElementsAre(1));
  EXPECT_THAT(tracks.start_ids, ElementsAre("N0", "N3"));
  EXPECT_THAT(tracks.end_ids, ElementsAre("N3", "N4"));
  ASSERT_THAT(tracks.stations, SizeIs(3));
  for (const auto& [station, s_m] : {std::pair{0, 1.0}, {1, 3.0}, {2, 6.0}}) {
    const TrackPosition at = tracks.stations[static_cast<std::size_t>(station)].position;
    EXPECT_EQ(at.section, 0U);
    EXPECT_NEAR(at.s_m, s_m, 1e-9);
  }
  EXPECT_THAT(drawn.texts(), IsEmpty());
}

TEST(LifPieces, leave_a_station_at_their_end_to_the_edge_that_comes_first) {
  Drawn drawn;
  for (const double x_m : {0.0, 1.0, 3.0}) drawn.node({x_m, 0.0});
  drawn.edge("first", drawn.node({3.0, 2.0}), 2);
  drawn.piece("X", 0, 1);
  drawn.piece("X.2", 1, 2);
  drawn.station("three", {2});
  const Tracks tracks = drawn.made();
  EXPECT_THAT(names_of(tracks), ElementsAre("first", "X"));
  ASSERT_THAT(tracks.stations, SizeIs(1));
  EXPECT_EQ(tracks.stations[0].position, (TrackPosition{0, 2.0}));
}

TEST(LifPieces, stay_apart_where_another_edge_meets_them) {
  Drawn leaves = cut_line();
  leaves.edge("side", 1, leaves.node({1.0, 5.0}));
  EXPECT_THAT(names_of(leaves.made()), ElementsAre("X", "X.2", "X.3", "side"));
  Drawn arrives = cut_line();
  arrives.edge("side", arrives.node({3.0, 5.0}), 2);
  EXPECT_THAT(names_of(arrives.made()), ElementsAre("X", "X.3", "side")) << "the first two are still one";
}

TEST(LifPieces, are_only_those_that_name_the_section_in_ascending_order_without_a_gap) {
  Drawn other = cut_line();
  other.document.edges[2].section = "X.3";
  EXPECT_THAT(names_of(other.made()), ElementsAre("X", "X.3"));
  Drawn none = cut_line();
  none.document.edges[1].section.clear();
  EXPECT_THAT(names_of(none.made()), ElementsAre("X", "X.2", "X.3"));
  Drawn backwards = cut_line();
  std::swap(backwards.document.edges[0], backwards.document.edges[1]);
  EXPECT_THAT(names_of(backwards.made()), ElementsAre("X.2", "X", "X.3"));
  Drawn gap = cut_line();
  gap.document.edges[1].id = "X.4";
  EXPECT_THAT(names_of(gap.made()), ElementsAre("X", "X.4", "X.3"));
  Drawn elsewhere = cut_line();
  elsewhere.document.edges[1].from = elsewhere.node({1.0, 1.0});
  EXPECT_THAT(names_of(elsewhere.made()), ElementsAre("X", "X.2", "X.3"));
}

TEST(LifPieces, that_do_not_follow_one_curve_stay_apart) {
  Drawn drawn;
  for (const Point2 at : {Point2{0.0, 0.0}, Point2{1.0, 0.0}, Point2{1.0, 1.0}}) drawn.node(at);
  drawn.piece("X", 0, 1);
  drawn.piece("X.2", 1, 2);
  const Tracks tracks = drawn.made();
  EXPECT_THAT(names_of(tracks), ElementsAre("X", "X.2"));
  EXPECT_THAT(tracks.parts[0].next, ElementsAre(1));
  EXPECT_THAT(tracks.end_ids, ElementsAre("N1", "N2"));
}

TEST(LifTracks, of_a_trajectory_with_a_corner_have_names_that_no_edge_has) {
  Drawn drawn;
  const auto from = drawn.node({0.0, 0.0});
  const auto to = drawn.node({1.0, 1.0});
  Edge& bent = drawn.edge("e", from, to);
  bent.speed_mps_max = 0.4;
  bent.trajectory = Nurbs{1, {0, 0, 0.5, 1, 1}, {{0.0, 0.0}, {1.0, 0.0}, {1.0, 1.0}}, {1.0, 1.0, 1.0}};
  drawn.edge("e.2", to, from);
  const Tracks tracks = drawn.made();
  EXPECT_THAT(names_of(tracks), ElementsAre("e", "e.2'", "e.2"));
  EXPECT_THAT(tracks.parts[0].next, ElementsAre(1));
  EXPECT_THAT(tracks.parts[1].next, ElementsAre(2));
  EXPECT_THAT(tracks.parts[2].next, ElementsAre(0));
  EXPECT_TRUE(tracks.parts[0].pivots);
  EXPECT_EQ(tracks.parts[0].speed_mps_max, 0.4);
  EXPECT_EQ(tracks.parts[1].speed_mps_max, 0.4);
  EXPECT_EQ(tracks.parts[2].speed_mps_max, std::nullopt);
  EXPECT_THAT(tracks.start_ids, ElementsAre("N0", "", "N1"));
  EXPECT_THAT(tracks.end_ids, ElementsAre("", "N1", "N0"));
}

// Joints ----------------------------------------------------------------------------------------------------------

TEST(LifTurns, of_a_tenth_of_a_radian_are_driven_where_turning_is_forbidden) {
  const auto forbidden = [](double turn_rad, Rotation arriving, Rotation leaving) {
    Drawn drawn;
    const auto from = drawn.node({-1.0, 0.0});
    const auto hub = drawn.node({0.0, 0.0});
    drawn.edge("in", from, hub).arriving = arriving;
    drawn.edge("out", hub, drawn.node(metre_on({0.0, 0.0}, turn_rad))).leaving = leaving;
    const Tracks tracks = drawn.made();
    EXPECT_THAT(tracks.parts[0].next, ElementsAre(1)) << "no other edge leads on";
    EXPECT_EQ(tracks.parts[0].pivots, arriving != Rotation::none || turn_rad != 0.0);
    return drawn.texts();
  };
  const std::string turned =
      "mended|edges[0]|no path leads on from edge 'in' without a turn, which its node forbids; vehicles turn there all "
      "the same";
  for (const auto& [arriving, leaving] : {std::pair{Rotation::none, Rotation::any}, {Rotation::any, Rotation::none}}) {
    for (const double side : {1.0, -1.0}) {
      EXPECT_THAT(forbidden(side * 0.099, arriving, leaving), IsEmpty());
      EXPECT_THAT(forbidden(side * 0.101, arriving, leaving), ElementsAre(turned));
    }
    EXPECT_THAT(forbidden(0.0, arriving, leaving), IsEmpty());
  }
  EXPECT_THAT(forbidden(1.5, Rotation::one_way, Rotation::any), IsEmpty());
  EXPECT_THAT(forbidden(1.5, Rotation::any, Rotation::one_way), IsEmpty());
}

/// The successors of an arc from A, heading east, that turns left by `turn_rad`: 1, straight back to A, and 2, that
/// turns by `other_rad`.
std::vector<SectionId> after_arc(double turn_rad, double other_rad) {
  const Point2 end{std::sin(turn_rad), 1.0 - std::cos(turn_rad)};
  Drawn drawn;
  const auto a = drawn.node({0.0, 0.0});
  const auto b = drawn.node(end);
  drawn.edge("arc", a, b).trajectory = Nurbs{
      2, {0, 0, 0, 1, 1, 1}, {{0.0, 0.0}, {std::tan(0.5 * turn_rad), 0.0}, end}, {1.0, std::cos(0.5 * turn_rad), 1.0}};
  drawn.edge("back", b, a);
  drawn.edge("other", b, drawn.node(metre_on(end, turn_rad + other_rad)));
  const Tracks tracks = drawn.made();
  EXPECT_THAT(names_of(tracks), ElementsAre("arc", "back", "other"));
  return tracks.parts[0].next;
}

TEST(LifTurns, back_to_the_node_before_are_last_from_135_degrees_on) {
  constexpr double degree = pi / 180.0;
  // The chord back leaves at 180° less half the arc's turn.
  EXPECT_THAT(after_arc(60.0 * degree, 170.0 * degree), ElementsAre(2, 1)) << "150° back";
  EXPECT_THAT(after_arc(120.0 * degree, 130.0 * degree), ElementsAre(1, 2)) << "120° is no turning back";
}

TEST(LifTurns, of_exactly_135_degrees_are_no_turning_back) {
  Drawn drawn;
  const auto a = drawn.node({0.0, 0.0});
  const auto b = drawn.node({1.0, 0.0});
  drawn.edge("in", a, b);
  drawn.edge("back", b, a).trajectory =
      Nurbs{1, {0, 0, 0.5, 1, 1}, {{1.0, 0.0}, {0.0, 1.0}, {0.0, 0.0}}, {1.0, 1.0, 1.0}};
  drawn.edge("other", b, drawn.node(metre_on({1.0, 0.0}, 150.0 / 180.0 * pi)));
  const Tracks tracks = drawn.made();
  EXPECT_THAT(names_of(tracks), ElementsAre("in", "back", "back.2", "other"));
  EXPECT_EQ(tracks.parts[1].section.start().heading_rad, 0.75 * pi);
  EXPECT_THAT(tracks.parts[0].next, ElementsAre(1, 3));
}

TEST(LifTurns, are_needless_at_a_dead_end) {
  for (const Rotation arriving : {Rotation::any, Rotation::none}) {
    Drawn drawn;
    const auto from = drawn.node({0.0, 0.0});
    drawn.edge("e", from, drawn.node({1.0, 0.0})).arriving = arriving;
    const Tracks tracks = drawn.made();
    EXPECT_THAT(tracks.parts[0].next, IsEmpty());
    EXPECT_EQ(tracks.parts[0].pivots, arriving == Rotation::any);
    EXPECT_THAT(drawn.texts(), IsEmpty());
  }
}

TEST(LifTracks, may_be_more_than_a_thousand_sections) {
  Drawn drawn;
  drawn.node({0.0, 0.0});
  for (std::size_t i = 0; i < 1100; ++i)
    drawn.edge("e" + std::to_string(i), i, drawn.node({static_cast<double>(i + 1), 0.0}));
  EXPECT_THAT(drawn.made().parts, SizeIs(1100));
}

TEST(LifTracks, may_join_a_hundred_and_twenty_edges_with_as_many) {
  Drawn drawn;
  const auto hub = drawn.node({0.0, 0.0});
  for (int i = 0; i < 120; ++i) {
    const std::string number = std::to_string(i);
    drawn.edge("in" + number, drawn.node({-1.0, 0.01 * i}), hub);
    drawn.edge("out" + number, hub, drawn.node({1.0, 0.01 * i}));
  }
  const Tracks tracks = drawn.made();
  ASSERT_THAT(tracks.parts, SizeIs(240));
  for (SectionId id = 0; id < 240; ++id) EXPECT_THAT(tracks.parts[id].next, SizeIs(id % 2 == 0 ? 120 : 0)) << id;
}

TEST(LifTracks, may_be_exactly_a_hundred_kilometres_long) {
  Drawn drawn;
  for (const double x_m : {0.0, 50'000.0, 100'000.0}) drawn.node({x_m, 0.0});
  drawn.edge("a", 0, 1);
  drawn.edge("b", 1, 2);
  EXPECT_THAT(drawn.made().parts, SizeIs(2));
  drawn.edge("c", 0, drawn.node({0.0, 1.0}));
  EXPECT_EQ(drawn.error(), "zone.size at edges[2]");
}

TEST(LifTracks, are_refused_where_no_edge_is_left) {
  Drawn drawn;
  EXPECT_EQ(drawn.error(), "circuit.empty at layouts");
  const auto a = drawn.node({0.0, 0.0});
  drawn.edge("e", a, a);
  EXPECT_EQ(drawn.error(), "circuit.empty at layouts");
}

// Stations --------------------------------------------------------------------------------------------------------

TEST(LifStations, lie_where_an_edge_to_their_own_node_ends_or_else_where_one_begins) {
  Drawn drawn;
  const auto a = drawn.node({-1.0, 0.0});
  const auto c = drawn.node({0.0, 2.0});
  const auto first = drawn.node({0.0, 0.0});
  const auto second = drawn.node({0.0, 0.0});
  const auto third = drawn.node({0.0, 0.0});
  drawn.edge("one", a, first);
  drawn.edge("two", c, second);
  drawn.station("S0", {second});
  drawn.station("S1", {first});
  drawn.station("S2", {third});
  drawn.station("S3", {c});
  const Tracks tracks = drawn.made();
  ASSERT_THAT(tracks.stations, SizeIs(4));
  EXPECT_EQ(tracks.stations[0].position, (TrackPosition{1, 2.0}));
  EXPECT_EQ(tracks.stations[1].position, (TrackPosition{0, 1.0}));
  EXPECT_EQ(tracks.stations[2].position, (TrackPosition{0, 1.0})) << "no edge leads to that very node";
  EXPECT_EQ(tracks.stations[3].position, (TrackPosition{1, 0.0})) << "no edge ends there";
}

/// Edges from N0 to N1, N2 and N3; N4 is reached by none.
Drawn fan() {
  Drawn drawn;
  for (const Point2 at : {Point2{0.0, 0.0}, Point2{1.0, 1.0}, Point2{1.0, 0.0}, Point2{1.0, -1.0}, Point2{9.0, 9.0}})
    drawn.node(at);
  for (std::size_t to = 1; to < 4; ++to) drawn.edge("e" + std::to_string(to), 0, to);
  return drawn;
}
std::vector<std::string> station_names(const Tracks& tracks) {
  std::vector<std::string> names;
  for (const zone::Station& station : tracks.stations) names.push_back(station.name);
  return names;
}

TEST(LifStations, of_several_nodes_are_numbered_from_the_second_on) {
  Drawn one = fan();
  one.station("S", {1});
  EXPECT_THAT(station_names(one.made()), ElementsAre("S"));
  EXPECT_THAT(one.texts(), IsEmpty());
  const std::string several =
      "notice|stations[0]|station 'S' has several interaction nodes; the further ones are numbered: .2, .3 …";
  Drawn two = fan();
  two.station("S", {1, 1, 2, 4});
  EXPECT_THAT(station_names(two.made()), ElementsAre("S", "S.2"));
  EXPECT_THAT(two.texts(), ElementsAre(several));
  Drawn three = fan();
  three.station("S", {1, 2, 3});
  EXPECT_THAT(station_names(three.made()), ElementsAre("S", "S.2", "S.3"));
  EXPECT_THAT(three.texts(), ElementsAre(several));
}

TEST(LifStations, that_no_edge_leads_to_are_lost) {
  Drawn drawn = fan();
  drawn.station("S", {4});
  EXPECT_THAT(drawn.made().stations, IsEmpty());
  EXPECT_THAT(drawn.texts(),
              ElementsAre("lost|stations[0]|no edge leads to an interaction node of station 'S'; not taken"));
}

TEST(LifStations, of_one_name_are_identified_by_their_ids) {
  Drawn drawn = fan();
  drawn.station("S1", {1}).name = "dock";
  drawn.station("S2", {2}).name = "dock";
  drawn.station("S2", {3}).name = "dock";
  EXPECT_THAT(station_names(drawn.made()), ElementsAre("dock", "S2", "S2'"));
  EXPECT_THAT(drawn.texts(),
              ElementsAre("mended|stations[1]|another station is called 'dock'; identified by its id (2 times, also at "
                          "stations[2])"));
}

TEST(LifStations, are_chargers_where_they_or_a_node_at_their_point_charge) {
  Drawn drawn = fan();
  drawn.document.nodes[1].charges = true;
  const auto twin = drawn.node({1.0, 0.0});  // where N2 lies
  drawn.document.nodes[twin].charges = true;
  drawn.station("by node", {1});
  drawn.station("by twin", {2, twin});
  drawn.station("by itself", {3}).charges = true;
  drawn.station("none", {3});
  const Tracks tracks = drawn.made();
  ASSERT_THAT(tracks.stations, SizeIs(4));
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(tracks.stations[i].kind, StationKind::charger) << i;
  EXPECT_EQ(tracks.stations[3].kind, StationKind::stop);
}

TEST(LifStations, are_made_for_chargers_that_have_none_and_can_be_reached) {
  Drawn drawn = fan();
  for (const std::size_t node : {1U, 2U, 4U}) drawn.document.nodes[node].charges = true;
  drawn.station("S", {1});
  const Tracks tracks = drawn.made();
  EXPECT_THAT(station_names(tracks), ElementsAre("S", "N2"));
  EXPECT_EQ(tracks.stations[1].kind, StationKind::charger);
  EXPECT_EQ(tracks.stations[1].position, (TrackPosition{1, 1.0}));
  EXPECT_THAT(
      drawn.texts(),
      ElementsAre("mended|nodes[2]|node 'N2' offers startCharging but no station; it is a charger of that name"));
}

}  // namespace
}  // namespace cosiva::zone::lif
