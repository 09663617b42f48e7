#include "cosiva/physical/plant/line_trial.h"

#include <gtest/gtest.h>

#include <cmath>

#include "cosiva/physical/plant/test_zones.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::physical {
namespace {

zone::TrafficZone zone_of(zone::ZoneConfiguration configuration) {
  auto rtm = zone::Rtm::initialise(std::move(configuration));
  EXPECT_TRUE(rtm) << to_string(rtm.error());
  return rtm->zone();
}

TEST(LineTrial, compares_the_algorithms_over_a_lap_of_lacet4) {
  const zone::TrafficZone zone = zone_of(lacet4());
  const double lap_m = zone.circuit.total_length_m();
  const auto rms_m = [&](const std::string& algorithm) {
    const auto trial = run_line_trial(zone, {algorithm, 0.4, lap_m, 0.0005, 1});
    EXPECT_TRUE(trial && !trial->line_lost) << algorithm;
    EXPECT_GE(trial->worst_m, trial->rms_m);
    EXPECT_NEAR(static_cast<double>(trial->offset_m.size()), 100.0 * (lap_m - 0.5), 0.3 * 100.0 * lap_m);
    return trial->rms_m;
  };
  const double usual_m = rms_m(line_trackings().front());
  EXPECT_LT(usual_m, 0.001);
  EXPECT_LT(usual_m, rms_m("path_observer"));
  EXPECT_LT(rms_m("path_observer"), rms_m("threshold"));
}

TEST(LineTrial, gives_the_same_numbers_for_the_same_seed_and_others_for_another) {
  const zone::TrafficZone zone = zone_of(lacet4());
  const auto offsets = [&](std::uint64_t seed) {
    return run_line_trial(zone, {"centroid_pd", 0.4, 5.0, 0.0005, seed})->offset_m;
  };
  EXPECT_EQ(offsets(1), offsets(1));
  EXPECT_NE(offsets(1), offsets(2));
}

TEST(LineTrial, is_refused_with_the_wrong_option) {
  const zone::TrafficZone zone = zone_of(lacet4());
  EXPECT_EQ(run_line_trial(zone, {"pid"}).error().code, "line.algorithm");
  EXPECT_EQ(run_line_trial(zone, {"threshold", 0.0}).error().code, "line.speed");
  EXPECT_EQ(run_line_trial(zone, {"threshold", 1.6}).error().code, "line.speed");
  EXPECT_EQ(run_line_trial(zone, {"threshold", std::nan("")}).error().code, "line.speed");
  EXPECT_EQ(run_line_trial(zone, {"threshold", 0.4, 0.5}).error().code, "line.distance");
}

TEST(LineTrial, fails_where_the_path_ends_before_the_distance) {
  const auto trial = run_line_trial(zone_of(straight(10.0)), {"centroid_pd", 0.5, 50.0});
  ASSERT_FALSE(trial);
  EXPECT_EQ(trial.error().code, "line.zone");
}

}  // namespace
}  // namespace cosiva::physical
