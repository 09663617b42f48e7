#include "cosiva/zone/routing/route.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <limits>

#include "cosiva/base/random.h"
#include "cosiva/zone/testing/test_zones.h"

namespace cosiva::zone {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::part;
using testing::section;

constexpr SpeedProfiles profiles{{0.1, 0.3, 0.6}, {0.3, 0.5, 0.8}, {0.5, 0.8, 1.0}};

TrafficZone zone_of(std::vector<Circuit::Part> parts) {
  return TrafficZone{"z", testing::circuit(std::move(parts)), {}, profiles, {}, {}, {}, {}, {}, {}};
}

/// A stem that forks into a straight of 4 m and a detour of 6 m round it, which merge again, and lead back.
///   stem (0) → straight (1) ┬→ back (4) → stem
///        └→ out (2) → in (3) ┘
/// Everything turns on the spot, so that only lengths matter to the geometry.
std::vector<Circuit::Part> fork_and_merge() {
  std::vector<Circuit::Part> parts{part("stem", section({0.0, 0.0, 0.0}, 2.0), {1, 2}),
                                   part("straight", section({2.0, 0.0, 0.0}, 4.0), {4}),
                                   part("out", section({2.0, 0.0, 0.9272952180016122}, 2.5), {3}),
                                   part("in", section({3.5, 2.0, -0.6747409422235527}, 3.2015621187164243), {4}),
                                   part("back", section({6.0, 0.0, pi}, 6.0), {0})};
  for (auto& one : parts) one.pivots = true;
  return parts;
}

TEST(Router, goes_straight_on_within_one_section) {
  const TrafficZone zone = zone_of(fork_and_merge());
  const auto route = Router{zone}.plan({1, 1.0}, {1, 3.0});
  ASSERT_TRUE(route);
  EXPECT_THAT(route->sections, ElementsAre(1));
  EXPECT_DOUBLE_EQ(route->length_m, 2.0);
  EXPECT_DOUBLE_EQ(route->time_s, 4.0);  // 0.5 m/s
}

TEST(Router, goes_all_the_way_round_to_a_position_behind) {
  const TrafficZone zone = zone_of(fork_and_merge());
  const auto route = Router{zone}.plan({1, 3.0}, {1, 1.0});
  ASSERT_TRUE(route);
  EXPECT_THAT(route->sections, ElementsAre(1, 4, 0, 1));
  EXPECT_DOUBLE_EQ(route->length_m, 1.0 + 6.0 + 2.0 + 1.0);
}

TEST(Router, stays_in_place_when_only_rounding_puts_the_goal_behind) {
  const TrafficZone zone = zone_of(fork_and_merge());
  const auto route = Router{zone}.plan({1, 1.0 + 1e-12}, {1, 1.0});
  ASSERT_TRUE(route);
  EXPECT_THAT(route->sections, ElementsAre(1));
  EXPECT_EQ(route->length_m, 0.0);
}

TEST(Router, takes_the_route_of_less_time_not_of_less_length) {
  auto parts = fork_and_merge();
  const TrafficZone fast = zone_of(parts);
  EXPECT_THAT(Router{fast}.plan({0, 0.0}, {4, 0.0})->sections, ElementsAre(0, 1, 4));
  parts[1].speed_mps_max = 0.1;  // 40 s instead of 8
  const TrafficZone slow = zone_of(parts);
  const auto route = Router{slow}.plan({0, 0.0}, {4, 0.0});
  EXPECT_THAT(route->sections, ElementsAre(0, 2, 3, 4));
}

TEST(Router, counts_turns_on_the_spot) {
  const TrafficZone zone = zone_of(fork_and_merge());
  const Router router{zone};
  EXPECT_DOUBLE_EQ(router.turn_time_s(1, 4), pi / pivot_rate_radps);
  EXPECT_EQ(router.turn_time_s(0, 1), 0.0);
  const auto route = router.plan({1, 4.0}, {4, 1.0});
  EXPECT_NEAR(route->time_s, pi / pivot_rate_radps + 2.0, 1e-12);
}

TEST(Router, never_enters_a_closed_section_but_leaves_the_one_it_begins_on) {
  const TrafficZone zone = zone_of(fork_and_merge());
  const Router router{zone};
  const SectionId straight[] = {1};
  EXPECT_THAT(router.plan({0, 0.0}, {4, 0.0}, straight)->sections, ElementsAre(0, 2, 3, 4));
  EXPECT_THAT(router.plan({1, 1.0}, {4, 0.0}, straight)->sections, ElementsAre(1, 4));
  EXPECT_TRUE(router.plan({1, 1.0}, {1, 2.0}, straight));   // ahead on the starting section
  EXPECT_FALSE(router.plan({1, 2.0}, {1, 1.0}, straight));  // the route would have to come back in
}

TEST(Router, reports_which_closed_section_is_on_the_route) {
  const TrafficZone zone = zone_of(fork_and_merge());
  const SectionId both[] = {1, 3};
  const auto route = Router{zone}.plan({0, 0.0}, {4, 0.0}, both);
  ASSERT_FALSE(route);
  EXPECT_EQ(route.error().code, "route.none");
  EXPECT_EQ(route.error().location, "stem");
  EXPECT_THAT(route.error().message, AllOf(HasSubstr("closed"), HasSubstr("'straight'"), HasSubstr("'back'")));
  EXPECT_THAT(route.error().message, ::testing::Not(HasSubstr("'in'")));  // not on the quickest route
}

TEST(Router, reports_that_the_goal_itself_is_closed) {
  const TrafficZone zone = zone_of(fork_and_merge());
  const SectionId back[] = {4};
  const auto route = Router{zone}.plan({0, 0.0}, {4, 1.0}, back);
  ASSERT_FALSE(route);
  EXPECT_THAT(route.error().message, AllOf(HasSubstr("'back'"), HasSubstr("is closed")));
}

TEST(Router, reports_how_far_a_vehicle_gets_where_no_route_leads) {
  const TrafficZone line = zone_of({part("a", section({}, 1.0), {1}), part("b", section({1.0, 0.0, 0.0}, 1.0))});
  const Router router{line};
  const auto back = router.plan({1, 0.5}, {0, 0.5});
  ASSERT_FALSE(back);
  EXPECT_EQ(back.error().message, "no route leads from 'b' to 'a': nothing follows 'b'");
  const auto round = router.plan({0, 0.5}, {0, 0.2});
  ASSERT_FALSE(round);
  EXPECT_EQ(round.error().message,
            "no route leads from 'a' to 'a': the routes from there reach 1 sections, the last of them 'b'");
}

TEST(Router, decides_equal_times_by_the_lower_section) {
  // A diamond: 1 and 2 mirror each other, exactly.
  std::vector<Circuit::Part> parts{part("a", section({}, 1.0), {2, 1}), part("up", section({1.0, 0.0, 0.5}, 2.0), {3}),
                                   part("down", section({1.0, 0.0, -0.5}, 2.0), {4})};
  const Pose2 up = parts[1].section.end();
  parts.push_back(part("up2", section({up.x_m, up.y_m, -0.5}, 2.0), {5}));
  parts.push_back(part("down2", section({up.x_m, -up.y_m, 0.5}, 2.0), {5}));
  const Pose2 end = parts[3].section.end();
  parts.push_back(part("end", section({end.x_m, end.y_m, 0.0}, 1.0)));
  for (auto& one : parts) one.pivots = true;
  const TrafficZone zone = zone_of(std::move(parts));
  EXPECT_THAT(Router{zone}.plan({0, 0.0}, {5, 0.0})->sections, ElementsAre(0, 1, 3, 5));
}

TEST(Router, measures_from_where_a_route_begins_to_where_it_ends) {
  auto parts = fork_and_merge();
  parts[1].speed_mps_max = 0.25;
  parts[4].speed_mps_max = 2.0;  // faster than the fast profile, which is 0.5 m/s
  const TrafficZone zone = zone_of(parts);
  const Router router{zone};
  EXPECT_DOUBLE_EQ(router.section_time_s(0), 4.0);
  EXPECT_DOUBLE_EQ(router.section_time_s(1), 16.0);
  EXPECT_DOUBLE_EQ(router.section_time_s(4), 12.0);
  const auto route = router.plan({0, 0.5}, {1, 1.0});
  ASSERT_TRUE(route);
  EXPECT_DOUBLE_EQ(route->length_m, 1.5 + 1.0);
  EXPECT_DOUBLE_EQ(route->time_s, 3.0 + 4.0);
  EXPECT_DOUBLE_EQ(router.turn_time_s(0, 2), 0.9272952180016122) << "a radian takes a second, to either side";
  EXPECT_DOUBLE_EQ(router.turn_time_s(3, 4), wrap_angle(pi + 0.6747409422235527) * -1.0);
  // A micrometre behind is the same position; more than that is a whole lap.
  EXPECT_THAT(router.plan({1, 1.0 + 0.9e-6}, {1, 1.0})->sections, ElementsAre(1));
  EXPECT_THAT(router.plan({1, 1.0 + 1.1e-6}, {1, 1.0})->sections, ElementsAre(1, 4, 0, 1));
}

TEST(Router, reports_all_closed_sections_of_the_quickest_route) {
  const TrafficZone zone = zone_of(fork_and_merge());
  const SectionId closed[] = {1, 2, 4};
  const auto route = Router{zone}.plan({0, 0.0}, {0, 0.0}, closed);
  ASSERT_TRUE(route) << "already there";
  const auto round = Router{zone}.plan({0, 1.0}, {0, 0.0}, closed);
  ASSERT_FALSE(round);
  EXPECT_EQ(
      round.error().message,
      "every route from 'stem' to 'stem' leads over closed sections; the quickest over 'straight', 'back'; open one "
      "of them");
}

TEST(Router, decides_equal_times_by_the_lower_section_even_where_it_is_reached_later) {
  // 3 m over "long" (2), or 1 m over "short" (3) and 2 m over "onward" (1), which is reached when "long" is left
  // already.
  const TrafficZone zone =
      zone_of({part("stem", section({}, 1.0), {2, 3}), part("onward", section({2.0, 0.0, 0.0}, 2.0), {4}),
               part("long", section({1.0, 0.0, 0.0}, 3.0), {4}), part("short", section({1.0, 0.0, 0.0}, 1.0), {1}),
               part("end", section({4.0, 0.0, 0.0}, 1.0))});
  const auto route = Router{zone}.plan({0, 0.0}, {4, 0.5});
  ASSERT_TRUE(route);
  EXPECT_THAT(route->sections, ElementsAre(0, 3, 1, 4));
  EXPECT_DOUBLE_EQ(route->time_s, 4.5 / 0.5);
}

TEST(Router, adds_the_turn_before_each_section_to_the_time_of_driving) {
  const TrafficZone zone = zone_of(fork_and_merge());
  const SectionId straight[] = {1};
  const auto route = Router{zone}.plan({0, 0.5}, {4, 3.0}, straight);
  ASSERT_TRUE(route);
  EXPECT_THAT(route->sections, ElementsAre(0, 2, 3, 4));
  const double length_m = 1.5 + 2.5 + 3.2015621187164243 + 3.0;
  EXPECT_NEAR(route->length_m, length_m, 1e-12);
  // From heading 0 to "out", from there to "in", and from there to π.
  const double turned_rad = 0.9272952180016122 + (0.9272952180016122 + 0.6747409422235527) + (pi - 0.6747409422235527);
  EXPECT_NEAR(route->time_s, length_m / 0.5 + turned_rad, 1e-12);
}

TEST(Router, stays_in_place_when_the_goal_is_exactly_a_micrometre_behind) {
  const TrafficZone zone = zone_of(fork_and_merge());
  EXPECT_THAT(Router{zone}.plan({1, 1e-6}, {1, 0.0})->sections, ElementsAre(1));
}

TEST(Router, of_sections_that_the_zone_does_not_have_is_an_error_of_the_program) {
  const TrafficZone zone = zone_of(fork_and_merge());
  const Router router{zone};
  const SectionId unknown[] = {5};
  EXPECT_DEATH(static_cast<void>(router.plan({0, 0.0}, {1, 0.0}, unknown)), "id < circuit.size");
  EXPECT_DEATH(static_cast<void>(router.goes_on_for_ever(unknown)), "id < circuit.size");
  constexpr const char* from_and_goal = "from.section < circuit.size.. && goal.section < circuit.size";
  EXPECT_DEATH(static_cast<void>(router.plan({5, 0.0}, {1, 0.0})), from_and_goal);
  EXPECT_DEATH(static_cast<void>(router.plan({1, 0.0}, {5, 0.0})), from_and_goal);
  constexpr const char* from_and_loop = "from.section < circuit.size.. && !loop.sections.empty";
  EXPECT_DEATH(static_cast<void>(router.plan({5, 0.0}, Loop{"inner", {0, 1, 4}})), from_and_loop);
  EXPECT_DEATH(static_cast<void>(router.plan({1, 0.0}, Loop{"none", {}})), from_and_loop);
}

// Loops
// ------------------------------------------------------------------------------------------------------

TEST(Router, joins_a_loop_at_the_first_section_reached_and_goes_round_once) {
  auto parts = fork_and_merge();
  const Pose2 stem = parts[0].section.start();
  parts.push_back(part("yard", section({stem.x_m - 1.0, stem.y_m, 0.0}, 1.0), {0}));
  const TrafficZone zone = zone_of(std::move(parts));
  const Loop loop{"inner", {1, 4, 0}};
  const auto route = Router{zone}.plan({5, 0.5}, loop);
  ASSERT_TRUE(route);
  EXPECT_THAT(route->sections, ElementsAre(5, 0, 1, 4));
  EXPECT_DOUBLE_EQ(route->length_m, 0.5 + 2.0 + 4.0 + 6.0);
  EXPECT_THAT(Router{zone}.plan({4, 1.0}, loop)->sections, ElementsAre(4, 0, 1));
}

TEST(Router, goes_round_a_closed_section_of_a_loop) {
  const TrafficZone zone = zone_of(fork_and_merge());
  const Loop loop{"inner", {0, 1, 4}};
  const SectionId straight[] = {1};
  EXPECT_THAT(Router{zone}.plan({0, 1.0}, loop, straight)->sections, ElementsAre(0, 2, 3, 4));
  const SectionId both[] = {1, 2};
  const auto none = Router{zone}.plan({0, 1.0}, loop, both);
  ASSERT_FALSE(none);
  EXPECT_THAT(none.error().message, AllOf(HasSubstr("the loop 'inner'"), HasSubstr("'straight'")));
}

// Dead ends
// ------------------------------------------------------------------------------------------------------

TEST(Router, knows_the_sections_from_which_a_vehicle_drives_on_for_ever) {
  auto parts = fork_and_merge();
  parts[0].next.push_back(5);
  parts.push_back(part("spur", section({2.0, 0.0, 1.0}, 1.0), {6}));
  const Pose2 end = parts[5].section.end();
  parts.push_back(part("siding", section(end, 1.0)));
  const TrafficZone zone = zone_of(std::move(parts));
  const Router router{zone};
  EXPECT_THAT(router.goes_on_for_ever(), ElementsAre(true, true, true, true, true, false, false));
  const SectionId back[] = {4};
  EXPECT_THAT(router.goes_on_for_ever(back), ElementsAre(false, false, false, false, false, false, false));
  const SectionId straight[] = {1};  // a vehicle on it leaves it, and drives on for ever
  EXPECT_THAT(router.goes_on_for_ever(straight), ElementsAre(true, true, true, true, true, false, false));
}

// Against brute force
// ----------------------------------------------------------------------------------------------------

/// A random graph: every section is a straight of its own length from the origin and back by turning on the spot; only
/// times matter.
TrafficZone random_zone(Random& random, std::size_t size) {
  std::vector<Circuit::Part> parts;
  for (std::size_t i = 0; i < size; ++i) {
    const double radius_m = 0.1 * static_cast<double>(1 + random.below(5));
    auto one = part("s" + std::to_string(i), section({}, 2.0 * pi * radius_m, 1.0 / radius_m));
    if (random.chance(0.3)) one.speed_mps_max = 0.1 + 0.1 * static_cast<double>(random.below(3));
    for (SectionId to = 0; to < size; ++to)
      if (random.chance(1.6 / static_cast<double>(size))) one.next.push_back(to);
    parts.push_back(std::move(one));
  }
  return zone_of(std::move(parts));
}

/// Least time from the end of `from` to the start of every section, by relaxing every edge again and again.
std::vector<double> all_times(const TrafficZone& zone, const Router& router, SectionId from,
                              const std::vector<bool>& closed) {
  std::vector<double> at_s(zone.circuit.size(), std::numeric_limits<double>::infinity());
  const auto relax = [&](SectionId id, double end_s) {
    for (const SectionId to : zone.circuit.next(id))
      if (!closed[to]) at_s[to] = std::min(at_s[to], end_s);
  };
  for (std::size_t round = 0; round <= zone.circuit.size(); ++round) {
    relax(from, 0.0);
    for (SectionId id = 0; id < zone.circuit.size(); ++id) relax(id, at_s[id] + router.section_time_s(id));
  }
  return at_s;
}

TEST(Router, is_never_beaten_and_never_leaves_the_graph) {
  EXPECT_TRUE(rc::check([] {
    Random random{*rc::gen::arbitrary<std::uint64_t>(), "route_test"};
    const std::size_t size = 2 + random.below(9);
    const TrafficZone zone = random_zone(random, size);
    const Router router{zone};
    std::vector<SectionId> closed;
    std::vector<bool> is_closed(size, false);
    for (SectionId id = 0; id < size; ++id) {
      if (!random.chance(0.15)) continue;
      closed.push_back(id);
      is_closed[id] = true;
    }
    const auto from = static_cast<SectionId>(random.below(size));
    const auto times = all_times(zone, router, from, is_closed);
    for (SectionId to = 0; to < size; ++to) {
      // From the end of the one to the start of the other, so that even the starting section must be reached again.
      const auto route = router.plan({from, zone.circuit.section(from).length_m()}, {to, 0.0}, closed);
      RC_ASSERT(route.has_value() == std::isfinite(times[to]));
      if (!route) continue;
      RC_ASSERT(std::fabs(route->time_s - times[to]) < 1e-9);
      RC_ASSERT(route->sections.front() == from);
      RC_ASSERT(route->sections.back() == to);
      for (std::size_t i = 1; i < route->sections.size(); ++i) {
        const auto next = zone.circuit.next(route->sections[i - 1]);
        RC_ASSERT(std::find(next.begin(), next.end(), route->sections[i]) != next.end());
        RC_ASSERT(!is_closed[route->sections[i]]);
      }
    }
  }));
}

TEST(Router, goes_on_for_ever_exactly_where_a_walk_of_any_length_exists) {
  EXPECT_TRUE(rc::check([] {
    Random random{*rc::gen::arbitrary<std::uint64_t>(), "route_test/ever"};
    const std::size_t size = 1 + random.below(9);
    const TrafficZone zone = random_zone(random, size);
    std::vector<SectionId> closed;
    for (SectionId id = 0; id < size; ++id)
      if (random.chance(0.15)) closed.push_back(id);
    const auto is_closed = [&](SectionId id) { return std::find(closed.begin(), closed.end(), id) != closed.end(); };
    // A walk of as many steps as there are sections visits one of them twice.
    std::vector<bool> walks(size, true);
    for (std::size_t steps = 0; steps <= size; ++steps) {
      std::vector<bool> longer(size, false);
      for (SectionId id = 0; id < size; ++id)
        for (const SectionId to : zone.circuit.next(id)) longer[id] = longer[id] || (!is_closed(to) && walks[to]);
      walks = longer;
    }
    RC_ASSERT(Router{zone}.goes_on_for_ever(closed) == walks);
  }));
}

}  // namespace
}  // namespace cosiva::zone
