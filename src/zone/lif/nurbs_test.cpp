#include "cosiva/zone/lif/nurbs.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>

#include "cosiva/base/random.h"
#include "cosiva/zone/geometry/fit.h"
#include "cosiva/zone/lif/nurbs_of.h"

namespace cosiva::zone::lif {
namespace {

/// Nᵢ,ₚ(u) as Cox and de Boor define it, without the triangle that the curve uses.
double basis(const std::vector<double>& knots, std::size_t i, std::size_t p, double u) {
  if (p == 0) return knots[i] <= u && u < knots[i + 1] ? 1.0 : 0.0;
  double sum = 0.0;
  if (knots[i + p] > knots[i]) sum += (u - knots[i]) / (knots[i + p] - knots[i]) * basis(knots, i, p - 1, u);
  if (knots[i + p + 1] > knots[i + 1])
    sum += (knots[i + p + 1] - u) / (knots[i + p + 1] - knots[i + 1]) * basis(knots, i + 1, p - 1, u);
  return sum;
}

Point2 by_definition(const Nurbs& curve, double u) {
  double x = 0.0;
  double y = 0.0;
  double w = 0.0;
  for (std::size_t i = 0; i < curve.points.size(); ++i) {
    const double ratio = curve.weights[i] * basis(curve.knots, i, curve.degree, u);
    x += ratio * curve.points[i].x_m;
    y += ratio * curve.points[i].y_m;
    w += ratio;
  }
  return {x / w, y / w};
}

TEST(Nurbs, equals_its_definition) {
  EXPECT_TRUE(rc::check([] {
    Random random{*rc::gen::arbitrary<std::uint64_t>(), "nurbs"};
    const auto degree = 1 + static_cast<std::size_t>(random.below(5));
    const auto count = degree + 1 + static_cast<std::size_t>(random.below(6));
    Nurbs curve{degree, {}, {}, {}};
    for (std::size_t i = 0; i < count; ++i) {
      curve.points.push_back({random.uniform(-5.0, 5.0), random.uniform(-5.0, 5.0)});
      curve.weights.push_back(random.uniform(0.2, 3.0));
    }
    if (random.chance(0.5)) {
      curve.knots = clamped_uniform_knots(count, degree);
    } else {
      double knot = 0.0;
      for (std::size_t i = 0; i < count + degree + 1; ++i) curve.knots.push_back(knot += random.uniform(0.1, 1.0));
    }
    for (int i = 0; i < 20; ++i) {
      const double u = random.uniform(curve.from(), curve.to());
      const Pose2 pose = curve.pose_at(u);
      RC_ASSERT(distance(position(pose), by_definition(curve, u)) < 1e-9);
      // The direction is that of a short step on.
      const double step = 1e-6 * (curve.to() - curve.from());
      if (u + step >= curve.to() || u - step <= curve.from()) continue;
      const Point2 a = by_definition(curve, u - step);
      const Point2 b = by_definition(curve, u + step);
      if (distance(a, b) < 1e-7) continue;
      const double along = det_atan2(b.y_m - a.y_m, b.x_m - a.x_m);
      RC_ASSERT(std::fabs(wrap_angle(along - pose.heading_rad)) < 0.02);
    }
  }));
}

TEST(Nurbs, of_degree_two_with_weights_is_a_circle) {
  const double w = std::sqrt(0.5);
  const Nurbs quarter{2, {0, 0, 0, 1, 1, 1}, {{1.0, 0.0}, {1.0, 1.0}, {0.0, 1.0}}, {1.0, w, 1.0}};
  for (int i = 0; i <= 10; ++i) {
    const Pose2 pose = quarter.pose_at(i / 10.0);
    EXPECT_NEAR(norm(pose.x_m, pose.y_m), 1.0, 1e-15);
    EXPECT_NEAR(wrap_angle(pose.heading_rad - det_atan2(pose.y_m, pose.x_m)), pi / 2.0, 1e-12);
  }
}

TEST(Nurbs, begins_and_ends_on_its_first_and_last_point_with_clamped_knots) {
  const Nurbs curve{3, clamped_uniform_knots(5, 3), {{0, 0}, {1, 2}, {3, 3}, {5, 0}, {6, 1}}, {1, 2, 1, 1, 1}};
  EXPECT_EQ(position(curve.pose_at(0.0)), (Point2{0.0, 0.0}));
  EXPECT_LT(distance(position(curve.pose_at(1.0)), Point2{6.0, 1.0}), 1e-12);
  EXPECT_EQ(curve.pose_at(-1.0), curve.pose_at(0.0));
  EXPECT_EQ(curve.pose_at(2.0), curve.pose_at(1.0));
}

TEST(Nurbs, has_a_direction_where_doubled_points_stop_it) {
  const Nurbs curve{3, clamped_uniform_knots(4, 3), {{0, 0}, {0, 0}, {1, 1}, {1, 1}}, {1, 1, 1, 1}};
  EXPECT_NEAR(curve.pose_at(0.0).heading_rad, pi / 4.0, 1e-6);
  EXPECT_NEAR(curve.pose_at(1.0).heading_rad, pi / 4.0, 1e-6);
}

TEST(Nurbs, knows_where_it_may_have_corners) {
  const Nurbs line{1, clamped_uniform_knots(4, 1), {{0, 0}, {1, 0}, {1, 1}, {2, 1}}, {1, 1, 1, 1}};
  ASSERT_EQ(line.inner_knots().size(), 2U);
  EXPECT_TRUE(line.inner_knots()[0].corner);
  EXPECT_NEAR(line.inner_knots()[0].u, 1.0 / 3.0, 1e-15);
  const Nurbs smooth{2, clamped_uniform_knots(4, 2), {{0, 0}, {1, 0}, {1, 1}, {2, 1}}, {1, 1, 1, 1}};
  ASSERT_EQ(smooth.inner_knots().size(), 1U);
  EXPECT_FALSE(smooth.inner_knots()[0].corner);
}

TEST(NurbsOf, an_arc_is_exact_with_weights_of_at_least_one) {
  for (const double turn_rad : {0.1, 1.0, -pi / 2.0, 1.5 * pi, -6.0}) {
    const double radius_m = 0.6;
    const auto section =
        Section::make({1.0, 2.0, 0.3}, radius_m * std::fabs(turn_rad), (turn_rad > 0.0 ? 1.0 : -1.0) / radius_m);
    ASSERT_TRUE(section);
    const Nurbs curve = nurbs_of(*section);
    EXPECT_EQ(curve.degree, 2U);
    const Point2 centre = Pose2{1.0, 2.0, 0.3} * Point2{0.0, turn_rad > 0.0 ? radius_m : -radius_m};
    for (int i = 0; i <= 100; ++i) EXPECT_NEAR(distance(centre, position(curve.pose_at(i / 100.0))), radius_m, 1e-14);
    for (const double weight : curve.weights) EXPECT_GE(weight, 1.0);
    EXPECT_NEAR(curve.weights[0] / curve.weights[1],
                1.0 / std::cos(0.5 * std::fabs(turn_rad) / (0.5 * static_cast<double>(curve.points.size() - 1))),
                1e-12);
  }
}

TEST(NurbsOf, has_as_few_pieces_as_keep_to_the_section) {
  const auto curve_of = [](double length_m, double bend, double rate) {
    return nurbs_of(*Section::make({1.0, 2.0, 0.5 * pi}, length_m, bend, rate));
  };
  const Nurbs straight = curve_of(3.0, 0.0, 0.0);
  EXPECT_EQ(straight.degree, 1U);
  EXPECT_EQ(straight.knots, (std::vector<double>{0, 0, 1, 1}));
  EXPECT_EQ(straight.weights, (std::vector<double>{1, 1}));
  EXPECT_LT(distance(straight.points[1], Point2{1.0, 5.0}), 1e-12);
  // An arc needs a piece for each 0.49 half turns, whichever side it turns to.
  for (const double sign : {1.0, -1.0}) {
    const Nurbs one = curve_of(1.53, sign, 0.0);
    EXPECT_EQ(one.knots, (std::vector<double>{0, 0, 0, 1, 1, 1}));
    EXPECT_LT(distance(one.points[1], Point2{1.0, 2.0 + std::tan(0.765)}), 1e-9);
    EXPECT_EQ(curve_of(1.55, sign, 0.0).knots, (std::vector<double>{0, 0, 0, 0.5, 0.5, 1, 1, 1}));
    EXPECT_EQ(curve_of(6.0, sign, 0.0).knots,
              (std::vector<double>{0, 0, 0, 0.25, 0.25, 0.5, 0.5, 0.75, 0.75, 1, 1, 1}));
  }
  const Nurbs gentle = curve_of(0.3, 0.0, 1.0);
  EXPECT_EQ(gentle.degree, 3U);
  EXPECT_EQ(gentle.knots, (std::vector<double>{0, 0, 0, 0, 1, 1, 1, 1}));
  EXPECT_EQ(gentle.weights, (std::vector<double>{1, 1, 1, 1}));
  EXPECT_LT(distance(gentle.points[1], Point2{1.0, 2.1}), 1e-12);  // a third of the length along its direction
  const Nurbs tight = curve_of(2.0, 0.0, 1.0);
  EXPECT_EQ(tight.knots.size(), tight.points.size() + 4);
  ASSERT_GT(tight.points.size(), 4U);
  const std::size_t pieces = (tight.points.size() - 1) / 3;
  EXPECT_EQ(pieces & (pieces - 1), 0U);  // doubled until the curve keeps to the section
  const Section section = *Section::make({1.0, 2.0, 0.5 * pi}, 2.0, 0.0, 1.0);
  for (std::size_t i = 0; i <= pieces; ++i) {
    const double ratio = static_cast<double>(i) / static_cast<double>(pieces);
    EXPECT_LT(distance(tight.points[3 * i], position(section.pose_at(2.0 * ratio))), 1e-9);
    EXPECT_EQ(tight.knots[3 * i + 1], ratio);
  }
  // Half as many would not do: a single cubic is off by more than the tenth of a millimetre.
  const Pose2 end = section.end();
  const double third_m = 2.0 / 3.0;
  const Nurbs one{3,
                  clamped_uniform_knots(4, 3),
                  {{1.0, 2.0},
                   {1.0, 2.0 + third_m},
                   {end.x_m - third_m * std::cos(end.heading_rad), end.y_m - third_m * std::sin(end.heading_rad)},
                   position(end)},
                  {1, 1, 1, 1}};
  double off_m = 0.0;
  for (int i = 0; i <= 50; ++i) off_m = std::max(off_m, section.nearest(position(one.pose_at(i / 50.0))).distance_m);
  EXPECT_GT(off_m, 1e-4);
}

TEST(NurbsOf, a_clothoid_is_within_a_tenth_of_a_millimetre_and_reads_back_as_itself) {
  EXPECT_TRUE(rc::check([] {
    Random random{*rc::gen::arbitrary<std::uint64_t>(), "clothoid"};
    const double length_m = random.uniform(0.2, 4.0);
    const double k0 = random.uniform(-2.0, 2.0);
    const double k1 = random.uniform(-2.0, 2.0);
    const auto section =
        Section::make({random.uniform(-9.0, 9.0), random.uniform(-9.0, 9.0), random.uniform(-3.0, 3.0)}, length_m, k0,
                      (k1 - k0) / length_m);
    RC_ASSERT(section.has_value());
    const Nurbs curve = nurbs_of(*section);
    for (int i = 0; i <= 200; ++i) {
      const auto near = section->nearest(position(curve.pose_at(i / 200.0)));
      RC_ASSERT(near.distance_m < 1e-4);
    }
    if (0.5 * (std::fabs(k0) + std::fabs(k1)) * length_m > 3.0) return;
    const auto fitted = fit({[&](double u) { return curve.pose_at(u); }, 0.0, 1.0, {}});
    RC_ASSERT(fitted.has_value());
    RC_ASSERT(fitted->sections.size() == 1U);
    RC_ASSERT(std::fabs(fitted->sections[0].length_m() - length_m) < 1e-3);
  }));
}

TEST(Nurbs, may_have_a_corner_only_where_an_inner_knot_occurs_as_often_as_its_degree) {
  const auto inner = [](std::size_t degree, std::vector<double> knots) {
    const std::size_t count = knots.size() - degree - 1;
    return Nurbs{degree, std::move(knots), std::vector<Point2>(count), std::vector<double>(count, 1.0)}.inner_knots();
  };
  const auto twice = inner(2, {0, 0, 0, 0.5, 0.5, 1, 1, 1});
  ASSERT_EQ(twice.size(), 1U);
  EXPECT_EQ(twice[0].u, 0.5);
  EXPECT_TRUE(twice[0].corner);
  EXPECT_FALSE(inner(3, {0, 0, 0, 0, 0.5, 0.5, 1, 1, 1, 1}).at(0).corner);
  EXPECT_TRUE(inner(3, {0, 0, 0, 0, 0.5, 0.5, 0.5, 1, 1, 1, 1}).at(0).corner);
  const auto mixed = inner(2, {0, 0, 0, 0.25, 0.5, 0.5, 0.75, 1, 1, 1});
  ASSERT_EQ(mixed.size(), 3U);
  EXPECT_FALSE(mixed[0].corner);
  EXPECT_TRUE(mixed[1].corner);
  EXPECT_EQ(mixed[2].u, 0.75);
  EXPECT_FALSE(mixed[2].corner);
  // Those before its begin and after its end do not count.
  const auto open = inner(2, {0, 1, 2, 3, 4, 5, 6});
  ASSERT_EQ(open.size(), 1U);
  EXPECT_EQ(open[0].u, 3.0);
  EXPECT_TRUE(inner(2, {0, 0, 0, 1, 1, 1}).empty());
}

TEST(Nurbs, has_a_degree_of_at_most_25) {
  const auto line = [](std::size_t degree) {
    Nurbs curve{degree, clamped_uniform_knots(degree + 1, degree), {}, std::vector<double>(degree + 1, 1.0)};
    for (std::size_t i = 0; i <= degree; ++i) curve.points.push_back({static_cast<double>(i), 2.0});
    return curve;
  };
  // A Bézier curve whose points are evenly spaced runs along them at constant speed.
  const Pose2 pose = line(25).pose_at(0.5);
  EXPECT_NEAR(pose.x_m, 12.5, 1e-9);
  EXPECT_NEAR(pose.y_m, 2.0, 1e-9);
  EXPECT_NEAR(pose.heading_rad, 0.0, 1e-9);
  constexpr const char* holds_together = "degree >= 1 && degree <= nurbs_degree_max && points.size.. > degree";
  EXPECT_DEATH(static_cast<void>(line(26).pose_at(0.5)), holds_together);
  Nurbs heavy = line(2);
  heavy.weights.push_back(1.0);
  EXPECT_DEATH(static_cast<void>(heavy.pose_at(0.5)), holds_together);
  Nurbs long_one = line(2);
  long_one.knots.push_back(1.0);
  EXPECT_DEATH(static_cast<void>(long_one.pose_at(0.5)), holds_together);
}

TEST(Nurbs, has_evenly_spaced_knots_only_for_more_points_than_its_degree) {
  EXPECT_EQ(clamped_uniform_knots(2, 1), (std::vector<double>{0, 0, 1, 1}));
  EXPECT_EQ(clamped_uniform_knots(3, 1), (std::vector<double>{0, 0, 0.5, 1, 1}));
  EXPECT_EQ(clamped_uniform_knots(6, 2), (std::vector<double>{0, 0, 0, 0.25, 0.5, 0.75, 1, 1, 1}));
  EXPECT_DEATH(static_cast<void>(clamped_uniform_knots(2, 2)), "degree >= 1 && points > degree");
  EXPECT_DEATH(static_cast<void>(clamped_uniform_knots(2, 0)), "degree >= 1 && points > degree");
}

}  // namespace
}  // namespace cosiva::zone::lif
