#include "cosiva/aiv/motion/motion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "cosiva/aiv/testing/test_graphs.h"
#include "cosiva/aiv/testing/test_zone.h"
#include "cosiva/base/math.h"
#include "cosiva/zone/testing/test_shapes.h"

namespace cosiva::aiv {
namespace {

using ::testing::Contains;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using Event = TravelDir::Event;
using State = TravelDir::State;
using test::lay;
using test::Piece;

constexpr double lap_m = 1e-9;

/// A stadium: two straights of 2 m, two half circles of radius 0.5 m.
zone::Circuit stadium() {
  const Piece straight{2.0};
  const Piece bend{0.5 * pi, 2.0};
  return lay({straight, bend, straight, bend}, true);
}

double whole(int low, int high, double unit) { return unit * *rc::gen::inRange(low, high); }

/// Arbitrary pieces that together turn by an integer fraction of a full turn, repeated as often as that fraction
/// requires: such a loop closes, because the repetitions cancel the offset of one round of pieces.
zone::Circuit any_loop() {
  const int folds = *rc::gen::inRange(2, 6);
  const int count = *rc::gen::inRange(1, 6);
  std::vector<Piece> round;
  double turned_rad = 0.0;
  for (int i = 0; i < count; ++i) {
    Piece piece{whole(1, 3000, 1e-3)};
    const int kind = *rc::gen::inRange(0, 3);
    if (kind > 0) piece.curvature_per_m = whole(-2500, 2500, 1e-3);
    if (kind > 1) piece.curvature_rate_per_m2 = whole(-1000, 1000, 1e-3);
    turned_rad += piece.length_m * (piece.curvature_per_m + 0.5 * piece.curvature_rate_per_m2 * piece.length_m);
    round.push_back(piece);
  }
  const double last_m = whole(100, 2000, 1e-3);
  round.push_back({last_m, (2.0 * pi / folds - turned_rad) / last_m});
  std::vector<Piece> loop;
  for (int i = 0; i < folds; ++i) loop.insert(loop.end(), round.begin(), round.end());
  return lay(loop, true);
}

zone::TrackPosition any_position(const zone::Circuit& circuit) {
  const auto id = *rc::gen::inRange<zone::SectionId>(0, static_cast<zone::SectionId>(circuit.size()));
  return {id, circuit.section(id).length_m() * whole(0, 1001, 1e-3)};
}

/// Distance from the start of the first section, along the loop.
double along(const zone::Circuit& circuit, zone::TrackPosition position) {
  double s_m = position.s_m;
  for (zone::SectionId id = 0; id < position.section; ++id) s_m += circuit.section(id).length_m();
  return s_m;
}

// --- equations (1) to (3) -----------------------------------------------------------------------------------------

TEST(Motion, follows_equation_1_on_an_arc) {
  // Anticlockwise on a circle of radius 0.8 m round (0.3, -0.2), from its lowest point.
  const double R = 0.8;
  const Point2 C{0.3, -0.2};
  const auto circuit = lay({{1.9 * pi * R, 1.0 / R}}, false, {C.x_m, C.y_m - R, 0.0});
  AivMotion aiv{circuit, {0, 0.0}};
  const double v_dt = 0.01;
  for (int n = 0; n < 400; ++n) {
    const Pose2 P_n = aiv.pose(circuit);
    EXPECT_EQ(aiv.move(circuit, v_dt), v_dt);
    const double angle_rad = std::atan2(P_n.y_m - C.y_m, P_n.x_m - C.x_m) + v_dt / R;
    EXPECT_NEAR(aiv.pose(circuit).x_m, C.x_m + R * std::cos(angle_rad), 1e-12);
    EXPECT_NEAR(aiv.pose(circuit).y_m, C.y_m + R * std::sin(angle_rad), 1e-12);
  }
}

TEST(Motion, follows_equation_2_on_a_horizontal_section) {
  const auto circuit = lay({{3.0}}, false, {1.0, 2.0, 0.0});
  AivMotion aiv{circuit, {0, 0.5}};
  aiv.move(circuit, 0.25);
  EXPECT_EQ(aiv.pose(circuit), (Pose2{1.75, 2.0, 0.0}));
}

TEST(Motion, follows_equation_3_on_a_vertical_section) {
  const auto circuit = lay({{3.0}}, false, {1.0, 2.0, 0.5 * pi});
  AivMotion aiv{circuit, {0, 0.5}};
  aiv.move(circuit, 0.25);
  EXPECT_NEAR(aiv.pose(circuit).x_m, 1.0, 1e-15);
  EXPECT_NEAR(aiv.pose(circuit).y_m, 2.75, 1e-15);
}

// --- the flowchart of figure 14 -----------------------------------------------------------------------------------

TEST(Motion, goes_through_phases_a_and_c_while_the_move_ends_on_its_section) {
  const auto circuit = stadium();
  AivMotion aiv{circuit, {0, 0.5}};
  EXPECT_EQ(aiv.move(circuit, 1.0), 1.0);
  EXPECT_EQ(aiv.current_section(), 0U);
  EXPECT_EQ(aiv.mDTCS_m(), 1.5);
}

TEST(Motion, goes_through_phases_a_b_and_c_when_the_section_ends_first) {
  const auto circuit = stadium();
  AivMotion aiv{circuit, {0, 1.5}};
  EXPECT_EQ(aiv.move(circuit, 0.75), 0.75);
  EXPECT_EQ(aiv.current_section(), 1U);
  EXPECT_EQ(aiv.mDTCS_m(), 0.25);
}

TEST(Motion, stays_on_its_section_when_it_reaches_exactly_its_end) {
  const auto circuit = stadium();
  AivMotion aiv{circuit, {0, 1.5}};
  EXPECT_EQ(aiv.move(circuit, 0.5), 0.5);
  EXPECT_EQ(aiv.current_section(), 0U);
  EXPECT_EQ(aiv.mDTCS_m(), 2.0);
  EXPECT_EQ(aiv.move(circuit, 0.25), 0.25);
  EXPECT_EQ(aiv.current_section(), 1U);
  EXPECT_EQ(aiv.mDTCS_m(), 0.25);
}

TEST(Motion, passes_several_short_sections_in_one_move) {
  const auto circuit = lay(std::vector<Piece>(10, Piece{0.125}), false);
  AivMotion aiv{circuit, {1, 0.0625}};
  EXPECT_EQ(aiv.move(circuit, 0.75), 0.75);
  EXPECT_EQ(aiv.current_section(), 7U);
  EXPECT_EQ(aiv.mDTCS_m(), 0.0625);
}

TEST(Motion, drives_many_laps_of_a_loop_in_one_move) {
  const auto circuit = stadium();
  AivMotion aiv{circuit, {0, 0.5}};
  const Pose2 before = aiv.pose(circuit);
  const double distance_m = 1000.0 * circuit.total_length_m();
  EXPECT_EQ(aiv.move(circuit, distance_m), distance_m);
  EXPECT_EQ(aiv.current_section(), 0U);
  EXPECT_NEAR(distance(aiv.pose(circuit), before), 0.0, 1e-8);  // a thousand laps of rounding
}

TEST(Motion, travels_less_than_requested_only_at_a_dead_end) {
  const auto circuit = lay({{1.0}, {0.5}}, false);
  AivMotion aiv{circuit, {0, 0.25}};
  EXPECT_EQ(aiv.move(circuit, 5.0), 1.25);
  EXPECT_EQ(aiv.current_section(), 1U);
  EXPECT_EQ(aiv.mDTCS_m(), 0.5);
  EXPECT_EQ(aiv.move(circuit, 1.0), 0.0);
}

TEST(Motion, takes_the_requested_branch_at_a_fork_and_the_last_one_when_there_are_fewer) {
  const Pose2 fork{1.0, 0.0, 0.0};
  std::vector<zone::Circuit::Part> parts;
  parts.push_back({"stem", zone::Section::make({}, 1.0).value(), std::nullopt, {1, 2}});
  parts.push_back({"ahead", zone::Section::make(fork, 1.0).value(), std::nullopt, {}});
  parts.push_back({"left", zone::Section::make(fork, 1.0, 1.0).value(), std::nullopt, {}});
  const auto circuit = zone::Circuit::make("fork", std::move(parts)).value();
  for (const auto& [branch, section] : {std::pair{0U, 1U}, {1U, 2U}, {7U, 2U}}) {
    AivMotion aiv{circuit, {0, 0.5}};
    aiv.move(circuit, 1.0, branch);
    EXPECT_EQ(aiv.current_section(), section) << "branch " << branch;
  }
}

TEST(Motion, clamps_a_position_to_its_section) {
  const auto circuit = stadium();
  EXPECT_EQ((AivMotion{circuit, {0, 9.0}}.mDTCS_m()), 2.0);
  EXPECT_EQ((AivMotion{circuit, {0, -1.0}}.mDTCS_m()), 0.0);
}

TEST(Motion, agrees_with_nextAIVposition_of_the_section) {
  EXPECT_TRUE(rc::check([] {
    const auto circuit = any_loop();
    AivMotion aiv{circuit, any_position(circuit)};
    const double DTT = whole(0, 500, 1e-3);
    const auto& section = circuit.section(aiv.current_section());
    const auto next = section.nextAIVposition(aiv.mDTCS_m(), DTT);
    const auto before = aiv.current_section();
    aiv.move(circuit, DTT);
    if (next.DT_m < DTT) return;  // phase b: the move continues beyond the section
    RC_ASSERT(aiv.current_section() == before);
    RC_ASSERT(distance(aiv.pose(circuit), next.pose) < 1e-12);
  }));
}

// --- the requests of figure 11 ------------------------------------------------------------------------------------

using Request = zone::test::CountingArc::Request;

/// Three straight sections of 1 m, 0.5 m and 1 m, each a double that counts its requests.
struct Counted {
  std::vector<std::shared_ptr<const zone::test::CountingArc>> arcs;
  zone::Circuit circuit{make()};

  zone::Circuit make() {
    std::vector<zone::Circuit::Part> parts;
    Pose2 start;
    for (const double length_m : {1.0, 0.5, 1.0}) {
      arcs.push_back(std::make_shared<const zone::test::CountingArc>(length_m, 0.0));
      const auto id = static_cast<zone::SectionId>(parts.size());
      parts.push_back(
          {"s" + std::to_string(id), zone::Section::make(start, arcs.back()).value(), std::nullopt, {id + 1}});
      start = parts.back().section.end();
    }
    parts.back().next.clear();
    return zone::Circuit::make("counted", std::move(parts)).value();
  }
};

TEST(MotionRequests, are_made_to_the_current_section_once_and_to_each_next_one_until_DT_is_DTT) {
  const Counted counted;
  AivMotion aiv{counted.circuit, {0, 0.5}};
  EXPECT_EQ(aiv.move(counted.circuit, 0.25), 0.25);
  EXPECT_THAT(counted.arcs[0]->requests, ElementsAre(Request{0.5, 0.25, false}));
  counted.arcs[0]->requests.clear();
  EXPECT_EQ(aiv.move(counted.circuit, 1.0), 1.0);
  EXPECT_EQ(aiv.current_section(), 2U);
  EXPECT_EQ(aiv.mDTCS_m(), 0.25);
  // The first one is requested a second time because the usual move expects that one section suffices.
  EXPECT_THAT(counted.arcs[0]->requests, Each(Request{0.75, 1.0, false}));
  EXPECT_THAT(counted.arcs[1]->requests, ElementsAre(Request{0.0, 0.75, false}));
  EXPECT_THAT(counted.arcs[2]->requests, ElementsAre(Request{0.0, 0.25, false}));
}

TEST(MotionRequests, are_made_in_indirect_direction_as_well) {
  const Counted counted;
  AivMotion aiv{counted.circuit, {2, 0.25}, TravelDir::indirect()};
  EXPECT_EQ(aiv.move(counted.circuit, 1.0), 1.0);
  EXPECT_EQ(aiv.track_position(counted.circuit), (zone::TrackPosition{0, 0.75}));
  EXPECT_THAT(counted.arcs[2]->requests, Each(Request{0.75, 1.0, true}));
  EXPECT_THAT(counted.arcs[1]->requests, ElementsAre(Request{0.0, 0.75, true}));
  EXPECT_THAT(counted.arcs[0]->requests, ElementsAre(Request{0.0, 0.25, true}));
}

TEST(MotionRequests, are_made_to_the_sections_of_a_course) {
  const Counted counted;
  AivMotion aiv{counted.circuit, {0, 0.5}};
  const std::vector<zone::SectionId> past_the_second{2};
  EXPECT_EQ(aiv.shift(counted.circuit, 0.75, past_the_second), 0.75);
  EXPECT_EQ(aiv.current_section(), 2U);
  EXPECT_THAT(counted.arcs[1]->requests, IsEmpty());
  EXPECT_EQ(counted.arcs[2]->requests.size(), 1U);
  EXPECT_EQ(aiv.shift(counted.circuit, -0.5, {}, std::vector<zone::SectionId>{0}), -0.5);
  EXPECT_EQ(aiv.track_position(counted.circuit), (zone::TrackPosition{0, 0.75}));
  EXPECT_THAT(counted.arcs[0]->requests, Contains(Request{0.0, 0.25, true}));
  EXPECT_TRUE(aiv.direction().is_direct());
}

TEST(MotionRequests, give_their_responses_in_the_order_of_the_sections) {
  const Counted counted;
  AivMotion aiv{counted.circuit, {0, 0.5}};
  std::vector<SectionResponse> responses;
  aiv.travel(counted.circuit, 5.0, {}, [&](const SectionResponse& response) { responses.push_back(response); });
  ASSERT_EQ(responses.size(), 3U);
  EXPECT_EQ(responses[0].next.DT_m, 0.5);
  EXPECT_EQ(responses[1].DTT_m, 4.5);
  EXPECT_EQ(responses[2].section, 2U);
  EXPECT_EQ(responses[2].next.DT_m, 1.0);
  EXPECT_NEAR(responses[2].next.pose.x_m, 2.5, 1e-12);
  EXPECT_EQ(aiv.mDTCS_m(), 1.0) << "a dead end";
}

// --- properties ---------------------------------------------------------------------------------------------------

TEST(Motion, returns_to_its_start_after_a_lap_of_any_sections_in_any_steps) {
  EXPECT_TRUE(rc::check([] {
    const auto circuit = any_loop();
    AivMotion aiv{circuit, any_position(circuit)};
    const Pose2 start = aiv.pose(circuit);
    double left_m = circuit.total_length_m();
    while (left_m > 0.0) {
      const double step_m = std::min(left_m, whole(1, 4000, 1e-3));
      aiv.move(circuit, step_m);
      left_m -= step_m;
    }
    RC_ASSERT(distance(aiv.pose(circuit), start) < lap_m);
  }));
}

TEST(Motion, travels_exactly_the_distance_requested) {
  EXPECT_TRUE(rc::check([] {
    const auto circuit = any_loop();
    AivMotion aiv{circuit, any_position(circuit)};
    const double before_m = along(circuit, aiv.track_position(circuit));
    const double requested_m = whole(0, 100'000, 1e-3);
    RC_ASSERT(aiv.move(circuit, requested_m) == requested_m);
    const double loop_length_m = circuit.total_length_m();
    const double off_m =
        std::remainder(along(circuit, aiv.track_position(circuit)) - before_m - requested_m, loop_length_m);
    RC_ASSERT(std::fabs(off_m) < lap_m);
  }));
}

TEST(Motion, forward_then_backward_returns_to_the_start) {
  EXPECT_TRUE(rc::check([] {
    const auto circuit = any_loop();
    AivMotion aiv{circuit, any_position(circuit)};
    const Pose2 start = aiv.pose(circuit);
    const auto steps_m = *rc::gen::container<std::vector<double>>(
        rc::gen::map(rc::gen::inRange(0, 5000), [](int mm) { return 1e-3 * mm; }));
    for (const double step_m : steps_m) aiv.move(circuit, step_m);
    RC_ASSERT(aiv.on_indirect_move_req(circuit));
    for (const double step_m : steps_m) aiv.move(circuit, step_m);
    RC_ASSERT(distance(aiv.pose(circuit), start) < lap_m);
    RC_ASSERT(std::fabs(wrap_angle(aiv.pose(circuit).heading_rad - start.heading_rad)) < 1e-8);
  }));
}

TEST(Motion, in_indirect_direction_is_the_motion_on_the_reversed_circuit_with_the_same_body) {
  EXPECT_TRUE(rc::check([] {
    const auto circuit = any_loop();
    const zone::Circuit back = reversed(circuit);
    const zone::TrackPosition start = any_position(circuit);
    AivMotion indirect{circuit, start, TravelDir::indirect()};
    AivMotion direct{back, reversed(circuit, start)};
    for (const double step_m : {0.01, 0.3, 2.0, 0.0, 7.5}) {
      RC_ASSERT(std::fabs(indirect.move(circuit, step_m) - direct.move(back, step_m)) < 1e-9);
      RC_ASSERT(distance(indirect.pose(circuit), direct.pose(back)) < 1e-6);
      RC_ASSERT(std::fabs(wrap_angle(indirect.pose(circuit).heading_rad -
                                     turned_round(direct.pose(back)).heading_rad)) < 1e-6);
    }
    RC_ASSERT(indirect.current_section() == direct.current_section());
    RC_ASSERT(std::fabs(indirect.mDTCS_m() - direct.mDTCS_m()) < 1e-6);
  }));
}

TEST(Motion, a_shift_and_its_opposite_cancel_and_keep_the_direction) {
  EXPECT_TRUE(rc::check([] {
    const auto circuit = any_loop();
    const TravelDir direction = *rc::gen::arbitrary<bool>() ? TravelDir::direct() : TravelDir::indirect();
    AivMotion aiv{circuit, any_position(circuit), direction};
    const Pose2 start = aiv.pose(circuit);
    const double distance_m = whole(-9000, 9000, 1e-3);
    RC_ASSERT(aiv.shift(circuit, distance_m) == distance_m);
    RC_ASSERT(aiv.shift(circuit, -distance_m) == -distance_m);
    RC_ASSERT(distance(aiv.pose(circuit), start) < lap_m);
    RC_ASSERT(aiv.direction() == direction);
  }));
}

// --- travel direction (figure 13) ---------------------------------------------------------------------------------

TEST(TravelDirection, follows_the_state_diagram) {
  struct Row {
    State before;
    Event event;
    State after;
    bool changes;
  };
  const std::array table{
      Row{State::St_DirectTravelDir, Event::Ev_OnDirectMoveReq, State::St_DirectTravelDir, false},
      Row{State::St_DirectTravelDir, Event::Ev_OnIndirectMoveReq, State::St_IndirectTravelDir, true},
      Row{State::St_IndirectTravelDir, Event::Ev_OnIndirectMoveReq, State::St_IndirectTravelDir, false},
      Row{State::St_IndirectTravelDir, Event::Ev_OnDirectMoveReq, State::St_DirectTravelDir, true},
  };
  const auto circuit = stadium();
  for (const Row& row : table) {
    const bool direct = row.before == State::St_DirectTravelDir;
    AivMotion aiv{circuit, {1, 0.5}, direct ? TravelDir::direct() : TravelDir::indirect()};
    const double mDTCS_m = aiv.mDTCS_m();
    const Pose2 before = aiv.pose(circuit);
    const bool changed =
        row.event == Event::Ev_OnDirectMoveReq ? aiv.on_direct_move_req(circuit) : aiv.on_indirect_move_req(circuit);
    EXPECT_EQ(changed, row.changes);
    EXPECT_EQ(aiv.direction().state(), row.after);
    const double mirrored_m = circuit.section(1).length_m() - mDTCS_m;
    EXPECT_DOUBLE_EQ(aiv.mDTCS_m(), row.changes ? mirrored_m : mDTCS_m);
    EXPECT_NEAR(distance(aiv.pose(circuit), before), 0.0, 1e-12) << "the position stays";
  }
}

TEST(TravelDirection, is_direct_by_default) {
  EXPECT_EQ(AivMotion{}.direction().state(), State::St_DirectTravelDir);
  EXPECT_EQ(TravelDir{}, TravelDir::direct());
}

TEST(TravelDirection, gives_next_section_and_start_of_section) {
  const auto circuit = stadium();
  EXPECT_EQ(TravelDir::direct().next_section(circuit, 3), 0U);
  EXPECT_EQ(TravelDir::indirect().next_section(circuit, 0), 3U);
  EXPECT_EQ(TravelDir::direct().section_start(circuit.section(1)), circuit.section(1).start());
  EXPECT_EQ(TravelDir::indirect().section_start(circuit.section(1)), circuit.section(1).end());
  const auto open = lay({{1.0}}, false);
  EXPECT_EQ(TravelDir::direct().next_section(open, 0), zone::no_section);
  EXPECT_EQ(TravelDir::indirect().next_section(open, 0), zone::no_section);
}

TEST(TravelDirection, keeps_the_heading_of_a_reversing_vehicle) {
  const auto circuit = stadium();
  AivMotion aiv{circuit, {0, 1.0}, TravelDir::indirect()};
  EXPECT_EQ(aiv.mDTCS_m(), 1.0);
  aiv.move(circuit, 0.25);
  EXPECT_EQ(aiv.pose(circuit), (Pose2{0.75, 0.0, 0.0}));
}

TEST(Motion, of_many_vehicles_in_one_pass_equals_the_single_moves) {
  const auto circuit = stadium();
  std::vector<AivMotion> fleet;
  std::vector<double> DTT_m;
  for (int i = 0; i < 50; ++i) {
    fleet.emplace_back(circuit, zone::TrackPosition{static_cast<zone::SectionId>(i % 4), 0.03 * i});
    DTT_m.push_back(0.1 * i);
  }
  std::vector<AivMotion> alone = fleet;
  std::vector<Pose2> poses(fleet.size());
  move_all(circuit, fleet, DTT_m, poses);
  for (std::size_t i = 0; i < alone.size(); ++i) {
    alone[i].move(circuit, DTT_m[i]);
    EXPECT_EQ(fleet[i], alone[i]);
    EXPECT_EQ(poses[i], alone[i].pose(circuit));
  }
  move_all(circuit, fleet, DTT_m, {});
}

TEST(AivMotion, shifts_forwards_through_given_sections_and_back_through_traversed_ones) {
  const zone::Circuit& circuit = test::diamond().circuit;
  const std::vector<zone::SectionId> remaining{4, 5};
  AivMotion motion{circuit, {0, 1.9}};
  EXPECT_NEAR(motion.shift(circuit, 0.3, remaining), 0.3, 1e-12);
  EXPECT_EQ(motion.current_section(), 4U);
  EXPECT_NEAR(motion.mDTCS_m(), 0.2, 1e-12);
  AivMotion back{circuit, {7, 0.1}};
  EXPECT_NEAR(back.shift(circuit, -0.2, {}, std::vector<zone::SectionId>{5, 6}), -0.2, 1e-12);
  EXPECT_EQ(back.current_section(), 6U);
  AivMotion end{circuit, {7, 1.9}};
  EXPECT_NEAR(end.shift(circuit, 0.5, {}, std::vector<zone::SectionId>{6}), 0.1, 1e-12) << "the route ends there";
}

TEST(AivMotion, shifts_along_given_sections_to_the_very_end_or_begin_of_one) {
  const zone::Circuit& circuit = test::diamond().circuit;
  AivMotion motion{circuit, {0, 1.5}};
  EXPECT_EQ(motion.shift(circuit, 0.5, std::vector<zone::SectionId>{4, 5}), 0.5);
  EXPECT_EQ(motion.track_position(circuit), (zone::TrackPosition{0, 2.0}));
  AivMotion back{circuit, {4, 0.25}};
  EXPECT_EQ(back.shift(circuit, -0.25, {}, std::vector<zone::SectionId>{0}), -0.25);
  EXPECT_EQ(back.track_position(circuit), (zone::TrackPosition{4, 0.0}));
}

TEST(MotionDeathTest, needs_a_section_of_the_circuit_and_a_distance_from_zero_to_a_thousand_million_metres) {
  const auto circuit = stadium();
  EXPECT_DEATH(static_cast<void>(AivMotion{circuit, {4, 0.0}}), "position.section < circuit.size");
  AivMotion aiv{circuit, {0, 0.5}};
  EXPECT_DEATH(aiv.move(circuit, -0.1), "min.DTT_m, mDTCS_m. >= 0.0");
  EXPECT_DEATH(aiv.move(circuit, 1.1e9), "DTT_m_max");
}

TEST(MotionDeathTest, of_many_vehicles_needs_as_many_distances_and_poses) {
  const auto circuit = stadium();
  std::vector<AivMotion> fleet(2, AivMotion{circuit, {0, 0.5}});
  std::vector<double> DTT_m(1, 0.1);
  EXPECT_DEATH(move_all(circuit, fleet, DTT_m, {}), "DTT_m.size");
  DTT_m.push_back(0.1);
  std::vector<Pose2> poses(1);
  EXPECT_DEATH(move_all(circuit, fleet, DTT_m, poses), "poses.empty");
}

}  // namespace
}  // namespace cosiva::aiv
