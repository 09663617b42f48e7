#include "cosiva/aiv/motion/manoeuvre.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "cosiva/wire/messages/board.h"

namespace cosiva::aiv {
namespace {

constexpr double dt_s = 0.01;

/// Steps until the manoeuvre is done, at most a minute; returns the duration.
double finish(Manoeuvre& manoeuvre, double speed_mps = 0.3) {
  for (int i = 1; i <= 6000; ++i) {
    manoeuvre.step(speed_mps, dt_s);
    if (manoeuvre.done()) return i * dt_s;
  }
  return 1e9;
}

TEST(Manoeuvre, on_the_spot_turns_with_a_ramp_up_and_one_down) {
  Manoeuvre left{{0.0, 0.0, 0.5 * pi}};
  // A trapezoid takes angle/rate + rate/ramp: 1.047 + 0.5 s.
  EXPECT_NEAR(finish(left), 0.5 * pi / 1.5 + 0.5, 0.05);
  EXPECT_EQ(left.X_SB(), (Pose2{0.0, 0.0, 0.5 * pi}));
  Manoeuvre right{{0.0, 0.0, -2.0}};
  double turned_rad = 0.0;
  double fastest_radps = 0.0;
  for (int i = 0; i < 400; ++i) {
    const auto step = right.step(0.05, dt_s);
    EXPECT_LE(step.turned_rad, 0.0);
    EXPECT_EQ(step.moved_m, 0.0);
    turned_rad += step.turned_rad;
    fastest_radps = std::max(fastest_radps, std::fabs(step.turned_rad) / dt_s);
  }
  EXPECT_NEAR(turned_rad, -2.0, 1e-9);
  EXPECT_NEAR(fastest_radps, 1.5, 1e-9);
}

TEST(Manoeuvre, turns_drives_and_turns_to_any_pose_and_ends_exactly_there) {
  EXPECT_TRUE(rc::check("ends at the goal, with no rate above its limits", [] {
    const Pose2 goal{*rc::gen::inRange(-350, 350) * 1e-3, *rc::gen::inRange(-350, 350) * 1e-3,
                     *rc::gen::inRange(-3141, 3142) * 1e-3};
    Manoeuvre manoeuvre{goal};
    Pose2 summed;
    for (int i = 0; i < 3000 && !manoeuvre.done(); ++i) {
      const auto step = manoeuvre.step(0.3, dt_s);
      RC_ASSERT(std::fabs(step.turned_rad) <= 1.5 * dt_s + 1e-6);
      RC_ASSERT(step.moved_m >= 0.0 && step.moved_m <= 0.15 * dt_s + 1e-6);
      RC_ASSERT(step.turned_rad == 0.0 || step.moved_m == 0.0);
      summed = summed * Pose2{step.moved_m, 0.0, step.turned_rad};
    }
    RC_ASSERT(manoeuvre.done());
    RC_ASSERT(distance(summed, manoeuvre.X_SB()) < 1e-9);
    RC_ASSERT(distance(summed, goal) < 6e-4);  // less than half a millimetre is not driven
    RC_ASSERT(std::fabs(wrap_angle(summed.heading_rad - goal.heading_rad)) < 1e-9);
  }));
}

TEST(Manoeuvre, waits_without_commands_and_then_continues) {
  Manoeuvre manoeuvre{{0.2, 0.2, 0.0}};
  for (int i = 0; i < 50; ++i) manoeuvre.step(0.1, dt_s);
  for (int i = 0; i < 29; ++i) manoeuvre.step(0.0, dt_s);
  EXPECT_FALSE(manoeuvre.abandoned());
  for (int i = 0; i < 30; ++i) manoeuvre.step(-0.1, dt_s);  // a backward command has no effect here either
  EXPECT_TRUE(manoeuvre.abandoned());
  const Pose2 waits = manoeuvre.X_SB();
  EXPECT_GT(waits.heading_rad, 0.2);
  EXPECT_LT(waits.heading_rad, 0.25 * pi);
  manoeuvre.step(0.0, dt_s);
  EXPECT_EQ(manoeuvre.X_SB(), waits);
  finish(manoeuvre);
  EXPECT_TRUE(manoeuvre.done());
  EXPECT_FALSE(manoeuvre.abandoned());
  EXPECT_EQ(manoeuvre.X_SB(), (Pose2{0.2, 0.2, 0.0}));
}

TEST(Manoeuvre, keeps_to_a_commanded_speed_below_its_own) {
  Manoeuvre manoeuvre{{0.3, 0.0, 0.0}};
  double fastest_mps = 0.0;
  for (int i = 0; i < 600; ++i) {
    manoeuvre.step(0.08, dt_s);
    fastest_mps = std::max(fastest_mps, manoeuvre.speed_mps());
  }
  EXPECT_NEAR(fastest_mps, 0.08, 1e-9);
  EXPECT_TRUE(manoeuvre.done());
}

TEST(Manoeuvre, without_a_distance_still_lasts_its_minimum_duration) {
  Manoeuvre manoeuvre{{}};
  manoeuvre.step(0.1, dt_s);
  EXPECT_FALSE(manoeuvre.done());
  EXPECT_NEAR(finish(manoeuvre), manoeuvre_s_min, 0.021);
  EXPECT_EQ(manoeuvre.X_SB(), Pose2{});
}

/// An edge east whose end branches, straight and left at a right angle; and an edge east with a single successor.
zone::Circuit node() {
  using zone::Section;
  const auto in = *Section::make({0, 0, 0}, 1.0);
  const auto ahead = *Section::make({1, 0, 0}, 1.0);
  const auto up = *Section::make({1, 0, 0.5 * pi}, 1.0);
  return *zone::Circuit::make("node", {{"in", in, {}, {1, 2}, true},
                                       {"ahead", ahead, {}, {3}},
                                       {"up", up, {}, {}, true},
                                       {"on", *Section::make({2, 0, 0}, 1.0), {}, {}}});
}

TEST(Onward, is_the_commanded_branch_with_its_turn) {
  const zone::Circuit circuit = node();
  EXPECT_EQ(onward(circuit, 0, 0).section, 1U);
  EXPECT_EQ(onward(circuit, 0, 0).turn_rad, 0.0);
  EXPECT_EQ(onward(circuit, 0, 1).section, 2U);
  EXPECT_DOUBLE_EQ(onward(circuit, 0, 1).turn_rad, 0.5 * pi);
  EXPECT_EQ(onward(circuit, 0, 7).section, 2U) << "beyond the last: the last";
}

TEST(Onward, is_none_at_a_dead_end_and_at_a_fork_without_a_branch) {
  const zone::Circuit circuit = node();
  EXPECT_EQ(onward(circuit, 2, 0).section, zone::no_section);
  EXPECT_EQ(onward(circuit, 0, wire::no_branch).section, zone::no_section);
  EXPECT_EQ(onward(circuit, 1, wire::no_branch).section, 3U) << "a single successor needs no branch";
}

TEST(Manoeuvre, follows_trapezoids_of_its_rates) {
  // A quarter turn left, 0.3 m, and a quarter turn right; each leg with its own ramps.
  const ManoeuvreRates rates{1.0, 2.0, 0.10, 0.25};
  Manoeuvre manoeuvre{{0.0, 0.3, 0.0}, rates};
  double fastest_radps = 0.0;
  double fastest_mps = 0.0;
  double hardest_radps2 = 0.0;
  double hardest_mps2 = 0.0;
  double turned_before = 0.0;
  double moved_before = 0.0;
  double seconds = 0.0;
  Pose2 summed;
  while (!manoeuvre.done() && seconds < 60.0) {
    const auto step = manoeuvre.step(1.0, dt_s);
    seconds += dt_s;
    const double turning = std::fabs(step.turned_rad) / dt_s;
    const double moving = step.moved_m / dt_s;
    fastest_radps = std::fmax(fastest_radps, turning);
    fastest_mps = std::fmax(fastest_mps, moving);
    hardest_radps2 = std::fmax(hardest_radps2, (turning - turned_before) / dt_s);
    hardest_mps2 = std::fmax(hardest_mps2, (moving - moved_before) / dt_s);
    EXPECT_TRUE(step.moved_m == 0.0 || step.turned_rad == 0.0);
    summed = summed * Pose2{step.moved_m, 0.0, step.turned_rad};
    EXPECT_LT(distance(summed, manoeuvre.X_SB()), 1e-9);
    turned_before = turning;
    moved_before = moving;
  }
  EXPECT_NEAR(fastest_radps, 1.0, 1e-9);
  EXPECT_NEAR(fastest_mps, 0.10, 1e-9);
  EXPECT_NEAR(hardest_radps2, 2.0, 1e-6);
  EXPECT_NEAR(hardest_mps2, 0.25, 1e-6);
  // Angle over rate and rate over ramp, for each leg.
  EXPECT_NEAR(seconds, 2.0 * (0.5 * pi + 0.5) + 3.0 + 0.4, 0.1);
  EXPECT_EQ(manoeuvre.X_SB(), (Pose2{0.0, 0.3, 0.0}));
}

TEST(Manoeuvre, of_less_than_half_a_millimetre_is_one_turn) {
  for (const double away_m : {0.00049, 0.00051}) {
    Manoeuvre manoeuvre{{0.0, away_m, 0.0}};
    double turned_rad = 0.0;
    for (int i = 0; i < 1000; ++i) turned_rad += std::fabs(manoeuvre.step(0.1, dt_s).turned_rad);
    EXPECT_NEAR(turned_rad, away_m < 0.0005 ? 0.0 : pi, 1e-9);
  }
}

TEST(Manoeuvre, is_abandoned_after_0_3_seconds_at_rest_without_a_command) {
  Manoeuvre manoeuvre{{0.2, 0.0, 0.0}};
  for (int i = 0; i < 40; ++i) manoeuvre.step(0.1, dt_s);
  EXPECT_NEAR(manoeuvre.speed_mps(), 0.1, 1e-9);
  // 0.2 s of braking by 0.5 m/s².
  for (int i = 0; i < 19; ++i) {
    EXPECT_GT(manoeuvre.step(0.0, dt_s).moved_m, 0.0);
    EXPECT_FALSE(manoeuvre.abandoned());
  }
  for (int i = 19; i < 29; ++i) manoeuvre.step(0.0, dt_s);
  EXPECT_EQ(manoeuvre.speed_mps(), 0.0);
  EXPECT_FALSE(manoeuvre.abandoned());
  manoeuvre.step(0.0, 2.0 * dt_s);
  EXPECT_TRUE(manoeuvre.abandoned());
  manoeuvre.step(0.1, dt_s);
  EXPECT_FALSE(manoeuvre.abandoned());
  EXPECT_FALSE(manoeuvre.done());
}

TEST(Onward, needs_a_branch_at_a_sharp_bend_too) {
  using zone::Section;
  const auto bent = *zone::Circuit::make("bent", {{"in", *Section::make({0, 0, 0}, 1.0), {}, {1}, true},
                                                  {"up", *Section::make({1, 0, 0.5 * pi}, 1.0), {}, {}}});
  EXPECT_EQ(onward(bent, 0, wire::no_branch).section, zone::no_section);
  EXPECT_EQ(onward(bent, 0, 0).section, 1U);
  EXPECT_DOUBLE_EQ(onward(bent, 0, 0).turn_rad, 0.5 * pi);
}

TEST(Sought, is_the_nearest_position_within_35_centimetres_or_the_commanded_one_within_10) {
  const zone::Circuit circuit = node();
  const auto s_m = [&](const Pose2& X_MB, std::optional<wire::Manoeuvre> goal = {}) {
    const auto found = sought(circuit, X_MB, goal);
    return found ? found->s_m : -1.0;
  };
  EXPECT_NEAR(s_m({0.4, 0.349, 0.0}), 0.4, 1e-9);
  EXPECT_EQ(s_m({0.4, 0.351, 0.0}), -1.0);
  // The goal, 0.2 m before a body that faces the path, is 0.1 m off it.
  EXPECT_NEAR(s_m({0.4, 0.299, -0.5 * pi}, wire::Manoeuvre{200, 0, 1571}), 0.4, 1e-6);
  EXPECT_EQ(s_m({0.4, 0.301, -0.5 * pi}, wire::Manoeuvre{200, 0, 1571}), -1.0);
}

TEST(Goal, within_six_millimetres_is_where_the_body_is) {
  EXPECT_TRUE(to_stay({6, 0, 500}));
  EXPECT_TRUE(to_stay({0, -6, 0}));
  EXPECT_FALSE(to_stay({7, 0, 0}));
  EXPECT_FALSE(to_stay({5, 4, 0}));
}

TEST(Goal, is_rounded_to_millimetres_and_milliradians) {
  const wire::Manoeuvre goal = to_manoeuvre({0.1234, -0.0567, 3.1411});
  EXPECT_EQ(goal, (wire::Manoeuvre{123, -57, 3141}));
  EXPECT_NEAR(to_pose(goal).x_m, 0.123, 1e-12);
  EXPECT_NEAR(to_pose(goal).y_m, -0.057, 1e-12);
  EXPECT_NEAR(to_pose(goal).heading_rad, 3.141, 1e-12);
  EXPECT_NEAR(to_pose({0, 0, 3142}).heading_rad, 3.142 - 2.0 * pi, 1e-12);
}

}  // namespace
}  // namespace cosiva::aiv
