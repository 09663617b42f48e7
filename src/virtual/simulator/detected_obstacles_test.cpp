#include "cosiva/virtual/simulator/detected_obstacles.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cosiva::virtual_side {
namespace {

using namespace std::chrono_literals;
using testing::IsEmpty;
using testing::SizeIs;

class Sightings : public testing::Test {
 protected:
  SimTime now{virtual_epoch};
  DetectedObstacles detected;
};

TEST_F(Sightings, of_one_object_from_two_vehicles_are_one_twin) {
  EXPECT_TRUE(detected.see("a", now, {1.0, 0.0}, 0.05));
  EXPECT_FALSE(detected.see("b", now + 1s, {1.1, 0.0}, 0.07));
  ASSERT_THAT(detected.obstacles(), SizeIs(1));
  const DetectedObstacle& one = detected.obstacles()[0];
  EXPECT_EQ(one.id, "S1");
  EXPECT_EQ(one.handle, 0xC000);
  EXPECT_NEAR(one.at.x_m, 1.05, 1e-12) << "the second weighs as much as the first";
  EXPECT_EQ(one.first, now);
  EXPECT_EQ(one.last, now + 1s);
  EXPECT_TRUE(DetectedObstacles::detected_by(one, "a"));
  EXPECT_TRUE(DetectedObstacles::detected_by(one, "b"));
  EXPECT_FALSE(DetectedObstacles::detected_by(one, "c"));
}

TEST_F(Sightings, further_apart_than_15_cm_are_two_twins) {
  detected.see("a", now, {1.0, 0.0}, 0.05);
  EXPECT_TRUE(detected.see("a", now, {1.16, 0.0}, 0.05));
  EXPECT_THAT(detected.obstacles(), SizeIs(2));
}

TEST_F(Sightings, are_removed_when_another_vehicle_s_body_covers_them) {
  detected.see("a", now, {1.0, 0.0}, 0.05);
  EXPECT_EQ(detected.pass("b", now, {0.8, 0.0, 0.0}, 0.20, 0.12), 0U) << "the obstacle is still before its front";
  EXPECT_EQ(detected.pass("b", now, {0.95, 0.0, 0.0}, 0.20, 0.12), 1U);
  EXPECT_THAT(detected.obstacles(), IsEmpty());
}

TEST_F(Sightings, stay_when_a_vehicle_passes_next_to_them) {
  detected.see("a", now, {1.0, 0.13}, 0.05);
  EXPECT_EQ(detected.pass("b", now, {1.0, 0.0, 0.0}, 0.20, 0.12), 0U) << "8 cm to its edge: no vehicle stops for that";
}

TEST_F(Sightings, that_reach_into_the_corridor_are_removed_when_a_vehicle_passes_abreast) {
  detected.see("a", now, {1.0, 0.10}, 0.036);
  EXPECT_EQ(detected.pass("b", now, {1.0, 0.0, 0.0}, 0.20, 0.12), 1U)
      << "a real obstacle would have stopped a body of half width 6 cm";
}

TEST_F(Sightings, of_a_vehicle_stopped_close_before_them_stay_while_it_detects_them) {
  detected.see("a", now, {1.0, 0.0}, 0.05);
  EXPECT_EQ(detected.pass("a", now + 300ms, {0.9, 0.0, 0.0}, 0.20, 0.12), 0U);
  EXPECT_EQ(detected.pass("a", now + 600ms, {0.9, 0.0, 0.0}, 0.20, 0.12), 1U);
}

/// Like the DOBS board: thirteen beams of 0.14 rad, centred straight ahead; all with the same range.
wire::Ranges beams(std::uint16_t mm) { return {0, -84, 14, std::vector<std::uint16_t>(13, mm)}; }

TEST_F(Sightings, are_removed_when_any_vehicle_s_beams_pass_through_their_position_three_times) {
  detected.see("a", now, {1.0, 0.0}, 0.05);
  EXPECT_THAT(detected.clear_through({0.2, 0.0, 0.0}, beams(wire::no_echo)), IsEmpty());
  EXPECT_THAT(detected.clear_through({0.2, 0.1, 0.0}, beams(1'100)), IsEmpty());
  EXPECT_THAT(detected.clear_through({0.3, 0.0, 0.0}, beams(wire::no_echo)), testing::ElementsAre("S1"));
  EXPECT_THAT(detected.obstacles(), IsEmpty());
}

TEST_F(Sightings, that_the_beams_detect_again_stay) {
  detected.see("a", now, {1.0, 0.0}, 0.05);
  wire::Ranges received = beams(wire::no_echo);
  received.range_mm[6] = 750;  // 0.8 m away less its radius
  for (int i = 0; i < 10; ++i) {
    detected.clear_through({0.2, 0.0, 0.0}, beams(wire::no_echo));
    detected.clear_through({0.2, 0.0, 0.0}, beams(wire::no_echo));
    detected.clear_through({0.2, 0.0, 0.0}, received);
  }
  EXPECT_THAT(detected.obstacles(), SizeIs(1)) << "one returning echo in three is enough";
}

TEST_F(Sightings, that_no_beam_could_detect_stay) {
  detected.see("a", now, {1.0, 0.0}, 0.05);
  wire::Ranges hidden = beams(wire::no_echo);
  hidden.range_mm[6] = 400;  // a body in between
  for (int i = 0; i < 10; ++i) {
    detected.clear_through({0.2, 0.0, 0.0}, hidden);
    detected.clear_through({-0.6, 0.0, 0.0}, beams(wire::no_echo));        // 1.6 m away
    detected.clear_through({0.2, 0.0, 1.2}, beams(wire::no_echo));         // outside the fan
    detected.clear_through({0.2, 0.0, 3.1}, beams(wire::no_echo));         // behind the sensor
    detected.clear_through({1.02, 0.0, 0.0}, beams(wire::no_echo));        // on the obstacle
    detected.clear_through({0.2, 0.0, 0.0}, {0, 0, 0, {wire::no_echo}});   // beams without a width
    detected.clear_through({0.2, 0.0, 0.0}, {0, -7, 14, {}});              // no beams
    detected.clear_through({0.5, 0.0, 0.0}, {0, 0, 14, {wire::no_echo}});  // the obstacle fills more than this beam
  }
  EXPECT_THAT(detected.obstacles(), SizeIs(1));
}

TEST_F(Sightings, that_are_detected_again_are_doubted_from_zero) {
  detected.see("a", now, {1.0, 0.0}, 0.05);
  for (int i = 0; i < 5; ++i) {
    detected.clear_through({0.2, 0.0, 0.0}, beams(wire::no_echo));
    detected.clear_through({0.2, 0.0, 0.0}, beams(wire::no_echo));
    detected.see("a", now + 1s, {1.0, 0.0}, 0.05);
  }
  EXPECT_THAT(detected.obstacles(), SizeIs(1));
}

TEST_F(Sightings, are_limited_in_number_and_the_oldest_is_replaced) {
  for (std::size_t i = 0; i <= DetectedObstacles::obstacles_max; ++i)
    detected.see("a", now + i * 1s, {static_cast<double>(i), 0.0}, 0.05);
  ASSERT_THAT(detected.obstacles(), SizeIs(DetectedObstacles::obstacles_max));
  EXPECT_EQ(detected.obstacles().front().id, "S2");
  detected.remove("S2");
  EXPECT_THAT(detected.obstacles(), SizeIs(DetectedObstacles::obstacles_max - 1));
}

}  // namespace
}  // namespace cosiva::virtual_side
