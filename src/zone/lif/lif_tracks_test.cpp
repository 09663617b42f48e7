#include "cosiva/zone/lif/lif_tracks.h"

#include <gmock/gmock.h>

#include <cmath>
#include <string>
#include <vector>

namespace cosiva::zone::lif {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

/// A maker, and its diagnostics as "mended|location|text".
struct Made {
  LifDiagnostics diagnostics{};
  TrackMaker maker{FitTolerance{}, diagnostics};
  Track track{};

  Made(const std::optional<Nurbs>& trajectory, Point2 from, Point2 to) {
    Edge edge{"A-B", "edges[0]", 0, 1};
    edge.trajectory = trajectory;
    track = maker.make(edge, from, to);
  }
  [[nodiscard]] std::vector<std::string> texts() const {
    std::vector<std::string> all;
    for (const Diagnostic& diagnostic : diagnostics.take())
      all.push_back(std::string(to_string(diagnostic.kind)) + '|' + diagnostic.location + '|' + diagnostic.text);
    return all;
  }
  [[nodiscard]] double length_m() const {
    double sum = 0.0;
    for (const Section& section : track.sections) sum += section.length_m();
    return sum;
  }
  /// Whether it was fitted to a trajectory, rather than drawn straight.
  [[nodiscard]] bool fitted() {
    const std::size_t before = texts().size();
    maker.record_worst();
    return texts().size() > before;
  }
};

const double half_root = std::sqrt(0.5);

/// A quarter of a circle round (0, 1), from the origin along x to (1, 1).
Nurbs quarter_circle() { return {2, {0, 0, 0, 1, 1, 1}, {{0.0, 0.0}, {1.0, 0.0}, {1.0, 1.0}}, {1.0, half_root, 1.0}}; }
Nurbs polyline(std::vector<Point2> points) {
  const std::size_t count = points.size();
  return {1, clamped_uniform_knots(count, 1), std::move(points), std::vector<double>(count, 1.0)};
}
void expect_ends(const Track& track, const Pose2& start, const Pose2& end) {
  ASSERT_FALSE(track.sections.empty());
  for (const auto& [found, expected] :
       {std::pair{track.sections.front().start(), start}, std::pair{track.sections.back().end(), end}}) {
    EXPECT_LT(distance(found, expected), 1e-6);
    EXPECT_NEAR(wrap_angle(found.heading_rad - expected.heading_rad), 0.0, 1e-3);
  }
}

TEST(TrackMaker, draws_a_straight_line_from_node_to_node_without_a_trajectory) {
  const Made made{std::nullopt, {1.0, 2.0}, {4.0, 6.0}};
  ASSERT_THAT(made.track.sections, SizeIs(1));
  EXPECT_THAT(made.track.corner, ElementsAre(false));
  EXPECT_EQ(made.track.sections[0].kind(), SectionKind::straight);
  EXPECT_NEAR(made.length_m(), 5.0, 1e-12);
  expect_ends(made.track, {1.0, 2.0, std::atan2(4.0, 3.0)}, {4.0, 6.0, std::atan2(4.0, 3.0)});
  EXPECT_THAT(Made(std::nullopt, {1.0, 2.0}, {1.0, 2.00101}).track.sections, SizeIs(1));
  EXPECT_THAT(Made(std::nullopt, {1.0, 2.0}, {1.0, 2.00099}).track.sections, IsEmpty());
}

TEST(TrackMaker, follows_a_trajectory_that_meets_its_nodes) {
  Made made{quarter_circle(), {0.0, 0.0}, {1.0, 1.0}};
  ASSERT_THAT(made.track.sections, SizeIs(1));
  EXPECT_EQ(made.track.sections[0].kind(), SectionKind::arc);
  EXPECT_NEAR(made.length_m(), 0.5 * pi, 1e-5);
  expect_ends(made.track, {0.0, 0.0, 0.0}, {1.0, 1.0, 0.5 * pi});
  EXPECT_THAT(made.texts(), IsEmpty());
  EXPECT_TRUE(made.fitted());
  EXPECT_THAT(made.texts()[0], ::testing::StartsWith("notice|layouts|1 trajectories are followed within 0.0"));
}

TEST(TrackMaker, moves_turns_and_stretches_a_trajectory_to_its_nodes) {
  // Twice as large, a quarter to the left, and from (10, 5): the end is at (10, 5) + 2·(−1, 1).
  const Made made{quarter_circle(), {10.0, 5.0}, {8.0, 7.0}};
  EXPECT_NEAR(made.length_m(), pi, 1e-5);
  expect_ends(made.track, {10.0, 5.0, 0.5 * pi}, {8.0, 7.0, pi});
  EXPECT_THAT(made.texts(),
              ElementsAre("mended|edges[0].trajectory|the trajectory misses its nodes by 11.180 m; it is moved to "
                          "them, turned by 1.571 rad and stretched by 2.000"));
  // A quarter to the right, half as large, with its end where it was.
  const Made smaller{quarter_circle(), {0.5, 1.5}, {1.0, 1.0}};
  expect_ends(smaller.track, {0.5, 1.5, -0.5 * pi}, {1.0, 1.0, 0.0});
  EXPECT_THAT(smaller.texts(),
              ElementsAre("mended|edges[0].trajectory|the trajectory misses its nodes by 1.581 m; it is moved to "
                          "them, turned by -1.571 rad and stretched by 0.500"));
  // A millimetre is no reason for a diagnostic, at either end.
  EXPECT_THAT(Made(quarter_circle(), {0.0009, 0.0}, {1.0, 1.0}).texts(), IsEmpty());
  EXPECT_THAT(Made(quarter_circle(), {0.0011, 0.0}, {1.0, 1.0}).texts(), SizeIs(1));
  EXPECT_THAT(Made(quarter_circle(), {0.0, 0.0}, {1.0, 1.0009}).texts(), IsEmpty());
  EXPECT_THAT(Made(quarter_circle(), {0.0, 0.0}, {1.0, 1.0011}).texts(), SizeIs(1));
}

TEST(TrackMaker, stretches_a_trajectory_by_less_than_twenty_times) {
  for (const auto& [factor, followed] : {std::pair{19.9, true}, {20.1, false}, {0.0505, true}, {0.0494, false}}) {
    Made made{quarter_circle(), {0.0, 0.0}, {factor, factor}};
    EXPECT_NEAR(made.length_m(), factor * (followed ? 0.5 * pi : std::sqrt(2.0)), 1e-3 * factor) << factor;
    if (followed) continue;
    EXPECT_THAT(made.texts(), ElementsAre("mended|edges[0].trajectory|the trajectory would have to be stretched by " +
                                          std::string(factor > 1.0 ? "20.100" : "0.049") +
                                          " to meet its nodes; a straight line from node to node instead"));
  }
}

TEST(TrackMaker, takes_no_loop_between_two_nodes_and_no_line_from_a_node_to_itself) {
  Nurbs loop = quarter_circle();
  loop.points.back() = {0.0, 0.0};
  const std::string apart =
      "mended|edges[0].trajectory|the trajectory and its nodes do not belong together; a straight line from node to "
      "node instead";
  const Made open{loop, {0.0, 0.0}, {1.0, 0.0}};
  EXPECT_THAT(open.texts(), ElementsAre(apart));
  EXPECT_NEAR(open.length_m(), 1.0, 1e-9);
  const Made point{quarter_circle(), {1.0, 1.0}, {1.0, 1.0}};
  EXPECT_THAT(point.texts(), ElementsAre(apart));
  EXPECT_THAT(point.track.sections, IsEmpty());
}

TEST(TrackMaker, moves_a_closed_trajectory_to_its_node_as_it_is) {
  // A full circle of 2 m in four quarters.
  Nurbs circle{2, {0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4}, {}, {}};
  const Point2 corners[] = {{0, 0}, {2, 0}, {2, 2}, {2, 4}, {0, 4}, {-2, 4}, {-2, 2}, {-2, 0}, {0, 0}};
  for (std::size_t i = 0; i < 9; ++i) {
    circle.points.push_back(corners[i]);
    circle.weights.push_back(i % 2 == 0 ? 1.0 : half_root);
  }
  const Made made{circle, {3.0, 1.0}, {3.0, 1.0}};
  EXPECT_NEAR(made.length_m(), 4.0 * pi, 1e-3);
  expect_ends(made.track, {3.0, 1.0, 0.0}, {3.0, 1.0, 0.0});
  EXPECT_THAT(made.texts(),
              ElementsAre("mended|edges[0].trajectory|the trajectory misses its nodes by 3.162 m; it is moved to "
                          "them, turned by 0.000 rad and stretched by 1.000"));
}

TEST(TrackMaker, draws_a_trajectory_straight_whose_points_lie_on_the_line_in_order) {
  EXPECT_FALSE(Made(polyline({{0, 0}, {1, 0}, {3, 0}}), {0, 0}, {3, 0}).fitted());
  EXPECT_FALSE(Made(polyline({{0, 0}, {1, 5e-7}, {3, 0}}), {0, 0}, {3, 0}).fitted());
  EXPECT_TRUE(Made(polyline({{0, 0}, {1, 2e-6}, {3, 0}}), {0, 0}, {3, 0}).fitted());
  EXPECT_TRUE(Made(polyline({{0, 0}, {1, -2e-6}, {3, 0}}), {0, 0}, {3, 0}).fitted());
  // On a slope, away from the origin.
  EXPECT_FALSE(Made(polyline({{1, 2}, {4, 6}, {7, 10}}), {1, 2}, {7, 10}).fitted());
  EXPECT_FALSE(Made(polyline({{10, 0}, {9, 0}, {7, 0}}), {10, 0}, {7, 0}).fitted());
  // A line that turns back is no straight line: vehicles turn on the spot there.
  const Made back{polyline({{0, 0}, {2, 0}, {1, 0}, {3, 0}}), {0, 0}, {3, 0}};
  EXPECT_NEAR(back.length_m(), 5.0, 1e-6);
  EXPECT_THAT(back.track.corner, ElementsAre(true, true, false));
}

TEST(TrackMaker, turns_on_the_spot_at_corners_of_more_than_0_15_rad) {
  const Made corner{polyline({{0, 0}, {2, 0}, {2, 1}}), {0, 0}, {2, 1}};
  ASSERT_THAT(corner.track.sections, SizeIs(2));
  EXPECT_THAT(corner.track.corner, ElementsAre(true, false));
  EXPECT_NEAR(corner.track.sections[0].length_m(), 2.0, 1e-6);
  EXPECT_NEAR(corner.track.sections[1].length_m(), 1.0, 1e-6);
  EXPECT_NEAR(corner.track.sections[0].end().heading_rad, 0.0, 1e-6);
  EXPECT_NEAR(corner.track.sections[1].start().heading_rad, 0.5 * pi, 1e-6);
  EXPECT_THAT(corner.texts(),
              ElementsAre("mended|edges[0].trajectory|the trajectory has corners; vehicles turn on the spot there"));
  for (const double sign : {1.0, -1.0}) {
    const auto bent = [&](double turn_rad) {
      const Point2 end{2.0 + std::cos(turn_rad), sign * std::sin(turn_rad)};
      return Made{polyline({{0, 0}, {2, 0}, end}), {0, 0}, end};
    };
    const Made sharp = bent(0.16);
    EXPECT_THAT(sharp.track.corner, ElementsAre(true, false));
    const Made gentle = bent(0.14);
    for (const bool turns : gentle.track.corner) EXPECT_FALSE(turns);
    EXPECT_NEAR(gentle.length_m(), 3.0, 1e-3);
    EXPECT_THAT(gentle.texts(), IsEmpty());
  }
}

TEST(TrackMaker, draws_straight_what_cannot_be_driven) {
  // A cusp within a span: a cubic that comes back on itself.
  const Nurbs cusp{3, clamped_uniform_knots(4, 3), {{0, 0}, {1, 1}, {0, 1}, {1, 0}}, {1, 1, 1, 1}};
  const Made made{cusp, {0, 0}, {1, 0}};
  EXPECT_NEAR(made.length_m(), 1.0, 1e-9);
  EXPECT_THAT(made.track.corner, ElementsAre(false));
  ASSERT_THAT(made.texts(), SizeIs(1));
  EXPECT_THAT(made.texts()[0], ::testing::StartsWith("mended|edges[0].trajectory|the trajectory cannot be driven: "));
}

TEST(TrackMaker, makes_one_section_of_those_that_are_parts_of_one) {
  LifDiagnostics diagnostics;
  const TrackMaker maker{FitTolerance{}, diagnostics};
  const auto chain = [](const std::vector<std::pair<double, double>>& lengths_and_bends) {
    std::vector<Section> sections;
    Pose2 at{1.0, 2.0, 0.3};
    for (const auto& [length_m, bend] : lengths_and_bends) {
      sections.push_back(*Section::make(at, length_m, bend));
      at = sections.back().end();
    }
    return sections;
  };
  const auto arcs = chain({{0.5, 0.8}, {1.0, 0.8}, {0.25, 0.8}});
  const auto one = maker.as_one(arcs);
  ASSERT_TRUE(one);
  EXPECT_EQ(one->kind(), SectionKind::arc);
  EXPECT_NEAR(one->length_m(), 1.75, 1e-6);
  EXPECT_LT(distance(one->end(), arcs.back().end()), 1e-6);
  EXPECT_FALSE(maker.as_one(chain({{1.0, 0.0}, {1.0, 0.8}})));
  EXPECT_FALSE(maker.as_one(chain({{1.0, 0.8}, {1.0, -0.8}})));
}

TEST(TrackMaker, reports_the_worst_of_all_fits_once) {
  Made made{std::nullopt, {0, 0}, {1, 0}};
  EXPECT_FALSE(made.fitted());
  Edge edge{"A-B", "edges[0]", 0, 1};
  // A parabola is no clothoid: it is followed within a millimetre and a milliradian, but not exactly.
  edge.trajectory = Nurbs{2, clamped_uniform_knots(3, 2), {{0, 0}, {1, 0}, {2, 1}}, {1, 1, 1}};
  const Track bent = made.maker.make(edge, {0, 0}, {2, 1});
  edge.trajectory = quarter_circle();
  (void)made.maker.make(edge, {0, 0}, {1, 1});
  double worst_m = 0.0;
  for (const Section& section : bent.sections) {
    for (int i = 0; i <= 50; ++i) {
      // y = x²/4 from 0 to 2; to the first order across its slope.
      const Pose2 pose = section.pose_at(section.length_m() * i / 50.0);
      worst_m = std::max(
          worst_m, std::fabs(pose.y_m - 0.25 * pose.x_m * pose.x_m) / std::sqrt(1.0 + 0.25 * pose.x_m * pose.x_m));
    }
  }
  ASSERT_GT(worst_m, 1e-5);
  made.maker.record_worst();
  ASSERT_THAT(made.texts(), SizeIs(1));
  const std::string begin = "notice|layouts|2 trajectories are followed within ";
  ASSERT_TRUE(made.texts()[0].starts_with(begin)) << made.texts()[0];
  EXPECT_NEAR(std::stod(made.texts()[0].substr(begin.size())), 1e3 * worst_m, 0.2 * 1e3 * worst_m + 1e-3);
}

}  // namespace
}  // namespace cosiva::zone::lif
