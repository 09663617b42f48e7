#include "cosiva/zone/circuit/circuit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/base/random.h"
#include "cosiva/zone/testing/test_zones.h"

namespace cosiva::zone {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::part;
using testing::section;
using testing::track;

std::string code_of(std::vector<Circuit::Part> parts) {
  const auto made = Circuit::make("bad", std::move(parts));
  return made ? "made" : made.error().code;
}

TEST(Circuit, knows_successors_and_predecessors_of_each_section) {
  const Circuit circuit = track();
  EXPECT_THAT(circuit.next(0), ElementsAre(1));
  EXPECT_THAT(circuit.previous(0), ElementsAre(3));
  EXPECT_EQ(circuit.size(), 4U);
  EXPECT_NEAR(circuit.total_length_m(), 4.0 + pi, 1e-12);
}

TEST(Circuit, finds_sections_by_name) {
  const Circuit circuit = track();
  EXPECT_EQ(circuit.find("north"), SectionId{2});
  EXPECT_EQ(circuit.find("north-east"), std::nullopt);
  EXPECT_EQ(circuit.find(""), std::nullopt);
}

TEST(Circuit, without_a_section_is_refused) { EXPECT_EQ(code_of({}), "circuit.empty"); }

TEST(Circuit, with_two_sections_of_one_name_is_refused) {
  const auto made =
      Circuit::make("bad", {part("a", section({}, 1.0)), part("b", section({}, 1.0)), part("a", section({}, 1.0))});
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().code, "circuit.duplicate");
  EXPECT_EQ(made.error().location, "a");
}

TEST(Circuit, with_a_gap_is_refused_with_its_location_and_width) {
  const auto made = Circuit::make("bad", {part("a", section({}, 1.0), {1}), part("b", section({1.0, 0.2, 0.0}, 1.0))});
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().code, "circuit.gap");
  EXPECT_EQ(made.error().location, "a");
  EXPECT_THAT(made.error().message, HasSubstr("0.200000 m"));
}

TEST(Circuit, tolerates_gaps_of_less_than_a_millimetre) {
  EXPECT_EQ(code_of({part("a", section({}, 1.0), {1}), part("b", section({1.0, 0.0009, 0.0}, 1.0))}), "made");
  EXPECT_EQ(code_of({part("a", section({}, 1.0), {1}), part("b", section({1.0, 0.0011, 0.0}, 1.0))}), "circuit.gap");
}

TEST(Circuit, with_a_kink_is_refused) {
  EXPECT_EQ(code_of({part("a", section({}, 1.0), {1}), part("b", section({1.0, 0.0, 0.01}, 1.0))}), "circuit.kink");
  // ±π are one heading, from whichever side of it the two ends approach.
  EXPECT_EQ(
      code_of({part("a", section({0.0, 0.0, pi - 1e-5}, 1.0), {1}), part("b", section({-1.0, 1e-5, -pi + 1e-5}, 1.0))}),
      "made");
}

TEST(Circuit, names_the_section_at_fault_and_what_was_expected) {
  const auto error = [](std::vector<Circuit::Part> parts) { return Circuit::make("bad", std::move(parts)).error(); };
  const Error gap = error({part("a", section({}, 1.0), {1}), part("b", section({1.0, 0.2, 0.0}, 1.0))});
  EXPECT_EQ(
      gap.message,
      "'a' ends at (1.000000, 0.000000) but 'b' starts at (1.000000, 0.200000), 0.200000 m away; expected at most "
      "0.001000 m");
  const Error kink = error({part("a", section({}, 1.0), {1}), part("b", section({1.0, 0.0, pi / 6.0}, 1.0))});
  EXPECT_EQ(kink.message,
            "'a' ends with heading 0.000000° but 'b' starts with 30.000000°; expected at most 0.057296° between them");
  EXPECT_EQ(kink.location, "a");
  const Error next = error({part("a", section({}, 1.0)), part("b", section({}, 1.0), {2})});
  EXPECT_EQ(next.message, "'b' is followed by section number 2, but there are only 2");
  EXPECT_EQ(next.location, "b");
}

TEST(Circuit, tolerates_kinks_of_less_than_a_milliradian) {
  for (const double side : {1.0, -1.0}) {
    EXPECT_EQ(code_of({part("a", section({}, 1.0), {1}), part("b", section({1.0, 0.0, side * 0.0009}, 1.0))}), "made");
    EXPECT_EQ(code_of({part("a", section({}, 1.0), {1}), part("b", section({1.0, 0.0, side * 0.0011}, 1.0))}),
              "circuit.kink");
  }
  // A joint at the very limit is no fault.
  const auto at_limit =
      Circuit::make("limit", {part("a", section({}, 1.0), {1}), part("b", section({1.0, 0.5, 0.25}, 1.0))}, 0.5, 0.25);
  EXPECT_TRUE(at_limit);
}

TEST(Circuit, finds_each_of_many_sections_by_its_name_whatever_their_order) {
  std::vector<Circuit::Part> parts;
  for (const char* name : {"m", "c", "x", "", "a", "zz", "z", "b"}) parts.push_back(part(name, section({}, 1.0)));
  const Circuit circuit = testing::circuit(parts);
  for (SectionId id = 0; id < parts.size(); ++id) EXPECT_EQ(circuit.find(parts[id].name), id);
  for (const char* none : {"A", "aa", "y", "zzz"}) EXPECT_EQ(circuit.find(none), std::nullopt) << none;
  EXPECT_EQ(circuit.name(), "test");
}

TEST(Circuit, followed_by_a_missing_section_is_refused) {
  EXPECT_EQ(code_of({part("a", section({}, 1.0), {7})}), "circuit.next");
}

TEST(Circuit, advances_over_as_many_sections_as_the_distance_needs) {
  const Circuit circuit = track();
  const double lap_m = circuit.total_length_m();
  const TrackPosition track_position = circuit.advance({0, 1.5}, 2.0 * lap_m + 1.0);
  EXPECT_EQ(track_position.section, 1U);
  EXPECT_NEAR(track_position.s_m, 0.5, 1e-12);
  EXPECT_EQ(circuit.advance({0, 0.5}, 1.0), (TrackPosition{0, 1.5}));
}

TEST(Circuit, advances_backwards_too) {
  const Circuit circuit = track();
  const TrackPosition track_position = circuit.advance({0, 0.5}, -1.0);
  EXPECT_EQ(track_position.section, 3U);
  EXPECT_NEAR(track_position.s_m, circuit.section(3).length_m() - 0.5, 1e-12);
}

TEST(Circuit, stops_at_dead_ends) {
  const Circuit circuit = testing::circuit({part("only", section({}, 2.0))});
  EXPECT_EQ(circuit.advance({0, 1.0}, 5.0), (TrackPosition{0, 2.0}));
  EXPECT_EQ(circuit.advance({0, 1.0}, -5.0), (TrackPosition{0, 0.0}));
}

TEST(Circuit, distance_ahead_is_the_distance_round_the_loop) {
  const Circuit circuit = track();
  const double lap_m = circuit.total_length_m();
  EXPECT_DOUBLE_EQ(circuit.distance_ahead({0, 0.5}, {0, 1.5}, 100.0).value(), 1.0);
  EXPECT_NEAR(circuit.distance_ahead({0, 1.5}, {0, 0.5}, 100.0).value(), lap_m - 1.0, 1e-12);
  EXPECT_NEAR(circuit.distance_ahead({3, 0.0}, {2, 1.0}, 100.0).value(), lap_m - 1.0, 1e-12);
}

TEST(Circuit, distance_ahead_ends_at_its_limit_and_at_dead_ends) {
  EXPECT_EQ(track().distance_ahead({0, 0.0}, {2, 0.0}, 3.5), std::nullopt);  // 2 + π/2 = 3.57 m
  EXPECT_TRUE(track().distance_ahead({0, 0.0}, {2, 0.0}, 3.6));
  const Circuit line = testing::circuit({part("a", section({}, 1.0), {1}), part("b", section({1.0, 0.0, 0.0}, 1.0))});
  EXPECT_TRUE(line.distance_ahead({0, 0.5}, {1, 0.5}, 10.0));
  EXPECT_EQ(line.distance_ahead({1, 0.5}, {0, 0.5}, 10.0), std::nullopt);
}

TEST(Circuit, distance_ahead_undoes_advance) {
  const Circuit circuit = track();
  EXPECT_TRUE(rc::check([&] {
    Random random{*rc::gen::arbitrary<std::uint64_t>(), "circuit_test"};
    const auto id = static_cast<SectionId>(random.below(4));
    const TrackPosition from{id, random.uniform(0.0, circuit.section(id).length_m())};
    const double distance_m = random.uniform(0.0, 0.99) * circuit.total_length_m();
    const auto back = circuit.distance_ahead(from, circuit.advance(from, distance_m), 100.0);
    RC_ASSERT(back.has_value());
    RC_ASSERT(std::fabs(*back - distance_m) < 1e-12);
  }));
}

TEST(Circuit, locates_the_nearest_position_of_all_sections) {
  const Circuit circuit = track();
  const auto located = circuit.locate({1.0, 0.9});  // above the centre of the field: north is nearer
  EXPECT_EQ(located.position.section, 2U);
  EXPECT_NEAR(located.position.s_m, 1.0, 1e-12);
  EXPECT_NEAR(located.left_m, 0.1, 1e-12);  // north runs west, its left is the field
  EXPECT_NEAR(located.distance_m, 0.1, 1e-12);
}

TEST(Circuit, locate_distinguishes_crossing_sections_by_heading) {
  const Circuit cross = testing::circuit(
      {part("east", section({-1.0, 0.0, 0.0}, 2.0)), part("north", section({0.0, -1.0, pi / 2.0}, 2.0))});
  const Point2 p{0.05, 0.02};
  EXPECT_EQ(cross.locate(p).position.section, 0U);
  EXPECT_EQ(cross.locate(p, 0.1).position.section, 0U);
  EXPECT_EQ(cross.locate(p, pi / 2.0 - 0.5).position.section, 1U);
  // Against every direction of travel: then only distance counts.
  EXPECT_EQ(cross.locate(p, -3.0 * pi / 4.0).position.section, 0U);
}

TEST(Circuit, locates_every_position_at_itself) {
  const Circuit circuit = track();
  EXPECT_TRUE(rc::check([&] {
    Random random{*rc::gen::arbitrary<std::uint64_t>(), "circuit_test"};
    const auto id = static_cast<SectionId>(random.below(4));
    const Pose2 pose = circuit.pose_at({id, random.uniform(0.0, circuit.section(id).length_m())});
    const auto located = circuit.locate(position(pose), pose.heading_rad);
    RC_ASSERT(located.distance_m < 1e-12);
    RC_ASSERT(distance(circuit.pose_at(located.position), pose) < 1e-9);
  }));
}

// Sections with branches
// ------------------------------------------------------------------------------------------------

/// stem → left → end, or stem → right, which is longer, → end.
Circuit diamond() {
  std::vector<Circuit::Part> parts{
      part("stem", section({}, 1.0), {1, 2}), part("left", section({1.0, 0.0, 0.0}, 1.0), {3}),
      part("right", section({1.0, 0.0, 0.0}, 3.0), {3}), part("end", section({2.0, 0.0, pi / 2.0}, 1.0), {0})};
  for (auto& one : parts) one.pivots = true;
  parts[2].section = section({1.0, 0.0, pi / 2.0}, 3.0, 2.0 * pi / 3.0);  // once round
  auto made = Circuit::make("diamond", parts, 10.0);                      // the positions of ends do not matter here
  EXPECT_TRUE(made);
  return std::move(*made);
}

TEST(Circuit, turns_on_the_spot_only_where_headings_differ) {
  const Circuit circuit = diamond();
  EXPECT_EQ(circuit.turn_at(0, 1), 0.0);
  EXPECT_DOUBLE_EQ(circuit.turn_at(0, 2), pi / 2.0);
  EXPECT_DOUBLE_EQ(circuit.turn_at(3, 0), -pi / 2.0);
  const Circuit back = testing::circuit({[] {
                                           auto there = part("there", section({}, 1.0), {1});
                                           there.pivots = true;
                                           return there;
                                         }(),
                                         part("back", section({1.0, 0.0, pi}, 1.0))});
  EXPECT_DOUBLE_EQ(std::fabs(back.turn_at(0, 1)), pi);
}

TEST(Circuit, refuses_a_kink_without_a_pivot_and_accepts_it_with_one) {
  auto corner = [](bool pivots) {
    std::vector<Circuit::Part> parts{part("a", section({}, 1.0), {1}), part("b", section({1.0, 0.0, 1.0}, 1.0))};
    parts[0].pivots = pivots;
    return parts;
  };
  EXPECT_EQ(code_of(corner(false)), "circuit.kink");
  EXPECT_EQ(code_of(corner(true)), "made");
  auto gap = corner(true);
  gap[1].section = section({1.0, 0.1, 1.0}, 1.0);
  EXPECT_EQ(code_of(gap), "circuit.gap");
}

TEST(Circuit, advances_along_a_chosen_route_and_back_along_it) {
  const Circuit circuit = diamond();
  const SectionId right[] = {2, 3};
  EXPECT_EQ(circuit.advance({0, 0.5}, 1.0), (TrackPosition{1, 0.5}));
  EXPECT_EQ(circuit.advance({0, 0.5}, 1.0, right), (TrackPosition{2, 0.5}));
  EXPECT_EQ(circuit.advance({0, 0.5}, 5.0, right), (TrackPosition{0, 0.5}));  // and on by default
  const SectionId traversed[] = {0, 2};
  EXPECT_EQ(circuit.advance({3, 0.5}, -1.0), (TrackPosition{1, 0.5}));
  EXPECT_EQ(circuit.advance({3, 0.5}, -1.0, {}, traversed), (TrackPosition{2, 2.5}));
  EXPECT_EQ(circuit.advance({3, 0.5}, -4.0, {}, traversed), (TrackPosition{0, 0.5}));
  EXPECT_EQ(circuit.advance({3, 0.5}, -5.0, {}, traversed),
            (TrackPosition{3, 0.5}));  // beyond the known route: by default
}

TEST(Circuit, measures_along_a_chosen_route) {
  const Circuit circuit = diamond();
  const SectionId right[] = {2, 3};
  const auto past_m = [&](const std::vector<SectionId>& course) {
    return circuit.distance_ahead({0, 0.5}, {3, 0.5}, 10.0, course).value();
  };
  EXPECT_DOUBLE_EQ(past_m({}), 2.0);
  EXPECT_DOUBLE_EQ(past_m({2, 3}), 4.0);
  EXPECT_EQ(circuit.distance_ahead({0, 0.5}, {2, 0.5}, 100.0), std::nullopt);  // never there by default
  EXPECT_DOUBLE_EQ(circuit.distance_ahead({0, 0.5}, {2, 0.5}, 10.0, right).value(), 1.0);
}

TEST(Circuit, finds_the_shortest_route_over_all_branches) {
  const Circuit circuit = diamond();
  const auto left = circuit.shortest_route({0, 0.5}, {3, 0.5}, 10.0);
  ASSERT_TRUE(left);
  EXPECT_DOUBLE_EQ(left->length_m, 2.0);
  EXPECT_THAT(left->sections, ElementsAre(0, 1, 3));
  const auto right = circuit.shortest_route({0, 0.5}, {2, 1.0}, 10.0);
  ASSERT_TRUE(right);
  EXPECT_THAT(right->sections, ElementsAre(0, 2));
  EXPECT_DOUBLE_EQ(right->length_m, 1.5);
  EXPECT_THAT(circuit.shortest_route({1, 0.7}, {1, 0.2}, 10.0)->sections, ElementsAre(1, 3, 0, 1));
  EXPECT_EQ(circuit.shortest_route({0, 0.5}, {2, 1.0}, 1.4), std::nullopt);
  EXPECT_TRUE(circuit.shortest_route({0, 0.5}, {2, 1.0}, 1.5));
}

TEST(Circuit, finds_the_shortest_route_of_a_random_graph) {
  EXPECT_TRUE(rc::check([] {
    Random random{*rc::gen::arbitrary<std::uint64_t>(), "circuit_test/route"};
    // Circles through the origin: every section begins and ends there, so that any may follow any.
    const std::size_t size = 2 + random.below(7);
    std::vector<Circuit::Part> parts;
    for (std::size_t i = 0; i < size; ++i) {
      const double radius_m = 0.1 * static_cast<double>(1 + random.below(5));
      parts.push_back(part("s" + std::to_string(i), section({}, 2.0 * pi * radius_m, 1.0 / radius_m)));
      for (SectionId to = 0; to < size; ++to)
        if (random.chance(1.6 / static_cast<double>(size))) parts.back().next.push_back(to);
    }
    const Circuit circuit = testing::circuit(std::move(parts));
    const auto from = static_cast<SectionId>(random.below(size));
    const auto to = static_cast<SectionId>(random.below(size));
    const double from_m = random.uniform(0.0, 1.0) * circuit.section(from).length_m();
    const double to_m = random.uniform(0.0, 1.0) * circuit.section(to).length_m();
    // To the start of each section, by relaxing every joint again and again.
    std::vector<double> start_m(size, 1e9);
    const auto relax = [&](SectionId id, double end_m) {
      for (const SectionId after : circuit.next(id)) start_m[after] = std::min(start_m[after], end_m);
    };
    for (std::size_t round = 0; round <= size; ++round) {
      relax(from, circuit.section(from).length_m() - from_m);
      for (SectionId id = 0; id < size; ++id) relax(id, start_m[id] + circuit.section(id).length_m());
    }
    const double wanted_m = from == to && to_m >= from_m ? to_m - from_m : start_m[to] + to_m;
    const double limit_m = random.chance(0.5) ? 100.0 : random.uniform(0.0, 2.0) * wanted_m;
    const auto route = circuit.shortest_route({from, from_m}, {to, to_m}, limit_m);
    RC_ASSERT(route.has_value() == (wanted_m < 1e8 && wanted_m <= limit_m));
    if (!route) return;
    RC_ASSERT(std::fabs(route->length_m - wanted_m) < 1e-9);
    RC_ASSERT(route->sections.front() == from);
    RC_ASSERT(route->sections.back() == to);
    for (std::size_t i = 1; i < route->sections.size(); ++i) {
      const auto next = circuit.next(route->sections[i - 1]);
      RC_ASSERT(std::find(next.begin(), next.end(), route->sections[i]) != next.end());
    }
  }));
}

TEST(Circuit, measures_up_to_its_limit_and_no_further) {
  const Circuit line =
      testing::circuit({part("a", section({}, 1.0), {1}), part("b", section({1.0, 0.0, 0.0}, 1.0), {2}),
                        part("c", section({2.0, 0.0, 0.0}, 1.0))});
  const auto measured = [&](TrackPosition from, TrackPosition to, double limit_m) {
    return line.distance_ahead(from, to, limit_m);
  };
  EXPECT_EQ(measured({0, 0.5}, {0, 0.75}, 0.25), 0.25);
  EXPECT_EQ(measured({0, 0.5}, {0, 0.75}, 0.2), std::nullopt);
  EXPECT_EQ(measured({0, 0.5}, {0, 0.5}, 0.0), 0.0);
  EXPECT_EQ(measured({0, 0.5}, {1, 0.0}, 0.5), 0.5);
  EXPECT_EQ(measured({0, 0.5}, {2, 0.25}, 1.75), 1.75);
  EXPECT_EQ(measured({0, 0.5}, {2, 0.25}, 1.5), std::nullopt);
  EXPECT_EQ(measured({0, 0.5}, {0, 0.25}, 100.0), std::nullopt);
  EXPECT_EQ(line.shortest_route({0, 0.5}, {0, 0.75}, 0.25)->length_m, 0.25);
  EXPECT_EQ(line.shortest_route({0, 0.5}, {0, 0.75}, 0.2), std::nullopt);
  EXPECT_EQ(line.shortest_route({0, 0.5}, {2, 0.25}, 1.75)->length_m, 1.75);
  EXPECT_EQ(line.shortest_route({0, 0.5}, {2, 0.25}, 1.5), std::nullopt);
  EXPECT_EQ(line.shortest_route({2, 0.5}, {0, 0.25}, 100.0), std::nullopt);
}

TEST(Circuit, advances_from_positions_beyond_a_section_s_ends_as_from_the_ends) {
  const Circuit line = testing::circuit({part("a", section({}, 1.0), {1}), part("b", section({1.0, 0.0, 0.0}, 1.0))});
  EXPECT_EQ(line.advance({0, -5.0}, 0.5), (TrackPosition{0, 0.5}));
  EXPECT_EQ(line.advance({0, 5.0}, 0.5), (TrackPosition{1, 0.5}));
  EXPECT_EQ(line.advance({0, 0.5}, 0.5), (TrackPosition{0, 1.0})) << "the end of a section is on it";
  EXPECT_EQ(line.advance({1, 0.5}, -0.5), (TrackPosition{1, 0.0}));
  EXPECT_EQ(line.advance({1, 0.5}, -0.75), (TrackPosition{0, 0.75}));
}

TEST(Circuit, turns_where_a_successor_leaves_by_more_than_a_milliradian) {
  const auto turn = [](double kink_rad) {
    auto a = part("a", section({}, 1.0), {1});
    a.pivots = true;
    return testing::circuit({a, part("b", section({1.0, 0.0, kink_rad}, 1.0))}).turn_at(0, 1);
  };
  EXPECT_EQ(turn(0.0009), 0.0);
  EXPECT_EQ(turn(-0.0009), 0.0);
  EXPECT_DOUBLE_EQ(turn(0.0011), 0.0011);
  EXPECT_DOUBLE_EQ(turn(-0.0011), -0.0011);
}

TEST(Circuit, of_positions_on_no_section_is_an_error_of_the_program) {
  const Circuit line = testing::circuit({part("a", section({}, 1.0), {1}), part("b", section({1.0, 0.0, 0.0}, 1.0))});
  constexpr const char* from_and_to = "from.section < parts_.size.. && to.section < parts_.size";
  constexpr const char* from_finite = "from.section < parts_.size.. && std::isfinite.distance_m.";
  EXPECT_DEATH(static_cast<void>(line.advance({2, 0.0}, 0.5)), from_finite);
  EXPECT_DEATH(static_cast<void>(line.advance({0, 0.0}, std::numeric_limits<double>::infinity())), from_finite);
  const TrackPosition outside{2, 0.0};
  for (const auto& [from, to] : {std::pair{outside, TrackPosition{}}, std::pair{TrackPosition{}, outside}})
    EXPECT_DEATH(static_cast<void>(line.distance_ahead(from, to, 1.0)), from_and_to);
  EXPECT_DEATH(static_cast<void>(line.shortest_route({2, 0.0}, {0, 0.0}, 1.0)), from_and_to);
  EXPECT_DEATH(static_cast<void>(line.shortest_route({0, 0.0}, {2, 0.0}, 1.0)), from_and_to);
}

TEST(Circuit, takes_a_turn_of_exactly_a_milliradian_for_straight_on) {
  auto a = part("a", section({}, 1.0), {1});
  a.pivots = true;
  for (const double side : {1.0, -1.0}) {
    const Circuit circuit = testing::circuit({a, part("b", section({1.0, 0.0, side * Circuit::smooth_rad}, 1.0))});
    EXPECT_EQ(circuit.turn_at(0, 1), 0.0);
  }
}

TEST(Circuit, measures_along_a_route_of_as_many_sections_as_it_has) {
  const Circuit circuit = track();
  const SectionId round[] = {1, 2, 3, 0};
  const auto distance_m = [&](const TrackPosition& to) {
    return circuit.distance_ahead({0, 0.5}, to, 100.0, round).value();
  };
  EXPECT_DOUBLE_EQ(distance_m({1, 0.25}), 1.75);
  EXPECT_NEAR(distance_m({0, 0.25}), circuit.total_length_m() - 0.25, 1e-12);
}

TEST(Circuit, measures_without_a_limit_once_round_and_no_further) {
  constexpr double unlimited = std::numeric_limits<double>::infinity();
  const auto distance_m = [&](const TrackPosition& to) { return diamond().distance_ahead({0, 0.5}, to, unlimited); };
  EXPECT_EQ(distance_m({2, 0.5}), std::nullopt);
  EXPECT_DOUBLE_EQ(distance_m({0, 0.25}).value(), 2.75);
}

TEST(Circuit, routes_to_its_own_position_without_driving_and_to_the_next_section_at_the_limit) {
  const Circuit line = testing::circuit({part("a", section({}, 1.0), {1}), part("b", section({1.0, 0.0, 0.0}, 1.0))});
  const auto here = line.shortest_route({0, 0.5}, {0, 0.5}, 0.0);
  ASSERT_TRUE(here);
  EXPECT_EQ(here->length_m, 0.0);
  EXPECT_THAT(here->sections, ElementsAre(0));
  const auto there = line.shortest_route({0, 0.5}, {1, 0.0}, 0.5);
  ASSERT_TRUE(there);
  EXPECT_EQ(there->length_m, 0.5);
  EXPECT_THAT(there->sections, ElementsAre(0, 1));
}

TEST(Circuit, routes_over_the_lower_of_two_equally_long_branches) {
  const Section branch = section({1.0, 0.0, 0.0}, 1.0);
  const Circuit circuit = testing::circuit({part("in", section({}, 1.0), {2, 1}), part("one", branch, {3}),
                                            part("two", branch, {3}), part("out", section({2.0, 0.0, 0.0}, 1.0))});
  EXPECT_THAT(circuit.shortest_route({0, 0.5}, {3, 0.5}, 10.0)->sections, ElementsAre(0, 1, 3));
}

TEST(Circuit, without_sections_locates_nothing_by_an_error_of_the_program) {
  EXPECT_DEATH(static_cast<void>(Circuit{}.locate(Point2{})), "parts_.empty");
}

/// A fork: "stem" leads to "left", its default, and to "right"; both lead back to "stem".
Circuit fork() {
  const Section stem = section({}, 1.0);
  const Section left = section(stem.end(), 1.0, 0.5);
  const Section right = section(stem.end(), 1.0, -0.5);
  std::vector<Circuit::Part> parts{part("right", right, {1}), part("stem", stem, {2, 0}), part("left", left, {1})};
  auto made = Circuit::make("fork", std::move(parts), 1e9, 1e9);
  return std::move(*made);
}

TEST(ReversedCircuit, follows_each_section_by_the_sections_that_precede_it) {
  const Circuit circuit = track();
  const Circuit back = reversed(circuit);
  EXPECT_THAT(back.next(0), ElementsAre(3));
  EXPECT_THAT(back.previous(0), ElementsAre(1));
  EXPECT_EQ(back.part(2).name, circuit.part(2).name);
  EXPECT_TRUE(is_reversed(back, circuit));
  EXPECT_TRUE(is_reversed(circuit, back));
  EXPECT_FALSE(is_reversed(circuit, circuit));
  EXPECT_FALSE(is_reversed(reversed(track(2.001)), circuit));
}

TEST(ReversedCircuit, has_the_same_points_from_the_other_end) {
  const Circuit circuit = track();
  const Circuit back = reversed(circuit);
  for (SectionId id = 0; id < circuit.size(); ++id) {
    const TrackPosition position{id, 0.3 * circuit.section(id).length_m()};
    const Pose2 there = circuit.pose_at(position);
    const Pose2 here = back.pose_at(reversed(circuit, position));
    EXPECT_NEAR(distance(here, there), 0.0, 1e-9);
    EXPECT_NEAR(std::fabs(wrap_angle(here.heading_rad - there.heading_rad)), pi, 1e-9);
    EXPECT_NEAR(reversed(back, reversed(circuit, position)).s_m, position.s_m, 1e-12);
  }
}

TEST(ReversedCircuit, goes_first_to_a_section_whose_own_default_led_here) {
  const Circuit back = reversed(fork());
  EXPECT_THAT(back.next(1), ElementsAre(0, 2)) << "both lead to the stem alone; the lower id is first";
  EXPECT_THAT(back.next(2), ElementsAre(1));
  const Circuit again = reversed(back);
  EXPECT_THAT(again.next(1), ElementsAre(0, 2)) << "which default the fork had is no longer known";
}

}  // namespace
}  // namespace cosiva::zone
