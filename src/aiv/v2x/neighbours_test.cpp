#include "cosiva/aiv/v2x/neighbours.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cosiva/aiv/testing/test_orders.h"
#include "cosiva/aiv/testing/test_senses.h"
#include "cosiva/aiv/testing/test_zone.h"
#include "cosiva/base/random.h"

namespace cosiva::aiv {
namespace {

using namespace std::chrono_literals;
using test::at;
using test::lacet4;
using test::order;
using Verdict = Neighbours::Verdict;

constexpr double infinite = std::numeric_limits<double>::infinity();
const wire::VehicleId me{"CoSiVA", "AIV1"};

/// A vehicle that approaches the crossings of the clover's eastward straight and may not enter them yet, and the
/// intents that it receives.
struct Ear {
  Agent agent{lacet4()};
  Neighbours neighbours{lacet4(), me};
  SimTime now{virtual_epoch};
  std::uint32_t header{0};

  explicit Ear(double s_m = 0.1) {
    agent.vehicle().estimator().position_at(at(lacet4(), "east", s_m));
    EXPECT_TRUE(
        agent.vehicle().take_order(order("O-1").through({"east@0", "east@190", "east@380"}).then({"east@1120"})));
    static_cast<void>(agent.decide());
  }

  /// Of another vehicle at this position.
  [[nodiscard]] wire::Intent one_at(zone::TrackPosition track_position, double speed_mps,
                                    const std::string& serial = "AIV2") {
    wire::Intent intent;
    intent.header_id = ++header;
    intent.map_id = "lacet4";
    intent.vehicle = {"CoSiVA", serial};
    intent.pose = lacet4().circuit.pose_at(track_position);
    intent.speed_mps = speed_mps;
    return intent;
  }
  /// Of a vehicle that approaches the same crossings from the south.
  [[nodiscard]] wire::Intent rival(double arrival_s, bool may_enter, double departure_s,
                                   const std::string& serial = "AIV2") {
    wire::Intent intent = one_at(at(lacet4(), "north", 0.2), 0.3, serial);
    for (const CrossingSpan& crossing_span : crossings()) {
      intent.crossings = {
          {lacet4().crossings[crossing_span.crossing].name, 0.2, 0.6, arrival_s, departure_s, may_enter}};
    }
    return intent;
  }
  [[nodiscard]] std::vector<CrossingSpan> crossings() const {
    std::vector<CrossingSpan> out;
    CrossingFinder{lacet4()}.ahead(agent.vehicle().position().outlook(), 1.0, 8, out);
    return out;
  }
  Verdict receive(wire::Intent intent) {
    const wire::V2xTopic topic{"lacet4", wire::cell_of(position(intent.pose)), intent.vehicle};
    return neighbours.receive(now, topic, std::make_shared<const wire::Intent>(std::move(intent)),
                              position(agent.vehicle().position().pose()));
  }
  Others around() { return neighbours.around(now, agent); }
};

TEST(Neighbours, keep_the_newest_intent_of_each_vehicle_for_a_second) {
  Ear ear;
  EXPECT_EQ(ear.receive(ear.one_at(at(lacet4(), "east", 0.5), 0.2)), Verdict::first);
  ear.now += 200ms;
  EXPECT_EQ(ear.receive(ear.one_at(at(lacet4(), "east", 0.54), 0.2)), Verdict::taken);
  EXPECT_EQ(ear.neighbours.size(), 1U);
  ear.now += 1000ms;
  ear.neighbours.age(ear.now);
  EXPECT_EQ(ear.neighbours.size(), 1U);
  ear.now += 1ms;
  ear.neighbours.age(ear.now);
  EXPECT_TRUE(ear.neighbours.empty());
}

TEST(Neighbours, recognise_repeated_and_late_intents) {
  Ear ear;
  const wire::Intent first = ear.one_at(at(lacet4(), "east", 0.5), 0.2);
  const wire::Intent second = ear.one_at(at(lacet4(), "east", 0.54), 0.2);
  EXPECT_EQ(ear.receive(second), Verdict::first);
  EXPECT_EQ(ear.receive(second), Verdict::old);
  EXPECT_EQ(ear.receive(first), Verdict::old);
  wire::Intent wrapped = second;
  wrapped.header_id = 4294967290U;
  Ear other;
  EXPECT_EQ(other.receive(wrapped), Verdict::first);
  wrapped.header_id = 3;
  EXPECT_EQ(other.receive(wrapped), Verdict::taken) << "the counter wraps";
}

TEST(Neighbours, do_not_read_the_clocks_of_senders) {
  Ear ear;
  wire::Intent intent = ear.one_at(at(lacet4(), "east", 0.5), 0.2);
  intent.timestamp = ear.now + std::chrono::hours{24 * 365};
  EXPECT_EQ(ear.receive(intent), Verdict::first);
  ear.now += 1001ms;
  ear.neighbours.age(ear.now);
  EXPECT_TRUE(ear.neighbours.empty());
}

TEST(Neighbours, refuse_implausible_intents) {
  Ear ear;
  const zone::TrackPosition there = at(lacet4(), "east", 0.5);
  wire::Intent own = ear.one_at(there, 0.2, "AIV1");
  EXPECT_EQ(ear.receive(own), Verdict::own);
  wire::Intent other_map = ear.one_at(there, 0.2);
  other_map.map_id = "indus8";
  EXPECT_EQ(ear.receive(other_map), Verdict::other_map);
  wire::Intent far = ear.one_at(there, 0.2);
  far.pose.x_m = 40.0;
  EXPECT_EQ(ear.receive(far), Verdict::far);
  EXPECT_EQ(ear.receive(ear.one_at(there, 20.0)), Verdict::implausible) << "forty times the fast profile";
  EXPECT_EQ(ear.receive(ear.one_at(there, std::nan(""))), Verdict::implausible);
  const auto elsewhere = std::make_shared<const wire::Intent>(ear.one_at(there, 0.2));
  EXPECT_EQ(ear.neighbours.receive(ear.now, {"lacet4", {2, 2}, elsewhere->vehicle}, elsewhere, {}),
            Verdict::implausible)
      << "published in a cell in which the sender is not";
  EXPECT_EQ(ear.neighbours.receive(ear.now, {"lacet4", wire::cell_of(position(elsewhere->pose)), {"CoSiVA", "AIV9"}},
                                   elsewhere, {}),
            Verdict::implausible)
      << "under the name of another vehicle";
  EXPECT_TRUE(ear.neighbours.empty());
}

TEST(Neighbours, discard_a_vehicle_that_leaps) {
  Ear ear;
  EXPECT_EQ(ear.receive(ear.one_at(at(lacet4(), "east", 0.5), 0.2)), Verdict::first);
  ear.now += 200ms;
  EXPECT_EQ(ear.receive(ear.one_at(at(lacet4(), "west", 0.1), 0.2)), Verdict::implausible);
  EXPECT_TRUE(ear.neighbours.empty()) << "neither of the two is known to be right";
}

TEST(Neighbours, keep_the_nearest_of_too_many_vehicles) {
  Ear ear;
  const Point2 here = position(ear.agent.vehicle().position().pose());
  for (int i = 0; i < 5000; ++i) {
    wire::Intent intent = ear.one_at(at(lacet4(), "east", 0.5), 0.0, "S" + std::to_string(i));
    intent.pose = {here.x_m + 0.5 + 0.001 * ((i * 37) % 5000), here.y_m, 0.0};
    ear.receive(std::move(intent));
    ASSERT_LE(ear.neighbours.size(), 32U);
  }
  wire::Intent near = ear.one_at(at(lacet4(), "east", 0.45), 0.1);
  EXPECT_EQ(ear.receive(near), Verdict::first);
  EXPECT_EQ(ear.neighbours.size(), 32U);
}

TEST(Neighbours, give_the_speed_of_the_leader) {
  Ear ear;
  ear.receive(ear.one_at(at(lacet4(), "east", 0.6), 0.25));
  EXPECT_EQ(ear.around().leader_gap_m, infinite) << "no body is detected";
  ear.agent.perceive(0.3);
  const Others others = ear.around();
  EXPECT_NEAR(others.leader_gap_m, 0.5 - 0.2, 0.01);
  ASSERT_TRUE(others.leader_mps);
  EXPECT_NEAR(*others.leader_mps, 0.25, 0.02);
}

TEST(Neighbours, extrapolate_the_leader_for_half_a_second_at_most) {
  Ear ear;
  ear.agent.perceive(0.3);
  ear.receive(ear.one_at(at(lacet4(), "east", 0.6), 0.2));
  ear.now += 300ms;
  EXPECT_NEAR(ear.around().leader_gap_m, 0.3 + 0.06, 0.01);
  ear.now += 600ms;
  EXPECT_NEAR(ear.around().leader_gap_m, 0.3 + 0.1, 0.01);
}

TEST(Neighbours, find_no_leader_off_the_path_or_behind) {
  Ear ear{0.1};
  ear.agent.perceive(0.3);
  ear.receive(ear.one_at(at(lacet4(), "loop_sw", 2.7), 0.3));
  ear.receive(ear.one_at(at(lacet4(), "west", 0.9), 0.3, "AIV3"));
  EXPECT_EQ(ear.around().leader_gap_m, infinite);
}

TEST(Neighbours, give_the_margin_of_a_rival) {
  Ear ear;
  const double own_s = earliest_s(ear.agent.decision().crossing_ahead_m, 0.0, lacet4().profiles.medium);
  wire::Intent higher = ear.rival(own_s + 1.5, false, own_s + 3.0);
  higher.priority = 1;
  ear.receive(higher);
  EXPECT_NEAR(ear.around().crossing_margin_s, 1.5, 1e-9);
  ear.now += 500ms;
  EXPECT_NEAR(ear.around().crossing_margin_s, 1.0, 1e-9) << "the rival comes nearer between its messages";
  ear.receive(ear.rival(own_s - 1.0, false, own_s + 3.0, "AIV3"));
  EXPECT_NEAR(ear.around().crossing_margin_s, -1.0, 1e-9) << "the most urgent rival counts";
}

TEST(Neighbours, let_the_first_of_two_equals_approach_as_if_alone) {
  Ear ear;
  const double own_s = earliest_s(ear.agent.decision().crossing_ahead_m, 0.0, lacet4().profiles.medium);
  ear.receive(ear.rival(own_s + 0.5, false, own_s + 3.0));
  EXPECT_EQ(ear.around().crossing_margin_s, infinite);
}

TEST(Neighbours, do_not_wait_for_a_stopped_vehicle_that_may_not_enter) {
  Ear ear;
  wire::Intent is_stopped = ear.rival(0.1, false, 9.0);
  is_stopped.speed_mps = 0.0;
  ear.receive(is_stopped);
  EXPECT_EQ(ear.around().crossing_margin_s, infinite);
}

TEST(Neighbours, yield_to_a_vehicle_that_may_enter_only_while_it_obstructs) {
  const double slow_s = Ear{}.agent.decision().crossing_ahead_m / lacet4().profiles.slow.speed_mps;
  Ear early;
  early.receive(early.rival(0.2, true, slow_s - 0.1));
  EXPECT_EQ(early.around().crossing_margin_s, infinite) << "the rival has left before the vehicle arrives, even slowly";
  Ear late;
  late.receive(late.rival(0.2, true, slow_s + 1.0));
  EXPECT_NEAR(late.around().crossing_margin_s, -1.0, 1e-9);
  EXPECT_EQ(late.around().crossing_priority, -1.0);
}

TEST(Neighbours, weigh_priorities_and_ignore_other_crossings) {
  Ear ear;
  wire::Intent rival = ear.rival(2.0, false, 3.0);
  rival.priority = 5;
  ear.receive(rival);
  EXPECT_EQ(ear.around().crossing_priority, -1.0);
  Ear other;
  rival.crossings.front().name = "no crossing of this path";
  other.receive(rival);
  EXPECT_EQ(other.around().crossing_margin_s, infinite);
}

TEST(Neighbours, do_not_matter_to_a_vehicle_that_may_enter) {
  Ear ear;
  EXPECT_TRUE(ear.agent.vehicle().take_order(
      order("O-1", 1).from_sequence(4).through({"east@380", "east@1120"}).then({"east@1310"})));
  static_cast<void>(ear.agent.decide());
  EXPECT_EQ(ear.agent.decision().crossing_ahead_m, infinite);
  ear.receive(ear.rival(0.1, true, 9.0));
  EXPECT_EQ(ear.around().crossing_margin_s, infinite);
}

TEST(Neighbours, have_limits_of_speed_distance_and_leaps) {
  const zone::TrackPosition there = at(lacet4(), "east", 0.5);
  // Three times the fast profile's 0.5 m/s.
  for (const double speed_mps : {1.499, -1.499, 1.501, -1.501}) {
    Ear ear;
    EXPECT_EQ(ear.receive(ear.one_at(there, speed_mps)),
              std::fabs(speed_mps) < 1.5 ? Verdict::first : Verdict::implausible);
  }
  // Two cells of 3 m and four slacks of 0.3 m along an axis.
  for (const Point2 off : {Point2{7.19, 0.0}, {-7.19, 7.19}, {0.0, 7.21}, {-7.21, 0.0}}) {
    Ear ear;
    wire::Intent intent = ear.one_at(there, 0.2);
    const Point2 own = position(ear.agent.vehicle().position().pose());
    intent.pose = {own.x_m + off.x_m, own.y_m + off.y_m, 0.0};
    EXPECT_EQ(ear.receive(intent),
              std::fmax(std::fabs(off.x_m), std::fabs(off.y_m)) < 7.2 ? Verdict::first : Verdict::far);
  }
  // Twice the slack outside the cell in which the message was sent.
  for (const double outside_m : {0.59, 0.61}) {
    Ear ear;
    wire::Intent intent = ear.one_at(there, 0.2);
    const wire::Cell cell = wire::cell_of(position(intent.pose));
    while (wire::outside_cell_m(cell, position(intent.pose)) < outside_m) intent.pose.x_m += 1e-4;
    const auto sent = std::make_shared<const wire::Intent>(intent);
    EXPECT_EQ(ear.neighbours.receive(ear.now, {"lacet4", cell, sent->vehicle}, sent, {}),
              outside_m < 0.6 ? Verdict::first : Verdict::implausible);
  }
  // Half a metre, and 0.2 s at 1.5 m/s.
  for (const double leap_m : {0.799, 0.801}) {
    Ear ear;
    ear.receive(ear.one_at(there, 0.2));
    ear.now += 200ms;
    wire::Intent next = ear.one_at(there, 0.2);
    next.pose.x_m += leap_m;
    EXPECT_EQ(ear.receive(next), leap_m < 0.8 ? Verdict::taken : Verdict::implausible);
    EXPECT_EQ(ear.neighbours.empty(), leap_m > 0.8);
  }
}

TEST(Neighbours, are_discarded_when_the_clock_is_set_back) {
  Ear ear;
  ear.receive(ear.one_at(at(lacet4(), "east", 0.5), 0.2));
  ear.now -= 1ms;
  ear.neighbours.age(ear.now);
  EXPECT_TRUE(ear.neighbours.empty());
}

TEST(Neighbours, replace_the_furthest_by_a_nearer_one) {
  Ear ear;
  Neighbours two{lacet4(), me, {.count_max = 2}};
  const auto receive = [&](const char* serial, double away_m) {
    wire::Intent intent = ear.one_at(at(lacet4(), "east", 0.5), 0.0, serial);
    intent.pose = {away_m, 0.0, 0.0};
    const wire::V2xTopic topic{"lacet4", wire::cell_of(position(intent.pose)), intent.vehicle};
    return two.receive(ear.now, topic, std::make_shared<const wire::Intent>(intent), {});
  };
  EXPECT_EQ(receive("B", 1.0), Verdict::first);
  EXPECT_EQ(receive("C", -2.0), Verdict::first);
  EXPECT_EQ(receive("A", 2.0), Verdict::crowded) << "as far as the furthest";
  EXPECT_EQ(receive("A", 1.9), Verdict::first);
  EXPECT_EQ(two.size(), 2U);
  EXPECT_EQ(receive("C", -2.0), Verdict::crowded) << "it has been replaced";
  EXPECT_EQ(receive("B", 1.0), Verdict::taken);
}

TEST(Neighbours, count_a_rival_by_all_its_crossings_of_the_chain) {
  Ear ear;
  const double stop_m = ear.agent.decision().crossing_ahead_m;
  const double own_s = earliest_s(stop_m, 0.0, lacet4().profiles.medium);
  const double slow_s = stop_m / lacet4().profiles.slow.speed_mps;
  const auto chain = ear.crossings();
  ASSERT_EQ(chain.size(), 2U);
  const auto name = [&](std::size_t i) { return lacet4().crossings[chain[i].crossing].name; };
  wire::Intent rival = ear.rival(0.0, false, 0.0);
  rival.priority = 3;
  rival.crossings = {{name(0), 0.2, 0.6, own_s - 0.5, own_s + 1.0, false},
                     {name(1), 0.2, 0.6, own_s - 0.2, slow_s + 2.0, false},
                     {"elsewhere", 0.2, 0.6, 0.0, 999.0, true}};
  ear.receive(rival);
  EXPECT_NEAR(ear.around().crossing_margin_s, -0.5, 1e-9) << "the first arrival";
  EXPECT_EQ(ear.around().crossing_priority, -1.0);
  // One that may enter one of them: until the last departure.
  Ear late;
  rival.crossings[1].may_enter = true;
  late.receive(rival);
  EXPECT_NEAR(late.around().crossing_margin_s, -2.0, 1e-9);
  EXPECT_EQ(late.around().crossing_priority, -1.0);
}

TEST(Neighbours, wait_for_a_rival_that_moves_and_of_equals_for_the_earlier_one) {
  const double own_s = earliest_s(Ear{}.agent.decision().crossing_ahead_m, 0.0, lacet4().profiles.medium);
  struct Case {
    double speed_mps;
    double margin_s;
    std::uint32_t priority;
    bool counts;
  };
  for (const Case& one : {Case{0.021, -0.1, 0, true},
                          {-0.021, -0.1, 0, true},
                          {0.019, -0.1, 0, false},
                          {0.3, 0.1, 0, false},
                          {0.3, 0.1, 1, true}}) {
    Ear ear;
    wire::Intent rival = ear.rival(own_s + one.margin_s, false, own_s + 30.0);
    rival.speed_mps = one.speed_mps;
    rival.priority = one.priority;
    ear.receive(rival);
    EXPECT_EQ(std::isfinite(ear.around().crossing_margin_s), one.counts) << one.speed_mps << " " << one.priority;
  }
}

TEST(Neighbours, of_lower_priority_let_the_vehicle_go_first) {
  zone::TrafficZone zone = lacet4();
  zone.priorities = {{wire::to_string(me), 5}};
  for (const std::uint32_t priority : {4U, 5U, 6U}) {
    Ear ear;
    const double own_s = earliest_s(ear.agent.decision().crossing_ahead_m, 0.0, lacet4().profiles.medium);
    Neighbours neighbours{zone, me};
    wire::Intent rival = ear.rival(own_s - 0.2, false, own_s + 30.0);
    rival.priority = priority;
    const wire::V2xTopic topic{"lacet4", wire::cell_of(position(rival.pose)), rival.vehicle};
    neighbours.receive(ear.now, topic, std::make_shared<const wire::Intent>(rival), {});
    const Others others = neighbours.around(ear.now, ear.agent);
    EXPECT_EQ(others.crossing_priority, 5.0 - priority);
    EXPECT_NEAR(others.crossing_margin_s, -0.2, 1e-9);
  }
}

TEST(Neighbours, take_the_nearest_body_for_the_leader) {
  Ear ear;
  ear.agent.perceive(0.3);
  ear.receive(ear.one_at(at(lacet4(), "east", 0.6), 0.1, "AIV4"));
  ear.receive(ear.one_at(at(lacet4(), "east", 0.9), 0.3, "AIV2"));
  ear.receive(ear.one_at(at(lacet4(), "east", 0.8), 0.2, "AIV5"));
  // A body of 0.2 m, of which both ends are round with half the width.
  EXPECT_NEAR(ear.around().leader_gap_m, 0.3, 1e-6);
  EXPECT_NEAR(*ear.around().leader_mps, 0.1, 1e-6);
}

TEST(Neighbours, are_part_of_the_digest) {
  const auto digest_of = [](const std::string& serial, std::uint32_t header_id, SimDuration later) {
    Ear ear;
    ear.now += later;
    wire::Intent intent = ear.one_at(at(lacet4(), "east", 0.5), 0.2, serial);
    intent.header_id = header_id;
    ear.receive(std::move(intent));
    Digest digest;
    ear.neighbours.fold(digest);
    return digest.value();
  };
  const auto usual = digest_of("AIV2", 7, 0ms);
  EXPECT_EQ(usual, digest_of("AIV2", 7, 0ms));
  EXPECT_NE(usual, digest_of("AIV3", 7, 0ms));
  EXPECT_NE(usual, digest_of("AIV2", 8, 0ms));
  EXPECT_NE(usual, digest_of("AIV2", 7, 20ms));
  Digest none;
  Ear{}.neighbours.fold(none);
  EXPECT_NE(usual, none.value());
}

TEST(Neighbours, name_their_verdicts) {
  const std::vector<std::string_view> names{"taken",
                                            "received for the first time",
                                            "old",
                                            "published under this vehicle's own name",
                                            "published for another map",
                                            "published from beyond the range of reception",
                                            "the reported pose or speed is impossible",
                                            "more vehicles are near than are stored",
                                            "?"};
  for (std::size_t i = 0; i < names.size(); ++i) EXPECT_EQ(to_string(static_cast<Verdict>(i)), names[i]);
}

/// For any intents all results are safe: every number is valid, and the number of stored intents is bounded.
TEST(Neighbours, handle_any_intent_that_can_be_decoded) {
  EXPECT_TRUE(rc::check([](std::uint64_t seed) {
    Random random{seed, "lies"};
    Ear ear;
    ear.agent.perceive(0.3);
    for (int i = 0; i < 60; ++i) {
      wire::Intent lie =
          ear.rival(random.uniform(0.0, 3600.0), random.chance(0.5), 3600.0, "S" + std::to_string(random.next() % 50));
      lie.header_id = static_cast<std::uint32_t>(random.next());
      lie.pose = {random.uniform(-8.0, 8.0), random.uniform(-8.0, 8.0), random.uniform(-3.14, 3.14)};
      lie.speed_mps = random.uniform(-3.0, 3.0);
      ear.receive(std::move(lie));
      ear.now += 20ms;
      const Others others = ear.around();
      RC_ASSERT(others.leader_gap_m >= 0.0);
      RC_ASSERT(!others.leader_mps || std::isfinite(*others.leader_mps));
      RC_ASSERT(!std::isnan(others.crossing_margin_s));
      RC_ASSERT(ear.neighbours.size() <= 32U);
    }
  }));
}

// --- use of the results by the agent ------------------------------------------------------------------------------

/// Records the situation it is called with, and chooses medium.
struct Requested final : SpeedPolicy {
  explicit Requested(Situation& out) : situation{out} {}
  [[nodiscard]] SpeedChoice target(const Situation& requested) const override {
    if (std::isfinite(requested.obstacle_ahead_m)) situation = requested;  // not the evaluation without the body
    return {Profile::medium};
  }
  Situation& situation;
};

void inform(Agent& agent, const Others& others) { agent.heed(others); }

TEST(Heeding, accepts_a_leader_only_where_its_sensors_detect_a_body) {
  Situation requested{};
  Agent agent{lacet4(), std::make_unique<Requested>(requested)};
  agent.vehicle().estimator().position_at(at(lacet4(), "east", 0.1));
  EXPECT_TRUE(agent.vehicle().take_order(order("O-1").through({"east@0", "east@190", "east@380"}).then({"east@1120"})));
  inform(agent, {.leader_gap_m = 0.40, .leader_mps = 0.25});
  static_cast<void>(agent.decide());
  EXPECT_FALSE(requested.closing_mps) << "no body is detected there";
  agent.perceive(0.45);
  static_cast<void>(agent.decide());
  ASSERT_TRUE(requested.closing_mps);
  EXPECT_NEAR(*requested.closing_mps, -0.25, 1e-9);
  agent.perceive(0.20);
  static_cast<void>(agent.decide());
  EXPECT_FALSE(requested.closing_mps) << "the detected body is another one";
}

TEST(Heeding, never_drives_faster_than_the_envelope_for_any_intents) {
  EXPECT_TRUE(rc::check([](std::uint64_t seed) {
    Random random{seed, "heeding"};
    Agent reported{lacet4()};
    Agent alone{lacet4()};
    const double s_m = random.uniform(0.0, 0.1);
    const double gap_m = random.uniform(0.0, 1.0);
    for (Agent* agent : {&reported, &alone}) {
      agent->vehicle().estimator().position_at(at(lacet4(), "east", s_m));
      RC_ASSERT(
          agent->vehicle().take_order(order("O-1").through({"east@0", "east@190", "east@380"}).then({"east@1120"})));
      agent->perceive(gap_m);
    }
    inform(reported, {.leader_gap_m = random.uniform(0.0, 1.0),
                      .leader_mps = random.uniform(-2.0, 2.0),
                      .crossing_margin_s = random.uniform(-20.0, 20.0),
                      .crossing_priority = random.uniform(-1.0, 1.0)});
    RC_ASSERT(reported.decide().speed_mmps <= alone.decide().speed_mmps);
  }));
}

}  // namespace
}  // namespace cosiva::aiv
