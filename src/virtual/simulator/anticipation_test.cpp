#include "cosiva/virtual/simulator/anticipation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <string>
#include <string_view>

#include "cosiva/base/archive.h"

namespace cosiva::virtual_side {
namespace {

constexpr zone::SpeedProfile medium{0.4, 0.5, 0.8};

TEST(Anticipation, accelerates_to_the_chosen_speed_and_keeps_it) {
  const Anticipation anticipation{0.2, {medium}};
  // 0.2 m/s more at 0.5 m/s²: 0.4 s.
  EXPECT_NEAR(anticipation.speed_mps(0.2), 0.3, 1e-9);
  EXPECT_NEAR(anticipation.distance_m(0.4), 0.5 * (0.2 + 0.4) * 0.4, 1e-9);
  EXPECT_NEAR(anticipation.distance_m(1.0), 0.12 + 0.4 * 0.6, 1e-9);
  EXPECT_NEAR(anticipation.distance_m(1.7), 0.12 + 0.4 * 1.3, 1e-9) << "beyond the table";
}

TEST(Anticipation, brakes_to_a_slower_profile) {
  const Anticipation anticipation{0.4, {{0.2, 0.5, 0.8}}};
  EXPECT_NEAR(anticipation.distance_m(0.25), 0.5 * (0.4 + 0.2) * 0.25, 1e-9);
  EXPECT_NEAR(anticipation.speed_mps(0.5), 0.2, 1e-9);
}

TEST(Anticipation, stops_at_the_end_of_the_base_as_the_vehicle_s_envelope_does) {
  Expectation expected{medium};
  expected.end_m = 0.15;
  const Anticipation anticipation{0.4, expected};
  // v·t + v²/(2b) = d: at full speed the vehicle begins to brake 0.132 m before the end.
  EXPECT_NEAR(anticipation.distance_m(0.045), 0.018, 1e-3);
  EXPECT_GT(anticipation.speed_mps(0.045), 0.395);
  EXPECT_LT(anticipation.speed_mps(0.3), 0.25);
  EXPECT_LT(anticipation.distance_m(10.0), 0.15 + 1e-12);
}

TEST(Anticipation, follows_the_leader_and_does_not_reach_it) {
  Expectation expected{medium};
  expected.leader_gap_m = 0.2;
  const Anticipation stopped{0.4, expected};
  EXPECT_LT(stopped.distance_m(1.0), 0.2 - 0.12 + 0.04) << "the clearance remains";
  expected.leader_mps = 0.4;
  const Anticipation drives{0.4, expected};
  EXPECT_GT(drives.distance_m(1.0), stopped.distance_m(1.0) + 0.1);
}

TEST(Anticipation, continues_an_observed_change_of_speed_that_the_known_limits_do_not_explain) {
  Expectation expected{medium};
  expected.trend_mps2 = -0.4;
  EXPECT_NEAR(Anticipation(0.3, expected).speed_mps(0.2), 0.3 - 0.4 * 0.2, 1e-9);
  expected.trend_mps2 = 0.2;
  EXPECT_NEAR(Anticipation(0.3, expected).speed_mps(0.2), 0.3 + 0.2 * 0.2, 1e-9);
  expected.trend_mps2 = 3.0;
  EXPECT_NEAR(Anticipation(0.3, expected).speed_mps(0.1), 0.3 + 0.5 * 0.1, 1e-9) << "not beyond the profile's";
  EXPECT_EQ(Anticipation(0.3, {medium, 1.0, 9.0, 0.0, -5.0}).speed_mps(1.0), 0.0) << "it stops, and does not reverse";
}

TEST(Anticipation, of_a_vehicle_that_stops_ends_after_its_braking_distance) {
  const Anticipation anticipation{0.4, {{0.0, 0.5, 0.8}}};
  EXPECT_NEAR(anticipation.distance_m(1.0), 0.4 * 0.4 / (2.0 * 0.8), 1e-9);
  EXPECT_EQ(anticipation.speed_mps(1.0), 0.0);
  EXPECT_EQ(Anticipation{}.distance_m(0.7), 0.0) << "without a report it stopped still";
}

TEST(Anticipation, never_drives_back_nor_beyond_the_end_of_the_base) {
  EXPECT_TRUE(rc::check([] {
    const auto upto = [](int top) { return *rc::gen::inRange(0, top) / 1000.0; };
    Expectation expected{{upto(1000), 0.1 + upto(1000), 0.1 + upto(1000)}};
    expected.end_m = upto(1000);
    expected.leader_gap_m = upto(1500);
    expected.leader_mps = upto(500);
    const Anticipation anticipation{upto(1000), expected};
    double before = 0.0;
    for (int ms = 0; ms <= 1500; ms += 7) {
      const double now = anticipation.distance_m(ms / 1000.0);
      RC_ASSERT(now >= before);
      RC_ASSERT(now <= expected.end_m);
      RC_ASSERT(anticipation.speed_mps(ms / 1000.0) >= 0.0);
      before = now;
    }
  }));
}

TEST(Anticipation, is_stored_as_it_is) {
  Expectation expected{medium};
  expected.end_m = 0.3;
  Anticipation anticipation{0.3, expected};
  std::string bytes;
  Archive writing{bytes};
  anticipation.archive(writing);
  Anticipation read;
  Archive reading{std::string_view{bytes}};
  read.archive(reading);
  ASSERT_FALSE(reading.failed());
  for (int ms = 0; ms <= 1500; ms += 30) EXPECT_EQ(read.distance_m(ms / 1000.0), anticipation.distance_m(ms / 1000.0));
}

}  // namespace
}  // namespace cosiva::virtual_side
