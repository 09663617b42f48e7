#include "cosiva/zone/geometry/section.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <limits>
#include <string>

#include "cosiva/base/random.h"
#include "cosiva/zone/testing/test_shapes.h"

namespace cosiva::zone {
namespace {

Section make(const Pose2& start, double length_m, double curvature = 0.0, double rate = 0.0) {
  auto section = Section::make(start, length_m, curvature, rate);
  EXPECT_TRUE(section) << to_string(section.error());
  return std::move(*section);
}

void expect_near(const Pose2& a, const Pose2& b, double tolerance) {
  EXPECT_NEAR(a.x_m, b.x_m, tolerance);
  EXPECT_NEAR(a.y_m, b.y_m, tolerance);
  EXPECT_NEAR(wrap_angle(a.heading_rad - b.heading_rad), 0.0, tolerance);
}

/// The end of a curve of linear curvature after s, by Simpson's rule over many small steps: a slow but certain
/// reference.
Pose2 integrate(const Pose2& start, double s_m, double curvature, double rate) {
  const auto heading = [&](long double s) {
    return static_cast<long double>(start.heading_rad) + s * (curvature + 0.5L * rate * s);
  };
  constexpr int steps = 20'000;
  const long double h = static_cast<long double>(s_m) / steps;
  long double x = 0.0L;
  long double y = 0.0L;
  for (int i = 0; i < steps; ++i) {
    const long double a = h * i;
    const long double t0 = heading(a), t1 = heading(a + 0.5L * h), t2 = heading(a + h);
    x += h / 6.0L * (std::cos(t0) + 4.0L * std::cos(t1) + std::cos(t2));
    y += h / 6.0L * (std::sin(t0) + 4.0L * std::sin(t1) + std::sin(t2));
  }
  return {static_cast<double>(start.x_m + x), static_cast<double>(start.y_m + y),
          wrap_angle(static_cast<double>(heading(s_m)))};
}

/// Random draws for one case of a property. Its values are spread evenly from the first case on, unlike rapidcheck's.
Random any() { return Random{*rc::gen::arbitrary<std::uint64_t>(), "section_test"}; }

/// A section of any kind, up to about two turns.
Section any_section(Random& random) {
  const auto between = [&](double low, double high) { return random.uniform(low, high); };
  const Pose2 start{between(-5.0, 5.0), between(-5.0, 5.0), between(-3.1, 3.1)};
  const double length_m = between(0.05, 6.0);
  const auto kind = random.below(3);
  const double curvature = kind == 0 ? 0.0 : between(-2.0, 2.0);
  const double rate = kind == 2 ? between(-2.0, 2.0) / length_m : 0.0;
  return make(start, length_m, curvature, rate);
}

// The article's equations ---------------------------------------------------------------------------------------------

TEST(Section, equation_1_an_arc_turns_the_vehicle_about_its_centre) {
  // x' = xc + R·cos(atan2(y − yc, x − xc) + v·Δt/R), likewise y; atan2 where the article writes arctg.
  constexpr double R = 0.6, xc = 2.0, yc = -1.0, v = 0.3, dt = 0.1;
  for (double start_deg = -180.0; start_deg < 180.0; start_deg += 15.0) {
    const double spoke = start_deg * pi / 180.0;
    const Section arc =
        make({xc + R * std::cos(spoke), yc + R * std::sin(spoke), spoke + pi / 2.0}, 1.5 * pi * R, 1.0 / R);
    double mDTCS_m = 0.0;
    while (mDTCS_m + v * dt < arc.length_m()) {
      const Pose2 now = arc.pose_at(mDTCS_m);
      const double angle = std::atan2(now.y_m - yc, now.x_m - xc) + v / R * dt;
      const auto next = arc.nextAIVposition(mDTCS_m, v * dt);
      EXPECT_DOUBLE_EQ(next.DT_m, v * dt);
      EXPECT_NEAR(next.pose.x_m, xc + R * std::cos(angle), 1e-13);
      EXPECT_NEAR(next.pose.y_m, yc + R * std::sin(angle), 1e-13);
      mDTCS_m += next.DT_m;
    }
  }
}

TEST(Section, equation_2_a_horizontal_section_moves_x_alone) {
  const Section horizontal = make({-0.75, -0.15, 0.0}, 1.5);
  const auto next = horizontal.nextAIVposition(0.4, 0.5 * 0.25);
  EXPECT_DOUBLE_EQ(next.pose.x_m, horizontal.pose_at(0.4).x_m + 0.5 * 0.25);
  EXPECT_EQ(next.pose.y_m, -0.15);
  EXPECT_EQ(next.pose.heading_rad, 0.0);
}

TEST(Section, equation_3_a_vertical_section_moves_y_alone) {
  const Section vertical = make({0.15, -0.75, pi / 2.0}, 1.5);
  const auto next = vertical.nextAIVposition(0.4, 0.5 * 0.25);
  EXPECT_NEAR(next.pose.x_m, 0.15, 1e-16);
  EXPECT_DOUBLE_EQ(next.pose.y_m, vertical.pose_at(0.4).y_m + 0.5 * 0.25);
  EXPECT_EQ(next.pose.heading_rad, pi / 2.0);
}

// Geometry ------------------------------------------------------------------------------------------------------------

TEST(Section, of_no_curvature_is_straight_at_any_angle) {
  const Section section = make({1.0, 2.0, 2.5}, 4.0);
  EXPECT_EQ(section.kind(), SectionKind::straight);
  expect_near(section.pose_at(3.0), {1.0 + 3.0 * std::cos(2.5), 2.0 + 3.0 * std::sin(2.5), 2.5}, 1e-14);
}

TEST(Section, arc_of_several_turns_stays_within_a_picometre_of_its_circle) {
  for (const double R : {0.25, 1.0, 40.0}) {
    for (const double side : {1.0, -1.0}) {
      const Section arc = make({0.0, 0.0, 0.0}, 3.7 * 2.0 * pi * R, side / R);
      EXPECT_EQ(arc.kind(), SectionKind::arc);
      for (double s = 0.0; s <= arc.length_m(); s += 0.0371 * R) {
        const Pose2 pose = arc.pose_at(s);
        EXPECT_NEAR(pose.x_m, R * std::sin(s / R), 1e-12 * std::max(R, 1.0));
        EXPECT_NEAR(pose.y_m, side * R * (1.0 - std::cos(s / R)), 1e-12 * std::max(R, 1.0));
        EXPECT_NEAR(wrap_angle(pose.heading_rad - side * s / R), 0.0, 1e-12);
      }
    }
  }
}

TEST(Section, of_very_small_curvature_keeps_its_digits) {
  // Offset of an arc of radius 1e9 m after 40 m: s²/2R = 0.8 µm, to 1e-15 m.
  const Section arc = make({0.0, 0.0, 0.0}, 40.0, 1e-9);
  EXPECT_NEAR(arc.end().y_m, 8e-7, 1e-15);
  EXPECT_NEAR(arc.end().x_m, 40.0, 1e-13);
}

TEST(Section, clothoid_agrees_with_numerical_integration) {
  struct Case {
    double length_m, start, end;
  };
  for (const Case& c : {Case{1.0, 0.0, 2.0}, {1.0, 2.0, 0.0}, {3.0, -1.5, 1.5}, {2.0, 0.5, 4.0}, {8.0, -2.0, 1.0}}) {
    const double rate = (c.end - c.start) / c.length_m;
    const Pose2 start{0.3, -0.7, 0.9};
    const Section clothoid = make(start, c.length_m, c.start, rate);
    EXPECT_EQ(clothoid.kind(), SectionKind::clothoid);
    for (const double part : {0.1, 0.37, 0.5, 0.81, 1.0})
      expect_near(clothoid.pose_at(part * c.length_m), integrate(start, part * c.length_m, c.start, rate), 1e-12);
  }
}

TEST(Section, clothoid_ends_at_the_fresnel_integrals) {
  // With κ = π·s from 0, ∫cos(π s²/2) over [0, 1] is C(1) and ∫sin is S(1) (Abramowitz and Stegun, table 7.7).
  const Section clothoid = make({0.0, 0.0, 0.0}, 1.0, 0.0, pi);
  EXPECT_NEAR(clothoid.end().x_m, 0.7798934003768228, 1e-14);
  EXPECT_NEAR(clothoid.end().y_m, 0.4382591473903548, 1e-14);
}

TEST(Section, has_no_step_between_its_pieces) {
  const Section clothoid = make({0.0, 0.0, 0.0}, 10.0, -3.0, 0.6);
  constexpr double step_m = 1e-4;
  Pose2 before = clothoid.pose_at(0.0);
  for (double s = step_m; s <= 10.0; s += step_m) {
    const Pose2 here = clothoid.pose_at(s);
    // A chord is shorter than its arc by κ²·h³/24, here under 4e-13 m.
    ASSERT_NEAR(distance(before, here), step_m, 1e-12);
    before = here;
  }
}

TEST(Section, clamps_positions_beyond_its_ends) {
  const Section arc = make({0.0, 0.0, 0.0}, 1.0, 0.5);
  EXPECT_EQ(arc.pose_at(-1.0), arc.start());
  EXPECT_EQ(arc.pose_at(2.0), arc.end());
  EXPECT_EQ(arc.pose_at(std::numeric_limits<double>::quiet_NaN()), arc.pose_at(0.0));
  EXPECT_EQ(arc.curvature_at(9.0), 0.5);
}

TEST(Section, curvature_is_linear_in_arc_length) {
  const Section clothoid = make({0.0, 0.0, 0.0}, 2.0, -1.0, 1.5);
  EXPECT_DOUBLE_EQ(clothoid.curvature_at(0.5), -0.25);
  EXPECT_DOUBLE_EQ(clothoid.curvature_at(2.0), 2.0);
  EXPECT_DOUBLE_EQ(clothoid.curvature_max_per_m(), 2.0);
}

TEST(Section, split_anywhere_gives_the_same_poses) {
  EXPECT_TRUE(rc::check([] {
    Random random = any();
    const Section whole = any_section(random);
    const double cut_m = whole.length_m() * random.uniform(0.05, 0.95);
    const double rate = (whole.curvature_at(whole.length_m()) - whole.curvature_at(0.0)) / whole.length_m();
    const Section first = make(whole.start(), cut_m, whole.curvature_at(0.0), rate);
    const Section second = make(first.end(), whole.length_m() - cut_m, whole.curvature_at(cut_m), rate);
    for (const double part : {0.0, 0.3, 0.8, 1.0}) {
      expect_near(first.pose_at(part * cut_m), whole.pose_at(part * cut_m), 1e-12);
      const double s = part * second.length_m();
      expect_near(second.pose_at(s), whole.pose_at(cut_m + s), 1e-12);
    }
    RC_ASSERT(!testing::Test::HasFailure());
  }));
}

TEST(Section, box_holds_every_point_and_little_more) {
  EXPECT_TRUE(rc::check([] {
    Random random = any();
    const Section section = any_section(random);
    Box detected{position(section.start()), position(section.start())};
    for (int i = 0; i <= 500; ++i) {
      const Point2 p = position(section.pose_at(i / 500.0 * section.length_m()));
      RC_ASSERT(distance(section.box(), p) == 0.0);
      detected = {{std::min(detected.low.x_m, p.x_m), std::min(detected.low.y_m, p.y_m)},
                  {std::max(detected.high.x_m, p.x_m), std::max(detected.high.y_m, p.y_m)}};
    }
    const double spare_m = section.kind() == SectionKind::straight ? 1e-12 : 0.02 * section.length_m();
    RC_ASSERT(section.box().high.x_m - detected.high.x_m < spare_m);
    RC_ASSERT(section.box().high.y_m - detected.high.y_m < spare_m);
    RC_ASSERT(detected.low.x_m - section.box().low.x_m < spare_m);
    RC_ASSERT(detected.low.y_m - section.box().low.y_m < spare_m);
  }));
}

// A30, figure 14 ------------------------------------------------------------------------------------------------------

TEST(Section, takes_the_whole_distance_while_it_lasts) {
  const Section section = make({0.0, 0.0, 0.0}, 1.0);
  const auto next = section.nextAIVposition(0.25, 0.5);
  EXPECT_EQ(next.DT_m, 0.5);
  EXPECT_EQ(next.pose.x_m, 0.75);
}

TEST(Section, takes_only_the_rest_of_its_length) {
  const Section section = make({0.0, 0.0, 0.0}, 1.0);
  const auto next = section.nextAIVposition(0.75, 0.5);
  EXPECT_EQ(next.DT_m, 0.25);
  EXPECT_EQ(next.pose, section.end());
}

TEST(Section, takes_nothing_at_its_end_and_everything_up_to_it) {
  const Section section = make({0.0, 0.0, 0.0}, 1.0);
  EXPECT_EQ(section.nextAIVposition(1.0, 0.1).DT_m, 0.0);
  EXPECT_EQ(section.nextAIVposition(0.0, 1.0).DT_m, 1.0);
  EXPECT_EQ(section.nextAIVposition(0.3, 0.0).DT_m, 0.0);
}

// The nearest point ---------------------------------------------------------------------------------------------------

TEST(Section, nearest_of_its_own_point_is_that_point) {
  EXPECT_TRUE(rc::check([] {
    // At most a turn of 6 rad: a curve that meets itself has two nearest points.
    Random random = any();
    const auto between = [&](double low, double high) { return random.uniform(low, high); };
    const Pose2 start{between(-5.0, 5.0), between(-5.0, 5.0), between(-3.1, 3.1)};
    const double length_m = between(0.05, 3.0);
    const double curvature = random.below(4) == 0 ? 0.0 : between(-2.0, 2.0);
    const double end = random.below(2) == 0 ? curvature : between(-2.0, 2.0);
    const Section section = make(start, length_m, curvature, (end - curvature) / length_m);
    const double s = section.length_m() * between(0.0, 1.0);
    const auto near = section.nearest(position(section.pose_at(s)));
    RC_ASSERT(std::fabs(near.s_m - s) < 1e-9);
    RC_ASSERT(near.distance_m < 1e-12);
    RC_ASSERT(std::fabs(near.left_m) < 1e-12);
  }));
}

TEST(Section, nearest_is_never_beaten_by_a_sample) {
  EXPECT_TRUE(rc::check([] {
    Random random = any();
    const Section section = any_section(random);
    const Point2 p{section.start().x_m + random.uniform(-4.0, 4.0), section.start().y_m + random.uniform(-4.0, 4.0)};
    const auto near = section.nearest(p);
    RC_ASSERT(near.s_m >= 0.0 && near.s_m <= section.length_m());
    RC_ASSERT(std::fabs(near.distance_m - distance(p, position(section.pose_at(near.s_m)))) < 1e-12);
    for (double part = 0.0; part <= 1.0; part += 0.001)
      RC_ASSERT(near.distance_m <= distance(p, position(section.pose_at(part * section.length_m()))) + 1e-12);
  }));
}

TEST(Section, nearest_distinguishes_left_from_right) {
  const Section straight = make({0.0, 0.0, 0.0}, 2.0);
  EXPECT_EQ(straight.nearest({1.0, 0.3}).left_m, 0.3);
  EXPECT_EQ(straight.nearest({1.0, -0.3}).left_m, -0.3);
  const Section right_bend = make({0.0, 0.0, 0.0}, 1.0, -1.0);  // centre (0, −1)
  const auto inside = right_bend.nearest({0.5 * std::sin(0.5), -1.0 + 0.5 * std::cos(0.5)});
  EXPECT_NEAR(inside.s_m, 0.5, 1e-12);
  EXPECT_NEAR(inside.left_m, -0.5, 1e-12);
}

TEST(Section, nearest_beyond_the_ends_is_the_end) {
  const Section straight = make({0.0, 0.0, 0.0}, 2.0);
  const auto beyond = straight.nearest({5.0, 4.0});
  EXPECT_EQ(beyond.s_m, 2.0);
  EXPECT_EQ(beyond.left_m, 4.0);
  EXPECT_EQ(beyond.distance_m, 5.0);

  const Section quarter = make({0.0, 0.0, 0.0}, pi / 2.0, 1.0);  // round (0, 1), from below it to its right
  EXPECT_EQ(quarter.nearest({-1.0, 0.0}).s_m, 0.0);
  EXPECT_EQ(quarter.nearest({0.9, 2.0}).s_m, quarter.length_m());
}

TEST(Section, nearest_to_the_centre_of_an_arc_is_a_radius_away) {
  const Section arc = make({0.0, 0.0, 0.0}, 1.5 * pi * 0.6, 1.0 / 0.6);
  const auto near = arc.nearest({0.0, 0.6});
  EXPECT_NEAR(near.distance_m, 0.6, 1e-12);
  EXPECT_NEAR(near.left_m, 0.6, 1e-12);
}

// Pieces of a curve turn by at most half a radian: a quarter of a circle of 1 m has four. The box holds their ends and
// centres with a margin of a quarter of a radian times half a piece, by 8.
TEST(Section, box_of_a_bend_has_a_margin_of_a_256th_of_its_pieces) {
  const double margin_m = 0.5 * (0.125 * pi) * 0.25 / 8.0;
  const Box left = make({0.0, 0.0, 0.0}, 0.5 * pi, 1.0).box();
  EXPECT_NEAR(left.low.x_m, 0.0 - margin_m, 1e-12);
  EXPECT_NEAR(left.low.y_m, 0.0 - margin_m, 1e-12);
  EXPECT_NEAR(left.high.x_m, 1.0 + margin_m, 1e-12);
  EXPECT_NEAR(left.high.y_m, 1.0 + margin_m, 1e-12);
  const Box right = make({0.0, 0.0, pi}, 0.5 * pi, 1.0).box();
  EXPECT_NEAR(right.low.x_m, -1.0 - margin_m, 1e-12);
  EXPECT_NEAR(right.low.y_m, -1.0 - margin_m, 1e-12);
  EXPECT_NEAR(right.high.x_m, margin_m, 1e-12);
  EXPECT_NEAR(right.high.y_m, margin_m, 1e-12);
  const Box straight = make({1.0, 2.0, pi}, 3.0).box();
  EXPECT_NEAR(straight.low.x_m, -2.0, 1e-12);
  EXPECT_EQ(straight.high.x_m, 1.0);
  EXPECT_NEAR(straight.low.y_m, 2.0, 1e-12);
}

// A circle of 1 m about (0, 1), from its lowest point to three quarters: the missing quarter is on the left.
TEST(Section, nearest_of_an_arc_is_an_end_where_the_arc_does_not_go) {
  const Section arc = make({0.0, 0.0, 0.0}, 1.5 * pi, 1.0);
  const auto near_start = arc.nearest({-0.5, 0.0});
  EXPECT_EQ(near_start.s_m, 0.0);
  EXPECT_NEAR(near_start.distance_m, 0.5, 1e-12);
  EXPECT_NEAR(near_start.left_m, 0.0, 1e-12);
  const auto near_end = arc.nearest({-1.0, 0.5});  // it ends at (−1, 1), heading south
  EXPECT_EQ(near_end.s_m, arc.length_m());
  EXPECT_NEAR(near_end.distance_m, 0.5, 1e-12);
  EXPECT_NEAR(near_end.left_m, 0.0, 1e-12);
  const auto outside = arc.nearest({3.0, 1.0});
  EXPECT_NEAR(outside.s_m, 0.5 * pi, 1e-12);
  EXPECT_NEAR(outside.left_m, -2.0, 1e-12);
  EXPECT_NEAR(outside.distance_m, 2.0, 1e-12);
  const auto above = arc.nearest({0.0, 2.5});
  EXPECT_NEAR(above.s_m, pi, 1e-12);
  EXPECT_NEAR(above.left_m, -0.5, 1e-12);
}

// κ = s: the heading is s²/2. Half a metre to the left of s = 1.2 m, where the radius is 0.83 m, and of others.
TEST(Section, nearest_of_a_clothoid_is_the_foot_of_the_perpendicular) {
  for (const double side : {1.0, -1.0}) {
    const Section clothoid = make({2.0, -1.0, 0.4}, 2.0, 0.0, side);
    for (const double s_m : {0.0, 0.3, 0.7, 1.2, 1.99, 2.0}) {
      for (const double left_m : {0.3, -0.3, 1e-7, -2.0 * side}) {
        const auto near = clothoid.nearest(clothoid.pose_at(s_m) * Point2{0.0, left_m});
        EXPECT_NEAR(near.s_m, s_m, 1e-9) << s_m << ' ' << left_m;
        EXPECT_NEAR(near.left_m, left_m, 1e-9) << s_m << ' ' << left_m;
        EXPECT_NEAR(near.distance_m, std::fabs(left_m), 1e-9) << s_m << ' ' << left_m;
      }
    }
    // Straight ahead of its end, and behind its start.
    const auto beyond = clothoid.nearest(clothoid.end() * Point2{0.4, 0.0});
    EXPECT_EQ(beyond.s_m, 2.0);
    EXPECT_NEAR(beyond.left_m, 0.0, 1e-12);
    EXPECT_NEAR(beyond.distance_m, 0.4, 1e-12);
    const auto behind = clothoid.nearest(clothoid.start() * Point2{-0.4, 0.0});
    EXPECT_EQ(behind.s_m, 0.0);
    EXPECT_NEAR(behind.distance_m, 0.4, 1e-12);
  }
}

// Invalid sections ----------------------------------------------------------------------------------------------------

TEST(Section, refuses_values_that_are_no_numbers) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  constexpr double infinity = std::numeric_limits<double>::infinity();
  for (const double bad : {nan, infinity, -infinity}) {
    EXPECT_FALSE(Section::make({bad, 0.0, 0.0}, 1.0));
    EXPECT_FALSE(Section::make({0.0, bad, 0.0}, 1.0));
    EXPECT_FALSE(Section::make({0.0, 0.0, bad}, 1.0));
    EXPECT_FALSE(Section::make({}, bad));
    EXPECT_FALSE(Section::make({}, 1.0, bad));
    EXPECT_FALSE(Section::make({}, 1.0, 0.0, bad));
  }
}

TEST(Section, refuses_lengths_and_turns_out_of_range) {
  for (const double bad : {0.0, -1.0, 1.1e5}) EXPECT_EQ(Section::make({}, bad).error().code, "section.invalid");
  EXPECT_EQ(Section::make({}, 1.0, 10'001.0).error().code, "section.invalid");
  EXPECT_EQ(Section::make({}, 1e5, 0.0, 1.0).error().code, "section.invalid");
  EXPECT_EQ(Section::make({}, 1.0, 1e308, 1e308).error().code, "section.invalid");
  EXPECT_TRUE(Section::make({}, 1e5, 0.0, 1e-6));
  // A curvature through zero: 2 · 100 · 1 / 2 … the turned angle is the integral of its size, 50 rad.
  EXPECT_TRUE(Section::make({}, 1.0, -100.0, 200.0));
}

TEST(Section, is_made_at_the_limits_of_its_numbers_and_refused_beyond_them) {
  const auto message = [](const Pose2& start, double length_m, double curvature = 0.0, double rate = 0.0) {
    const auto section = Section::make(start, length_m, curvature, rate);
    return section ? std::string("made") : section.error().message;
  };
  using ::testing::HasSubstr;
  EXPECT_EQ(message({}, 1e-6), "made");
  EXPECT_THAT(message({}, 0.99e-6), HasSubstr("from 0.000001 to 100000 m, not 0.000001 m"));
  EXPECT_EQ(message({}, 1e5), "made");
  EXPECT_THAT(message({}, 100'001.0), HasSubstr("not 100001.000000 m"));
  EXPECT_EQ(message({0.0, 0.0, 1e6}, 1.0), "made");
  EXPECT_EQ(message({0.0, 0.0, -1e6}, 1.0), "made");
  EXPECT_THAT(message({0.0, 0.0, 1.001e6}, 1.0), HasSubstr("heading"));
  EXPECT_THAT(message({0.0, 0.0, -1.001e6}, 1.0), HasSubstr("heading"));
  EXPECT_EQ(message({}, 1.0, 1e4), "made");
  EXPECT_THAT(message({}, 1.0, -10'001.0), HasSubstr("at most 10000 rad, not 10001.000000 rad"));
  // From −a to 2a: triangles of a third and two thirds of the length, (a + 4a)/6 in all.
  EXPECT_EQ(message({}, 1.0, -12'000.0, 36'000.0), "made");
  EXPECT_THAT(message({}, 1.0, -12'012.0, 36'036.0), HasSubstr("not 10010.000000 rad"));
  // From a to 3a: 2a.
  EXPECT_THAT(message({}, 1.0, 5'001.0, 10'002.0), HasSubstr("not 10002.000000 rad"));
}

TEST(Section, kinds_have_names) {
  EXPECT_EQ(to_string(SectionKind::straight), "straight");
  EXPECT_EQ(to_string(SectionKind::arc), "arc");
  EXPECT_EQ(to_string(SectionKind::clothoid), "clothoid");
}

TEST(Box, is_nearest_at_an_edge_or_a_corner) {
  const Box box{{1.0, 2.0}, {3.0, 5.0}};
  EXPECT_EQ(distance(box, {2.0, 3.0}), 0.0);
  EXPECT_EQ(distance(box, {0.5, 3.0}), 0.5);
  EXPECT_EQ(distance(box, {3.25, 3.0}), 0.25);
  EXPECT_EQ(distance(box, {2.0, 1.0}), 1.0);
  EXPECT_EQ(distance(box, {2.0, 7.0}), 2.0);
  EXPECT_EQ(distance(box, {6.0, 9.0}), 5.0);
  EXPECT_EQ(distance(box, {-2.0, -2.0}), 5.0);
}

TEST(Section, nearest_to_a_flat_arc_keeps_its_digits) {
  // A turn of 0.04 rad and of 0.06 rad over 1 m: by search, and by the centre. 0.3 m to the left at s = 0.7 m.
  for (const double turn_rad : {1e-9, 0.04, 0.06, -0.04, -0.06}) {
    const Section arc = make({1e3, -2e3, 0.4}, 1.0, turn_rad);
    const Point2 p = arc.pose_at(0.7) * Point2{0.0, 0.3};
    const auto near = arc.nearest(p);
    EXPECT_NEAR(near.s_m, 0.7, 1e-9) << turn_rad;
    EXPECT_NEAR(near.left_m, 0.3, 1e-9) << turn_rad;
    EXPECT_NEAR(near.distance_m, 0.3, 1e-9) << turn_rad;
  }
}

TEST(Section, wraps_the_heading_it_starts_with) {
  const Section section = make({0.0, 0.0, 3.0 * pi}, 1.0);
  EXPECT_DOUBLE_EQ(std::fabs(section.start().heading_rad), pi);
}

TEST(Section, moves_a_vehicle_forward_only) {
  const Section section = make({}, 1.0);
  EXPECT_DEATH(static_cast<void>(section.nextAIVposition(-0.1, 0.5)), "min.DTT_m, mDTCS_m. >= 0.0");
  EXPECT_DEATH(static_cast<void>(section.nextAIVposition(0.5, -0.1)), "min.DTT_m, mDTCS_m. >= 0.0");
}

TEST(Section, point_and_heading_alone_are_those_of_the_pose_to_the_last_bit) {
  for (const Section& section :
       {make({1.0, 2.0, 2.5}, 4.0), make({1.0, 2.0, 2.5}, 4.0, -1.3), make({0.3, 0.1, -3.0}, 2.0, 0.7, -0.4)}) {
    for (double s = -0.5; s < section.length_m() + 0.5; s += 0.013) {
      const Pose2 pose = section.pose_at(s);
      EXPECT_EQ(section.point_at(s), position(pose)) << s;
      EXPECT_EQ(section.heading_at(s), pose.heading_rad) << s;
    }
  }
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Section bent = make({1.0, 2.0, 2.5}, 4.0, -1.3);
  EXPECT_EQ(bent.point_at(nan), position(bent.pose_at(0.0)));
}

TEST(ReversedSection, has_each_position_at_the_rest_of_the_length_with_the_opposite_heading) {
  EXPECT_TRUE(rc::check([] {
    Random random = any();
    const Section section = any_section(random);
    const Section back = reversed(section);
    RC_ASSERT(back.length_m() == section.length_m());
    for (const double part : {0.0, 0.2, 0.5, 0.9, 1.0}) {
      const double s_m = part * section.length_m();
      const Pose2 there = section.pose_at(section.length_m() - s_m);
      const Pose2 here = back.pose_at(s_m);
      RC_ASSERT(distance(here, there) < 1e-9);
      RC_ASSERT(std::fabs(std::fabs(wrap_angle(here.heading_rad - there.heading_rad)) - pi) < 1e-9);
      RC_ASSERT(std::fabs(back.curvature_at(s_m) + section.curvature_at(section.length_m() - s_m)) < 1e-9);
    }
  }));
}

TEST(ReversedSection, of_a_shape_is_the_same_curve_and_reversed_twice_the_shape_itself) {
  const auto shape = test::sine_shape(0.2, 1.5, 1.25);
  const Section section = *Section::make({1.0, 2.0, 0.7}, shape);
  const Section back = reversed(section);
  for (double s_m = 0.0; s_m <= section.length_m(); s_m += 0.05) {
    expect_near(back.pose_at(s_m), turned_round(section.pose_at(section.length_m() - s_m)), 1e-9);
    EXPECT_NEAR(back.curvature_at(s_m), -section.curvature_at(section.length_m() - s_m), 1e-9);
  }
  EXPECT_EQ(reversed(back).shape(), shape);
}

}  // namespace
}  // namespace cosiva::zone
