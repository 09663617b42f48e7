#include "cosiva/experiments/positioning/metrology/limit.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "cosiva/experiments/positioning/metrology/simulate.h"
#include "cosiva/experiments/positioning/metrology/test_tracks.h"

namespace cosiva::experiments {
namespace {

// Odometry of (1 cm)² per metre, beacons read to 1 cm: millimetres at six pitches, computed by hand from the closed
// forms.
struct Row {
  double pitch_m, filter_mm, smoother_mm, reset_mm;
};
constexpr std::array<Row, 6> table{{{0.1, 5.66, 3.98, 10.25},
                                    {0.25, 7.18, 5.03, 10.61},
                                    {0.5, 8.66, 6.01, 11.18},
                                    {1.0, 10.57, 7.22, 12.25},
                                    {2.0, 13.16, 8.77, 14.14},
                                    {4.0, 16.82, 10.86, 17.32}}};

TEST(Limit, equals_the_table) {
  for (const Row& row : table) {
    const Regime regime{1e-4, row.pitch_m, 1e-4};
    EXPECT_NEAR(1e3 * filter_limit_m(regime), row.filter_mm, 0.005) << row.pitch_m;
    EXPECT_NEAR(1e3 * smoother_limit_m(regime), row.smoother_mm, 0.005) << row.pitch_m;
    EXPECT_NEAR(1e3 * reset_rule_m(regime), row.reset_mm, 0.005) << row.pitch_m;
  }
}

TEST(Limit, solves_the_riccati_equation) {
  const Regime regime{2e-4, 0.7, 5e-5};
  const Sawtooth p = sawtooth(regime);
  EXPECT_NEAR(p.before_m2, p.after_m2 + 2e-4 * 0.7, 1e-18);
  EXPECT_NEAR(1.0 / p.after_m2, 1.0 / p.before_m2 + 1.0 / 5e-5, 1e-6);
}

TEST(Limit, tends_to_the_limits_of_odometry_or_beacons_alone) {
  EXPECT_NEAR(filter_limit_m({1e-4, 1e-4, 1e-4}) / std::pow(1e-4 * 1e-4 * 1e-4, 0.25), 1.0, 1e-2);
  EXPECT_NEAR(filter_limit_m({1e-4, 1e4, 1e-4}) / std::sqrt(0.5 * 1e-4 * 1e4), 1.0, 1e-3);
  EXPECT_NEAR(smoother_limit_m({1e-4, 1e4, 1e-4}) / std::sqrt(1e-4 * 1e4 / 6.0), 1.0, 1e-3);
}

TEST(Limit, of_precision_is_the_normal_ratio_for_a_nearly_constant_variance) {
  // Beacons so dense that P is S/2 everywhere.
  const Regime regime{1e-4, 1e-6, 1e-2};
  EXPECT_NEAR(precision_limit(regime, filter_limit_m(regime)), std::erf(1.0 / std::sqrt(2.0)), 1e-4);
  EXPECT_GT(precision_limit({1e-4, 0.5, 1e-4}, 0.02), precision_limit({1e-4, 2.0, 1e-4}, 0.02));
}

TEST(Limit, pitch_for_a_tolerance_has_this_tolerance_as_its_limit) {
  const auto pitch = pitch_for(0.01, 1e-4, 1e-4);
  ASSERT_TRUE(pitch);
  EXPECT_NEAR(filter_limit_m({1e-4, *pitch, 1e-4}), 0.01, 1e-12);
  EXPECT_FALSE(pitch_for(0.0, 1e-4, 1e-4));
}

TEST(Limit, of_a_run_s_own_readings_is_the_closed_form_for_regular_readings) {
  for (const double pitch_m : {0.25, 1.0}) {
    Simulation simulation{testing::oval()};
    simulation.distance_m = 400.0;
    simulation.pitch_m = pitch_m;
    simulation.turns = false;
    simulation.sensors.line_sigma_m = 0.0;
    simulation.start_sigma_m = std::sqrt(sawtooth({1e-4, pitch_m, 1e-4}).after_m2);
    Trial run;
    simulate(simulation, 1, run);
    const RunLimit limit = limit_of(run);
    EXPECT_NEAR(std::sqrt(limit.filter_m2) / filter_limit_m({1e-4, pitch_m, 1e-4}), 1.0, 0.01);
    EXPECT_NEAR(std::sqrt(limit.smoother_m2) / smoother_limit_m({1e-4, pitch_m, 1e-4}), 1.0, 0.01);
  }
}

}  // namespace
}  // namespace cosiva::experiments
