#include "cosiva/virtual/simulator/twin.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>

#include "cosiva/base/random.h"
#include "cosiva/virtual/simulator/follow.h"

namespace cosiva::virtual_side {
namespace {

using namespace std::chrono_literals;
using zone::Circuit;
using zone::Section;

/// Two straights of 2 m joined by half circles of 0.5 m.
Circuit oval() {
  std::vector<Circuit::Part> parts;
  Pose2 start{};
  const std::vector<std::pair<double, double>> shape{{2.0, 0.0}, {pi * 0.5, 2.0}, {2.0, 0.0}, {pi * 0.5, 2.0}};
  for (std::uint32_t i = 0; i < shape.size(); ++i) {
    Section section = *Section::make(start, shape[i].first, shape[i].second);
    start = section.end();
    parts.push_back({"s" + std::to_string(i), section, std::nullopt, {(i + 1) % 4}});
  }
  return *Circuit::make("oval", std::move(parts), 1e-6, 1e-6);
}

class TwinOnOval : public testing::Test {
 protected:
  Circuit circuit{oval()};
  Twin twin{"make/a", 1, 1s};
  SimTime t0{virtual_epoch};

  std::optional<Twin::Divergence> report(SimTime now, SimTime at, zone::TrackPosition track_position, double speed_mps,
                                         double left_m = 0.0) {
    Pose2 pose = circuit.pose_at(track_position);
    pose = pose * Pose2{0.0, left_m, 0.0};
    return twin.report(&circuit, now, {at, pose, speed_mps, 0.0, 0.0});
  }
  [[nodiscard]] Pose2 shown(SimTime time) const { return twin.image_at(&circuit, time).X_MB; }
};

TEST_F(TwinOnOval, is_extrapolated_along_the_arc_not_along_its_tangent) {
  report(t0, t0, {1, 0.2}, 0.3);
  const Pose2 after = shown(t0 + 500ms);
  EXPECT_LT(distance(after, circuit.pose_at({1, 0.35})), 1e-12);
  // The tangent would have led 2 cm off the path.
  EXPECT_NEAR(distance(Point2{2.0, 0.5}, position(after)), 0.5, 1e-9);
  EXPECT_EQ(twin.image_at(&circuit, t0 + 500ms).position->section, 1U);
}

TEST_F(TwinOnOval, never_leaves_the_circuit_for_any_requested_time) {
  EXPECT_TRUE(rc::check("on the path", [&] {
    Random random{*rc::gen::arbitrary<std::uint64_t>(), "twin"};
    Twin own{"make/b", 1, 1s};
    const auto section = static_cast<zone::SectionId>(random.below(4));
    const zone::TrackPosition track_position{section, random.uniform(0.0, circuit.section(section).length_m())};
    own.report(&circuit, t0, {t0, circuit.pose_at(track_position), random.uniform(0.0, 1.0), 0.0, 0.0});
    const Pose2 pose = own.image_at(&circuit, t0 + std::chrono::milliseconds{random.below(3000)}).X_MB;
    RC_ASSERT(circuit.locate(position(pose), pose.heading_rad).distance_m < 1e-6);
  }));
}

TEST_F(TwinOnOval, predicts_a_vehicle_at_constant_speed_exactly) {
  report(t0, t0, {0, 1.9}, 0.4);
  const auto divergence = report(t0 + 510ms, t0 + 500ms, {1, 0.1}, 0.4);
  ASSERT_TRUE(divergence.has_value());
  EXPECT_LT(divergence->m, 1e-9);
  EXPECT_LT(divergence->rad, 1e-9);
}

TEST_F(TwinOnOval, measures_divergence_at_the_time_stamp_of_the_report_not_at_its_arrival) {
  report(t0, t0, {0, 0.0}, 0.3);
  // 0.2 s later the vehicle had stopped after 0.05 m; predicted were 0.06 m. The message took 100 ms.
  const auto divergence = report(t0 + 300ms, t0 + 200ms, {0, 0.05}, 0.0);
  ASSERT_TRUE(divergence.has_value());
  EXPECT_NEAR(divergence->m, 0.01, 1e-9);
}

TEST_F(TwinOnOval, has_no_divergence_at_its_first_report) { EXPECT_FALSE(report(t0, t0, {0, 0.0}, 0.3).has_value()); }

TEST_F(TwinOnOval, corrects_without_a_jump_within_300_ms) {
  report(t0, t0, {0, 0.5}, 0.3);
  const SimTime t1 = t0 + 100ms;
  const Pose2 before = shown(t1);
  report(t1, t1, {0, 0.63}, 0.3, 0.02);  // 10 cm further and 2 cm to the left
  EXPECT_LT(distance(before, shown(t1)), 1e-9);
  Pose2 last = shown(t1);
  for (SimTime t = t1; t <= t1 + 400ms; t += 10ms) {
    EXPECT_LT(distance(last, shown(t)), 0.02) << "10 ms";
    last = shown(t);
  }
  const Pose2 done = shown(t1 + 300ms);
  EXPECT_NEAR(done.x_m, 0.63 + 0.09, 1e-9);
  EXPECT_NEAR(done.y_m, 0.02, 1e-9);
}

TEST_F(TwinOnOval, corrects_across_a_joint_along_the_path) {
  report(t0, t0, {0, 1.95}, 0.0);
  report(t0 + 100ms, t0 + 100ms, {1, 0.05}, 0.0);
  for (SimTime t = t0 + 100ms; t < t0 + 400ms; t += 20ms)
    EXPECT_LT(circuit.locate(position(shown(t)), shown(t).heading_rad).distance_m, 1e-6);
}

TEST_F(TwinOnOval, moves_at_once_to_a_position_more_than_half_a_metre_away) {
  report(t0, t0, {0, 0.5}, 0.3);
  report(t0 + 100ms, t0 + 100ms, {2, 0.5}, 0.3);
  EXPECT_LT(distance(shown(t0 + 100ms), circuit.pose_at({2, 0.5})), 1e-9);
}

TEST_F(TwinOnOval, stops_when_no_report_was_received_for_too_long) {
  report(t0, t0, {0, 0.5}, 0.3);
  EXPECT_NEAR(shown(t0 + 1s).x_m, 0.8, 1e-9);
  EXPECT_NEAR(shown(t0 + 10s).x_m, 0.8, 1e-9);
  EXPECT_EQ(twin.image_at(&circuit, t0 + 10s).speed_mps, 0.0);
}

TEST_F(TwinOnOval, is_not_extrapolated_beyond_the_end_of_its_base) {
  report(t0, t0, {0, 0.5}, 0.3);
  twin.set_base_end(&circuit, zone::TrackPosition{0, 0.6});
  EXPECT_NEAR(shown(t0 + 900ms).x_m, 0.6, 1e-9);
  report(t0 + 400ms, t0 + 400ms, {0, 0.605}, 0.1);
  EXPECT_NEAR(shown(t0 + 1300ms).x_m, 0.605, 1e-9) << "coasted a little beyond: it stays there";
  twin.set_base_end(&circuit, zone::TrackPosition{1, 0.5});
  EXPECT_NEAR(shown(t0 + 1300ms).x_m, 0.605 + 0.09, 1e-9);
}

TEST_F(TwinOnOval, keeps_the_lateral_offset_of_a_vehicle_that_drives_off_path) {
  report(t0, t0, {1, 0.2}, 0.3, 0.02);
  const auto located = circuit.locate(position(shown(t0 + 500ms)));
  EXPECT_NEAR(located.left_m, 0.02, 1e-9);
}

TEST_F(TwinOnOval, follows_a_vehicle_that_drives_backwards) {
  report(t0, t0, {1, 0.2}, -0.2);
  EXPECT_LT(distance(shown(t0 + 500ms), circuit.pose_at({1, 0.1})), 1e-9);
}

TEST_F(TwinOnOval, derives_the_speed_from_positions_if_the_vehicle_reports_none) {
  twin.report(&circuit, t0, {t0, circuit.pose_at({0, 0.5}), {}, 0.0, 0.0});
  twin.report(&circuit, t0 + 100ms, {t0 + 100ms, circuit.pose_at({0, 0.53}), {}, 0.0, 0.0});
  EXPECT_NEAR(twin.speed_mps(), 0.3, 1e-9);
}

TEST_F(TwinOnOval, uses_dead_reckoning_far_from_any_section) {
  const Pose2 far{10.0, 10.0, pi / 2.0};
  twin.report(&circuit, t0, {t0, far, 0.5, 0.0, 0.0});
  EXPECT_FALSE(twin.on_circuit());
  const Twin::Image image = twin.image_at(&circuit, t0 + 400ms);
  EXPECT_FALSE(image.position.has_value());
  EXPECT_NEAR(image.X_MB.x_m, 10.0, 1e-9);
  EXPECT_NEAR(image.X_MB.y_m, 10.2, 1e-9);
}

TEST_F(TwinOnOval, uses_dead_reckoning_without_a_zone_and_the_circuit_as_soon_as_there_is_one) {
  twin.report(nullptr, t0, {t0, {0.5, 0.01, 0.0}, 0.3, 0.0, 0.0});
  EXPECT_NEAR(twin.image_at(nullptr, t0 + 100ms).X_MB.x_m, 0.53, 1e-9);
  twin.report(&circuit, t0 + 100ms, {t0 + 100ms, {0.53, 0.01, 0.0}, 0.3, 0.0, 0.0});
  EXPECT_TRUE(twin.on_circuit());
}

TEST_F(TwinOnOval, is_not_extrapolated_along_a_section_that_it_crosses) {
  twin.report(&circuit, t0, {t0, {1.0, 0.05, pi / 2.0}, 0.5, 0.0, 0.0});
  const Pose2 after = shown(t0 + 200ms);
  EXPECT_NEAR(after.x_m, 1.0, 1e-9);
  EXPECT_NEAR(after.y_m, 0.15, 1e-9);
}

TEST(TwinOnALane, is_on_the_one_of_two_coinciding_sections_that_its_course_leads_along) {
  // East on one section, back west on the other: the section that the vehicle came along coincides with the next one.
  const auto part = [](const char* name, const Pose2& start, std::vector<zone::SectionId> next) {
    return Circuit::Part{name, *Section::make(start, 2.0), std::nullopt, std::move(next), true};
  };
  const Pose2 east{2.0, 0.0, pi};
  const Circuit lane =
      *Circuit::make("lane", {part("there", {}, {1, 2}), part("back", east, {0}), part("back_too", east, {0})});
  for (const auto& [before, now] : {std::pair<zone::SectionId, zone::SectionId>{1, 2}, {2, 1}}) {
    Twin twin{"make/a", 1, 1s};
    const SimTime t0{virtual_epoch};
    twin.set_course(&lane, zone::Course{{before, 0, now}});
    twin.report(&lane, t0, {t0, lane.pose_at({before, 2.0}), 0.0, 0.0, 0.0});
    twin.report(&lane, t0, {t0, lane.pose_at({0, 1.0}), 0.3, 0.0, 0.0});
    EXPECT_EQ(twin.reported_position().section, 0U);
    for (const double turned_rad : {1.0, 2.5, pi}) {
      const Pose2 X_MB = lane.pose_at({0, 2.0}) * Pose2{0.0, 0.0, turned_rad};
      twin.report(&lane, t0, {t0, X_MB, 0.0, 0.0, 1.0});
    }
    twin.report(&lane, t0, {t0, lane.pose_at({now, 0.4}), 0.3, 0.0, 0.0});
    EXPECT_EQ(twin.reported_position().section, now);
  }
}

TEST(TwinOnALane, that_visited_a_section_long_ago_is_not_on_its_course_there) {
  zone::Course course{{1, 0, 2, 0}, 3};
  std::vector<Circuit::Part> parts;
  for (const char* name : {"a", "b", "c"})
    parts.push_back({name, *Section::make({}, 2.0), std::nullopt, {0, 1, 2}, true});
  const Circuit circuit = *Circuit::make("lanes", std::move(parts), 10.0);
  EXPECT_FALSE(follow(course, circuit, 1)) << "6 m back";
  EXPECT_EQ(course.traversed().size(), 3U);
  EXPECT_TRUE(follow(course, circuit, 2)) << "near a joint it may fall back";
}

TEST(TwinOnALane, does_not_advance_its_course_while_it_is_off_path) {
  // A loop of four: its course begins on the third section and visits the first one later.
  std::vector<Circuit::Part> parts;
  for (zone::SectionId i = 0; i < 4; ++i)
    parts.push_back({"side" + std::to_string(i),
                     *Section::make(Pose2{0, 0, 0.5 * pi * i} * Pose2{-1.0, -1.0, 0.0}, 2.0),
                     std::nullopt,
                     {(i + 1) % 4},
                     true});
  const Circuit cycle = *Circuit::make("ring", std::move(parts));
  Twin twin{"make/a", 1, 1s};
  SimTime now{virtual_epoch};
  twin.report(&cycle, now, {now, {0.0, -0.8, 0.0}, 0.0, 0.0, 0.0});
  EXPECT_EQ(twin.reported_position().section, 0U) << "0.2 m off the path";
  twin.set_course(&cycle, zone::Course{{2, 3, 0, 1}});
  for (const double y_m : {-0.8, 0.8, 1.0}) {
    now += 100ms;
    twin.report(&cycle, now, {now, {0.0, y_m, pi}, 0.0, 0.0, 0.0});
  }
  EXPECT_EQ(twin.reported_position().section, 2U);
  for (const double x_m : {-0.9, -0.99}) {
    now += 100ms;
    twin.report(&cycle, now, {now, {x_m, 1.0, pi}, 0.3, 0.0, 0.0});
  }
  EXPECT_EQ(twin.reported_position().section, 2U) << "its course leads along this section and has not passed it";
}

TEST_F(TwinOnOval, limits_a_reported_speed_that_no_vehicle_has) {
  report(t0, t0, {0, 0.0}, 1e12);
  EXPECT_LE(twin.speed_mps(), Twin::speed_mps_max);
  const Pose2 pose = shown(t0 + 10s);
  EXPECT_LT(circuit.locate(position(pose), pose.heading_rad).distance_m, 1e-6);
}

TEST_F(TwinOnOval, with_constant_speed_never_moves_faster_than_that_between_reports) {
  report(t0, t0, {0, 0.5}, 0.3);
  Pose2 last = shown(t0);
  for (SimTime t = t0; t < t0 + 2s; t += 10ms) {
    EXPECT_LE(distance(last, shown(t)), 0.3 * 0.01 + 1e-9);
    last = shown(t);
  }
}

}  // namespace
}  // namespace cosiva::virtual_side
