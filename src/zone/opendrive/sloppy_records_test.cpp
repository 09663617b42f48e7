#include "cosiva/zone/opendrive/sloppy_records.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <initializer_list>
#include <string>
#include <variant>
#include <vector>

namespace cosiva::zone::opendrive {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

/// Straight records with these starts and lengths, after they are redrawn where they are sloppy.
struct Redrawn {
  struct Given {
    Pose2 start;
    double length_m;
  };
  std::vector<Geometry> geometries{};
  std::vector<PlanRecord> records{};
  Report report{};

  Redrawn(std::initializer_list<Given> given) {
    for (const Given& one : given)
      geometries.push_back({0.0, one.start, one.length_m, Clothoid{}, "g" + std::to_string(geometries.size())});
    std::vector<const Geometry*> plan;
    for (const Geometry& geometry : geometries) {
      plan.push_back(&geometry);
      records.push_back(*make_record(geometry, report));
    }
    redraw_sloppy_records(plan, records, report);
  }
  /// The names of the redrawn ones.
  [[nodiscard]] std::vector<std::string> names() const {
    std::vector<std::string> all;
    for (std::size_t i = 0; i < records.size(); ++i) {
      if (std::holds_alternative<CubicPath>(records[i].path)) all.push_back(geometries[i].location);
    }
    EXPECT_EQ(all.size(), report.diagnostics().size());
    return all;
  }
};

void expect_record(const PlanRecord& record, const Pose2& start, const Pose2& end) {
  const auto expect_jet_near = [](const Jet& jet, const Pose2& pose) {
    EXPECT_NEAR(jet.p.x_m, pose.x_m, 1e-9);
    EXPECT_NEAR(jet.p.y_m, pose.y_m, 1e-9);
    EXPECT_NEAR(jet.heading_rad(), pose.heading_rad, 1e-9);
  };
  expect_jet_near(raw(record, 0.0), start);
  expect_jet_near(raw(record, record.arc), end);
}

TEST(RedrawSloppyRecords, leaves_records_that_meet) {
  EXPECT_THAT((Redrawn{{{}, 1.0}, {{1.0, 0.0, 0.0}, 1.0}, {{2.0, 0.0, 0.0}, 1.0}}.names()), IsEmpty());
  EXPECT_THAT((Redrawn{{{}, 1.0}}.names()), IsEmpty());
}

TEST(RedrawSloppyRecords, leads_through_the_centre_between_the_ends_of_two_short_ones) {
  const Redrawn redrawn{{{}, 1.0}, {{1.0, 0.03, 0.0}, 1.0}};
  ASSERT_THAT(redrawn.names(), ElementsAre("g0", "g1"));
  // Along the line from the first begin to the last end, which rises by 15 mm each metre.
  const Pose2 joint{1.0, 0.015, std::atan(0.015)};
  expect_record(redrawn.records[0], {}, joint);
  expect_record(redrawn.records[1], joint, {2.0, 0.03, 0.0});
  for (const PlanRecord& record : redrawn.records) {
    EXPECT_GT(record.arc, std::hypot(1.0, 0.015));
    EXPECT_LT(record.arc, 1.001);
    EXPECT_NEAR(record.slack, record.arc - 1.0, 1e-12) << "by as much its s may be off";
  }
  for (const Diagnostic& diagnostic : redrawn.report.diagnostics()) {
    EXPECT_EQ(diagnostic.kind, Diagnostic::Kind::mended);
    EXPECT_EQ(diagnostic.text,
              "misses its neighbours by up to 30.00 mm and 0.000000 rad, and is short; a curve leads through the "
              "positions where they should meet");
  }
}

TEST(RedrawSloppyRecords, reports_the_worse_of_both_ends) {
  const Redrawn redrawn{{{}, 1.0}, {{1.0, 0.03, 0.0}, 1.0}, {{2.0, 0.08, 0.0}, 1.0}};
  ASSERT_THAT(redrawn.names(), ElementsAre("g0", "g1", "g2"));
  const auto all = redrawn.report.diagnostics();
  const char* gaps[] = {"by up to 30.00 mm", "by up to 50.00 mm", "by up to 50.00 mm"};
  for (std::size_t i = 0; i < 3; ++i) EXPECT_THAT(all[i].text, ::testing::HasSubstr(gaps[i])) << i;
}

TEST(RedrawSloppyRecords, leaves_a_long_neighbour_in_its_position) {
  const Redrawn behind{{{}, 20.0}, {{20.0, 0.03, 0.0}, 1.0}};
  ASSERT_THAT(behind.names(), ElementsAre("g1"));
  expect_record(behind.records[1], {20.0, 0.0, 0.0}, {21.0, 0.03, 0.0});
  const Redrawn before{{{}, 1.0}, {{1.0, 0.03, 0.0}, 20.0}};
  ASSERT_THAT(before.names(), ElementsAre("g0"));
  expect_record(before.records[0], {}, {1.0, 0.03, 0.0});
}

TEST(RedrawSloppyRecords, takes_a_gap_of_more_than_a_fiftieth_of_the_record) {
  const auto names = [](double gap_m, double length_m) {
    return Redrawn{{{}, length_m}, {{length_m, gap_m, 0.0}, length_m}}.names().size();
  };
  EXPECT_EQ(names(0.019, 1.0), 0U);
  EXPECT_EQ(names(0.021, 1.0), 2U);
  EXPECT_EQ(names(0.095, 5.0), 0U);
  EXPECT_EQ(names(0.105, 5.0), 2U);
  // Half of the record's length is too far to be closed.
  EXPECT_EQ(names(0.49, 1.0), 2U);
  EXPECT_EQ(names(0.51, 1.0), 0U);
}

TEST(RedrawSloppyRecords, takes_a_polygon_s_corner_of_more_than_a_fiftieth_of_a_radian_on_a_short_record) {
  const auto names = [](double kink_rad, double length_m) {
    return Redrawn{{{}, length_m}, {{length_m, 0.0, kink_rad}, length_m}}.names().size();
  };
  for (const double side : {1.0, -1.0}) {
    EXPECT_EQ(names(side * 0.019, 1.0), 0U);
    EXPECT_EQ(names(side * 0.021, 1.0), 2U);
    // Up to a radian of corner for each metre of length.
    EXPECT_EQ(names(side * 0.05, 19.0), 2U);
    EXPECT_EQ(names(side * 0.05, 21.0), 0U);
    EXPECT_EQ(names(side * 1.59, 0.5), 2U);
    EXPECT_EQ(names(side * 1.61, 0.5), 0U) << "no corner that can be closed";
  }
}

TEST(RedrawSloppyRecords, has_the_heading_of_the_circle_through_three_positions) {
  // A corner of 0.3 rad between 1 m and 3 m: a quarter of the turn is made in the first of the four metres.
  const Redrawn redrawn{{{}, 1.0}, {{1.0, 0.0, 0.3}, 3.0}};
  ASSERT_THAT(redrawn.names(), ElementsAre("g0", "g1"));
  const Pose2 end{1.0 + 3.0 * std::cos(0.3), 3.0 * std::sin(0.3), 0.3};
  expect_record(redrawn.records[0], {}, {1.0, 0.0, 0.075});
  expect_record(redrawn.records[1], {1.0, 0.0, 0.075}, end);
}

// Chords of a metre that turn by 0.3 rad: the central one becomes the arc over its chord, R = 1/(2·sin 0.15), which
// lies R·(1 − cos 0.15) = ½·tan 0.075 to the right of the chord's centre.
TEST(RedrawSloppyRecords, makes_arcs_of_a_polygon_s_sides) {
  const Pose2 second{1.0, 0.0, 0.3};
  const Pose2 third{1.0 + std::cos(0.3), std::sin(0.3), 0.6};
  const Redrawn redrawn{{{}, 1.0}, {second, 1.0}, {third, 1.0}};
  ASSERT_THAT(redrawn.names(), ElementsAre("g0", "g1", "g2"));
  const PlanRecord& arc = redrawn.records[1];
  expect_record(arc, {second.x_m, second.y_m, 0.15}, {third.x_m, third.y_m, 0.45});
  EXPECT_NEAR(arc.arc, 0.15 / std::sin(0.15), 1e-5);
  const Point2 centre = second * Point2{0.5, -0.5 * std::tan(0.075)};
  const Jet centre_jet = raw(arc, 0.5 * arc.arc);
  EXPECT_NEAR(centre_jet.p.x_m, centre.x_m, 1e-9);
  EXPECT_NEAR(centre_jet.p.y_m, centre.y_m, 1e-9);
  EXPECT_NEAR(centre_jet.heading_rad(), 0.3, 1e-9);
}

TEST(RedrawSloppyRecords, leaves_a_record_that_would_change_its_length_by_more_than_a_fifth) {
  // The joint is at the centre between the ends: each record becomes longer by half of the gap.
  const Redrawn near{{{}, 1.0}, {{1.35, 0.0, 0.0}, 1.0}};
  ASSERT_THAT(near.names(), ElementsAre("g0", "g1"));
  EXPECT_NEAR(near.records[0].arc, 1.175, 1e-9);
  EXPECT_NEAR(near.records[0].slack, 0.175, 1e-9);
  EXPECT_NEAR(near.records[1].arc, 1.175, 1e-9);
  expect_record(near.records[1], {1.175, 0.0, 0.0}, {2.35, 0.0, 0.0});
  const Redrawn far{{{}, 1.0}, {{1.45, 0.0, 0.0}, 1.0}};
  EXPECT_THAT(far.names(), IsEmpty());
  EXPECT_EQ(far.records[0].arc, 1.0);
  EXPECT_EQ(far.records[0].slack, 0.0);
}

}  // namespace
}  // namespace cosiva::zone::opendrive
