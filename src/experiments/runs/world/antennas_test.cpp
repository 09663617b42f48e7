#include "cosiva/experiments/runs/world/antennas.h"

#include <gtest/gtest.h>

namespace cosiva::experiments {
namespace {

using enum Antennas::Kind;

TEST(Antennas, of_vehicles_reach_each_other_up_to_their_distance_and_those_of_units_further) {
  Antennas antennas{{.vehicles_m = 0.8, .units_m = 3.0}};
  antennas.position_at(1, vehicle, {0.0, 0.0});
  antennas.position_at(2, vehicle, {0.8, 0.0});
  antennas.position_at(3, vehicle, {-0.1, 0.0});
  antennas.position_at(4, unit, {0.0, 2.9});
  antennas.position_at(5, unit, {0.0, 6.0});
  EXPECT_TRUE(antennas.reach(1, 2));
  EXPECT_TRUE(antennas.reach(2, 1));
  EXPECT_FALSE(antennas.reach(2, 3)) << "0.9 m";
  EXPECT_TRUE(antennas.reach(1, 4));
  EXPECT_TRUE(antennas.reach(4, 1));
  EXPECT_FALSE(antennas.reach(4, 5)) << "3.1 m";
  antennas.position_at(2, vehicle, {0.9, 0.0});
  EXPECT_FALSE(antennas.reach(1, 2)) << "it has driven on";
  EXPECT_FALSE(antennas.reach(1, 6)) << "an antenna of which no position is known";
}

}  // namespace
}  // namespace cosiva::experiments
