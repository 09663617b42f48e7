#include "cosiva/planning/track/track_floor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "cosiva/planning/floor/distances.h"
#include "cosiva/zone/testing/test_zones.h"

namespace cosiva::planning {
namespace {

using zone::testing::read_zone;

/// A lane of 4 m in both directions, with a station at each end, for vehicles of 1.2 m by 0.8 m.
constexpr const char* lane = R"(name = "lane"
format_version = 1
[vehicle]
length_m = 1.2
width_m = 0.8
[waypoints]
nodes_only = true
[[section]]
name = "there"
kind = "straight"
length_m = 4
pivots = true
start = { x = 0, y = 0, heading_deg = 0 }
start_node = "west"
next = ["back"]
[[section]]
name = "back"
kind = "straight"
length_m = 4
pivots = true
start = { x = 4, y = 0, heading_deg = 180 }
start_node = "east"
next = ["there"]
[[station]]
name = "dock"
section = "there"
s_m = 0
)";

TrackFloor floor_of(const char* text) {
  const auto zone = read_zone(text);
  EXPECT_TRUE(zone) << to_string(zone.error());
  return TrackFloor::make(*zone);
}

TEST(TrackFloor, has_one_state_per_waypoint_and_section_by_which_it_is_reached) {
  const TrackFloor track = floor_of(lane);
  ASSERT_EQ(track.floor().states(), 4U);
  EXPECT_EQ(track.position(0), (zone::TrackPosition{0, 0.0}));
  EXPECT_EQ(track.position(1), (zone::TrackPosition{0, 4.0}));
  EXPECT_EQ(track.position(3), (zone::TrackPosition{1, 4.0}));
  EXPECT_THAT(track.floor().successors(1), testing::ElementsAre(3));
  EXPECT_THAT(track.sections(1, 3), testing::ElementsAre(1));
}

TEST(TrackFloor, leads_a_vehicle_that_begins_at_the_beginning_of_a_section_along_that_section) {
  const TrackFloor track = floor_of(lane);
  EXPECT_THAT(track.floor().successors(0), testing::ElementsAre(1));
  EXPECT_THAT(track.sections(0, 1), testing::IsEmpty());
  EXPECT_THAT(track.floor().predecessors(0), testing::IsEmpty());
}

TEST(TrackFloor, finds_the_state_at_a_position_and_the_next_one) {
  const TrackFloor track = floor_of(lane);
  EXPECT_EQ(track.state_at({1, 4.0}), 3U);
  EXPECT_EQ(track.state_at({0, 0.0}), 0U);
  EXPECT_EQ(track.state_at({0, 2.0}), std::nullopt);
  EXPECT_EQ(track.state_after({0, 2.0}, {}), 1U);
}

TEST(TrackFloor, finds_the_states_of_stations_and_waypoints) {
  const TrackFloor track = floor_of(lane);
  ASSERT_TRUE(track.goal("dock"));
  EXPECT_THAT(track.floor().goal(*track.goal("dock")), testing::ElementsAre(0, 3));
  ASSERT_TRUE(track.goal("east"));
  EXPECT_THAT(track.floor().goal(*track.goal("east")), testing::ElementsAre(1, 2));
  EXPECT_FALSE(track.goal("nowhere"));
}

TEST(TrackFloor, finds_the_moves_into_closed_sections) {
  const TrackFloor track = floor_of(lane);
  const zone::SectionId back[] = {1};
  const auto closed = track.moves_into(back);
  ASSERT_FALSE(closed.empty());
  const Floor open = track.floor().without({{}, closed});
  EXPECT_TRUE(open.successors(1).empty()) << "a vehicle at the end of the lane cannot turn back";
  EXPECT_THAT(open.successors(3), testing::ElementsAre(1)) << "a vehicle on the closed section may leave it";
}

/// An independent test of two rectangles: points of one that lie in the other, at most 2 cm apart.
bool overlap(const Pose2& a, const Pose2& b, const zone::VehicleShape& shape) {
  const auto contains = [&](const Pose2& body, Point2 p_M) {
    const Point2 p_B = inverse(body) * p_M;
    return std::fabs(p_B.x_m) <= 0.5 * shape.length_m && std::fabs(p_B.y_m) <= 0.5 * shape.width_m;
  };
  const auto meets = [&](const Pose2& body, const Pose2& other) {
    for (double x = -0.5 * shape.length_m; x <= 0.5 * shape.length_m; x += 0.02)
      for (double y = -0.5 * shape.width_m; y <= 0.5 * shape.width_m; y += 0.02)
        if (contains(other, body * Point2{x, y})) return true;
    return false;
  };
  return meets(a, b) || meets(b, a);
}

bool have_common_cell(const Floor& floor, StateId a, StateId b) {
  return std::ranges::any_of(floor.footprint(a),
                             [&](CellId cell) { return std::ranges::binary_search(floor.footprint(b), cell); });
}

class ShippedZones : public testing::TestWithParam<const char*> {};

TEST_P(ShippedZones, have_a_common_cell_for_any_two_states_whose_bodies_overlap) {
  const zone::TrafficZone zone = zone::testing::zone_file(GetParam());
  const TrackFloor track = TrackFloor::make(zone);
  const auto pose = [&](StateId state) { return zone.circuit.pose_at(track.position(state)); };
  std::size_t overlapping = 0;
  for (StateId a = 0; a < track.floor().states(); ++a) {
    for (StateId b = a + 1; b < track.floor().states(); ++b) {
      if (distance(pose(a), pose(b)) > zone.vehicle.length_m + zone.vehicle.width_m) continue;
      if (!overlap(pose(a), pose(b), zone.vehicle)) continue;
      ++overlapping;
      EXPECT_TRUE(have_common_cell(track.floor(), a, b)) << a << " and " << b;
    }
  }
  EXPECT_GT(overlapping, 0U);
}

TEST_P(ShippedZones, have_no_common_cell_for_states_further_apart_than_a_body_is_long) {
  const zone::TrafficZone zone = zone::testing::zone_file(GetParam());
  const TrackFloor track = TrackFloor::make(zone);
  const auto point = [&](StateId state) { return position(zone.circuit.pose_at(track.position(state))); };
  const double apart_m = zone.vehicle.length_m + zone.vehicle.width_m + zone.clearance_m;
  for (StateId a = 0; a < track.floor().states(); ++a) {
    for (StateId b = a + 1; b < track.floor().states(); ++b) {
      if (distance(point(a), point(b)) <= apart_m) continue;
      EXPECT_FALSE(have_common_cell(track.floor(), a, b)) << a << " and " << b;
    }
  }
}

/// Poses of a body in the course of a move.
std::vector<Pose2> poses(const zone::TrafficZone& zone, const TrackFloor& track, StateId from, StateId to) {
  std::vector<Pose2> found;
  zone::TrackPosition at = track.position(from);
  const auto drive = [&](double end_m) {
    for (; at.s_m < end_m; at.s_m += 0.05) found.push_back(zone.circuit.pose_at(at));
  };
  for (const zone::SectionId section : track.sections(from, to)) {
    drive(zone.circuit.section(at.section).length_m());
    at = {section, 0.0};
  }
  drive(track.position(to).s_m);
  return found;
}

TEST_P(ShippedZones, let_no_move_touch_a_vehicle_in_a_state_that_footprints_and_sweep_leave_free) {
  const zone::TrafficZone zone = zone::testing::zone_file(GetParam());
  const TrackFloor track = TrackFloor::make(zone);
  const Floor& floor = track.floor();
  for (StateId from = 0; from < floor.states(); ++from) {
    for (std::size_t move = 0; move < floor.successors(from).size(); ++move) {
      const StateId to = floor.successors(from)[move];
      std::set<CellId> used;
      for (const auto cells : {floor.footprint(from), floor.footprint(to), floor.sweep(from, move)})
        used.insert(cells.begin(), cells.end());
      const auto path = poses(zone, track, from, to);
      for (StateId other = 0; other < floor.states(); ++other) {
        const auto cells = floor.footprint(other);
        if (std::ranges::any_of(cells, [&](CellId cell) { return used.contains(cell); })) continue;
        const Pose2 body = zone.circuit.pose_at(track.position(other));
        const bool touched = std::ranges::any_of(path, [&](const Pose2& pose) {
          return distance(pose, body) <= zone.vehicle.length_m + zone.vehicle.width_m &&
                 overlap(pose, body, zone.vehicle);
        });
        EXPECT_FALSE(touched) << "from " << from << " to " << to << ", past " << other;
      }
    }
  }
}

TEST(TrackFloor, has_a_common_cell_for_two_moves_that_cross_between_their_ends) {
  const TrackFloor track = floor_of(R"(name = "cross"
format_version = 1
[vehicle]
length_m = 1.2
width_m = 0.8
[waypoints]
nodes_only = true
[[section]]
name = "east"
kind = "straight"
length_m = 6
start = { x = 0, y = 0, heading_deg = 0 }
start_node = "W"
end_node = "E"
next = []
[[section]]
name = "north"
kind = "straight"
length_m = 6
start = { x = 3, y = -3, heading_deg = 90 }
start_node = "S"
end_node = "N"
next = []
)");
  const Floor& floor = track.floor();
  // Of all swept cells: which sections the moves are on.
  std::map<CellId, std::set<zone::SectionId>> sections;
  for (StateId from = 0; from < floor.states(); ++from)
    for (std::size_t move = 0; move < floor.successors(from).size(); ++move)
      for (const CellId cell : floor.sweep(from, move)) sections[cell].insert(track.position(from).section);
  EXPECT_TRUE(std::ranges::any_of(sections, [](const auto& swept) { return swept.second.size() == 2; }));
}

TEST_P(ShippedZones, lead_from_every_state_to_every_station) {
  const zone::TrafficZone zone = zone::testing::zone_file(GetParam());
  const TrackFloor track = TrackFloor::make(zone);
  Distances distances{track.floor()};
  for (const zone::Station& station : zone.stations) {
    const auto goal = track.goal(station.name);
    ASSERT_TRUE(goal) << station.name;
    const auto* const to = distances.to(*goal);
    for (StateId state = 0; state < track.floor().states(); ++state)
      EXPECT_LT(to[state], Distances::unreachable) << station.name << " from " << state;
  }
}

std::string name_of(const testing::TestParamInfo<const char*>& info) {
  std::string name = info.param;
  std::ranges::replace_if(
      name, [](char c) { return std::isalnum(static_cast<unsigned char>(c)) == 0; }, '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(TrackFloor, ShippedZones,
                         testing::Values("lacet4.toml", "indus8.toml", "../src/planning/testdata/warehouse12.toml"),
                         name_of);

TEST(TrackFloor, measures_its_moves) {
  const TrackFloor track = floor_of(lane);
  EXPECT_DOUBLE_EQ(track.length_m(0, 1), 4.0);
  EXPECT_DOUBLE_EQ(track.length_m(1, 3), 4.0);
  EXPECT_EQ(track.driven_m(0, 1, {0, 1.5}), 1.5);
  EXPECT_EQ(track.driven_m(1, 3, {0, 4.0}), 0.0) << "before it has turned";
  EXPECT_EQ(track.driven_m(1, 3, {1, 1.5}), 1.5);
  EXPECT_EQ(track.driven_m(0, 1, {1, 1.5}), std::nullopt);
  EXPECT_EQ(track.state_before({0, 2.0}), 0U);
  EXPECT_EQ(track.state_before({1, 3.9}), 2U);
}

TEST(TrackFloor, is_obstructed_by_a_body_on_the_track_and_not_by_one_off_it) {
  const TrackFloor track = floor_of(lane);
  const auto by = [&](const Pose2& X_MB) {
    SweptArea area = track.empty_area();
    area.add_pose(X_MB);
    return track.obstructed(area);
  };
  const Obstruction between = by({2.0, 0.0, 0.0});
  EXPECT_THAT(between.cells, testing::IsEmpty()) << "no state is within 1.2 m, a body's length";
  EXPECT_THAT(between.moves, testing::ElementsAre(FloorMove{0, 1}, FloorMove{1, 3}, FloorMove{2, 3}, FloorMove{3, 1}));
  EXPECT_EQ(by({0.5, 0.0, 0.0}).cells.size(), 1U);
  EXPECT_EQ(by({2.0, 1.2, 0.0}), Obstruction{});
}

/// Four two-way tracks from one node: section 2·i leads outwards, to the east, north, west and south,
/// section 2·i + 1 back.
TrackFloor star(int pitch_m) {
  std::string text = R"(name = "star"
format_version = 1
[vehicle]
length_m = 1.2
width_m = 0.8
[waypoints]
nodes_only = true
)";
  const std::array<std::string, 4> ends{"east", "north", "west", "south"};
  const std::array<std::pair<int, int>, 4> directions{{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};
  const std::string all = R"("to_east", "to_north", "to_west", "to_south")";
  const auto add = [&](const std::string& name, int x, int y, int heading, const std::string& node,
                       const std::string& next) {
    text += "[[section]]\nname = \"" + name;
    text += "\"\nkind = \"straight\"\npivots = true\nlength_m = " + std::to_string(pitch_m);
    text += "\nstart = { x = " + std::to_string(x) + ", y = " + std::to_string(y);
    text += ", heading_deg = " + std::to_string(heading % 360) + " }\nstart_node = \"" + node;
    text += "\"\nnext = [" + next + "]\n";
  };
  for (std::size_t i = 0; i < 4; ++i) {
    const auto [x, y] = directions[i];
    const int heading = 90 * static_cast<int>(i);
    add("to_" + ends[i], 0, 0, heading, "centre", "\"from_" + ends[i] + "\"");
    add("from_" + ends[i], x * pitch_m, y * pitch_m, heading + 180, ends[i], all);
  }
  return floor_of(text.c_str());
}

TEST(TrackFloor, is_clear_of_a_node_when_no_body_that_turns_there_touches_the_rest_of_the_move) {
  const TrackFloor track = star(3);
  const auto to_east = *track.state_at({0, 3.0});
  const auto from_north = *track.state_at({3, 3.0});
  // Half a diagonal of 0.72 m at the node and half a length of 0.6 m, and the clearances of both bodies.
  const double clear_m = track.clear_m(from_north, to_east);
  EXPECT_GE(clear_m, 0.72 + 0.6);
  EXPECT_LE(clear_m, 0.72 + 0.6 + 0.6) << "poses are half a width apart";
}

}  // namespace
}  // namespace cosiva::planning
