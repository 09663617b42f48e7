#include "cosiva/experiments/positioning/recording/alignment.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cosiva::experiments {
namespace {

constexpr std::array<std::array<double, 3>, 9> ground_truth{{{1.229017, 2.41787, 2.951936},
                                                             {-0.343773, 4.433567, 1.489746},
                                                             {-0.30931, -2.534272, 0.437609},
                                                             {4.163454, 2.657255, -3.403958},
                                                             {1.174525, -3.733008, -4.982251},
                                                             {3.724078, -2.106948, 4.61478},
                                                             {-2.952205, 4.40976, 1.906419},
                                                             {-3.340439, -3.542981, -4.348603},
                                                             {-4.966169, 1.779342, -1.621031}}};
constexpr std::array<std::array<double, 3>, 9> estimate{{{1.536021, 2.301753, 2.994796},
                                                         {-0.366527, 4.513206, 1.432571},
                                                         {-0.338363, -2.548833, 0.471214},
                                                         {4.321863, 2.689168, -3.508518},
                                                         {1.269271, -3.832134, -4.859897},
                                                         {4.279338, -2.398875, 4.541342},
                                                         {-2.538018, 4.321443, 1.84928},
                                                         {-3.15992, -3.629207, -4.090741},
                                                         {-5.102099, 2.122927, -1.793997}}};

std::vector<Pair> nine() {
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < ground_truth.size(); ++i)
    pairs.push_back({{static_cast<double>(i), ground_truth[i], {0.0, 0.0, 0.0, 1.0}},
                     {static_cast<double>(i), estimate[i], {0.0, 0.0, 0.0, 1.0}}});
  return pairs;
}

std::vector<Pair> moved(std::vector<Pair> pairs, const RigidMotion& motion) {
  for (Pair& pair : pairs) pair.estimate = motion * pair.estimate;
  return pairs;
}

ApeMetrics aligned(Alignment how) {
  const auto motion = alignment_of(how, nine());
  EXPECT_TRUE(motion);
  return ape(moved(nine(), *motion));
}

// Umeyama's method, by the singular values of the covariance with forty digits, from another program.
TEST(Alignment, in_space_equals_umeyama_s_singular_values) {
  const ApeMetrics metrics = aligned(Alignment::se3);
  EXPECT_NEAR(metrics.rmse, 0.2769598532318277551, 1e-12);
  EXPECT_NEAR(metrics.mean, 0.2470975991139667081, 1e-12);
  EXPECT_NEAR(metrics.median, 0.2087577922105911459, 1e-12);
  EXPECT_NEAR(metrics.std, 0.1250981087559239246, 1e-12);
  EXPECT_NEAR(metrics.max, 0.5082292050445125785, 1e-12);
  EXPECT_NEAR(metrics.sse, 0.690360842719760139, 1e-12);
  const auto motion = alignment_of(Alignment::se3, nine());
  EXPECT_NEAR(motion->shift_m[0], -0.170999366372016137, 1e-12);
  EXPECT_NEAR(motion->shift_m[1], 0.02506518004474748591, 1e-12);
  EXPECT_NEAR(motion->shift_m[2], -0.001062687125655344049, 1e-12);
  EXPECT_NEAR(motion->turn_rad(), 0.01061971868664342628, 1e-12);
}

TEST(Alignment, about_the_vertical_equals_singular_values_of_the_plane) {
  const ApeMetrics metrics = aligned(Alignment::se2);
  EXPECT_NEAR(metrics.rmse, 0.2889212953435930093, 1e-12);
  EXPECT_NEAR(metrics.mean, 0.2593430692018203619, 1e-12);
  EXPECT_NEAR(metrics.median, 0.2219556709421561836, 1e-12);
  EXPECT_NEAR(metrics.std, 0.1273447578818991449, 1e-12);
  EXPECT_NEAR(metrics.max, 0.4774164026782592602, 1e-12);
  const auto motion = alignment_of(Alignment::se2, nine());
  EXPECT_NEAR(motion->turn_rad(), 0.0135616561724871549, 1e-12);
  EXPECT_NEAR(motion->shift_m[0], -0.1638219718134447377, 1e-12);
  EXPECT_NEAR(motion->shift_m[2], 0.0009552222222222222222, 1e-12);
}

TEST(Alignment, at_the_origin_leaves_the_first_pose_without_an_error) {
  const ApeMetrics metrics = aligned(Alignment::origin);
  EXPECT_EQ(metrics.min, 0.0);
  EXPECT_NEAR(metrics.rmse, 0.3404784475504041847, 1e-12);
  EXPECT_NEAR(metrics.max, 0.6738674346160378153, 1e-12);
  // With headings: a path that began a quarter turn off is corrected by the first pose.
  std::vector<Pair> turned;
  for (int i = 0; i < 5; ++i)
    turned.push_back({stamped(i, {1.0 + i, 2.0, 0.0}), stamped(i, {-3.0, 7.0 + i, 1.5707963267948966})});
  const auto motion = alignment_of(Alignment::origin, turned);
  EXPECT_NEAR(ape(moved(turned, *motion)).max, 0.0, 1e-12);
  EXPECT_NEAR(motion->turn_rad(), -1.5707963267948966, 1e-12);
  EXPECT_NEAR((*motion * turned[3].estimate).pose().heading_rad, 0.0, 1e-12);
}

TEST(Alignment, is_optimal_against_small_changes) {
  for (const Alignment how : {Alignment::se2, Alignment::se3}) {
    const auto best = alignment_of(how, nine());
    const std::vector<Pair> there = moved(nine(), *best);
    const double least = ape(there).sse;
    for (std::size_t axis = 0; axis < 6; ++axis) {
      // About the vertical the other two axes are fixed.
      if (how == Alignment::se2 && (axis == 3 || axis == 4)) continue;
      for (const double step : {1e-4, -1e-4}) {
        RigidMotion nudge;
        if (axis < 3) {
          nudge.shift_m[axis] = step;
        } else {
          nudge.q[axis - 3] = 0.5 * step;
          nudge.q[3] = std::sqrt(1.0 - 0.25 * step * step);
        }
        EXPECT_GT(ape(moved(there, nudge)).sse, least) << to_string(how) << " " << axis;
      }
    }
  }
}

TEST(Alignment, removes_any_motion_and_never_mirrors) {
  const RigidMotion motion{{0.1, -0.5, 0.7, 0.5}, {3.0, -20.0, 0.4}};
  std::vector<Pair> pairs = nine();
  for (Pair& pair : pairs) pair.estimate = motion * pair.reference;
  EXPECT_NEAR(ape(moved(pairs, *alignment_of(Alignment::se3, pairs))).max, 0.0, 1e-12);
  EXPECT_NEAR(ape(moved(pairs, *alignment_of(Alignment::origin, pairs))).max, 0.0, 1e-12);
  // A mirror image is another shape: the residual must be visible.
  for (Pair& pair : pairs) {
    pair.estimate = pair.reference;
    pair.estimate.p_m[0] = -pair.estimate.p_m[0];
  }
  EXPECT_GT(ape(moved(pairs, *alignment_of(Alignment::se3, pairs))).rmse, 1.0);
}

TEST(Alignment, of_positions_that_do_not_determine_a_rotation_is_refused) {
  std::vector<Pair> line;
  for (int i = 0; i < 9; ++i) line.push_back({stamped(i, {0.3 * i, 0.1 * i, 0.0}), stamped(i, {0.3 * i, 0.0, 0.0})});
  EXPECT_TRUE(alignment_of(Alignment::se2, line));
  ASSERT_FALSE(alignment_of(Alignment::se3, line));
  EXPECT_EQ(alignment_of(Alignment::se3, line).error().code, "align.turn");
  std::vector<Pair> still;
  for (int i = 0; i < 9; ++i) still.push_back({stamped(i, {0.3 * i, 0.1 * i, 0.0}), stamped(i, {1.0, 2.0, 0.0})});
  EXPECT_EQ(alignment_of(Alignment::se2, still).error().code, "align.turn");
  EXPECT_EQ(alignment_of(Alignment::se2, {line[0]}).error().code, "align.turn");
  EXPECT_EQ(alignment_of(Alignment::se3, still).error().code, "align.turn");
  EXPECT_TRUE(alignment_of(Alignment::origin, still));
}

}  // namespace
}  // namespace cosiva::experiments
