#include "cosiva/zone/opendrive/plan_record.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <initializer_list>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace cosiva::zone::opendrive {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::StartsWith;

/// A record and the diagnostics of making it.
struct Made {
  std::optional<PlanRecord> record;
  std::vector<Diagnostic> diagnostics;
};
Made made_of(double length_m, std::variant<Clothoid, Cubics> shape) {
  Report report;
  auto record = make_record({7.0, {1.0, 2.0, 0.5}, length_m, std::move(shape), "here"}, report);
  return {std::move(record), report.diagnostics()};
}
Cubics straight_cubic(double b, Cubics::Range range) { return {{0.0, 0.0, b}, {}, range}; }

TEST(MakeRecord, of_a_clothoid_is_a_section_from_curvature_to_curvature) {
  const Made made = made_of(10.0, Clothoid{0.1, 0.3});
  ASSERT_TRUE(made.record);
  EXPECT_EQ(made.record->from, 0.0);
  EXPECT_EQ(made.record->factor, 1.0);
  EXPECT_EQ(made.record->arc, 10.0);
  EXPECT_EQ(made.record->slack, 0.0);
  const auto& section = std::get<Section>(made.record->path);
  EXPECT_EQ(section.start(), (Pose2{1.0, 2.0, 0.5}));
  EXPECT_EQ(section.length_m(), 10.0);
  EXPECT_DOUBLE_EQ(section.curvature_at(0.0), 0.1);
  EXPECT_DOUBLE_EQ(section.curvature_at(10.0), 0.3);
  EXPECT_THAT(made.diagnostics, IsEmpty());
}

TEST(MakeRecord, that_cannot_be_followed_is_none_and_states_why) {
  const std::string lost = "cannot be followed, and its road is not taken: ";
  for (const auto& [made, why] :
       {std::pair{made_of(1e-7, Clothoid{}), "a section's length must be"},
        {made_of(10.0, straight_cubic(0.0, Cubics::Range::normalized)), "its polynomials do not move, or lead"},
        {made_of(10.0, straight_cubic(0.0, Cubics::Range::arc_length)), "its polynomials do not move, or lead"},
        {made_of(10.0, straight_cubic(1e6, Cubics::Range::normalized)), "its polynomials do not move, or lead"}}) {
    EXPECT_FALSE(made.record);
    ASSERT_EQ(made.diagnostics.size(), 1U);
    EXPECT_EQ(made.diagnostics[0].kind, Diagnostic::Kind::lost);
    EXPECT_EQ(made.diagnostics[0].location, "here");
    EXPECT_THAT(made.diagnostics[0].text, StartsWith(lost + why));
  }
}

TEST(MakeRecord, takes_the_other_range_of_p_where_only_that_gives_the_length) {
  const std::string other = "its length is that of the other pRange, which is taken: ";
  const Made normalized = made_of(50.0, straight_cubic(50.0, Cubics::Range::arc_length));
  ASSERT_TRUE(normalized.record);
  EXPECT_NEAR(normalized.record->arc, 50.0, 1e-9);
  ASSERT_EQ(normalized.diagnostics.size(), 1U);
  EXPECT_EQ(normalized.diagnostics[0].kind, Diagnostic::Kind::mended);
  EXPECT_EQ(normalized.diagnostics[0].location, "here");
  EXPECT_EQ(normalized.diagnostics[0].text, other + "normalized");
  const Made by_length = made_of(50.0, straight_cubic(1.0, Cubics::Range::normalized));
  ASSERT_TRUE(by_length.record);
  EXPECT_NEAR(by_length.record->arc, 50.0, 1e-9);
  ASSERT_EQ(by_length.diagnostics.size(), 1U);
  EXPECT_EQ(by_length.diagnostics[0].text, other + "arcLength");
}

TEST(MakeRecord, keeps_its_range_of_p_up_to_a_twentieth_off_unless_the_other_is_a_hundredth_off_at_most) {
  // u = b·p is b·length long by arc length and b long normalized.
  const auto arc = [](double length_m, double b) {
    const Made made = made_of(length_m, straight_cubic(b, Cubics::Range::arc_length));
    EXPECT_TRUE(made.record);
    return std::pair{made.record->arc, made.diagnostics.size()};
  };
  const auto expect_arc = [&](std::pair<double, std::size_t> found, double arc_m, std::size_t diagnostics) {
    EXPECT_NEAR(found.first, arc_m, 1e-9);
    EXPECT_EQ(found.second, diagnostics);
  };
  expect_arc(arc(1.04, 1.04), 1.04 * 1.04, 0);
  expect_arc(arc(1.06, 1.06), 1.06, 1);
  expect_arc(arc(1.06, 1.06 * 1.008), 1.06 * 1.008, 1);
  expect_arc(arc(1.06, 1.06 * 1.012), 1.06 * 1.06 * 1.012, 0);
}

PlanRecord straight_record(double arc_m) { return {0.0, 1.0, arc_m, *Section::make({}, arc_m)}; }

TEST(RawRecord, is_the_curve_by_the_road_s_s) {
  // Round 10 m to the left, twice as fast as s: 5 m after its begin it has passed 10 m, one radian.
  const PlanRecord arc{3.0, 2.0, 20.0, *Section::make({}, 20.0, 0.1)};
  const Jet jet = raw(arc, 8.0);
  EXPECT_NEAR(jet.p.x_m, 10.0 * std::sin(1.0), 1e-9);
  EXPECT_NEAR(jet.p.y_m, 10.0 * (1.0 - std::cos(1.0)), 1e-9);
  EXPECT_NEAR(jet.d.x_m, 2.0 * std::cos(1.0), 1e-9);
  EXPECT_NEAR(jet.d.y_m, 2.0 * std::sin(1.0), 1e-9);
  EXPECT_NEAR(jet.dd.x_m, -4.0 * 0.1 * std::sin(1.0), 1e-9);
  EXPECT_NEAR(jet.dd.y_m, 4.0 * 0.1 * std::cos(1.0), 1e-9);
  const PlanRecord cubic{3.0, 0.5, 20.0, *CubicPath::make({}, straight_cubic(20.0, Cubics::Range::normalized), 20.0)};
  const Jet along = raw(cubic, 7.0);
  EXPECT_NEAR(along.p.x_m, 2.0, 1e-9);
  EXPECT_NEAR(along.d.x_m, 0.5, 1e-9);
  EXPECT_NEAR(along.d.y_m, 0.0, 1e-9);
}

TEST(CanClose, a_gap_of_two_metres_or_half_the_shorter_record_and_a_corner_of_1_6_rad) {
  const auto closes = [](double before_m, double after_m, double gap_m, double kink_rad) {
    const Jet left{{1.0, 2.0}, {1.0, 0.0}, {}};
    const Jet right{{1.0, 2.0 + gap_m}, {std::cos(kink_rad), std::sin(kink_rad)}, {}};
    return can_close(straight_record(before_m), left, right, straight_record(after_m));
  };
  EXPECT_TRUE(closes(100.0, 100.0, 2.0, 0.0));
  EXPECT_FALSE(closes(100.0, 100.0, 2.001, 0.0));
  EXPECT_TRUE(closes(10.0, 3.0, 1.5, 0.0));
  EXPECT_FALSE(closes(10.0, 3.0, 1.501, 0.0));
  EXPECT_TRUE(closes(3.0, 10.0, 1.5, 0.0));
  EXPECT_FALSE(closes(3.0, 10.0, 1.501, 0.0));
  for (const double side : {1.0, -1.0}) {
    EXPECT_TRUE(closes(10.0, 10.0, 0.0, side * 1.599));
    EXPECT_FALSE(closes(10.0, 10.0, 0.0, side * 1.601));
  }
}

/// Straight records of these lengths that begin at these x, and what is left of them.
struct Crumbs {
  std::vector<Geometry> geometries{};
  std::vector<const Geometry*> plan{};
  std::vector<PlanRecord> records{};
  Report report{};

  Crumbs(std::initializer_list<std::pair<double, double>> x_and_length_m) {
    for (const auto& [x_m, length_m] : x_and_length_m)
      geometries.push_back({0.0, {x_m, 0.0, 0.0}, length_m, Clothoid{}, "g" + std::to_string(geometries.size())});
    for (const Geometry& geometry : geometries) {
      plan.push_back(&geometry);
      records.push_back(*make_record(geometry, report));
    }
    drop_crumbs(plan, records, report);
  }
  [[nodiscard]] std::vector<std::string> left() const {
    std::vector<std::string> names;
    for (const Geometry* geometry : plan) names.push_back(geometry->location);
    return names;
  }
  [[nodiscard]] std::vector<double> arcs_m() const {
    std::vector<double> all;
    for (const PlanRecord& record : records) all.push_back(record.arc);
    return all;
  }
  [[nodiscard]] std::vector<double> slacks_m() const {
    std::vector<double> all;
    for (const PlanRecord& record : records) all.push_back(record.slack);
    return all;
  }
  [[nodiscard]] std::vector<std::string> left_out() const {
    std::vector<std::string> names;
    for (const Diagnostic& diagnostic : report.diagnostics()) names.push_back(diagnostic.location);
    return names;
  }
};

TEST(DropCrumbs, leaves_out_a_short_record_that_misses_the_one_before_it) {
  const Crumbs crumbs{{0.0, 20.0}, {20.125, 0.0625}, {20.25, 10.0}};
  EXPECT_THAT(crumbs.left(), ElementsAre("g0", "g2"));
  EXPECT_THAT(crumbs.arcs_m(), ElementsAre(20.0, 10.0));
  EXPECT_THAT(crumbs.slacks_m(), ElementsAre(0.0625, 0.0)) << "its length is missing before the next record";
  ASSERT_THAT(crumbs.left_out(), ElementsAre("g1"));
  EXPECT_EQ(crumbs.report.diagnostics()[0].kind, Diagnostic::Kind::mended);
  EXPECT_EQ(crumbs.report.diagnostics()[0].text, "is 62.50 mm long and does not meet its neighbours; it is left out");
}

TEST(DropCrumbs, leaves_out_a_short_record_that_misses_the_one_behind_it) {
  const Crumbs crumbs{{0.0, 20.0}, {20.0, 0.125}, {25.0, 10.0}, {35.0, 10.0}};
  EXPECT_THAT(crumbs.left(), ElementsAre("g0", "g2", "g3"));
  EXPECT_THAT(crumbs.arcs_m(), ElementsAre(20.0, 10.0, 10.0));
  EXPECT_THAT(crumbs.slacks_m(), ElementsAre(0.125, 0.0, 0.0));
  EXPECT_THAT(crumbs.left_out(), ElementsAre("g1"));
}

TEST(DropCrumbs, adds_the_lengths_of_several) {
  const Crumbs crumbs{{0.0, 20.0}, {20.0, 0.125}, {40.0, 0.0625}, {25.0, 10.0}};
  EXPECT_THAT(crumbs.left(), ElementsAre("g0", "g3"));
  EXPECT_THAT(crumbs.slacks_m(), ElementsAre(0.1875, 0.0));
  EXPECT_THAT(crumbs.left_out(), ElementsAre("g2", "g1"));
}

TEST(DropCrumbs, leaves_the_first_record_where_the_road_begins) {
  const Crumbs crumbs{{0.0, 0.0625}, {5.0, 0.25}};
  EXPECT_THAT(crumbs.left(), ElementsAre("g0"));
  EXPECT_THAT(crumbs.slacks_m(), ElementsAre(0.25));
  EXPECT_THAT(crumbs.left_out(), ElementsAre("g1"));
}

TEST(DropCrumbs, leaves_records_that_meet_or_are_longer_than_30_cm) {
  EXPECT_THAT((Crumbs{{0.0, 20.0}, {20.0, 0.0625}, {20.0625, 10.0}}.left()), ElementsAre("g0", "g1", "g2"));
  EXPECT_THAT((Crumbs{{0.0, 20.0}, {25.0, 0.31}, {30.0, 10.0}}.left()), ElementsAre("g0", "g1", "g2"));
  EXPECT_THAT((Crumbs{{0.0, 20.0}, {25.0, 0.3}, {30.0, 10.0}}.left()), ElementsAre("g0", "g2"));
  const Crumbs one{{0.0, 0.0625}};
  EXPECT_THAT(one.left(), ElementsAre("g0"));
  EXPECT_THAT(one.left_out(), IsEmpty());
}

TEST(DropCrumbs, leaves_out_no_long_record_for_a_crumb_where_the_road_begins) {
  const Crumbs crumbs{{0.0, 0.0625}, {5.0, 20.0}, {25.0, 20.0}};
  EXPECT_THAT(crumbs.left(), ::testing::Contains("g1"));
  EXPECT_THAT(crumbs.left(), ::testing::Contains("g2"));
}

}  // namespace
}  // namespace cosiva::zone::opendrive
