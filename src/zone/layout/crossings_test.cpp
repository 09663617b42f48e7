#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/base/random.h"
#include "cosiva/zone/layout/crossings.h"
#include "cosiva/zone/layout/traffic_zone.h"
#include "cosiva/zone/testing/test_zones.h"

namespace cosiva::zone {
namespace {

using ::testing::IsEmpty;
using testing::part;
using testing::section;
using ::testing::SizeIs;

constexpr VehicleShape vehicle{0.20, 0.12};
constexpr double clearance_m = 0.04;
/// A body's edge this near to a centre line may touch a vehicle on it.
constexpr double near_m = 0.5 * 0.12 + clearance_m;

/// The distance between the outlines of two bodies; 0 where they overlap. By corners against edges, in both directions.
double gap_between_bodies(const Pose2& X_MA, const Pose2& X_MB) {
  const auto outside = [](const Pose2& X_MB_, const Pose2& X_MA_) {
    double least_m = 1e9;
    for (double i = -1.0; i <= 1.0; i += 0.05) {
      for (const Point2 edge : {Point2{i * 0.10, 0.06}, {i * 0.10, -0.06}, {0.10, i * 0.06}, {-0.10, i * 0.06}}) {
        const Point2 p = inverse(X_MB_) * (X_MA_ * edge);
        least_m =
            std::min(least_m, norm(std::max(std::fabs(p.x_m) - 0.10, 0.0), std::max(std::fabs(p.y_m) - 0.06, 0.0)));
      }
    }
    return least_m;
  };
  return std::min(outside(X_MA, X_MB), outside(X_MB, X_MA));
}

bool in_span(const Crossing& crossing, const TrackPosition& position) {
  return std::any_of(crossing.spans.begin(), crossing.spans.end(), [&](const CrossingSpan& span) {
    return span.section == position.section && span.from_m <= position.s_m && position.s_m <= span.to_m;
  });
}

/// Wherever two vehicles would touch that do not follow each other, one crossing has a span over both.
void expect_every_touch_is_in_a_crossing(const Circuit& circuit, const std::vector<Crossing>& crossings) {
  std::vector<std::pair<TrackPosition, Pose2>> positions;
  for (SectionId id = 0; id < circuit.size(); ++id) {
    for (double s = 0.0; s <= circuit.section(id).length_m(); s += 0.03)
      positions.emplace_back(TrackPosition{id, s}, circuit.pose_at({id, s}));
  }
  for (const auto& [a, X_MA] : positions) {
    for (const auto& [b, X_MB] : positions) {
      if (distance(X_MA, X_MB) > 0.25 || gap_between_bodies(X_MA, X_MB) > 0.0) continue;
      bool follows = false;
      for (const SectionId after : circuit.next(a.section))
        follows = follows || (after == b.section && circuit.section(a.section).length_m() - a.s_m + b.s_m < 0.4);
      for (const SectionId after : circuit.next(b.section))
        follows = follows || (after == a.section && circuit.section(b.section).length_m() - b.s_m + a.s_m < 0.4);
      if (follows || (a.section == b.section && std::fabs(a.s_m - b.s_m) < 0.4)) continue;
      EXPECT_TRUE(std::any_of(crossings.begin(), crossings.end(),
                              [&, a = a, b = b](const Crossing& c) { return in_span(c, a) && in_span(c, b); }))
          << circuit.part(a.section).name << "@" << a.s_m << " touches " << circuit.part(b.section).name << "@"
          << b.s_m;
    }
  }
}

TEST(Crossings, of_two_straights_at_right_angles_reach_a_body_and_a_section_around) {
  const Circuit circuit = testing::circuit(
      {part("east", section({-1.0, 0.0, 0.0}, 2.0)), part("north", section({0.0, -1.0, pi / 2.0}, 2.0))});
  const auto crossings = find_crossings(circuit, vehicle, clearance_m);
  ASSERT_THAT(crossings, SizeIs(1));
  EXPECT_EQ(crossings[0].name, "X1");
  EXPECT_NEAR(crossings[0].centre.x_m, 0.0, 1e-3);
  EXPECT_NEAR(crossings[0].centre.y_m, 0.0, 1e-3);
  ASSERT_THAT(crossings[0].spans, SizeIs(2));
  for (const CrossingSpan& span : crossings[0].spans) {
    // Half a body's length and the section's half width with its clearance, on either side of the centre.
    EXPECT_NEAR(span.from_m, 1.0 - (0.10 + near_m), 2e-5);
    EXPECT_NEAR(span.to_m, 1.0 + (0.10 + near_m), 2e-5);
  }
  expect_every_touch_is_in_a_crossing(circuit, crossings);
}

TEST(Crossings, at_a_slant_are_longer) {
  const Circuit circuit = testing::circuit(
      {part("a", section({-1.0, 0.0, 0.0}, 2.0)), part("b", section({-std::cos(0.5), -std::sin(0.5), 0.5}, 2.0))});
  const auto crossings = find_crossings(circuit, vehicle, clearance_m);
  ASSERT_THAT(crossings, SizeIs(1));
  // The front corner (0.10, ±0.06) of a body at −x is near the slanted line when x·sin φ = near + reach across it.
  const double reach_m = 0.10 * std::sin(0.5) + 0.06 * std::cos(0.5);
  EXPECT_NEAR(crossings[0].spans[0].from_m, 1.0 - (near_m + reach_m) / std::sin(0.5), 1e-4);
  expect_every_touch_is_in_a_crossing(circuit, crossings);
}

TEST(Crossings, are_none_where_sections_keep_their_distance) {
  const double apart_m = 0.12 + clearance_m;  // body edge to centre line: near, and slightly more
  const auto lanes = [&](double y_m) {
    return testing::circuit({part("a", section({0.0, 0.0, 0.0}, 1.0)), part("b", section({1.0, y_m, pi}, 1.0))});
  };
  EXPECT_THAT(find_crossings(lanes(apart_m + 1e-6), vehicle, clearance_m), IsEmpty());
  EXPECT_THAT(find_crossings(lanes(apart_m - 1e-3), vehicle, clearance_m), SizeIs(1));
}

TEST(Crossings, are_none_on_a_loop_that_does_not_meet_itself) {
  EXPECT_THAT(find_crossings(testing::track(), vehicle, clearance_m), IsEmpty());
}

TEST(Crossings, of_a_wider_vehicle_are_more) {
  // The straights of this track are 0.5 m apart: nothing for 0.12 m, too near for 0.30 m.
  const Circuit narrow = testing::track(2.0, 0.25);
  EXPECT_THAT(find_crossings(narrow, vehicle, clearance_m), IsEmpty());
  EXPECT_FALSE(find_crossings(narrow, {0.40, 0.50}, clearance_m).empty());
}

TEST(Crossings, at_a_fork_keep_the_branches_apart_until_they_part) {
  const Section stem = section({0.0, 0.0, 0.0}, 1.0);
  const Circuit fork = testing::circuit({part("stem", stem, {1, 2}), part("left", section(stem.end(), 2.0, 1.0)),
                                         part("right", section(stem.end(), 2.0, -1.0))});
  const auto crossings = find_crossings(fork, vehicle, clearance_m);
  ASSERT_THAT(crossings, SizeIs(1));
  ASSERT_THAT(crossings[0].spans, SizeIs(2));
  EXPECT_EQ(crossings[0].spans[0].section, 1U);
  EXPECT_EQ(crossings[0].spans[0].from_m, 0.0);
  EXPECT_EQ(crossings[0].spans[1].section, 2U);
  EXPECT_EQ(crossings[0].spans[1].from_m, 0.0);
  expect_every_touch_is_in_a_crossing(fork, crossings);
}

TEST(Crossings, at_a_merge_begin_where_the_sections_come_together) {
  const Section trunk = section({0.0, 0.0, 0.0}, 1.0);
  // Both branches end at the origin heading east, one from above, one from below.
  const Section above = section({-std::sin(1.5), 1.0 - std::cos(1.5), -1.5}, 1.5, 1.0);
  const Section below = section({-std::sin(1.5), std::cos(1.5) - 1.0, 1.5}, 1.5, -1.0);
  const Circuit merge = testing::circuit({part("above", above, {2}), part("below", below, {2}), part("trunk", trunk)});
  const auto crossings = find_crossings(merge, vehicle, clearance_m);
  ASSERT_THAT(crossings, SizeIs(1));
  ASSERT_THAT(crossings[0].spans, SizeIs(2));
  EXPECT_EQ(crossings[0].spans[0].to_m, 1.5);
  EXPECT_EQ(crossings[0].spans[1].to_m, 1.5);
  EXPECT_GT(crossings[0].spans[0].from_m, 0.5);
  expect_every_touch_is_in_a_crossing(merge, crossings);
}

TEST(Crossings, of_a_section_with_itself_are_found) {
  // Once and a tenth round a circle: the overlap is a stretch with two vehicles a whole lap apart.
  const Circuit spiral = testing::circuit({part("spiral", section({0.0, 0.0, 0.0}, 1.1 * 2.0 * pi * 0.5, 2.0))});
  const auto crossings = find_crossings(spiral, vehicle, clearance_m);
  ASSERT_THAT(crossings, SizeIs(1));
  expect_every_touch_is_in_a_crossing(spiral, crossings);
}

TEST(Crossings, of_three_sections_at_one_position_are_one) {
  std::vector<Circuit::Part> parts;
  for (int i = 0; i < 3; ++i) {
    const double angle = i * pi / 3.0;
    parts.push_back(part("way" + std::to_string(i), section({-std::cos(angle), -std::sin(angle), angle}, 2.0)));
  }
  const Circuit star = testing::circuit(std::move(parts));
  const auto crossings = find_crossings(star, vehicle, clearance_m);
  ASSERT_THAT(crossings, SizeIs(1));
  EXPECT_THAT(crossings[0].spans, SizeIs(3));
  expect_every_touch_is_in_a_crossing(star, crossings);
}

// Sections at 60° and 120°: the front corner (0.10, 0.06) of a body at −x is near the others' lines when
// x·sin 60° = near + 0.10·sin 60° + 0.06·cos 60°.
TEST(Crossings, of_three_sections_reach_as_far_on_each_of_them) {
  std::vector<Circuit::Part> parts;
  for (int i = 0; i < 3; ++i) {
    const double angle = i * pi / 3.0;
    parts.push_back(part("s" + std::to_string(i), section({3.0 - std::cos(angle), 2.0 - std::sin(angle), angle}, 2.0)));
  }
  const auto crossings = find_crossings(testing::circuit(std::move(parts)), vehicle, clearance_m);
  ASSERT_THAT(crossings, SizeIs(1));
  EXPECT_EQ(crossings[0].name, "X1");
  EXPECT_NEAR(crossings[0].centre.x_m, 3.0, 0.005) << "the mean of all six contacts";
  EXPECT_NEAR(crossings[0].centre.y_m, 2.0, 0.005);
  ASSERT_THAT(crossings[0].spans, SizeIs(3));
  const double sine = std::sin(pi / 3.0);
  const double reach_m = (near_m + 0.10 * sine + 0.06 * 0.5) / sine;
  for (SectionId id = 0; id < 3; ++id) {
    EXPECT_EQ(crossings[0].spans[id].section, id);
    EXPECT_NEAR(crossings[0].spans[id].from_m, 1.0 - reach_m, 1e-4) << id;
    EXPECT_NEAR(crossings[0].spans[id].to_m, 1.0 + reach_m, 1e-4) << id;
  }
}

TEST(Crossings, where_the_crossed_section_has_a_joint_are_still_one) {
  for (const double joint_x : {-0.15, -0.05, 0.0, 0.08, 0.15}) {
    const Section west = section({-1.0, 0.0, 0.0}, 1.0 + joint_x);
    const Circuit circuit = testing::circuit({part("west", west, {1}), part("east", section(west.end(), 1.0 - joint_x)),
                                              part("north", section({0.0, -1.0, pi / 2.0}, 2.0))});
    const auto crossings = find_crossings(circuit, vehicle, clearance_m);
    EXPECT_THAT(crossings, SizeIs(1)) << joint_x;
    expect_every_touch_is_in_a_crossing(circuit, crossings);
  }
}

TEST(Crossings, at_a_dead_end_cover_the_vehicle_that_is_stopped_there) {
  const Circuit circuit = testing::circuit(
      {part("stub", section({-1.0, 0.0, 0.0}, 0.78)), part("north", section({0.0, -1.0, pi / 2.0}, 2.0))});
  const auto crossings = find_crossings(circuit, vehicle, clearance_m);
  // At its end the vehicle's nose is 0.12 m before the section; a passing body's edge comes to 0.06 m. They do not
  // touch.
  expect_every_touch_is_in_a_crossing(circuit, crossings);
  const Circuit longer = testing::circuit(
      {part("stub", section({-1.0, 0.0, 0.0}, 0.86)), part("north", section({0.0, -1.0, pi / 2.0}, 2.0))});
  const auto touching = find_crossings(longer, vehicle, clearance_m);
  ASSERT_THAT(touching, SizeIs(1));
  EXPECT_THAT(touching[0].spans, SizeIs(2));
  expect_every_touch_is_in_a_crossing(longer, touching);
}

// Against a definition that compares every body with every position
// ----------------------------------------------------------------------------------------------------

/// A centre line every 4 mm, with the overhang of half a vehicle at its open ends.
std::vector<std::pair<double, Point2>> samples_of(const Section& line) {
  std::vector<std::pair<double, Point2>> samples;
  constexpr double step_m = 0.004;
  const double half_m = 0.5 * vehicle.length_m;
  for (double x = 0.0; x <= half_m; x += step_m) {
    samples.emplace_back(0.0, line.start() * Point2{-x, 0.0});
    samples.emplace_back(line.length_m(), line.end() * Point2{x, 0.0});
  }
  for (double s = 0.0; s < line.length_m(); s += step_m) samples.emplace_back(s, position(line.pose_at(s)));
  return samples;
}

/// Where bodies on `on` come too near to the other line, and which part of that line they touch.
struct Touched {
  std::vector<double> on_m;
  std::vector<double> other_m;
};
Touched touched(const Section& on, const Section& other, double slack_m) {
  Touched found;
  const auto samples = samples_of(other);
  for (double s = 0.0; s <= on.length_m(); s += 0.004) {
    const Pose2 X_BM = inverse(on.pose_at(s));
    bool touches = false;
    for (const auto& [other_s, p] : samples) {
      const Point2 p_B = X_BM * p;
      const double beyond_m = norm(std::max(std::fabs(p_B.x_m) - 0.5 * vehicle.length_m, 0.0),
                                   std::max(std::fabs(p_B.y_m) - 0.5 * vehicle.width_m, 0.0));
      if (beyond_m > near_m + slack_m) continue;
      touches = true;
      found.other_m.push_back(other_s);
    }
    if (touches) found.on_m.push_back(s);
  }
  return found;
}

bool holds_any(const std::vector<double>& positions_m, double s_m, double within_m) {
  return std::any_of(positions_m.begin(), positions_m.end(),
                     [&](double at_m) { return std::fabs(at_m - s_m) <= within_m; });
}

TEST(Crossings, hold_exactly_the_positions_where_a_body_comes_too_near) {
  EXPECT_TRUE(rc::check([] {
    Random random{*rc::gen::arbitrary<std::uint64_t>(), "crossings_test"};
    if (!random.chance(0.25)) return;  // a case takes some ten milliseconds
    const auto any = [&] {
      return section({random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5), random.uniform(-3.1, 3.1)},
                     random.uniform(0.1, 1.2), random.chance(0.5) ? 0.0 : random.uniform(-2.0, 2.0));
    };
    const Section lines[] = {any(), any()};
    const Circuit circuit = testing::circuit({part("a", lines[0]), part("b", lines[1])});
    const auto crossings = find_crossings(circuit, vehicle, clearance_m);
    const Touched surely[] = {touched(lines[0], lines[1], -1e-4), touched(lines[1], lines[0], -1e-4)};
    const Touched perhaps[] = {touched(lines[0], lines[1], 0.006), touched(lines[1], lines[0], 0.006)};
    for (const SectionId id : {SectionId{0}, SectionId{1}}) {
      const auto held = [&](double s_m) {
        return std::any_of(crossings.begin(), crossings.end(), [&](const Crossing& c) {
          return in_span(c, {id, s_m});
        });
      };
      for (const double s_m : surely[id].on_m) RC_ASSERT(held(s_m));
      for (double s_m = 0.0; s_m <= lines[id].length_m(); s_m += 0.01) {
        // Where its own bodies touch, or around what bodies on the other section touch, half a vehicle to either side.
        if (held(s_m)) {
          RC_ASSERT(holds_any(perhaps[id].on_m, s_m, 0.006) ||
                    holds_any(perhaps[1 - id].other_m, s_m, 0.5 * vehicle.length_m + 0.006));
        }
      }
    }
  }));
}

TEST(Crossings, are_numbered_in_the_order_of_sections_and_lie_between_the_centre_lines) {
  // "east" is crossed at 3 m, then at 1 m, by the second and third section; those run 20 m apart from all others.
  const Circuit circuit =
      testing::circuit({part("east", section({0.0, 0.0, 0.0}, 4.0)), part("late", section({3.0, -1.0, pi / 2.0}, 2.0)),
                        part("early", section({1.0, -1.0, pi / 2.0}, 2.0))});
  const auto crossings = find_crossings(circuit, vehicle, clearance_m);
  ASSERT_THAT(crossings, SizeIs(2));
  EXPECT_EQ(crossings[0].name, "X1");
  EXPECT_NEAR(crossings[0].centre.x_m, 1.0, 1e-3);
  EXPECT_NEAR(crossings[0].centre.y_m, 0.0, 1e-3);
  EXPECT_EQ(crossings[1].name, "X2");
  EXPECT_NEAR(crossings[1].centre.x_m, 3.0, 1e-3);
  // Each with the section that crosses, in order.
  EXPECT_EQ(crossings[0].spans[0].section, 0U);
  EXPECT_EQ(crossings[0].spans[1].section, 2U);
  EXPECT_EQ(crossings[1].spans[1].section, 1U);
}

TEST(Crossings, at_positions_nearer_than_their_width_are_one) {
  // Two sections cross "east"; their crossings have centres d apart. One position is 2 · 0.10 m wide.
  const auto number = [](double apart_m) {
    const Circuit circuit =
        testing::circuit({part("east", section({0.0, 0.0, 0.0}, 4.0)), part("one", section({1.0, -1.0, pi / 2.0}, 2.0)),
                          part("two", section({1.0 + apart_m, 1.0, -pi / 2.0}, 2.0))});
    return find_crossings(circuit, vehicle, clearance_m).size();
  };
  EXPECT_EQ(number(0.195), 1U);
  EXPECT_EQ(number(0.205), 2U);
}

TEST(Crossings, of_a_section_that_ends_close_to_another_hold_half_a_vehicle_around_what_is_touched) {
  // "stub" points at "north" and ends 0.23 m before it: a body there reaches 0.10 m ahead and is 0.13 m away, which is
  // free. A body on "north" is 0.06 m wide and 0.04 m of air: 0.17 m from the end of the stub, whose overhang of 0.10 m
  // it touches.
  const Circuit circuit = testing::circuit(
      {part("stub", section({-1.0, 0.0, 0.0}, 0.77)), part("north", section({0.0, -1.0, pi / 2.0}, 2.0))});
  const auto crossings = find_crossings(circuit, vehicle, clearance_m);
  ASSERT_THAT(crossings, SizeIs(1));
  ASSERT_THAT(crossings[0].spans, SizeIs(2));
  EXPECT_EQ(crossings[0].spans[0].section, 0U);
  EXPECT_NEAR(crossings[0].spans[0].from_m, 0.77 - 0.10, 1e-9) << "half a vehicle before the end";
  EXPECT_EQ(crossings[0].spans[0].to_m, 0.77);
  // A body on "north" touches the overhang's tip at (−0.13, 0): from 0.10 + √(0.10² − 0.07²) m before to after it.
  const double reach_m = 0.10 + std::sqrt(0.10 * 0.10 - 0.07 * 0.07);
  EXPECT_NEAR(crossings[0].spans[1].from_m, 1.0 - reach_m, 2e-5);
  EXPECT_NEAR(crossings[0].spans[1].to_m, 1.0 + reach_m, 2e-5);
}

TEST(Crossings, of_a_zone_of_large_vehicles_are_as_exact_as_of_small_ones) {
  const VehicleShape lorry{12.0, 2.5};
  const Circuit circuit = testing::circuit(
      {part("east", section({-50.0, 0.0, 0.0}, 100.0)), part("north", section({0.0, -50.0, pi / 2.0}, 100.0))});
  const auto crossings = find_crossings(circuit, lorry, 0.5);
  ASSERT_THAT(crossings, SizeIs(1));
  for (const CrossingSpan& span : crossings[0].spans) {
    EXPECT_NEAR(span.from_m, 50.0 - (6.0 + 1.25 + 0.5), 2e-3);
    EXPECT_NEAR(span.to_m, 50.0 + (6.0 + 1.25 + 0.5), 2e-3);
  }
}

// Nets of nodes where vehicles turn on the spot
// ----------------------------------------------------------------------------------------------------

/// Every node leads on to every section that begins there, also back.
Circuit net(const std::vector<Point2>& nodes, const std::vector<std::pair<std::size_t, std::size_t>>& edges) {
  std::vector<Circuit::Part> parts;
  for (const auto& [from, to] : edges) {
    const Point2 along{nodes[to].x_m - nodes[from].x_m, nodes[to].y_m - nodes[from].y_m};
    const Pose2 start{nodes[from].x_m, nodes[from].y_m, det_atan2(along.y_m, along.x_m)};
    auto one = part(std::to_string(from) + "-" + std::to_string(to) + "#" + std::to_string(parts.size()),
                    section(start, norm(along.x_m, along.y_m)));
    one.pivots = true;
    for (SectionId id = 0; id < edges.size(); ++id)
      if (edges[id].first == to) one.next.push_back(id);
    parts.push_back(std::move(one));
  }
  return testing::circuit(std::move(parts));
}

std::vector<std::string> crossings_over(const std::vector<Crossing>& crossings, const TrackPosition& position) {
  std::vector<std::string> names;
  for (const Crossing& crossing : crossings)
    if (in_span(crossing, position)) names.push_back(crossing.name);
  return names;
}

TEST(Crossings, of_a_two_way_chain_are_one_per_edge_and_one_per_node) {
  const Circuit chain = net({{0.0, 0.0}, {2.0, 0.0}, {4.0, 0.0}}, {{0, 1}, {1, 0}, {1, 2}, {2, 1}});
  const auto crossings = find_crossings(chain, vehicle, clearance_m);
  EXPECT_THAT(crossings, SizeIs(5));
  expect_every_touch_is_in_a_crossing(chain, crossings);
  // Far apart there is no common crossing: in the middle of one edge, and of the other.
  EXPECT_THAT(crossings_over(crossings, {0, 1.0}), SizeIs(1));
  EXPECT_THAT(crossings_over(crossings, {2, 1.0}), SizeIs(1));
  EXPECT_NE(crossings_over(crossings, {0, 1.0}), crossings_over(crossings, {2, 1.0}));
  // The two directions are one crossing along their whole length.
  for (const double s : {0.0, 0.5, 1.5, 2.0}) {
    const auto there = crossings_over(crossings, {0, s});
    EXPECT_THAT(there, ::testing::Contains(crossings_over(crossings, {1, 1.0}).front())) << s;
  }
}

TEST(Crossings, of_a_two_way_grid_are_one_per_edge_and_one_per_node) {
  std::vector<Point2> nodes;
  std::vector<std::pair<std::size_t, std::size_t>> edges;
  for (std::size_t y = 0; y < 3; ++y) {
    for (std::size_t x = 0; x < 3; ++x) {
      const std::size_t here = 3 * y + x;
      nodes.push_back({0.9 * static_cast<double>(x), 0.9 * static_cast<double>(y)});
      if (x > 0) edges.insert(edges.end(), {{here - 1, here}, {here, here - 1}});
      if (y > 0) edges.insert(edges.end(), {{here - 3, here}, {here, here - 3}});
    }
  }
  const Circuit grid = net(nodes, edges);
  const auto crossings = find_crossings(grid, vehicle, clearance_m);
  EXPECT_THAT(crossings, SizeIs(9 + 12));
  expect_every_touch_is_in_a_crossing(grid, crossings);
}

TEST(Crossings, of_a_two_way_edge_shorter_than_a_vehicle_keep_the_next_edges_apart) {
  const Circuit chain =
      net({{0.0, 0.0}, {2.0, 0.0}, {2.3, 0.0}, {4.3, 0.0}}, {{0, 1}, {1, 0}, {1, 2}, {2, 1}, {2, 3}, {3, 2}});
  const auto crossings = find_crossings(chain, vehicle, clearance_m);
  EXPECT_THAT(crossings, SizeIs(3 + 4));
  expect_every_touch_is_in_a_crossing(chain, crossings);
}

TEST(Crossings, of_two_edges_between_the_same_nodes_are_one_along_their_length) {
  const Circuit twice = net({{0.0, 0.0}, {2.0, 0.0}}, {{0, 1}, {0, 1}});
  const auto crossings = find_crossings(twice, vehicle, clearance_m);
  ASSERT_THAT(crossings, SizeIs(1));
  for (const CrossingSpan& span : crossings[0].spans) {
    EXPECT_EQ(span.from_m, 0.0);
    EXPECT_EQ(span.to_m, 2.0);
  }
}

TEST(Crossings, of_two_edges_that_part_in_between_are_one_at_either_end) {
  const Section direct = section({0.0, 0.0, 0.0}, 2.0);
  const Section round = section({0.0, 0.0, pi / 2.0}, pi, -1.0);  // half a circle over it
  const Circuit circuit = testing::circuit({part("direct", direct), part("round", round)});
  const auto crossings = find_crossings(circuit, vehicle, clearance_m);
  EXPECT_THAT(crossings, SizeIs(2));
  expect_every_touch_is_in_a_crossing(circuit, crossings);
}

TEST(Crossings, where_a_vehicle_turns_on_the_spot_hold_all_that_its_disc_touches) {
  // A corner of 90°, and a straight section that passes 0.18 m from it: a body there, 0.12 m wide, leaves 0.12 m to the
  // corner. That is free for a vehicle at rest (half a width of 0.06 m and 0.04 m of air), but not for one that turns:
  // half its diagonal is 0.117 m.
  const auto circuit_with = [](bool pivots, double beside_m) {
    auto in = part("in", section({-2.0, 0.0, 0.0}, 2.0), {1});
    in.pivots = true;
    std::vector<Circuit::Part> parts{in, part("out", section({0.0, 0.0, pivots ? pi / 2.0 : 0.0}, 2.0))};
    parts.push_back(part("past", section({beside_m, 2.0, -pi / 2.0}, 1.0)));
    parts[2].section = section({beside_m, -2.0, pi / 2.0}, 1.99);
    return testing::circuit(std::move(parts));
  };
  const Circuit corner = circuit_with(true, 0.18);
  const auto crossings = find_crossings(corner, vehicle, clearance_m);
  const double disc_m = norm(0.10, 0.06);
  // Wherever a body on any section comes nearer to the corner than the disc and the clearance, it has a crossing in
  // common with the vehicle that turns at the end of "in".
  for (SectionId id = 0; id < corner.size(); ++id) {
    for (double s = 0.0; s <= corner.section(id).length_m(); s += 0.01) {
      const Point2 p = inverse(corner.pose_at({id, s})) * Point2{0.0, 0.0};
      const double apart_m = norm(std::max(std::fabs(p.x_m) - 0.10, 0.0), std::max(std::fabs(p.y_m) - 0.06, 0.0));
      const bool held = std::any_of(crossings.begin(), crossings.end(), [&](const Crossing& c) {
        return in_span(c, {id, s}) && in_span(c, {0, 2.0});
      });
      if (apart_m < disc_m + clearance_m - 1e-4) {
        EXPECT_TRUE(held) << corner.part(id).name << "@" << s;
      }
      if (apart_m > disc_m + clearance_m + 0.05 && norm(p.x_m, p.y_m) > 0.5) {
        EXPECT_FALSE(held) << corner.part(id).name << "@" << s;
      }
    }
  }
}

TEST(Crossings, where_a_vehicle_turns_at_the_end_of_a_one_way_street_keep_the_next_one_out) {
  const Circuit dead_end = net({{0.0, 0.0}, {2.0, 0.0}}, {{0, 1}, {1, 0}});
  const auto crossings = find_crossings(dead_end, vehicle, clearance_m);
  EXPECT_THAT(crossings, SizeIs(3));  // the edge, and where vehicles turn at either end
  const double disc_m = norm(0.10, 0.06) + clearance_m;
  const auto at_end = crossings_over(crossings, {0, 2.0});
  EXPECT_THAT(at_end, SizeIs(2));
  for (const Crossing& crossing : crossings) {
    for (const CrossingSpan& span : crossing.spans) {
      if (span.section != 0 || span.from_m < 1.0) continue;
      EXPECT_NEAR(span.from_m, 2.0 - 0.10 - disc_m, 1e-4);
    }
  }
}

TEST(Crossings, of_many_regular_sections_are_found_and_of_a_heap_are_not) {
  std::vector<Circuit::Part> lanes;
  for (int i = 0; i < 3000; ++i) lanes.push_back(part("l" + std::to_string(i), section({0.0, 0.3 * i, 0.0}, 5.0)));
  const Circuit honest = testing::circuit(std::move(lanes));
  EXPECT_THAT(find_crossings(honest, vehicle, clearance_m), IsEmpty());

  std::vector<Circuit::Part> heap;
  for (int i = 0; i < 3000; ++i) heap.push_back(part("h" + std::to_string(i), section({0.0, 1e-5 * i, 0.0}, 5.0)));
  const Circuit heaped = testing::circuit(std::move(heap));
  EXPECT_EQ(find_crossings_unless_crowded(heaped, vehicle, clearance_m), std::nullopt);
}

TEST(Crossings, of_a_node_with_thousands_of_edges_are_refused_in_time) {
  std::vector<Circuit::Part> parts;
  std::vector<SectionId> outgoing;
  for (SectionId id = 2000; id < 4000; ++id) outgoing.push_back(id);
  for (int i = 0; i < 4000; ++i) {
    const double heading_rad = 0.0015 * (i % 2000);
    const SinCos turn = sincos(heading_rad);
    const Pose2 start = i < 2000 ? Pose2{-turn.cos, -turn.sin, heading_rad} : Pose2{0.0, 0.0, heading_rad};
    parts.push_back(part("e" + std::to_string(i), section(start, 1.0), i < 2000 ? outgoing : std::vector<SectionId>{}));
    parts.back().pivots = true;
  }
  EXPECT_EQ(find_crossings_unless_crowded(testing::circuit(std::move(parts)), vehicle, clearance_m), std::nullopt);
}

TEST(Crossings, of_an_impossible_vehicle_and_of_a_heap_are_errors_of_the_program) {
  const Circuit line = testing::circuit({part("a", section({}, 1.0))});
  EXPECT_THAT(find_crossings(line, vehicle, 0.0), IsEmpty());
  constexpr const char* broken = "shape.length_m > 0.0 && shape.width_m > 0.0 && clearance_m >= 0.0";
  EXPECT_DEATH(static_cast<void>(find_crossings(line, {0.0, 0.12}, 0.04)), broken);
  EXPECT_DEATH(static_cast<void>(find_crossings(line, {0.20, 0.0}, 0.04)), broken);
  EXPECT_DEATH(static_cast<void>(find_crossings(line, vehicle, -0.01)), broken);
  std::vector<Circuit::Part> heap;
  for (int i = 0; i < 800; ++i) heap.push_back(part("h" + std::to_string(i), section({}, 0.1)));
  const Circuit heaped = testing::circuit(std::move(heap));
  EXPECT_DEATH(static_cast<void>(find_crossings(heaped, vehicle, clearance_m)), "has_value");
}

}  // namespace
}  // namespace cosiva::zone
