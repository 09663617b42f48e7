#include "cosiva/planning/fleet/fleet_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "cosiva/base/digest.h"
#include "cosiva/planning/testing/test_floors.h"

namespace cosiva::planning {
namespace {

/// How a fleet is driven in these tests.
struct DriveRules {
  double stop_chance = 0.0;  ///< with which a vehicle stops in the course of a move, for 2 to 10 steps
  double speed_spread = 0.1;
  Vehicle dead = no_vehicle;  ///< never ends its first move
  bool replans = true;
};

/// Executes a FleetPlan in continuous time: each vehicle needs about one time unit for a move, and all drive from one
/// random stop to the next one.
class Drive {
 public:
  Drive(const Grid& grid, GridMotion motion, std::size_t vehicles, std::uint64_t seed, const DriveRules& rules)
      : floor_{grid_floor(grid, motion)}, rules_{rules}, random_{seed, "drive"}, plan_{floor_, {}, seed} {
    const std::uint32_t headings = motion == GridMotion::forward_turn ? 4 : 1;
    for (std::uint32_t square = 0; square < grid.free.size(); ++square)
      if (grid.free[square] != 0) goals_.push_back(square);
    for (std::size_t i = goals_.size() - 1; i > 0; --i) std::swap(goals_[i], goals_[random_.below(i + 1)]);
    std::vector<StateId> states;
    for (std::size_t i = 0; i < vehicles; ++i) {
      states.push_back(goals_[i] * headings);
      vehicles_.push_back({goal(), 1.0 + random_.uniform(-rules.speed_spread, rules.speed_spread)});
    }
    plan_.begin(states);
  }

  /// @param duration  in mean durations of a move
  void run(double duration) {
    for (int tick = 0; tick < duration / tick_; ++tick) {
      if (rules_.replans && tick % 20 == 0 && any_late()) plan_.replan();
      for (Vehicle vehicle = 0; vehicle < vehicles_.size(); ++vehicle)
        plan_.set_stops(vehicle, std::vector{vehicles_[vehicle].stop}, vehicles_[vehicle].urgency++ / 100);
      plan_.plan();
      for (Vehicle vehicle = 0; vehicle < vehicles_.size(); ++vehicle) move(vehicle);
      check();
    }
  }

  [[nodiscard]] std::vector<int> stops_reached() const {
    std::vector<int> counts;
    for (const auto& vehicle : vehicles_) counts.push_back(vehicle.reached);
    return counts;
  }
  [[nodiscard]] double longest_wait() const {
    return std::ranges::max(vehicles_, {}, &State::longest_wait).longest_wait;
  }
  [[nodiscard]] const std::string& fault() const { return fault_; }
  [[nodiscard]] std::uint64_t digest() const { return digest_.value(); }
  [[nodiscard]] const FleetPlan& plan() const { return plan_; }

 private:
  static constexpr double tick_ = 0.1;

  struct State {
    Stop stop;
    double speed{1.0};
    double left{0.0};  // of the present move; 0: at a standstill
    double stay{0.0};
    double driven{0.0};
    double wait{0.0};
    double longest_wait{0.0};
    std::uint32_t urgency{0};
    int reached{0};
  };

  [[nodiscard]] Stop goal() { return {goals_[random_.below(goals_.size())], 3}; }
  [[nodiscard]] bool any_late() const {
    return std::ranges::any_of(vehicles_, [](const State& state) { return state.driven > 3.0; });
  }

  void move(Vehicle vehicle) {
    State& state = vehicles_[vehicle];
    const PassingOrder& order = plan_.order();
    if (state.stay > 0.0) {
      if ((state.stay -= tick_) <= 0.0) {
        state.stop = goal();
        state.urgency = 0;
      }
      return;
    }
    if (order.granted_moves(vehicle) < 2) (void)plan_.grant(vehicle);
    if (state.left <= 0.0 && order.granted_moves(vehicle) > 0) {
      state.left = 1.0 / state.speed + (random_.chance(rules_.stop_chance) ? random_.uniform(2.0, 10.0) : 0.0);
      if (vehicle == rules_.dead) state.left = 1e9;
    }
    if (state.left <= 0.0) {
      state.longest_wait = std::max(state.longest_wait, state.wait += tick_);
    } else if (state.driven += tick_; (state.left -= tick_) <= 0.0) {
      plan_.arrive(vehicle);
      state.driven = 0.0;
      state.wait = 0.0;
    }
    const auto goal_states = floor_.goal(state.stop.goal);
    const bool at_goal = std::ranges::find(goal_states, order.states(vehicle)[0]) != goal_states.end();
    if (at_goal && order.granted_moves(vehicle) == 0) {
      ++state.reached;
      state.stay = 3.0;
      state.wait = 0.0;
    }
  }

  /// No cell of a granted move belongs to two vehicles.
  void check() {
    std::map<CellId, Vehicle> owners;
    const PassingOrder& order = plan_.order();
    for (Vehicle vehicle = 0; vehicle < vehicles_.size(); ++vehicle) {
      for (std::size_t i = 0; i <= order.granted_moves(vehicle); ++i) {
        digest_.add(std::uint64_t{order.states(vehicle)[i]});
        for (const CellId cell : floor_.footprint(order.states(vehicle)[i]))
          if (owners.emplace(cell, vehicle).first->second != vehicle)
            fault_ = "cell " + std::to_string(cell) + " is granted twice";
      }
    }
  }

  Floor floor_;
  DriveRules rules_;
  Random random_;
  FleetPlan plan_;
  std::vector<GoalId> goals_;
  std::vector<State> vehicles_;
  Digest digest_;
  std::string fault_;
};

/// A loop of `nodes` squares around a blocked area, with dead ends one square deep outside it: a grid of 6 by 6.
Grid loop_with_dead_ends() {
  const char* const rows[] = {"@.@.@@", "@....@", "...@..", "@..@.@", "@....@", "@@.@.@"};
  Grid grid{6, 6, {}};
  for (const std::string row : rows)
    for (const char square : row) grid.free.push_back(square == '.' ? 1 : 0);
  return grid;
}

TEST(FleetPlan, lets_every_vehicle_of_a_crowded_two_way_floor_reach_its_stops) {
  for (const GridMotion motion : {GridMotion::any_direction, GridMotion::forward_turn}) {
    for (const std::size_t vehicles : {6U, 12U, 20U}) {
      Drive drive{fixture::open_grid(6, 5), motion, vehicles, 7, {.stop_chance = 0.02}};
      drive.run(150.0);
      EXPECT_EQ(drive.fault(), "");
      EXPECT_GE(std::ranges::min(drive.stops_reached()), 1) << vehicles << " vehicles";
    }
  }
}

TEST(FleetPlan, serves_dead_ends_of_one_vehicle_from_a_loop_on_which_no_vehicle_can_pass_another) {
  Drive drive{loop_with_dead_ends(), GridMotion::any_direction, 8, 3, {.stop_chance = 0.02}};
  drive.run(600.0);
  EXPECT_EQ(drive.fault(), "");
  EXPECT_GE(std::ranges::min(drive.stops_reached()), 2);
}

TEST(FleetPlan, is_the_same_on_every_run) {
  const auto digest = [] {
    Drive drive{fixture::open_grid(5, 5), GridMotion::forward_turn, 10, 11, {.stop_chance = 0.05}};
    drive.run(100.0);
    return drive.digest();
  };
  EXPECT_EQ(digest(), digest());
}

TEST(FleetPlan, grants_no_cell_of_a_vehicle_that_never_ends_its_move) {
  Drive drive{fixture::open_grid(6, 5), GridMotion::any_direction, 6, 5, {.dead = 2}};
  drive.run(200.0);
  EXPECT_EQ(drive.fault(), "");
  EXPECT_EQ(drive.stops_reached()[2], 0);
}

TEST(FleetPlan, grants_nothing_beyond_a_stop_that_has_not_ended) {
  const Floor floor = grid_floor(fixture::open_grid(4, 1), GridMotion::any_direction);
  FleetPlan plan{floor, {}, 1};
  plan.begin(std::vector<StateId>{0});
  const std::vector<Stop> stops{{1, 2}, {3, 0}};
  plan.set_stops(0, stops, 0);
  plan.plan();
  EXPECT_TRUE(plan.grant(0));
  plan.plan();
  EXPECT_FALSE(plan.grant(0)) << "the vehicle has to stop at 1, for as long as it takes";
  plan.arrive(0);
  EXPECT_FALSE(plan.grant(0));
  plan.set_stops(0, std::vector<Stop>{{3, 0}}, 0);
  plan.plan();
  EXPECT_TRUE(plan.grant(0));
  EXPECT_TRUE(plan.grant(0));
  EXPECT_EQ(plan.order().granted_end(0), 3U);
}

TEST(FleetPlan, makes_no_more_steps_than_two_windows_while_no_vehicle_arrives) {
  const Floor floor = grid_floor(fixture::open_grid(6, 1), GridMotion::any_direction);
  FleetPlan plan{floor, {}, 1};
  plan.begin(std::vector<StateId>{0, 3});
  plan.set_stops(0, std::vector<Stop>{{5, 0}}, 0);  // beyond the other one, which cannot be passed
  for (int call = 0; call < 100; ++call) plan.plan();
  EXPECT_LE(plan.steps(), 2 * FleetPlanOptions{}.window.horizon);
}

TEST(FleetPlan, plans_other_stops_from_the_ends_of_what_is_planned) {
  const Floor floor = grid_floor(fixture::open_grid(5, 1), GridMotion::any_direction);
  FleetPlan plan{floor, {}, 1};
  plan.begin(std::vector<StateId>{2});
  plan.set_stops(0, std::vector<Stop>{{4, 0}}, 0);
  plan.plan();
  ASSERT_TRUE(plan.grant(0));
  plan.arrive(0);
  plan.set_stops(0, std::vector<Stop>{{0, 0}}, 0);
  for (int move = 0; move < 8; ++move) {
    plan.plan();
    if (plan.grant(0)) plan.arrive(0);
  }
  EXPECT_EQ(plan.order().granted_end(0), 0U);
}

TEST(FleetPlan, proves_that_a_vehicle_on_a_lane_cannot_pass_another_one_that_stays) {
  const Floor floor = grid_floor(fixture::open_grid(6, 1), GridMotion::any_direction);
  FleetPlan plan{floor, {}, 1};
  plan.begin(std::vector<StateId>{0, 3});
  plan.set_stops(0, std::vector<Stop>{{5, 0}}, 0);
  for (int i = 0; i < 200 && plan.search_result(0) != SearchResult::impossible; ++i) {
    plan.plan();
    for (const Vehicle vehicle : {0U, 1U})
      if (plan.grant(vehicle)) plan.arrive(vehicle);
  }
  EXPECT_EQ(plan.search_result(0), SearchResult::impossible);
}

TEST(FleetPlan, knows_that_a_stop_cannot_be_reached) {
  Grid grid = fixture::open_grid(5, 1);
  grid.free[3] = 0;
  const Floor floor = grid_floor(grid, GridMotion::any_direction);
  FleetPlan plan{floor, {}, 1};
  plan.begin(std::vector<StateId>{0, 2});
  plan.set_stops(0, std::vector<Stop>{{4, 0}}, 0);
  plan.set_stops(1, std::vector<Stop>{{1, 0}}, 0);
  plan.plan();
  EXPECT_FALSE(plan.reachable(0));
  EXPECT_TRUE(plan.reachable(1));
}

}  // namespace
}  // namespace cosiva::planning
