#include "cosiva/zone/opendrive/reference_line.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/zone/opendrive/easing.h"

namespace cosiva::zone::opendrive {
namespace {

Road road_of(std::vector<Geometry> plan, double length) {
  Road road;
  road.id = "1";
  road.location = "road 1";
  road.length = length;
  road.plan = std::move(plan);
  return road;
}

ReferenceLine line_of(const Road& road, Report& report) {
  auto line = ReferenceLine::make(road, report);
  EXPECT_TRUE(line);
  return *line;
}

/// Midpoint rule with a hundred thousand steps over the heading's own integral: nothing of the code under test.
Pose2 integrated(Pose2 pose, double length, double k0, double k1) {
  constexpr int steps = 100000;
  const double h = length / steps;
  const double heading = pose.heading_rad;
  for (int i = 0; i < steps; ++i) {
    const double s = (i + 0.5) * h;
    const double theta = heading + s * (k0 + 0.5 * (k1 - k0) / length * s);
    pose.x_m += h * std::cos(theta);
    pose.y_m += h * std::sin(theta);
  }
  pose.heading_rad = heading + 0.5 * (k0 + k1) * length;
  return pose;
}

double heading_of(const Jet& jet) { return std::atan2(jet.d.y_m, jet.d.x_m); }

TEST(ReferenceLine, of_lines_arcs_and_spirals_ends_where_their_curvature_integrates_to) {
  const Pose2 start{12.0, -7.0, 0.8};
  for (const auto& [k0, k1] : {std::pair{0.0, 0.0}, {0.02, 0.02}, {-0.3, -0.3}, {0.025, 0.0125}, {-0.01, 0.04}}) {
    Report report;
    const Road road = road_of({{0.0, start, 60.0, Clothoid{k0, k1}, ""}}, 60.0);
    const ReferenceLine line = line_of(road, report);
    const Pose2 end = integrated(start, 60.0, k0, k1);
    EXPECT_NEAR(line.at(60.0).p.x_m, end.x_m, 1e-7);
    EXPECT_NEAR(line.at(60.0).p.y_m, end.y_m, 1e-7);
    EXPECT_NEAR(std::remainder(heading_of(line.at(60.0)) - end.heading_rad, 2.0 * pi), 0.0, 1e-9);
    EXPECT_TRUE(report.diagnostics().empty());
  }
}

/// Where a dense polygon through u(p), v(p) has the length `arc`.
Point2 walked(const std::function<Point2(double)>& at, double p_end, double arc) {
  constexpr int steps = 400000;
  double walked_m = 0.0;
  Point2 here = at(0.0);
  for (int i = 1; i <= steps; ++i) {
    const Point2 next = at(p_end * i / steps);
    const double step = distance(here, next);
    if (walked_m + step >= arc) {
      const double ratio = (arc - walked_m) / step;
      return {here.x_m + ratio * (next.x_m - here.x_m), here.y_m + ratio * (next.y_m - here.y_m)};
    }
    walked_m += step;
    here = next;
  }
  return here;
}
double length_of(const std::function<Point2(double)>& at, double p_end) {
  constexpr int steps = 400000;
  double sum = 0.0;
  for (int i = 1; i <= steps; ++i) sum += distance(at(p_end * (i - 1) / steps), at(p_end * i / steps));
  return sum;
}

TEST(ReferenceLine, of_cubics_runs_by_arc_length) {
  const Polynomial u{0.0, 0.0, 40.0, -3.2, 0.0};
  const Polynomial v{0.0, 0.0, 2.0, 6.4, -3.2};
  const auto at = [&](double p) { return Point2{u.at(p), v.at(p)}; };
  const double length = length_of(at, 1.0);
  Report report;
  const ReferenceLine line =
      line_of(road_of({{0.0, {}, length, Cubics{u, v, Cubics::Range::normalized}, ""}}, length), report);
  for (const double ratio : {0.1, 0.35, 0.5, 0.77, 0.999})
    EXPECT_LT(distance(line.at(ratio * length).p, walked(at, 1.0, ratio * length)), 1e-4) << ratio;
  // The curve leaves along (bU, bV), whatever hdg is.
  EXPECT_NEAR(heading_of(line.at(0.0)), std::atan2(2.0, 40.0), 1e-12);
  EXPECT_TRUE(report.diagnostics().empty());
}

TEST(ReferenceLine, of_an_arc_length_curve_is_the_same_as_of_its_normalized_twin) {
  // p from 0 to 30: v = 0.001 p². Nearly its own arc length, as exporters write it.
  const Polynomial u{0.0, 0.0, 1.0, 0.0, 0.0};
  const Polynomial v{0.0, 0.0, 0.0, 0.001, 0.0};
  const Polynomial u1{0.0, 0.0, 30.0, 0.0, 0.0};
  const Polynomial v1{0.0, 0.0, 0.0, 0.9, 0.0};
  Report report;
  const Road one = road_of({{0.0, {1.0, 2.0, 0.3}, 30.0, Cubics{u, v, Cubics::Range::arc_length}, ""}}, 30.0);
  const Road two = road_of({{0.0, {1.0, 2.0, 0.3}, 30.0, Cubics{u1, v1, Cubics::Range::normalized}, ""}}, 30.0);
  const ReferenceLine a = line_of(one, report);
  const ReferenceLine b = line_of(two, report);
  for (double s = 0.0; s <= 30.0; s += 1.7) EXPECT_LT(distance(a.at(s).p, b.at(s).p), 1e-9);
}

TEST(ReferenceLine, of_a_curve_whose_range_of_p_is_wrong_takes_the_other) {
  const Polynomial u{0.0, 0.0, 50.0, 0.0, 0.0};
  const Polynomial v{0.0, 0.0, 0.0, 1.0, 0.0};
  Report report;
  const ReferenceLine line =
      line_of(road_of({{0.0, {}, 50.01, Cubics{u, v, Cubics::Range::arc_length}, "here"}}, 50.01), report);
  EXPECT_NEAR(line.at(line.length()).p.x_m, 50.0, 1e-6);
  ASSERT_FALSE(report.diagnostics().empty());
  EXPECT_EQ(report.diagnostics()[0].kind, Diagnostic::Kind::mended);
  EXPECT_EQ(report.diagnostics()[0].location, "here");
}

TEST(ReferenceLine, of_poly3_ends_where_its_length_says) {
  const Polynomial v{0.0, 0.0, 0.1, 0.02, -3e-4};
  const auto at = [&](double p) { return Point2{p, v.at(p)}; };
  Report report;
  const ReferenceLine line = line_of(
      road_of({{0.0, {}, 35.0, Cubics{{0.0, 0.0, 1.0, 0.0, 0.0}, v, Cubics::Range::along_u}, ""}}, 35.0), report);
  for (const double s : {5.0, 17.0, 34.99}) EXPECT_LT(distance(line.at(s).p, walked(at, 40.0, s)), 1e-4) << s;
  EXPECT_NEAR(line.length(), 35.0, 1e-9);
  EXPECT_TRUE(report.diagnostics().empty());
}

TEST(ReferenceLine, has_derivatives_that_are_those_of_its_points) {
  const Polynomial u{0.0, 0.0, 40.0, -3.0, 2.0};
  const Polynomial v{0.0, 0.0, 2.0, 8.0, -4.0};
  const double length = length_of([&](double p) { return Point2{u.at(p), v.at(p)}; }, 1.0);
  Report report;
  // With a kink of 20 mrad at the joint, so that its smoothing is differentiated, too.
  const double bend = std::atan2(v.slope_at(1.0), u.slope_at(1.0)) + 0.02;
  const ReferenceLine line = line_of(road_of({{0.0, {}, length, Cubics{u, v, Cubics::Range::normalized}, ""},
                                              {length, {u.at(1.0), v.at(1.0), bend}, 30.0, Clothoid{0.0, 0.02}, ""}},
                                             length + 30.0),
                                     report);
  constexpr double h = 1e-4;
  for (double s = 0.3; s < length + 29.0; s += 0.37) {
    const Jet before = line.at(s - h);
    const Jet here = line.at(s);
    const Jet after = line.at(s + h);
    EXPECT_NEAR((after.p.x_m - before.p.x_m) / (2.0 * h), here.d.x_m, 1e-6) << s;
    EXPECT_NEAR((after.p.y_m - before.p.y_m) / (2.0 * h), here.d.y_m, 1e-6) << s;
    EXPECT_NEAR((after.d.x_m - before.d.x_m) / (2.0 * h), here.dd.x_m, 1e-4) << s;
    EXPECT_NEAR((after.d.y_m - before.d.y_m) / (2.0 * h), here.dd.y_m, 1e-4) << s;
  }
}

TEST(ReferenceLine, closes_small_gaps_and_kinks_and_reports_them) {
  Report report;
  const ReferenceLine line = line_of(road_of({{0.0, {0.0, 0.0, 0.0}, 20.0, Clothoid{}, "first"},
                                              {20.0, {20.01, 0.02, 0.05}, 20.0, Clothoid{}, "second"}},
                                             40.0),
                                     report);
  EXPECT_LT(distance(line.at(20.0 - 1e-9).p, line.at(20.0 + 1e-9).p), 1e-7);
  EXPECT_NEAR(heading_of(line.at(20.0 - 1e-9)), heading_of(line.at(20.0 + 1e-9)), 1e-7);
  EXPECT_NEAR(heading_of(line.at(20.0)), 0.025, 1e-7);
  EXPECT_NEAR(line.at(0.0).p.x_m, 0.0, 1e-12);
  EXPECT_NEAR(heading_of(line.at(40.0)), 0.05, 1e-9);
  ASSERT_EQ(report.diagnostics().size(), 1U);
  EXPECT_EQ(report.diagnostics()[0].location, "second");
}

TEST(ReferenceLine, is_missing_across_a_corner_or_a_gap_and_this_is_reported) {
  for (const Pose2& second : {Pose2{20.0, 0.0, 1.7}, Pose2{25.0, 0.0, 0.0}}) {
    Report report;
    const auto line = ReferenceLine::make(
        road_of({{0.0, {}, 20.0, Clothoid{}, "first"}, {20.0, second, 20.0, Clothoid{}, "second"}}, 40.0), report);
    EXPECT_FALSE(line);
    ASSERT_EQ(report.diagnostics().size(), 1U);
    EXPECT_EQ(report.diagnostics()[0].kind, Diagnostic::Kind::lost);
    EXPECT_EQ(report.diagnostics()[0].location, "second");
  }
}

TEST(ReferenceLine, rounds_a_right_angle_within_a_metre) {
  Report report;
  const ReferenceLine line = line_of(
      road_of({{0.0, {}, 20.0, Clothoid{}, "first"}, {20.0, {20.0, 0.0, 0.5 * pi}, 20.0, Clothoid{}, "second"}}, 40.0),
      report);
  double turned = 0.0;
  for (double s = 0.1; s <= 40.0; s += 0.1) {
    const Jet before = line.at(s - 0.1);
    const Jet here = line.at(s);
    const double turn = wrap_angle(det_atan2(here.d.y_m, here.d.x_m) - det_atan2(before.d.y_m, before.d.x_m));
    EXPECT_LT(std::fabs(turn), 0.12) << s;
    turned += turn;
    EXPECT_LT(std::min(std::fabs(here.p.y_m), std::fabs(here.p.x_m - 20.0)), 1.0) << s;
  }
  EXPECT_NEAR(turned, 0.5 * pi, 1e-6);
  ASSERT_FALSE(report.diagnostics().empty());
  EXPECT_EQ(report.diagnostics()[0].kind, Diagnostic::Kind::mended);
}

TEST(ReferenceLine, leads_through_short_records_that_miss_each_other) {
  // A circle of 6 m, cut into arcs of a metre whose headings are those of their chords: each misses the next by 8 cm.
  Report report;
  std::vector<Geometry> plan;
  const auto on_circle = [](int i) {
    const double angle = i / 6.0;
    return Point2{6.0 * det_sin(angle), 6.0 - 6.0 * det_cos(angle)};
  };
  for (int i = 0; i < 9; ++i) {
    const Point2 from = on_circle(i);
    const Point2 to = on_circle(i + 1);
    const double chord = det_atan2(to.y_m - from.y_m, to.x_m - from.x_m);
    plan.push_back({static_cast<double>(i), {from.x_m, from.y_m, chord}, 1.0, Clothoid{1.0 / 6.0, 1.0 / 6.0}, "arc"});
  }
  const ReferenceLine line = line_of(road_of(plan, 9.0), report);
  for (double s = 1.0; s < 8.0; s += 0.1) {
    const Jet jet = line.at(s);
    EXPECT_NEAR(distance(jet.p, {0.0, 6.0}), 6.0, 0.06) << s;
    const double v = norm(jet.d.x_m, jet.d.y_m);
    // The first and the last record keep the heading of their chord.
    const double bend = (jet.d.x_m * jet.dd.y_m - jet.d.y_m * jet.dd.x_m) / (v * v * v);
    EXPECT_NEAR(bend, 1.0 / 6.0, s < 2.0 || s > 7.0 ? 0.1 : 0.03) << s;
  }
  ASSERT_FALSE(report.diagnostics().empty());
  EXPECT_EQ(report.diagnostics()[0].kind, Diagnostic::Kind::mended);
}

TEST(ReferenceLine, removes_many_tiny_records_quickly) {
  Report report;
  std::vector<Geometry> plan{{0.0, {}, 20.0, Clothoid{}, "first"}};
  for (int i = 0; i < 20'000; ++i) plan.push_back({20.0, {1e3, 1e3, 0.1 * i}, 0.01, Clothoid{}, "crumb"});
  plan.push_back({20.0, {20.0, 0.0, 0.0}, 20.0, Clothoid{}, "last"});
  EXPECT_NEAR(line_of(road_of(plan, 40.0), report).length(), 40.0, 1e-9);
}

TEST(ReferenceLine, removes_a_tiny_record_that_meets_no_other) {
  Report report;
  const ReferenceLine line = line_of(road_of({{0.0, {}, 20.0, Clothoid{}, "first"},
                                              {20.0, {20.0, 0.05, 3.0}, 0.06, Clothoid{}, "crumb"},
                                              {20.06, {20.06, 0.0, 0.0}, 20.0, Clothoid{}, "last"}},
                                             40.06),
                                     report);
  EXPECT_NEAR(line.length(), 40.06, 1e-9);
  for (double s = 0.0; s < 40.0; s += 0.5) EXPECT_LT(distance(line.at(s).p, {s, 0.0}), 0.07) << s;
  ASSERT_FALSE(report.diagnostics().empty());
  EXPECT_EQ(report.diagnostics()[0].location, "crumb");
}

TEST(ReferenceLine, trusts_a_shape_whose_s_contradicts_it) {
  Report report;
  const ReferenceLine line = line_of(
      road_of({{0.0, {}, 20.0, Clothoid{}, "first"}, {12.0, {20.0, 0.0, 0.0}, 20.0, Clothoid{}, "second"}}, 40.0),
      report);
  EXPECT_NEAR(line.length(), 40.0, 1e-12);
  EXPECT_NEAR(line.at(30.0).p.x_m, 30.0, 1e-12);
  EXPECT_FALSE(report.diagnostics().empty());
}

TEST(ReferenceLine, removes_tiny_records) {
  Report report;
  const ReferenceLine line = line_of(road_of({{0.0, {}, 20.0, Clothoid{}, ""},
                                              {20.0, {20.0, 0.0, 0.0}, 1e-9, Clothoid{}, ""},
                                              {20.000000001, {20.000000001, 0.0, 0.0}, 10.0, Clothoid{}, ""}},
                                             30.000000001),
                                     report);
  EXPECT_NEAR(line.at(line.length()).p.x_m, 30.0, 1e-8);
  EXPECT_TRUE(report.diagnostics().empty());
}

/// "mended|location|text"
std::vector<std::string> texts_of(const Report& report) {
  std::vector<std::string> all;
  for (const Diagnostic& diagnostic : report.diagnostics())
    all.push_back(std::string(to_string(diagnostic.kind)) + '|' + diagnostic.location + '|' + diagnostic.text);
  return all;
}

/// A line that begins at s = 5 m with a straight record, and what is reported of it.
struct Published {
  double length_m;    ///< of the line
  double end_x_m;     ///< where it ends
  double centre_x_m;  ///< at the centre of its s
  std::vector<std::string> texts;
};
Published published(double shape_m, double file_m) {
  Report report;
  const ReferenceLine line = line_of(road_of({{5.0, {}, shape_m, Clothoid{}, "here"}}, 5.0 + file_m), report);
  return {line.length() - 5.0, line.at(line.length()).p.x_m, line.at(0.5 * (5.0 + line.length())).p.x_m,
          texts_of(report)};
}

// A thousandth and a ten-thousandth of 20 m is rounding. A hundredth is stretched, as is a centimetre.
TEST(ReferenceLine, is_stretched_to_a_length_in_the_file_that_is_a_hundredth_off) {
  const auto expect_length = [](double shape_m, double file_m, double length_m, const std::string& text) {
    const Published found = published(shape_m, file_m);
    EXPECT_NEAR(found.length_m, length_m, 1e-9) << file_m;
    EXPECT_NEAR(found.end_x_m, shape_m, 1e-9) << file_m;
    EXPECT_NEAR(found.centre_x_m, 0.5 * shape_m, 1e-9) << file_m;
    EXPECT_EQ(found.texts, text.empty() ? std::vector<std::string>{} : std::vector<std::string>{"mended|here|" + text});
  };
  const std::string stretched = "lanes are stretched along it accordingly";
  const std::string own = "its own length is taken";
  expect_length(20.0, 20.0, 20.0, "");
  expect_length(20.0, 20.0029, 20.0029, "");
  expect_length(20.0, 19.9971, 19.9971, "");
  expect_length(20.0, 20.0031, 20.0031, "the file has 20.00 m for it, but it is 20.00 m long; " + stretched);
  expect_length(20.0, 20.19, 20.19, "the file has 20.19 m for it, but it is 20.00 m long; " + stretched);
  expect_length(20.0, 19.81, 19.81, "the file has 19.81 m for it, but it is 20.00 m long; " + stretched);
  expect_length(20.0, 20.21, 20.0, "the file has 20.21 m for it, but it is 20.00 m long; " + own);
  expect_length(20.0, 19.79, 20.0, "the file has 19.79 m for it, but it is 20.00 m long; " + own);
  expect_length(0.5, 0.509, 0.509, "the file has 0.51 m for it, but it is 0.50 m long; " + stretched);
  expect_length(0.5, 0.512, 0.5, "the file has 0.51 m for it, but it is 0.50 m long; " + own);
}

TEST(ReferenceLine, of_polynomials_that_lead_on_too_far_ends_at_its_length) {
  const auto texts = [](double lead_m, std::optional<double> next_x_m, double& length_m) {
    Report report;
    std::vector<Geometry> plan{{0.0, {}, 20.0, Cubics{{0.0, 0.0, lead_m}, {}, Cubics::Range::normalized}, "cubic"}};
    if (next_x_m) plan.push_back({20.0, {*next_x_m, 0.0, 0.0}, 20.0, Clothoid{}, "next"});
    length_m = line_of(road_of(plan, next_x_m ? 40.0 : 20.0), report).length();
    return texts_of(report);
  };
  double length_m = 0.0;
  const std::vector<std::string> cut{
      "mended|cubic|its polynomials lead on for 22.00 m; they are taken up to its length, 20.00 m"};
  EXPECT_EQ(texts(22.0, std::nullopt, length_m), cut);
  EXPECT_NEAR(length_m, 20.0, 1e-9);
  EXPECT_EQ(texts(22.0, 20.0, length_m), cut) << "the next record begins there";
  EXPECT_NEAR(length_m, 40.0, 1e-9);
  // Up to a hundredth is stretched instead.
  EXPECT_EQ(texts(20.15, std::nullopt, length_m),
            (std::vector<std::string>{"mended|cubic|the file has 20.00 m for it, but it is 20.15 m long; lanes are "
                                      "stretched along it accordingly"}));
  EXPECT_NEAR(length_m, 20.0, 1e-9);
  // The next record begins where the polynomials end: these are right, and the length in the file is not.
  EXPECT_EQ(texts(22.0, 22.0, length_m),
            (std::vector<std::string>{
                "mended|cubic|the file has 20.00 m for it, but it is 22.00 m long; its own length is taken"}));
  EXPECT_NEAR(length_m, 42.0, 1e-9);
}

/// Two straight records of 20 m, or a first one of another length; the second begins this far off.
struct JoinedRecords {
  double gap_m{};
  double kink_rad{};
  double first_m{20.0};

  [[nodiscard]] std::optional<ReferenceLine> line(Report& report) const {
    return ReferenceLine::make(road_of({{0.0, {}, first_m, Clothoid{}, "first"},
                                        {first_m, {first_m, gap_m, kink_rad}, 20.0, Clothoid{}, "second"}},
                                       first_m + 20.0),
                               report);
  }
  [[nodiscard]] std::vector<std::string> texts() const {
    Report report;
    EXPECT_TRUE(line(report));
    return texts_of(report);
  }
  [[nodiscard]] std::vector<double> breaks() const {
    Report report;
    const auto made = line(report);
    EXPECT_TRUE(made);
    return made->breaks();
  }
  /// What is left of the gap, and of the kink.
  [[nodiscard]] Pose2 left() const {
    Report report;
    const auto made = line(report);
    EXPECT_TRUE(made);
    const Jet before = made->at(first_m - 1e-9);
    const Jet after = made->at(first_m);
    return {0.0, after.p.y_m - before.p.y_m, heading_of(after) - heading_of(before)};
  }
};

TEST(ReferenceLine, leaves_gaps_of_five_micrometres_and_kinks_of_half_a_microradian) {
  EXPECT_NEAR((JoinedRecords{.gap_m = 4e-6}.left().y_m), 4e-6, 1e-10);
  EXPECT_NEAR((JoinedRecords{.gap_m = 6e-6}.left().y_m), 0.0, 1e-10);
  EXPECT_NEAR((JoinedRecords{.gap_m = -6e-6}.left().y_m), 0.0, 1e-10);
  EXPECT_NEAR((JoinedRecords{.kink_rad = 4e-7}.left().heading_rad), 4e-7, 1e-11);
  EXPECT_NEAR((JoinedRecords{.kink_rad = 6e-7}.left().heading_rad), 0.0, 1e-11);
  EXPECT_NEAR((JoinedRecords{.kink_rad = -6e-7}.left().heading_rad), 0.0, 1e-11);
}

TEST(ReferenceLine, reports_joints_from_a_tenth_of_a_millimetre_and_of_a_milliradian_on) {
  using Texts = std::vector<std::string>;
  EXPECT_EQ((JoinedRecords{.gap_m = 0.9e-4}.texts()), Texts{});
  EXPECT_EQ((JoinedRecords{.gap_m = 1.1e-4}.texts().size()), 1U);
  EXPECT_EQ((JoinedRecords{.kink_rad = 0.9e-4}.texts()), Texts{});
  EXPECT_EQ((JoinedRecords{.kink_rad = 1.1e-4}.texts().size()), 1U);
  EXPECT_EQ((JoinedRecords{.kink_rad = -1.1e-4}.texts().size()), 1U);
  EXPECT_EQ((JoinedRecords{.gap_m = 0.03}.texts()),
            Texts{"mended|second|begins 30.00 mm and 0.000000 rad from where the record before it ends; smoothed over "
                  "5.00 m to each side"});
  // 160 m for each radian of half the kink.
  EXPECT_EQ((JoinedRecords{.kink_rad = 0.06}.texts()),
            Texts{"mended|second|begins 0.0000 mm and 0.060000 rad from where the record before it ends; smoothed over "
                  "4.80 m to each side"});
  Report report;
  EXPECT_FALSE((JoinedRecords{.kink_rad = 1.7}.line(report)));
  EXPECT_EQ(texts_of(report), Texts{"lost|second|begins 0.0000 mm and 1.700000 rad from where the record before it "
                                    "ends, which is too much to round: the road is not taken"});
}

TEST(ReferenceLine, has_breaks_at_its_joints_and_where_their_corrections_end) {
  using Breaks = std::vector<double>;
  EXPECT_EQ((JoinedRecords{}.breaks()), Breaks{20.0});
  EXPECT_EQ((JoinedRecords{.gap_m = 0.03}.breaks()), (Breaks{15.0, 20.0, 25.0}));
  EXPECT_EQ((JoinedRecords{.gap_m = 0.03, .first_m = 3.0}.breaks()), (Breaks{0.0, 3.0, 8.0}));
}

TEST(ReferenceLine, takes_records_in_the_order_of_their_s_and_none_of_less_than_five_millimetres) {
  Report report;
  const ReferenceLine line = line_of(
      road_of({{20.0, {20.0, 0.0, 0.0}, 20.0, Clothoid{}, "second"}, {0.0, {}, 20.0, Clothoid{}, "first"}}, 40.0),
      report);
  EXPECT_NEAR(line.at(30.0).p.x_m, 30.0, 1e-9);
  EXPECT_NEAR(line.at(10.0).p.x_m, 10.0, 1e-9);
  EXPECT_NEAR(line.at(-1.0).p.x_m, 0.0, 1e-9);
  EXPECT_NEAR(line.at(41.0).p.x_m, 40.0, 1e-9);
  EXPECT_EQ(texts_of(report), (std::vector<std::string>{"mended|road 1|its geometry records are not in the order of "
                                                        "their s; they are taken in that order"}));
  Report short_report;
  EXPECT_TRUE(ReferenceLine::make(road_of({{0.0, {}, 5e-3, Clothoid{}, ""}}, 5e-3), short_report));
  EXPECT_EQ(texts_of(short_report), std::vector<std::string>{});
  EXPECT_FALSE(ReferenceLine::make(road_of({{0.0, {}, 4.9e-3, Clothoid{}, ""}}, 4.9e-3), short_report));
  EXPECT_EQ(texts_of(short_report), std::vector<std::string>{"lost|road 1|has no plan view of any length"});
}

TEST(Easing, is_full_at_its_end_and_zero_with_slope_and_bend_at_the_other) {
  const Easing easing{0.3, -0.1, 4.0};
  EXPECT_DOUBLE_EQ(easing.at(0.0), 0.3);
  EXPECT_DOUBLE_EQ(easing.slope_at(0.0), -0.1);
  EXPECT_NEAR(easing.at(4.0 - 1e-6), 0.0, 1e-12);
  EXPECT_NEAR(easing.slope_at(4.0 - 1e-6), 0.0, 1e-9);
  EXPECT_NEAR(easing.bend_at(4.0 - 1e-6), 0.0, 1e-5);
  EXPECT_DOUBLE_EQ(easing.at(5.0), 0.0);
  for (double x = 0.1; x < 3.9; x += 0.3) {
    EXPECT_NEAR((easing.at(x + 1e-5) - easing.at(x - 1e-5)) / 2e-5, easing.slope_at(x), 1e-8);
    EXPECT_NEAR((easing.slope_at(x + 1e-5) - easing.slope_at(x - 1e-5)) / 2e-5, easing.bend_at(x), 1e-8);
  }
}

}  // namespace
}  // namespace cosiva::zone::opendrive
