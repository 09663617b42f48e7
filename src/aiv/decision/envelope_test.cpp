#include "cosiva/aiv/decision/envelope.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "cosiva/aiv/decision/branch_choice.h"
#include "cosiva/aiv/motion/speed.h"
#include "cosiva/aiv/testing/test_graphs.h"
#include "cosiva/aiv/testing/test_orders.h"
#include "cosiva/aiv/testing/test_zone.h"

namespace cosiva::aiv {
namespace {

using test::at;
using test::lacet4;
using test::order;

constexpr double nothing = std::numeric_limits<double>::infinity();

// --- crossings ----------------------------------------------------------------------------------------------------

TEST(CrossingLookAhead, takes_the_two_crossings_of_a_straight_as_one) {
  const CrossingLookAhead crossings{lacet4()};
  const auto chain = crossings.first(at(lacet4(), "east", 0.1), 1.0);
  EXPECT_NEAR(chain.entry_m, 0.3, 0.001);
  EXPECT_NEAR(chain.exit_m, 1.0, 0.001);
}

TEST(CrossingLookAhead, finds_crossings_beyond_the_joint_of_two_sections) {
  const CrossingLookAhead crossings{lacet4()};
  const auto chain = crossings.first(at(lacet4(), "loop_se", 2.7), 1.0);
  EXPECT_NEAR(chain.entry_m, 0.9 * pi - 2.7 + 0.4, 0.001);
}

TEST(CrossingLookAhead, has_nothing_within_a_shorter_reach) {
  const CrossingLookAhead crossings{lacet4()};
  EXPECT_EQ(crossings.first(at(lacet4(), "east", 0.1), 0.2).entry_m, nothing);
}

TEST(CrossingLookAhead, does_not_stop_a_vehicle_that_is_in_one) {
  const CrossingLookAhead crossings{lacet4()};
  EXPECT_EQ(crossings.first(at(lacet4(), "east", 0.6), 1.0).entry_m, nothing);
}

TEST(CrossingLookAhead, measures_from_the_exit_of_the_last_crossing_over_joints) {
  const CrossingLookAhead crossings{lacet4()};
  EXPECT_EQ(crossings.passed_m(at(lacet4(), "east", 0.6), 1.0), 0.0) << "in a crossing";
  // The second crossing of a straight ends at 1.1 m, 0.4 m before its end.
  EXPECT_NEAR(crossings.passed_m(at(lacet4(), "east", 1.3), 1.0), 0.2, 0.001);
  EXPECT_NEAR(crossings.passed_m(at(lacet4(), "loop_se", 0.5), 1.0), 0.9, 0.001);
  EXPECT_EQ(crossings.passed_m(at(lacet4(), "loop_se", 1.2), 1.0), nothing) << "further than its reach";
}

TEST(CrossingLookAhead, of_an_open_circuit_has_passed_none_before_the_first) {
  zone::TrafficZone zone = lacet4();
  zone.circuit = test::lay({{5.0}}, false);
  zone.crossings = {{"X", {}, {{0, 1.0, 1.5}}}};
  const CrossingLookAhead crossings{zone};
  EXPECT_EQ(crossings.passed_m({0, 0.9}, 1.0), nothing);
  EXPECT_NEAR(crossings.passed_m({0, 1.7}, 1.0), 0.2, 1e-12);
}

zone::TrafficZone with_spans(std::vector<zone::CrossingSpan> spans, std::vector<test::Piece> pieces, bool closed) {
  zone::TrafficZone zone = lacet4();
  zone.circuit = test::lay(pieces, closed);
  zone.crossings = {{"X", {}, std::move(spans)}};
  return zone;
}

TEST(CrossingLookAhead, keeps_crossings_separate_when_a_vehicle_can_stop_between) {
  // The vehicle is 0.2 m long and needs 0.3 m to stop between crossings.
  const auto near = with_spans({{0, 1.0, 1.5}, {0, 1.79, 2.0}}, {{5.0}}, false);
  EXPECT_NEAR(CrossingLookAhead{near}.first({0, 0.5}, 1.0).exit_m, 1.5, 1e-12);
  const auto far = with_spans({{0, 1.0, 1.5}, {0, 1.81, 2.0}}, {{5.0}}, false);
  EXPECT_NEAR(CrossingLookAhead{far}.first({0, 0.5}, 1.0).exit_m, 1.0, 1e-12);
}

TEST(CrossingLookAhead, joins_the_spans_of_one_crossing_over_a_joint) {
  const auto zone = with_spans({{0, 0.8, 1.0}, {1, 0.0, 0.3}}, {{1.0}, {5.0}}, false);
  const CrossingLookAhead crossings{zone};
  const auto chain = crossings.first({0, 0.5}, 1.0);
  EXPECT_NEAR(chain.entry_m, 0.3, 1e-12);
  EXPECT_NEAR(chain.exit_m, 0.8, 1e-12);
  EXPECT_EQ(crossings.first({0, 0.9}, 1.0).entry_m, nothing) << "the vehicle is in the crossing already";
}

TEST(CrossingLookAhead, ends_the_search_on_a_loop_that_is_all_crossing) {
  const auto zone = with_spans({{0, 0.2, 0.9}}, {{1.0}, {1.0}, {1.0}, {1.0}}, false);
  EXPECT_NEAR(CrossingLookAhead{zone}.first({0, 0.1}, 1.0).exit_m, 0.8, 1e-12);
  zone::TrafficZone loop = lacet4();
  loop.crossings.clear();
  for (zone::SectionId id = 0; id < loop.circuit.size(); ++id)
    loop.crossings.push_back({"X", {}, {{id, 0.1, loop.circuit.section(id).length_m()}}});
  EXPECT_GT(CrossingLookAhead{loop}.first({0, 0.05}, 1.0).exit_m, loop.circuit.total_length_m());
}

// --- the envelope -------------------------------------------------------------------------------------------------

const zone::SpeedProfile target_speed{.speed_mps = 0.5, .acceleration_mps2 = 0.5, .braking_mps2 = 0.8};

struct Scene {
  OrderBook book{lacet4()};
  zone::TrackPosition here;
  Scene(std::string_view section, double s_m, const wire::Order& order) : here{at(lacet4(), section, s_m)} {
    if (!book.offer(order, {here, true})) std::abort();
  }
  Limit limit(double obstacle_m = nothing, double speed_mps = 0.3) const {
    return Envelope{lacet4()}.limit({here, speed_mps, obstacle_m, book}, target_speed);
  }
};

TEST(Envelope, leaves_the_target_speed_unchanged_on_a_free_path) {
  const Scene scene{"loop_se", 0.0, order("O").through({"loop_se@0", "loop_se@283", "loop_se@1131"})};
  EXPECT_EQ(scene.limit().speed_mps, target_speed.speed_mps);
  EXPECT_EQ(scene.limit().braking_mps2, target_speed.braking_mps2);
  EXPECT_FALSE(scene.limit().by_obstacle);
}

TEST(Envelope, lets_the_vehicle_stop_at_the_end_of_its_base) {
  const Scene scene{"loop_se", 0.2, order("O").through({"loop_se@0", "loop_se@283"}).then({"loop_se@565"})};
  EXPECT_NEAR(scene.limit().speed_mps, stoppable_speed(0.282743 - 0.2, 0.8, 0.08), 1e-5);
}

TEST(Envelope, allows_for_the_delay_of_the_vehicle_s_cycle) {
  using namespace std::chrono_literals;
  EXPECT_EQ(Lateness::of(20ms).command_s, 0.08);
  EXPECT_EQ(Lateness::of(20ms).obstacle_s, 0.15);
  // Eighty milliseconds more between two decisions, and forty between two frames of the obstacle sensor.
  const Lateness late = Lateness::of(100ms);
  EXPECT_NEAR(late.command_s, 0.16, 1e-12);
  EXPECT_NEAR(late.obstacle_s, 0.27, 1e-12);
  const Scene scene{"loop_se", 0.2, order("O").through({"loop_se@0", "loop_se@283"}).then({"loop_se@565"})};
  const Envelope slow{lacet4(), late};
  const auto limit_mps = [&](double obstacle_m) {
    return slow.limit({scene.here, 0.3, obstacle_m, scene.book}, target_speed).speed_mps;
  };
  EXPECT_NEAR(limit_mps(nothing), stoppable_speed(0.282743 - 0.2, 0.8, 0.16), 1e-5);
  EXPECT_NEAR(limit_mps(0.16), stoppable_speed(0.16 - 0.12, 0.8, 0.27), 1e-9);
}

TEST(Envelope, is_zero_without_an_order) {
  OrderBook empty{lacet4()};
  EXPECT_EQ((Envelope{lacet4()}.limit({at(lacet4(), "east", 0.1), 0.0, nothing, empty}, target_speed).speed_mps), 0.0);
}

TEST(Envelope, stops_before_a_crossing_that_the_base_does_not_lead_through) {
  // The base ends between the two crossings, and more is announced: another vehicle may hold them.
  auto into = order("O").through({"east@190", "centre"}).then({"east@1120"});
  into.node(1).position = wire::NodePosition{0.0, -0.15, {}, {}, {}, ""};
  const Scene scene{"east", 0.30, into};
  EXPECT_NEAR(scene.limit().speed_mps, stoppable_speed(0.10 - 0.01, 0.8, 0.08), 1e-3);
  EXPECT_NEAR(scene.limit().crossing_ahead_m, 0.10, 1e-3);
}

TEST(Envelope, reports_a_crossing_up_to_half_a_metre_beyond_its_stopping_distance) {
  const auto into = order("O").through({"loop_se@2545", "north@190"}).then({"north@1120"});
  const auto reported_m = [&](double distance_m, double speed_mps) {
    // The crossing begins 0.4 m behind the joint of the two sections.
    return Scene{"loop_se", 0.9 * pi + 0.4 - distance_m, into}.limit(nothing, speed_mps).crossing_ahead_m;
  };
  EXPECT_NEAR(reported_m(0.49, 0.0), 0.49, 1e-3);
  EXPECT_EQ(reported_m(0.51, 0.0), nothing);
  // 0.1 m of braking and 0.08 s of reaction at 0.4 m/s.
  EXPECT_NEAR(reported_m(0.62, 0.4), 0.62, 1e-3);
  EXPECT_EQ(reported_m(0.64, 0.4), nothing);
}

TEST(Envelope, enters_a_crossing_that_the_base_leads_through) {
  const Scene scene{"east", 0.30, order("O").through({"east@190", "east@380", "east@1120"}).then({"east@1310"})};
  EXPECT_EQ(scene.limit().speed_mps, target_speed.speed_mps);
  EXPECT_EQ(scene.limit().crossing_ahead_m, nothing);
}

TEST(Envelope, enters_a_crossing_at_the_end_of_the_order) {
  auto into = order("O").through({"east@190", "centre"});
  into.node(1).position = wire::NodePosition{0.0, -0.15, {}, {}, {}, ""};
  const Scene scene{"east", 0.30, into};
  EXPECT_EQ(scene.limit().speed_mps, target_speed.speed_mps);
}

TEST(Envelope, keeps_its_distance_to_an_obstacle) {
  const Scene scene{"loop_se", 0.0, order("O").through({"loop_se@0", "loop_se@283", "loop_se@1131"})};
  EXPECT_NEAR(scene.limit(0.22).speed_mps, stoppable_speed(0.10, 0.8, 0.15), 1e-12);
  EXPECT_TRUE(scene.limit(0.22).by_obstacle);
  EXPECT_EQ(scene.limit(clearance_m).speed_mps, 0.0);
}

TEST(Envelope, brakes_as_hard_as_it_can_when_the_profile_s_brakes_do_not_suffice) {
  const Scene scene{"loop_se", 0.0, order("O").through({"loop_se@0", "loop_se@283", "loop_se@1131"})};
  EXPECT_EQ(scene.limit(0.5, 0.5).braking_mps2, target_speed.braking_mps2);
  EXPECT_EQ(scene.limit(0.2, 0.5).braking_mps2, lacet4().profiles.fast.braking_mps2);
}

TEST(Envelope, obeys_an_edge_s_speed_limit_and_brakes_for_the_next_one_s) {
  auto limited = order("O").through({"loop_se@0", "loop_se@283", "loop_se@565", "loop_se@1131"});
  limited.edge(1).max_speed_mps = 0.1;
  EXPECT_EQ((Scene{"loop_se", 0.0, limited}.limit().speed_mps), target_speed.speed_mps);
  // 5 cm before the edge: the speed from which these 5 cm, less the reaction's distance, suffice to brake down to 0.1
  // m/s.
  const double before_mps = (Scene{"loop_se", 0.2327, limited}.limit().speed_mps);
  EXPECT_NEAR(before_mps, std::sqrt(0.01 + 1.6 * (0.05 - 0.008)), 1e-3);
  auto on_it = order("O").through({"loop_se@283", "loop_se@565", "loop_se@1131"});
  on_it.edge(0).max_speed_mps = 0.1;
  EXPECT_NEAR((Scene{"loop_se", 0.3, on_it}.limit().speed_mps), 0.1, 1e-12);
}

TEST(Envelope, obeys_a_section_s_speed_limit) {
  zone::TrafficZone zone = lacet4();
  std::vector<zone::Circuit::Part> parts;
  for (zone::SectionId id = 0; id < zone.circuit.size(); ++id) parts.push_back(zone.circuit.part(id));
  parts[1].speed_mps_max = 0.2;
  zone.circuit = zone::Circuit::make("limited", parts).value();
  OrderBook book{zone};
  ASSERT_TRUE(book.offer(order("O").through({"loop_se@0", "loop_se@1131"}), {at(zone, "loop_se", 0.1), true}));
  EXPECT_NEAR((Envelope{zone}.limit({at(zone, "loop_se", 0.1), 0.2, nothing, book}, target_speed).speed_mps), 0.2,
              1e-12);
}

TEST(Envelope, brakes_for_a_section_s_speed_limit_before_it) {
  zone::TrafficZone zone = lacet4();
  std::vector<zone::Circuit::Part> parts;
  for (zone::SectionId id = 0; id < zone.circuit.size(); ++id) parts.push_back(zone.circuit.part(id));
  parts[1].speed_mps_max = 0.2;
  zone.circuit = zone::Circuit::make("limited", parts).value();
  const auto limit_mps = [&](double before_m) {
    const zone::TrackPosition here = at(zone, "east", zone.circuit.section(0).length_m() - before_m);
    OrderBook book{zone};
    EXPECT_TRUE(book.offer(order("O").through({"east@1310", "loop_se@0", "loop_se@1131"}), {here, true}));
    return Envelope{zone}.limit({here, 0.4, nothing, book}, target_speed).speed_mps;
  };
  EXPECT_NEAR(limit_mps(0.10), std::sqrt(0.04 + 1.6 * (0.10 - 0.2 * 0.08)), 1e-9);
  EXPECT_NEAR(limit_mps(0.05), std::sqrt(0.04 + 1.6 * (0.05 - 0.2 * 0.08)), 1e-9);
}

TEST(Envelope, off_the_path_is_limited_by_obstacles_alone) {
  const auto limit = [](double obstacle_m) { return Envelope{lacet4()}.limit_off_path(obstacle_m, target_speed); };
  const Limit free = limit(nothing);
  EXPECT_EQ(free.speed_mps, 0.5);
  EXPECT_EQ(free.braking_mps2, 0.8);
  EXPECT_FALSE(free.by_obstacle);
  EXPECT_EQ(free.crossing_ahead_m, nothing);
  EXPECT_EQ(free.bend_ahead_m, nothing);
  const Limit blocked = limit(0.22);
  EXPECT_NEAR(blocked.speed_mps, stoppable_speed(0.10, 0.8, 0.15), 1e-12);
  EXPECT_TRUE(blocked.by_obstacle);
}

TEST(Envelope, brakes_with_the_strongest_brakes_of_all_profiles_where_its_own_do_not_suffice) {
  // 0.3²/(2·0.8) = 0.05625 m to the end of the base.
  for (const double before_m : {0.057, 0.055}) {
    for (const int strongest : {0, 1, 2}) {
      zone::TrafficZone zone = lacet4();
      zone::SpeedProfile* all_profiles[] = {&zone.profiles.slow, &zone.profiles.medium, &zone.profiles.fast};
      all_profiles[strongest]->braking_mps2 = 3.0;
      const zone::TrackPosition here = at(zone, "loop_se", 0.282743338823 - before_m);
      OrderBook book{zone};
      ASSERT_TRUE(book.offer(order("O").through({"loop_se@0", "loop_se@283"}), {here, true}));
      EXPECT_EQ((Envelope{zone}.limit({here, 0.3, nothing, book}, target_speed).braking_mps2),
                before_m > 0.05625 ? 0.8 : 3.0);
      EXPECT_EQ((Envelope{zone}.limit({here, 0.0, nothing, book}, target_speed).braking_mps2), 0.8);
    }
  }
}

TEST(Envelope, creeps_to_a_bend_on_the_spot_and_passes_it_where_its_order_leads_straight_on) {
  const zone::TrafficZone& zone = test::square();
  const auto limit = [&](const char* to, double before_m, double speed_mps) {
    const zone::TrackPosition here = at(zone, "south", 1.0 - before_m);
    OrderBook book{zone};
    EXPECT_TRUE(book.offer(order("O").through({"A", "B", to}), {here, true}));
    const zone::Course course = book.course_from(here);
    return Envelope{zone}.limit({Outlook{here, course.remaining()}, speed_mps, nothing, book}, target_speed);
  };
  const Limit turns = limit("C", 0.1, 0.3);
  EXPECT_NEAR(turns.bend_ahead_m, 0.1, 1e-9);
  EXPECT_NEAR(turns.speed_mps, std::sqrt(0.05 * 0.05 + 1.6 * (0.1 - 0.015 - 0.05 * 0.08)), 1e-9);
  EXPECT_NEAR(limit("C", 0.0, 0.0).speed_mps, 0.05, 1e-9);
  EXPECT_EQ(limit("C", 0.51, 0.0).bend_ahead_m, nothing) << "beyond half a metre";
  EXPECT_NEAR(limit("C", 0.49, 0.0).bend_ahead_m, 0.49, 1e-9);
  const Limit straight_on = limit("S", 0.1, 0.3);
  EXPECT_EQ(straight_on.bend_ahead_m, nothing);
  EXPECT_EQ(straight_on.speed_mps, target_speed.speed_mps);
}

TEST(Envelope, keeps_to_the_limits_of_all_edges_of_its_base) {
  auto text = order("O").through({"loop_se@0", "loop_se@283", "loop_se@565"}).then({"loop_se@848", "loop_se@1131"});
  text.edge(0).max_speed_mps = 0.3;
  text.edge(1).max_speed_mps = 0.35;
  text.edge(2).max_speed_mps = 0.05;  // behind the base
  EXPECT_NEAR((Scene{"loop_se", 0.05, text}.limit().speed_mps), 0.3, 1e-12);
  text.edge(0).max_speed_mps.reset();
  EXPECT_NEAR((Scene{"loop_se", 0.1, text}.limit().speed_mps),
              std::fmin(0.5, std::sqrt(0.35 * 0.35 + 1.6 * (0.282743338823 - 0.1 - 0.35 * 0.08))), 1e-6);
}

// --- the branch that the board is to take -------------------------------------------------------------------------

/// The branch that is chosen by a vehicle that has driven `driven_m` of an order from a position on.
int chosen_branch(const zone::TrafficZone& zone, const zone::TrackPosition& from, const wire::Order& order,
                  double driven_m) {
  PositionEstimator position{zone};
  position.position_at(from);
  OrderBook book{zone};
  EXPECT_TRUE(book.offer(order, {from, true}));
  position.follow(book.course_from(position.track_position()));
  wire::Odometry odometry;
  for (int i = 0; i <= 100; ++i) {
    odometry.distance_um = std::llround(1e4 * driven_m * i);
    static_cast<void>(position.on_odometry(odometry));
  }
  book.travelled(driven_m);
  return int{choose_branch(zone.circuit, position, book)};
}
/// Of an order from the start of section 0 to "end".
int chosen_branch(const zone::TrafficZone& zone, double driven_m) {
  return chosen_branch(zone, {0, 0.0}, order("O").through({"start", "end"}), driven_m);
}

TEST(BranchChoice, is_that_of_the_order_from_its_base_to_ten_centimetres_beyond_the_fork) {
  const zone::TrafficZone& zone = test::diamond();
  const auto branch = [&](const char* node, double driven_m, std::vector<std::string> horizon = {}) {
    return chosen_branch(zone, at(zone, "trunk", 1.0), order("O").through({"T1", "F", node}).then(horizon), driven_m);
  };
  EXPECT_EQ(branch("lo", 0.0), 0);
  EXPECT_EQ(branch("ro", 0.0), 1);
  EXPECT_EQ(branch("ro", 0.9), 1);
  EXPECT_EQ(branch("lo", 1.09), 0);
  EXPECT_EQ(branch("ro", 1.09), 1);
  EXPECT_EQ(branch("ro", 1.11), int{wire::no_branch});
  // A base that ends at the fork leads over no branch.
  PositionEstimator position{zone};
  OrderBook book{zone};
  EXPECT_EQ(choose_branch(zone.circuit, position, book), wire::no_branch) << "the position is unknown";
  position.position_at(at(zone, "trunk", 1.0));
  ASSERT_TRUE(book.offer(order("O").through({"T1", "F"}).then({"ro"}), {at(zone, "trunk", 1.0), true}));
  position.follow(book.course_from(position.track_position()));
  EXPECT_EQ(choose_branch(zone.circuit, position, book), wire::no_branch);
}

TEST(BranchChoice, is_none_for_a_vehicle_that_overshoots_the_fork_at_the_end_of_its_base) {
  const zone::TrafficZone& zone = test::diamond();
  const auto base_to_the_fork = order("O").through({"T1", "F"});
  for (const double driven_m : {0.95, 0.999, 1.003, 1.02})
    EXPECT_EQ(chosen_branch(zone, at(zone, "trunk", 1.0), base_to_the_fork, driven_m), int{wire::no_branch})
        << driven_m;
}

// --- limits that are met exactly ----------------------------------------------------------------------------------

TEST(CrossingLookAhead, counts_a_crossing_at_its_reach_and_none_at_whose_begin_the_vehicle_is) {
  const auto zone = with_spans({{0, 1.0, 1.5}}, {{5.0}}, false);
  EXPECT_EQ(CrossingLookAhead{zone}.first({0, 0.5}, 0.5).entry_m, 0.5);
  EXPECT_EQ(CrossingLookAhead{zone}.first({0, 0.5}, 0.4999).entry_m, nothing);
  EXPECT_EQ(CrossingLookAhead{zone}.first({0, 1.0}, 1.0).entry_m, nothing);
  EXPECT_EQ(CrossingLookAhead{zone}.first({0, 1.5}, 1.0).entry_m, nothing);
  const auto behind_joint = with_spans({{1, 0.0, 0.25}}, {{1.0}, {1.0}}, false);
  EXPECT_EQ(CrossingLookAhead{behind_joint}.first({0, 0.5}, 0.5).entry_m, 0.5);
}

TEST(CrossingLookAhead, ends_a_chain_where_a_vehicle_has_exactly_the_room_to_stop) {
  // A vehicle of 0.15 m needs 0.25 m.
  auto zone = with_spans({{0, 1.0, 1.25}, {0, 1.5, 1.75}}, {{5.0}}, false);
  zone.vehicle.length_m = 0.15;
  ASSERT_EQ(zone::stopping_room_m(zone.vehicle), 0.25);
  EXPECT_EQ(CrossingLookAhead{zone}.first({0, 0.5}, 1.0).exit_m, 0.75);
}

TEST(CrossingLookAhead, takes_a_crossing_inside_another_one_for_a_part_of_it) {
  const auto zone = with_spans({{0, 1.25, 1.5}, {0, 1.0, 2.0}, {0, 3.0, 3.5}}, {{5.0}}, false);
  const auto chain = CrossingLookAhead{zone}.first({0, 0.5}, 1.0);
  EXPECT_EQ(chain.entry_m, 0.5);
  EXPECT_EQ(chain.exit_m, 1.5);
  // From inside, the next one is the one behind.
  EXPECT_EQ((CrossingLookAhead{zone}.first({0, 1.75}, 2.0).entry_m), 1.25);
}

/// The limit of a vehicle at 0.5 m on a lane of 5 m with a crossing from 1.0 m to 1.5 m, whose base ends at `end_m`.
Limit on_lane(double end_m, const zone::SpeedProfile& by, double s_m = 0.5) {
  zone::TrafficZone zone = test::graph("lane", {{"lane", {}, 5.0, 0.0, {}}},
                                       {{"here", {0, s_m}}, {"end", {0, end_m}}, {"announced", {0, 4.5}}});
  zone.crossings.push_back({"X", {}, {{0, 1.0, 1.5}}});
  OrderBook book{zone};
  EXPECT_TRUE(book.offer(order("O").through({"here", "end"}).then({"announced"}), {{0, s_m}, true}));
  return Envelope{zone}.limit({Outlook{0, s_m}, 0.3, nothing, book}, by);
}

TEST(Envelope, lets_a_base_lead_through_a_crossing_up_to_five_millimetres_before_its_exit) {
  const auto to_closed_crossing_m = [](double base_end_m) {
    const auto [speed_mps, braking_mps2, by_obstacle, crossing_m, bend_m, end_m] = on_lane(base_end_m, target_speed);
    return crossing_m;
  };
  EXPECT_EQ(to_closed_crossing_m(1.496), nothing);
  EXPECT_EQ(to_closed_crossing_m(1.494), 0.5);
  EXPECT_EQ(to_closed_crossing_m(2.0), nothing);
}

TEST(Envelope, stops_at_the_nearer_of_stop_line_and_end_of_base) {
  constexpr zone::SpeedProfile racing{.speed_mps = 5.0, .acceleration_mps2 = 0.5, .braking_mps2 = 0.8};
  EXPECT_NEAR(on_lane(0.6, racing).speed_mps, stoppable_speed(0.1, 0.8, 0.08), 1e-9);
  EXPECT_NEAR(on_lane(1.0, racing).speed_mps, stoppable_speed(0.5, 0.8, 0.08), 1e-9) << "a base that ends at the entry";
  EXPECT_NEAR(on_lane(1.25, racing).speed_mps, stoppable_speed(0.5 - 0.01, 0.8, 0.08), 1e-9);
  EXPECT_EQ(on_lane(1.25, racing, 0.995).speed_mps, 0.0) << "the vehicle is beyond the stop line";
}

TEST(Envelope, states_where_the_vehicle_must_stop_whatever_happens) {
  EXPECT_NEAR(on_lane(0.6, target_speed).end_m, 0.1, 1e-9) << "the end of its base";
  EXPECT_NEAR(on_lane(1.25, target_speed).end_m, 0.5 - 0.01, 1e-9) << "the stop line of the crossing in which it ends";
  EXPECT_NEAR(on_lane(2.0, target_speed).end_m, 1.5, 1e-9) << "beyond the crossing";
}

// --- forks that are near or far --------------------------------------------------------------------------------------

TEST(BranchChoice, needs_a_base_that_ends_over_five_millimetres_behind_the_fork) {
  for (const double beyond_m : {0.004, 0.006}) {
    zone::TrafficZone zone = test::diamond();
    zone.waypoints = std::vector<zone::Waypoint>{{"start", {0, 0.0}}, {"end", {4, beyond_m}}};
    EXPECT_EQ(chosen_branch(zone, 0.0), beyond_m < 0.005 ? int{wire::no_branch} : 1) << beyond_m;
  }
}

TEST(BranchChoice, finds_a_fork_behind_sections_that_end_within_three_metres) {
  const zone::TrafficZone zone = test::graph("far",
                                             {{"first", {0.0, 0.0, 0.0}, 2.0, 0.0, {1}},
                                              {"second", {2.0, 0.0, 0.0}, 2.0, 0.0, {2}},
                                              {"third", {4.0, 0.0, 0.0}, 2.0, 0.0, {3, 4}},
                                              {"on", {6.0, 0.0, 0.0}, 2.0, 0.0, {}},
                                              {"left", {6.0, 0.0, 0.0}, 2.0, 0.5, {}}},
                                             {{"start", {0, 0.0}}, {"end", {4, 1.0}}});
  EXPECT_EQ(chosen_branch(zone, 0.9), int{wire::no_branch}) << "the section that ends 3.1 m ahead is no fork";
  EXPECT_EQ(chosen_branch(zone, 1.1), 1);
}

TEST(BranchChoice, changes_to_the_next_fork_halfway_between_two_that_are_near_to_each_other) {
  const zone::TrafficZone zone = test::graph("comb",
                                             {{"stem", {0.0, 0.0, 0.0}, 1.0, 0.0, {1, 2}},
                                              {"between", {1.0, 0.0, 0.0}, 0.12, 0.0, {3, 4}},
                                              {"left", {1.0, 0.0, 0.0}, 1.0, 0.5, {}},
                                              {"on", {1.12, 0.0, 0.0}, 1.0, 0.0, {}},
                                              {"right", {1.12, 0.0, 0.0}, 1.0, -0.5, {}}},
                                             {{"start", {0, 0.0}}, {"end", {4, 0.5}}});
  EXPECT_EQ(chosen_branch(zone, 0.9), 0);
  EXPECT_EQ(chosen_branch(zone, 1.055), 0);
  EXPECT_EQ(chosen_branch(zone, 1.065), 1);
  EXPECT_EQ(chosen_branch(zone, 1.2), 1);
  EXPECT_EQ(chosen_branch(zone, 1.23), int{wire::no_branch});
}

TEST(BranchChoice, is_that_of_the_next_of_two_forks_exactly_halfway_between_them) {
  const zone::TrafficZone zone = test::graph("comb",
                                             {{"stem", {0.0, 0.0, 0.0}, 1.0, 0.0, {1, 2}},
                                              {"between", {1.0, 0.0, 0.0}, 0.125, 0.0, {3, 4}},
                                              {"left", {1.0, 0.0, 0.0}, 1.0, 0.5, {}},
                                              {"on", {1.125, 0.0, 0.0}, 1.0, 0.0, {}},
                                              {"right", {1.125, 0.0, 0.0}, 1.0, -0.5, {}}},
                                             {{"start", {0, 0.0}}, {"end", {4, 0.5}}});
  PositionEstimator position{zone};
  position.position_at({0, 0.0});
  OrderBook book{zone};
  ASSERT_TRUE(book.offer(order("O").through({"start", "end"}), {{0, 0.0}, true}));
  position.follow(book.course_from(position.track_position()));
  position.position_at({1, 0.0624});
  EXPECT_EQ(int{choose_branch(zone.circuit, position, book)}, 0);
  position.position_at({1, 0.0625});
  EXPECT_EQ(int{choose_branch(zone.circuit, position, book)}, 1);
}

}  // namespace
}  // namespace cosiva::aiv
