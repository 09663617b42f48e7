#include "cosiva/wire/messages/travel_frame.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <vector>

namespace cosiva::wire {
namespace {

const Ranges front{7, -84, 14, std::vector<std::uint16_t>(13, 500)};

TEST(TravelFrame, has_the_opposite_signs_along_its_axes_and_the_same_turns) {
  Odometry odometry{20, 1'500'000, 250, 12, false, Manoeuvre{100, -50, 785}};
  const Odometry turned = turned_round(odometry);
  EXPECT_EQ(turned, (Odometry{20, -1'500'000, -250, -12, false, Manoeuvre{-100, 50, 785}}));
  const Drive drive{300, 500, 800, 2, true, Manoeuvre{200, 30, -40}, 700};
  EXPECT_EQ(turned_round(drive), (Drive{-300, 500, 800, 2, true, Manoeuvre{-200, -30, -40}, 700}));
}

TEST(TravelFrame, turned_twice_is_the_body_frame) {
  const Odometry odometry{20, -1, -250, 12, true, Manoeuvre{1, 2, 3}};
  EXPECT_EQ(turned_round(turned_round(odometry)), odometry);
  const Drive drive{-1, 2, 3, 4, false, Manoeuvre{5, 6, 7}, 8};
  EXPECT_EQ(turned_round(turned_round(drive)), drive);
  EXPECT_EQ(turned_round(turned_round(front)), front);
}

TEST(TravelFrame, of_the_lowest_value_has_the_highest) {
  constexpr auto lowest = std::numeric_limits<std::int16_t>::min();
  EXPECT_EQ(turned_round(Drive{lowest}).speed_mmps, std::numeric_limits<std::int16_t>::max());
  EXPECT_EQ(turned_round(Odometry{0, std::numeric_limits<std::int64_t>::min()}).distance_um,
            std::numeric_limits<std::int64_t>::max());
}

TEST(TravelFrame, shows_a_sensor_at_the_rear_pointing_forwards) {
  EXPECT_TRUE(points_forwards(front));
  const Ranges rear = turned_round(front);
  EXPECT_EQ(rear.first_bearing_crad, 230) << "the centre beam at 3.14 rad";
  EXPECT_FALSE(points_forwards(rear));
  EXPECT_TRUE(points_forwards(turned_round(rear)));
}

TEST(TravelFrame, has_bearings_within_one_turn_for_a_fan_to_any_side) {
  for (int first_crad = -314; first_crad <= 314; ++first_crad) {
    const Ranges fan{0, static_cast<std::int16_t>(first_crad), 14, {500}};
    const Ranges turned = turned_round(fan);
    EXPECT_GE(turned.first_bearing_crad, -314);
    EXPECT_LE(turned.first_bearing_crad, 314);
    EXPECT_EQ((turned.first_bearing_crad - first_crad + 628) % 628, 314);
  }
}

}  // namespace
}  // namespace cosiva::wire
