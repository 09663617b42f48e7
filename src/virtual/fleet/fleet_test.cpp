#include "cosiva/virtual/fleet/fleet.h"

#include <gmock/gmock.h>
#include <rapidcheck/gtest.h>

#include <string>

#include "cosiva/aiv/motion/manoeuvre.h"
#include "cosiva/aiv/testing/test_graphs.h"
#include "cosiva/base/test_property.h"
#include "cosiva/virtual/fleet/test_fleet.h"

namespace cosiva::virtual_side {
namespace {

using namespace test;
using testing::ElementsAre;
using testing::IsEmpty;

/// Steps, and checks the invariants now and then.
void drive(Fleet& fleet, int steps, int check_every = 7) {
  for (int k = 0; k < steps; ++k) {
    fleet.step();
    if (k % check_every == 0) {
      ASSERT_NO_FATAL_FAILURE(expect_safe(fleet));
    }
  }
  EXPECT_EQ(fleet.collisions(), 0U);
  EXPECT_GT(fleet.smallest_gap_m(), 0.0);
}

double driven_least(const Fleet& fleet) {
  double least = 1e9;
  for (Fleet::Vehicle i = 0; i < fleet.size(); ++i) least = std::min(least, fleet.distance_m(i));
  return least;
}

TEST(Fleet, drives_round_a_clover_with_crossings_without_touching) {
  for (const bool rules : {false, true}) {
    Fleet many = fleet(zone_file("zones/lacet4.toml"), 8, rules);
    ASSERT_EQ(many.size(), 8U);
    drive(many, 3000);
    EXPECT_GT(driven_least(many), 50.0);
    EXPECT_EQ(many.stuck(), 0U);
  }
}

TEST(Fleet, drives_round_a_loop_with_limits_without_touching) {
  Fleet many = fleet(zone_file("zones/indus8.toml"), 20);
  ASSERT_EQ(many.size(), 20U);
  drive(many, 3000);
  EXPECT_GT(driven_least(many), 40.0);
}

TEST(Fleet, passes_crossings_of_clothoids_without_touching) {
  Fleet many = fleet(zone_file("zones/crossing8.xodr"), 6);
  drive(many, 3000);
  EXPECT_GT(driven_least(many), 30.0);
}

TEST(Fleet, keeps_limits_of_sections) {
  const Zone zone = zone_file("zones/indus8.toml");
  Fleet many = fleet(zone, 10);
  for (int k = 0; k < 1000; ++k) {
    many.step();
    for (Fleet::Vehicle i = 0; i < many.size(); ++i) {
      const auto limit = zone->circuit.part(many.track_position(i).section).speed_mps_max;
      if (limit) {
        ASSERT_LE(many.speed_mps()[i], *limit + 1e-3) << k;
      }
    }
  }
}

TEST(Fleet, that_is_as_large_as_the_circuit_holds_does_not_collide) {
  for (const char* name : {"zones/lacet4.toml", "zones/indus8.toml", "bench/clover.toml"}) {
    Fleet full = fleet(zone_file(name), 100'000);
    EXPECT_LT(full.size(), 100'000U);
    drive(full, 1500);
  }
}

// A factory layout has many forks, merges, lay-bys and crossings.
TEST(Fleet, drives_through_a_factory_layout_without_touching) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Fleet many = fleet(plant({.rows = 2, .aisles = 4, .bays = 3, .seed = seed}), 25);
    ASSERT_GT(many.size(), 10U);
    drive(many, 1500, 11);
  }
}

RC_GTEST_PROP(Fleet, touches_no_vehicle_in_any_factory_layout_however_full, ()) {
  const zone::PlantOptions options{.rows = *rc::gen::inRange(1U, 4U),
                                   .aisles = *rc::gen::inRange(2U, 6U),
                                   .bays = *rc::gen::inRange(1U, 4U),
                                   .seed = *rc::gen::inRange<std::uint64_t>(1, 1000)};
  // One after the other: compilers differ in the order in which they evaluate the arguments of a call.
  const auto count = *rc::gen::inRange<std::size_t>(1, 80);
  const bool rules = *rc::gen::arbitrary<bool>();
  Fleet many = fleet(plant(options), count, rules);
  const std::string failures = failures_of([&] { drive(many, 120, 17); });
  RC_ASSERT(failures == "");
}

// A vehicle leaves a lay-by through a bend of 2.36 m, where bodies of 1.2 m by 0.8 m touch if their body origins are
// less than 1.4 m of arc length apart.
TEST(Fleet, keeps_inner_corners_apart_in_a_tight_bend) {
  Fleet many = fleet(plant({.rows = 1, .aisles = 2, .bays = 1, .seed = 1}), 51, false);
  drive(many, 600, 5);
}

TEST(Fleet, drives_in_every_ready_zone) {
  for (const char* name : {"lacet4.toml", "indus8.toml", "crossing8.xodr", "plant1000.toml"}) {
    Fleet some = fleet(zone_file(std::string("zones/") + name), 6);
    drive(some, 600, 13);
    EXPECT_GT(driven_least(some), 0.0) << name;
  }
}

TEST(Fleet, may_have_no_vehicles_at_all) {
  Fleet empty = fleet(zone_file("zones/lacet4.toml"), std::vector<FleetStart>{});
  empty.step();
  EXPECT_EQ(empty.size(), 0U);
  EXPECT_EQ(empty.copies(), 0U);
  EXPECT_EQ(empty.stuck(), 0U);
  EXPECT_EQ(empty.steps(), 1U);
}

/// The leader on the default path, found by walking along it and comparing all vehicles.
Fleet::Ahead found_slowly(const Fleet& fleet, Fleet::Vehicle self) {
  const zone::Circuit& circuit = fleet.zone().circuit;
  const zone::TrackPosition position = fleet.track_position(self);
  double start_m = -position.s_m;
  zone::SectionId section = position.section;
  for (std::size_t steps = 0; steps <= circuit.size(); ++steps) {
    Fleet::Ahead nearest;
    for (Fleet::Vehicle i = 0; i < fleet.size(); ++i) {
      const zone::TrackPosition other = fleet.track_position(i);
      if (i == self || fleet.copy_of(i) != fleet.copy_of(self) || other.section != section) continue;
      const double gap_m = start_m + other.s_m - fleet.zone().vehicle.length_m;
      if (steps == 0 && other.s_m < position.s_m) continue;
      if (gap_m < nearest.gap_m) nearest = {i, gap_m};
    }
    if (nearest.vehicle != Fleet::none) return nearest;
    start_m += circuit.section(section).length_m();
    section = circuit.next(section).front();
  }
  return {};
}

TEST(Fleet, finds_the_same_leaders_as_a_comparison_of_all_vehicles) {
  for (const char* name : {"zones/lacet4.toml", "zones/indus8.toml", "bench/clover.toml"}) {
    const Zone zone = zone_file(name);
    std::vector<FleetStart> starts = Fleet::spread(*zone, 7, 0);
    for (const FleetStart& start : Fleet::spread(*zone, 3, 1)) starts.push_back(start);
    Fleet many = fleet(zone, starts);
    for (int k = 0; k < 2000; ++k) {
      many.step();
      if (k % 37 != 0) continue;
      for (Fleet::Vehicle i = 0; i < many.size(); ++i) {
        const Fleet::Ahead slow = found_slowly(many, i);
        const Fleet::Ahead ahead = many.ahead(i);
        if (slow.gap_m > many.sensed_m()) continue;  // too far to matter
        ASSERT_EQ(ahead.vehicle, slow.vehicle) << name << " step " << k << " vehicle " << i;
        ASSERT_NEAR(ahead.gap_m, slow.gap_m, 1e-9);
      }
    }
  }
}

/// The choice of a single agent and its speed after a step, computed from the fleet's outputs.
TEST(Fleet, drives_as_its_agents_decide) {
  const Zone zone = zone_file("zones/indus8.toml");
  Fleet many = fleet(zone, 14);
  const aiv::FuzzySpeedPolicy speed_policy{aiv::AgentRules::built_in(), zone->profiles};
  std::vector<std::optional<aiv::Profile>> present(many.size());
  for (int k = 0; k < 500; ++k) {
    std::vector<aiv::Profile> meant;
    for (Fleet::Vehicle i = 0; i < many.size(); ++i) {
      constexpr double free = std::numeric_limits<double>::infinity();
      aiv::Situation situation{many.speed_mps()[i], free, free, free, 1.0, std::nullopt};
      situation.present = present[i];
      if (const Fleet::Ahead ahead = many.ahead(i); ahead.gap_m <= many.sensed_m()) {
        situation.obstacle_ahead_m = ahead.gap_m;
        situation.closing_mps = many.speed_mps()[i] - many.speed_mps()[ahead.vehicle];
      }
      meant.push_back(speed_policy.choose(situation));
    }
    std::vector<double> before_mps(many.speed_mps().begin(), many.speed_mps().end());
    std::vector<double> may_mps;
    for (Fleet::Vehicle i = 0; i < many.size(); ++i) {
      const zone::SpeedProfile target_speed = aiv::kinematics(zone->profiles, meant[i]);
      may_mps.push_back(
          std::min(target_speed.speed_mps, aiv::stoppable_speed(many.ahead(i).gap_m - aiv::clearance_m,
                                                                target_speed.braking_mps2, aiv::obstacle_reaction_s)));
    }
    many.step();
    for (Fleet::Vehicle i = 0; i < many.size(); ++i) {
      ASSERT_EQ(many.profile(i), meant[i]) << "step " << k << " vehicle " << i;
      const zone::SpeedProfile target_speed = aiv::kinematics(zone->profiles, meant[i]);
      const double most_mps = std::max(may_mps[i], before_mps[i] - 0.1 * zone->profiles.fast.braking_mps2);
      ASSERT_LE(many.speed_mps()[i], most_mps + 1e-12);
      ASSERT_LE(many.speed_mps()[i], before_mps[i] + 0.1 * target_speed.acceleration_mps2 + 1e-12);
      present[i] = meant[i];
    }
  }
}

/// Parts in any order.
class Backwards final : public Workers {
 protected:
  void run(std::size_t count, Call call, void* context) override {
    for (std::size_t i = count; i-- > 0;) call(context, i);
  }
};

TEST(Fleet, does_not_depend_on_the_order_of_its_parts) {
  const Zone zone = zone_file("bench/clover.toml");
  const std::vector<FleetStart> one = Fleet::spread(*zone, 12);
  std::vector<FleetStart> starts;
  for (std::uint32_t copy = 0; copy < 300; ++copy)
    for (std::size_t k = 0; k < one.size() - copy % 3; ++k) starts.push_back({copy, one[k].position, 0});
  Fleet forwards = fleet(zone, starts);
  Fleet backwards = fleet(zone, starts);
  Backwards workers;
  for (int k = 0; k < 300; ++k) {
    forwards.step();
    backwards.step(workers);
  }
  EXPECT_EQ(forwards.digest(), backwards.digest());
}

TEST(Fleet, in_several_copies_does_the_same_as_alone_in_each) {
  const Zone zone = zone_file("zones/lacet4.toml");
  const std::vector<FleetStart> one = Fleet::spread(*zone, 8);
  std::vector<FleetStart> starts;
  for (std::uint32_t copy = 0; copy < 5; ++copy)
    for (const FleetStart& start : one) starts.push_back({copy, start.position, 0});
  Fleet alone = fleet(zone, one);
  Fleet five = fleet(zone, starts);
  for (int k = 0; k < 1000; ++k) {
    alone.step();
    five.step();
  }
  for (Fleet::Vehicle i = 0; i < five.size(); ++i) {
    EXPECT_EQ(five.track_position(i), alone.track_position(i % 8));
    EXPECT_EQ(five.pose(i), alone.pose(i % 8));
    EXPECT_EQ(five.waiting(i), alone.waiting(i % 8));
  }
}

TEST(Fleet, stops_exactly_at_its_goal_and_reports_it_once) {
  const Zone zone = zone_file("zones/indus8.toml");
  Fleet one = fleet(zone, 1);
  const zone::TrackPosition start = one.track_position(0);
  const zone::SectionId next = zone->circuit.next(start.section).front();
  EXPECT_FALSE(one.has_goal(0));
  ASSERT_TRUE(one.send(0, std::vector{start.section, next}, 0.3));
  EXPECT_TRUE(one.has_goal(0));
  int commanded = 0;
  for (int k = 0; k < 400; ++k) {
    one.step();
    for (const Fleet::Vehicle arrived_vehicle : one.arrived()) commanded += arrived_vehicle == 0 ? 1 : 0;
  }
  EXPECT_EQ(commanded, 1);
  EXPECT_TRUE(one.is_at_goal(0));
  EXPECT_EQ(one.track_position(0), (zone::TrackPosition{next, 0.3}));
  EXPECT_EQ(one.speed_mps()[0], 0.0);
  const SimDuration waited = one.waiting(0);
  for (int k = 0; k < 50; ++k) one.step();
  EXPECT_EQ(one.waiting(0), waited) << "a vehicle at its goal does not wait";

  one.circulate(0);
  for (int k = 0; k < 100; ++k) one.step();
  EXPECT_FALSE(one.has_goal(0));
  EXPECT_GT(one.distance_m(0), 4.0);
}

TEST(Fleet, sent_to_its_own_position_arrives_in_the_next_step) {
  const Zone zone = zone_file("zones/indus8.toml");
  Fleet one = fleet(zone, 1);
  const zone::TrackPosition here = one.track_position(0);
  ASSERT_TRUE(one.send(0, std::vector{here.section}, here.s_m));
  one.step();
  EXPECT_THAT(one.arrived(), ElementsAre(0));
  one.step();
  EXPECT_THAT(one.arrived(), IsEmpty());
  EXPECT_EQ(one.track_position(0), here);
}

TEST(Fleet, rejects_routes_that_it_cannot_take) {
  const Zone zone = zone_file("zones/indus8.toml");
  Fleet one = fleet(zone, 1);
  for (int k = 0; k < 30; ++k) one.step();
  const zone::TrackPosition here = one.track_position(0);
  const zone::SectionId next = zone->circuit.next(here.section).front();
  EXPECT_FALSE(one.send(0, {}, 0.0));
  EXPECT_FALSE(one.send(0, std::vector{next}, 0.1)) << "the vehicle is not there";
  EXPECT_FALSE(one.send(0, std::vector{here.section, here.section}, 0.1)) << "no successor";
  EXPECT_FALSE(one.send(0, std::vector<zone::SectionId>{here.section, 999}, 0.1));
  EXPECT_FALSE(one.send(0, std::vector{here.section, next}, 1e3)) << "beyond the end";
  EXPECT_FALSE(one.send(0, std::vector{here.section}, here.s_m - 0.1)) << "behind the vehicle";
  EXPECT_FALSE(one.send(0, std::vector{here.section}, here.s_m + 0.01)) << "too near to stop";
  EXPECT_FALSE(one.send(0, std::vector{here.section}, std::nan("")));
  EXPECT_FALSE(one.has_goal(0));
}

TEST(Fleet, at_a_sharp_bend_stops_turns_on_the_spot_and_drives_on) {
  // A square with turns on the spot at its corners; the spur that is its default successor ends blind.
  const Zone zone = std::make_shared<zone::TrafficZone>(aiv::test::square());
  Fleet one = fleet(zone, std::vector<FleetStart>{{0, {0, 0.2}}});
  ASSERT_TRUE(one.send(0, std::vector<zone::SectionId>{0, 1, 2}, 0.5));
  int turning = 0;
  double heading_rad = 0.0;
  for (int k = 0; k < 400; ++k) {
    one.step();
    const double turned_rad = wrap_angle(one.heading_rad()[0] - heading_rad);
    heading_rad = one.heading_rad()[0];
    if (turned_rad == 0.0) continue;
    ++turning;
    EXPECT_EQ(one.speed_mps()[0], 0.0);
    EXPECT_GT(turned_rad, 0.0);
    EXPECT_LE(turned_rad, aiv::ManoeuvreRates{}.turn_radps * 0.1 + 1e-9);
  }
  EXPECT_EQ(one.track_position(0), (zone::TrackPosition{2, 0.5}));
  // A quarter turn at 1.5 rad/s, with 3 rad/s² up and down: 1.55 s, twice; and a little in steps of 0.1 s.
  EXPECT_NEAR(turning, 33, 4);
}

TEST(Fleet, stops_before_the_line_of_a_crossing_that_another_vehicle_holds) {
  const Zone zone = zone_file("bench/clover.toml");
  Fleet many = fleet(zone, 12);
  bool waited = false;
  for (int k = 0; k < 2000; ++k) {
    many.step();
    for (Fleet::Vehicle i = 0; i < many.size(); ++i) {
      const zone::TrackPosition position = many.track_position(i);
      if (many.speed_mps()[i] > 0.0 || position.section % 2 != 0 || position.s_m < 3.5 || position.s_m > 4.5) continue;
      EXPECT_NEAR(position.s_m, 3.951 - aiv::stop_line_m, 1e-3);
      waited = true;
    }
  }
  EXPECT_TRUE(waited);
}

TEST(Fleet, lets_the_higher_priority_go_first) {
  const Zone zone = zone_file("bench/clover.toml");
  SimDuration waited[2]{};
  for (const bool first : {false, true}) {
    Fleet many = fleet(zone, 12);
    if (first) many.set_priority(5, 999);
    for (int k = 0; k < 6000; ++k) many.step();
    waited[first ? 1 : 0] = many.waiting(5);
  }
  EXPECT_LT(waited[1], waited[0]);
}

TEST(Fleet, counts_grants_laps_and_occupancy) {
  const Zone zone = zone_file("zones/lacet4.toml");
  Fleet many = fleet(zone, 6);
  for (int k = 0; k < 3000; ++k) many.step();
  SimDuration occupied{};
  for (zone::SectionId id = 0; id < zone->circuit.size(); ++id) occupied += many.occupancy(id);
  EXPECT_EQ(occupied, 6 * many.time()) << "every vehicle is on some section all the time";
  std::uint64_t grants = 0;
  for (std::size_t x = 0; x < zone->crossings.size(); ++x) grants += many.crossing(x).grants;
  for (Fleet::Vehicle i = 0; i < 6; ++i) {
    EXPECT_NEAR(many.laps(i), many.distance_m(i) / zone->circuit.total_length_m(), 1.0);
    EXPECT_LT(many.waiting(i), many.time());
  }
  // Each lap passes each of four crossings twice.
  double laps = 0.0;
  for (Fleet::Vehicle i = 0; i < 6; ++i) laps += many.distance_m(i) / zone->circuit.total_length_m();
  EXPECT_NEAR(static_cast<double>(grants), 8.0 * laps, 8.0 * 6.0);
}

TEST(Fleet, obeys_an_instruction_and_a_limit_of_its_own) {
  const Zone zone = zone_file("zones/indus8.toml");
  Fleet two = fleet(zone, 2);
  two.impose(0, aiv::Profile::slow);
  two.limit_speed(1, 0.1);
  for (int k = 0; k < 300; ++k) {
    two.step();
    EXPECT_LE(two.speed_mps()[0], zone->profiles.slow.speed_mps);
    EXPECT_LE(two.speed_mps()[1], 0.1);
  }
  EXPECT_GT(two.distance_m(0), 2.0);
  EXPECT_GT(two.distance_m(1), 2.0);
  two.impose(0, aiv::Profile::stop);
  for (int k = 0; k < 30; ++k) two.step();
  EXPECT_EQ(two.speed_mps()[0], 0.0);
}

TEST(Fleet, rejects_starts_where_no_vehicle_may_start) {
  const Zone zone = zone_file("zones/lacet4.toml");
  const auto code = [&](std::vector<FleetStart> starts) {
    const auto made = Fleet::make(zone, {}, starts);
    return made ? std::string() : made.error().code;
  };
  EXPECT_EQ(code({{0, {1, 1.2}}}), "");
  EXPECT_EQ(code({{0, {99, 0.0}}}), "fleet.start");
  EXPECT_EQ(code({{0, {1, -1.0}}}), "fleet.start");
  EXPECT_EQ(code({{0, {0, 0.6}}}), "fleet.start") << "in a crossing";
  EXPECT_EQ(code({{0, {1, 1.2}}, {0, {1, 1.45}}}), "fleet.start") << "too close";
  EXPECT_EQ(code({{1, {1, 1.2}}, {0, {1, 1.2}}}), "fleet.start") << "copies out of order";
  const auto slow = Fleet::make(zone, {.step = std::chrono::seconds{1}}, {});
  EXPECT_FALSE(slow);
}

TEST(Fleet, has_the_same_bits_with_every_compiler_and_optimisation) {
  // The only golden number here: it proves identity, the other tests correctness.
  Fleet many = fleet(zone_file("zones/lacet4.toml"), 8);
  for (int k = 0; k < 2000; ++k) many.step();
  EXPECT_EQ(many.digest(), 6142195479809546613U);
}

}  // namespace
}  // namespace cosiva::virtual_side
