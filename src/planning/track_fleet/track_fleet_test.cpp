#include "cosiva/planning/track_fleet/track_fleet.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <string>

#include "cosiva/base/archive.h"
#include "cosiva/zone/testing/test_zones.h"

namespace cosiva::planning {
namespace {

/// A square of four nodes, 3 m apart, joined by two-way tracks: section 2·i leads from node i to the next one, section
/// 2·i + 1 back.
zone::TrafficZone square() {
  std::string text =
      "name = \"square\"\nformat_version = 1\n[vehicle]\nlength_m = 1.2\nwidth_m = 0.8\n[waypoints]\nnodes_only = "
      "true\n";
  const std::array<std::string, 4> starts{"x = 0, y = 0", "x = 3, y = 0", "x = 3, y = 3", "x = 0, y = 3"};
  const auto section = [&](const std::string& name, int at, int heading, const std::string& next) {
    const auto node = static_cast<std::size_t>(at % 4);
    text += "[[section]]\nname = \"" + name + "\"\nkind = \"straight\"\nlength_m = 3\npivots = true\nstart = { " +
            starts[node] + ", heading_deg = " + std::to_string(heading % 360) + " }\nstart_node = \"n" +
            std::to_string(node) + "\"\nnext = [" + next + "]\n";
  };
  const auto named = [](const char* kind, int i) {
    return "\"" + std::string(kind) + std::to_string((i + 4) % 4) + "\"";
  };
  for (int i = 0; i < 4; ++i) {
    section("on" + std::to_string(i), i, 90 * i, named("on", i + 1) + ", " + named("back", i));
    section("back" + std::to_string(i), i + 1, 90 * i + 180, named("back", i - 1) + ", " + named("on", i));
  }
  const auto zone = zone::testing::read_zone(text.c_str());
  EXPECT_TRUE(zone) << to_string(zone.error());
  return *zone;
}

class FleetOnASquare : public ::testing::Test {
 protected:
  FleetOnASquare() { fleet.resize(vehicles); }
  /// The state of a vehicle that has come to node i along the square.
  [[nodiscard]] StateId at(int node) const {
    return *fleet.track().state_at({static_cast<zone::SectionId>(2 * ((node + 3) % 4)), 3.0});
  }
  [[nodiscard]] GoalId node(int i) const { return *fleet.track().goal("n" + std::to_string(i)); }
  void go(Vehicle vehicle, int i) {
    const Stop stop{node(i), 1};
    fleet.set_stops(vehicle, std::span{&stop, 1}, 0);
  }
  [[nodiscard]] bool is_at(Vehicle vehicle, int i) const {
    const auto states = fleet.track().floor().goal(node(i));
    return std::ranges::find(states, fleet.states(vehicle)[0]) != states.end();
  }
  /// Plans, and executes what is granted, in so many rounds.
  void drive(int rounds) {
    for (int i = 0; i < rounds; ++i) {
      fleet.plan();
      for (Vehicle vehicle = 0; vehicle < vehicles; ++vehicle)
        if (fleet.takes_part(vehicle)) static_cast<void>(fleet.grant(vehicle));
      for (Vehicle vehicle = 0; vehicle < vehicles; ++vehicle)
        if (fleet.takes_part(vehicle) && !fleet.is_set_aside(vehicle) && fleet.granted_moves(vehicle) > 0)
          fleet.arrive(vehicle);
    }
  }
  [[nodiscard]] bool join(Vehicle vehicle, int i) {
    const StateId state = at(i);
    return fleet.join(vehicle, std::span{&state, 1});
  }

  static constexpr Vehicle vehicles = 3;
  TrackFleet fleet{square(), {}, 1};
};

TEST_F(FleetOnASquare, plans_for_the_vehicles_that_have_joined) {
  ASSERT_TRUE(join(0, 0));
  go(0, 2);
  drive(4);
  EXPECT_TRUE(is_at(0, 2));
  ASSERT_TRUE(join(2, 0));
  go(0, 0);
  go(2, 2);
  drive(8);
  EXPECT_TRUE(is_at(0, 0));
  EXPECT_TRUE(is_at(2, 2)) << "the two have passed each other";
  EXPECT_FALSE(fleet.takes_part(1));
}

TEST_F(FleetOnASquare, refuses_a_vehicle_where_another_one_is_or_is_granted_to_go) {
  ASSERT_TRUE(join(0, 0));
  EXPECT_FALSE(join(1, 0));
  go(0, 1);
  fleet.plan();
  ASSERT_TRUE(fleet.grant(0));
  EXPECT_FALSE(join(1, 1));
  EXPECT_TRUE(join(1, 2));
  fleet.leave(0);
  EXPECT_TRUE(join(2, 1));
}

TEST_F(FleetOnASquare, goes_round_a_vehicle_that_is_set_aside) {
  ASSERT_TRUE(join(0, 0) && join(1, 1));
  fleet.set_aside(1, true);
  go(0, 2);
  drive(6);
  EXPECT_TRUE(is_at(0, 2));
  EXPECT_TRUE(is_at(1, 1));
  go(0, 1);
  fleet.plan();
  EXPECT_FALSE(fleet.reachable(0)) << "it does not make room";
  fleet.set_aside(1, false);
  drive(8);
  EXPECT_TRUE(is_at(0, 1)) << "now it does";
}

TEST_F(FleetOnASquare, keeps_the_granted_moves_of_a_vehicle_that_is_set_aside) {
  ASSERT_TRUE(join(0, 0) && join(1, 2));
  go(0, 1);
  fleet.plan();
  ASSERT_TRUE(fleet.grant(0));
  fleet.set_aside(0, true);
  EXPECT_EQ(fleet.granted_moves(0), 1U);
  go(1, 0);
  drive(6);
  EXPECT_FALSE(is_at(1, 0)) << "the body may be anywhere between the nodes 0 and 1";
  fleet.clear(0);
  drive(6);
  EXPECT_TRUE(is_at(1, 0));
  fleet.arrive(0);
  EXPECT_TRUE(is_at(0, 1));
}

TEST_F(FleetOnASquare, goes_round_what_is_obstructed) {
  ASSERT_TRUE(join(0, 0));
  const zone::SectionId closed[] = {0};
  fleet.obstruct({{}, fleet.track().moves_into(closed)});
  go(0, 1);
  drive(1);
  EXPECT_FALSE(is_at(0, 1));
  drive(4);
  EXPECT_TRUE(is_at(0, 1)) << "by the other three sides";
  EXPECT_EQ(fleet.moves_to(node(1), at(0)), 1U) << "were nothing obstructed";
}

TEST_F(FleetOnASquare, continues_from_its_archive_as_without) {
  ASSERT_TRUE(join(0, 0) && join(1, 1) && join(2, 3));
  go(0, 2);
  go(1, 3);
  go(2, 1);
  drive(1);
  fleet.set_aside(2, true);
  fleet.plan();
  std::string bytes;
  Archive out{bytes};
  out(fleet);
  ASSERT_TRUE(out.finish());
  TrackFleet other{square(), {}, 1};
  Archive in{std::string_view{bytes}};
  in(other);
  ASSERT_TRUE(in.finish());
  const auto end_of = [&](TrackFleet& one) {
    std::vector<StateId> states;
    one.set_aside(2, false);
    for (int i = 0; i < 12; ++i) {
      one.plan();
      for (Vehicle vehicle = 0; vehicle < 3; ++vehicle)
        if (one.grant(vehicle)) one.arrive(vehicle);
      for (Vehicle vehicle = 0; vehicle < 3; ++vehicle)
        states.insert(states.end(), one.states(vehicle).begin(), one.states(vehicle).end());
    }
    return states;
  };
  EXPECT_EQ(end_of(fleet), end_of(other));
}

}  // namespace
}  // namespace cosiva::planning
