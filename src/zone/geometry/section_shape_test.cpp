#include "cosiva/zone/geometry/section_shape.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <functional>
#include <limits>

#include "cosiva/zone/geometry/section.h"
#include "cosiva/zone/testing/test_shapes.h"

namespace cosiva::zone {
namespace {

using ::testing::HasSubstr;

void expect_near(const Pose2& a, const Pose2& b, double within) {
  EXPECT_NEAR(a.x_m, b.x_m, within);
  EXPECT_NEAR(a.y_m, b.y_m, within);
  EXPECT_NEAR(wrap_angle(a.heading_rad - b.heading_rad), 0.0, within);
}

/// A straight line that contradicts itself in one respect.
struct Faulty final : SectionShape {
  double length{2.0};
  double limit_per_m{0.0};
  std::function<Pose2(double)> pose{[](double s_m) { return Pose2{s_m, 0.0, 0.0}; }};
  std::function<double(double)> curvature{[](double) { return 0.0; }};

  std::string_view kind() const override { return "faulty"; }
  double length_m() const override { return length; }
  Pose2 pose_at(double s_m) const override { return pose(s_m); }
  double curvature_at(double s_m) const override { return curvature(s_m); }
  double curvature_max_per_m() const override { return limit_per_m; }
  std::vector<Field> fields() const override { return {}; }
};

std::string fault_of(const SectionShape& shape) {
  const auto checked = check_shape(shape);
  return checked ? "none" : checked.error().code + ": " + checked.error().message;
}

TEST(SectionShape, is_accepted_where_it_is_consistent) {
  EXPECT_EQ(fault_of(Faulty{}), "none");
  EXPECT_EQ(fault_of(test::CountingArc{3.0, 0.8}), "none");
  EXPECT_EQ(fault_of(test::CountingArc{500.0, -12.0}), "none");
}

TEST(SectionShape, is_refused_where_it_contradicts_itself) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Faulty late;
  late.pose = [](double s_m) { return Pose2{s_m + 0.01, 0.0, 0.0}; };
  EXPECT_THAT(fault_of(late), HasSubstr("section.invalid: a section of kind 'faulty' does not begin at the origin"));
  Faulty fast;
  fast.pose = [](double s_m) { return Pose2{1.001 * s_m, 0.0, 0.0}; };
  EXPECT_THAT(fault_of(fast), HasSubstr("is not parametrised by its arc length at s = 0.000000 m"));
  Faulty across;
  across.pose = [](double s_m) { return Pose2{s_m, 0.0, 0.5 * s_m}; };
  across.curvature = [](double) { return 0.5; };
  across.limit_per_m = 0.5;
  EXPECT_THAT(fault_of(across), HasSubstr("heading that is not its direction"));
  Faulty straighter;
  straighter.pose = [](double s_m) { return test::CountingArc{2.0, 0.5}.pose_at(s_m); };
  straighter.limit_per_m = 0.5;
  EXPECT_THAT(fault_of(straighter),
              HasSubstr("a curvature of 0.000000 per m at s = 0.000000 m, but its heading changes"));
  straighter.curvature = [](double) { return 0.5; };
  EXPECT_EQ(fault_of(straighter), "none");
  straighter.limit_per_m = 0.4;
  EXPECT_THAT(fault_of(straighter), HasSubstr("above its own limit of 0.400000"));
  Faulty hole;
  hole.pose = [nan](double s_m) { return Pose2{s_m > 1.0 ? nan : s_m, 0.0, 0.0}; };
  EXPECT_THAT(fault_of(hole), HasSubstr("is not finite"));
  for (const double length_m : {0.0, -1.0, 1e-7, 2e5, nan}) {
    Faulty wrong;
    wrong.length = length_m;
    EXPECT_THAT(fault_of(wrong), HasSubstr("must have a length"));
  }
  Faulty wild;
  wild.limit_per_m = nan;
  EXPECT_THAT(fault_of(wild), HasSubstr("may turn at most"));
}

TEST(SectionShape, makes_no_section_where_it_is_refused) {
  auto late = std::make_shared<Faulty>();
  late->pose = [](double s_m) { return Pose2{s_m, 0.01, 0.0}; };
  const auto section = Section::make({}, late);
  ASSERT_FALSE(section);
  EXPECT_EQ(section.error().code, "section.invalid");
  EXPECT_FALSE(Section::make({1e300 * 1e300, 0.0, 0.0}, std::make_shared<Faulty>()));
  EXPECT_FALSE(Section::make({0.0, 0.0, 2e6}, std::make_shared<Faulty>()));
}

TEST(ShapedSection, agrees_with_the_built_in_section_of_the_same_curve) {
  EXPECT_TRUE(rc::check("an arc given as a shape", [] {
    const double curvature = 0.01 * *rc::gen::inRange(-200, 201);
    const double length_m = 0.01 * *rc::gen::inRange(1, 500);
    const Pose2 start{0.1 * *rc::gen::inRange(-50, 50), 0.1 * *rc::gen::inRange(-50, 50),
                      0.01 * *rc::gen::inRange(-314, 315)};
    const auto own = Section::make(start, length_m, curvature);
    const auto shaped = Section::make(start, std::make_shared<test::CountingArc>(length_m, curvature));
    RC_ASSERT(own.has_value() && shaped.has_value());
    RC_ASSERT(shaped->kind() == SectionKind::shaped && kind_name(*shaped) == "counting_arc");
    for (const double ratio : {-0.1, 0.0, 0.3, 1.0, 1.2}) {
      const double s_m = ratio * length_m;
      RC_ASSERT(distance(own->pose_at(s_m), shaped->pose_at(s_m)) < 1e-11);
      RC_ASSERT(std::fabs(wrap_angle(own->heading_at(s_m) - shaped->heading_at(s_m))) < 1e-11);
      RC_ASSERT(shaped->point_at(s_m) == position(shaped->pose_at(s_m)));
      RC_ASSERT(own->curvature_at(s_m) == shaped->curvature_at(s_m));
    }
    const Point2 p{start.x_m + 0.1 * *rc::gen::inRange(-30, 30), start.y_m + 0.1 * *rc::gen::inRange(-30, 30)};
    RC_ASSERT(std::fabs(own->nearest(p).distance_m - shaped->nearest(p).distance_m) < 1e-9);
    for (double i = 0.0; i <= 20.0; i += 1.0)
      RC_ASSERT(distance(shaped->box(), shaped->point_at(length_m * (i / 20.0))) == 0.0);
  }));
}

TEST(ShapedSection, responds_to_nextAIVposition_by_its_shape_in_both_directions) {
  const auto arc = std::make_shared<test::CountingArc>(2.0, 0.5);
  const auto section = Section::make({1.0, 2.0, 0.3}, arc);
  ASSERT_TRUE(section);
  const NextPosition direct = section->nextAIVposition(0.5, 0.75);
  EXPECT_EQ(direct.DT_m, 0.75);
  expect_near(direct.pose, section->pose_at(1.25), 1e-12);
  const NextPosition beyond = section->nextAIVposition(0.5, 5.0);
  EXPECT_EQ(beyond.DT_m, 1.5);
  expect_near(beyond.pose, section->end(), 1e-12);
  const NextPosition indirect = section->nextAIVposition(0.5, 0.75, true);
  EXPECT_EQ(indirect.DT_m, 0.75);
  expect_near(indirect.pose, section->pose_at(0.75), 1e-12);
  const NextPosition to_start = section->nextAIVposition(0.5, 5.0, true);
  EXPECT_EQ(to_start.DT_m, 1.5);
  expect_near(to_start.pose, section->start(), 1e-12);
  EXPECT_THAT(
      arc->requests,
      ::testing::ElementsAre(test::CountingArc::Request{0.5, 0.75, false}, test::CountingArc::Request{0.5, 5.0, false},
                             test::CountingArc::Request{0.5, 0.75, true}, test::CountingArc::Request{0.5, 5.0, true}));
}

TEST(PartOf, is_the_same_curve_between_its_ends) {
  const auto whole = Section::make({1.0, 2.0, 0.3}, test::sine_shape(0.3, 2.0, 1.5));
  const auto clothoid = Section::make({1.0, 2.0, 0.3}, 3.0, 0.2, 0.4);
  ASSERT_TRUE(whole && clothoid);
  for (const Section& section : {*whole, *clothoid}) {
    const Section part = part_of(section, 0.7, 2.1);
    EXPECT_NEAR(part.length_m(), 1.4, 1e-12);
    EXPECT_EQ(part.kind(), section.kind());
    for (const double s_m : {0.0, 0.4, 1.4}) {
      expect_near(part.pose_at(s_m), section.pose_at(0.7 + s_m), 1e-9);
      EXPECT_NEAR(part.curvature_at(s_m), section.curvature_at(0.7 + s_m), 1e-9);
    }
  }
}

TEST(SameShape, compares_kind_fields_and_length) {
  const auto a = test::sine_shape(0.3, 2.0, 1.0);
  EXPECT_TRUE(same_shape(a.get(), test::sine_shape(0.3, 2.0, 1.0).get()));
  EXPECT_FALSE(same_shape(a.get(), test::sine_shape(0.3, 2.0, 1.5).get()));
  EXPECT_FALSE(same_shape(a.get(), std::make_shared<test::CountingArc>(2.0, 0.1).get()));
  EXPECT_FALSE(same_shape(a.get(), nullptr));
  EXPECT_TRUE(same_shape(nullptr, nullptr));
  EXPECT_FALSE(same_shape(a.get(), part_of_shape(a, 0.1, 0.9).get()));
}

}  // namespace
}  // namespace cosiva::zone
