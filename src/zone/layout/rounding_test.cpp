#include "cosiva/zone/layout/rounding.h"

#include <gtest/gtest.h>

#include "cosiva/zone/testing/test_zones.h"

namespace cosiva::zone {
namespace {

TEST(Rounding, of_a_length_is_to_a_tenth_of_a_millimetre) {
  EXPECT_EQ(rounded_m(1.23456), 1.2346);
  EXPECT_EQ(rounded_m(1.23454), 1.2345);
  EXPECT_EQ(rounded_m(-0.00006), -0.0001);
  EXPECT_EQ(rounded_m(0.00004), 0.0);
  EXPECT_EQ(rounded_m(12345.0), 12345.0);
}

TEST(Rounding, of_an_angle_is_to_a_ten_thousandth_of_a_degree) {
  EXPECT_EQ(rounded_deg(pi / 6.0), 30.0);
  EXPECT_EQ(rounded_deg(-0.1), -5.7296);
  EXPECT_EQ(rounded_rad(pi / 6.0 + 1e-8), 30.0 * pi / 180.0);
}

TEST(Rounding, moves_no_position_off_its_section) {
  const Circuit circuit = testing::circuit({testing::part("a", testing::section({}, 1.23456))});
  EXPECT_EQ(position_as_written(circuit, {0, 0.50004}), (TrackPosition{0, 0.5}));
  EXPECT_EQ(position_as_written(circuit, {0, 1.23456}), (TrackPosition{0, 1.2345}));
  EXPECT_EQ(position_as_written(circuit, {0, 1.23454}), (TrackPosition{0, 1.2345}));
  const Circuit whole = testing::circuit({testing::part("a", testing::section({}, 1.25))});
  EXPECT_EQ(position_as_written(whole, {0, 1.25}), (TrackPosition{0, 1.25}));
}

TEST(Rounding, writes_metres_with_two_to_four_decimals) {
  EXPECT_EQ(metres_text(1.41372), "1.4137");
  EXPECT_EQ(metres_text(0.2), "0.20");
  EXPECT_EQ(metres_text(3.0), "3.00");
  EXPECT_EQ(metres_text(0.125), "0.125");
  EXPECT_EQ(metres_text(100.0), "100.00");
  EXPECT_EQ(metres_text(-0.05), "-0.05");
}

}  // namespace
}  // namespace cosiva::zone
