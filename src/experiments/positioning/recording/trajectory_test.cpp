#include "cosiva/experiments/positioning/recording/trajectory.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

namespace cosiva::experiments {
namespace {

constexpr const char* reference_text =
    "# t x y z qx qy qz qw\n"
    "100.0 1.229017 2.41787 2.951936 0 0 0 1\n"
    "100.1 -0.343773 4.433567 1.489746 0 0 0 1\n"
    "100.2 -0.30931 -2.534272 0.437609 0 0 0 1\n"
    "100.3 4.163454 2.657255 -3.403958 0 0 0 1\n"
    "100.4 1.174525 -3.733008 -4.982251 0 0 0 1\n"
    "100.5 3.724078 -2.106948 4.61478 0 0 0 1\n"
    "100.6 -2.952205 4.40976 1.906419 0 0 0 1\n"
    "100.7 -3.340439 -3.542981 -4.348603 0 0 0 1\n"
    "100.8 -4.966169 1.779342 -1.621031 0 0 0 1\n";
constexpr const char* estimate_text =
    "100.0 1.536021 2.301753 2.994796 0 0 0 1\n"
    "100.1 -0.366527 4.513206 1.432571 0 0 0 1\n"
    "100.2 -0.338363 -2.548833 0.471214 0 0 0 1\n"
    "100.3 4.321863 2.689168 -3.508518 0 0 0 1\n"
    "100.4 1.269271 -3.832134 -4.859897 0 0 0 1\n"
    "100.5 4.279338 -2.398875 4.541342 0 0 0 1\n"
    "100.6 -2.538018 4.321443 1.84928 0 0 0 1\n"
    "100.7 -3.15992 -3.629207 -4.090741 0 0 0 1\n"
    "100.8 -5.102099 2.122927 -1.793997 0 0 0 1\n";

Trajectory read(const std::string& text, const std::string& name = "a.tum") {
  auto trajectory = read_trajectory(name, text);
  EXPECT_TRUE(trajectory) << to_string(trajectory.error());
  return trajectory ? *trajectory : Trajectory{};
}

std::string refusal(const std::string& text) {
  const auto trajectory = read_trajectory("bad.txt", text);
  return trajectory ? "" : trajectory.error().code + " " + trajectory.error().location;
}

TEST(Ape, equals_another_program_s_result_with_forty_digits) {
  const auto pairs = associate(read(reference_text), read(estimate_text), {});
  ASSERT_TRUE(pairs);
  const ApeMetrics metrics = ape(*pairs);
  EXPECT_EQ(metrics.pairs, 9U);
  EXPECT_NEAR(metrics.rmse, 0.3411105239254084, 1e-12);
  EXPECT_NEAR(metrics.mean, 0.2942153665772972, 1e-12);
  EXPECT_NEAR(metrics.median, 0.3263661187700096, 1e-12);
  EXPECT_NEAR(metrics.std, 0.1726085386139784, 1e-12);
  EXPECT_NEAR(metrics.min, 0.0467482144578806, 1e-12);
  EXPECT_NEAR(metrics.max, 0.6316076161454990, 1e-12);
  EXPECT_NEAR(metrics.sse, 1.0472075057940000, 1e-12);
}

TEST(Association, interpolates_the_reference_inside_the_gap_and_never_across_it) {
  const Trajectory reference = read("0 0 0 0 0 0 0 1\n1 2 0 0 0 0 0 1\n3 4 0 0 0 0 0 1\n");
  const Trajectory estimate = read("-1 0 0 0 0 0 0 1\n0.5 0 0 0 0 0 0 1\n2 0 0 0 0 0 0 1\n3 9 0 0 0 0 0 1\n");
  const auto pairs = associate(reference, estimate, {Association::interpolate, 1.0});
  ASSERT_TRUE(pairs);
  ASSERT_EQ(pairs->size(), 2U);
  EXPECT_EQ(pairs->front().reference.p_m[0], 1.0);
  EXPECT_EQ(pairs->back().reference.t_s, 3.0);
  EXPECT_EQ(associate(reference, estimate, {Association::interpolate, 2.0})->size(), 3U);
}

TEST(Association, by_the_nearest_stamp_uses_each_stamp_of_the_shorter_one_once) {
  const Trajectory reference = read("0 0 0 0 0 0 0 1\n0.105 1 0 0 0 0 0 1\n0.2 2 0 0 0 0 0 1\n0.3 3 0 0 0 0 0 1\n");
  const Trajectory estimate = read("0.1 1 0 0 0 0 0 1\n0.25 0 0 0 0 0 0 1\n");
  const auto pairs = associate(reference, estimate, {Association::nearest, 0.01});
  ASSERT_TRUE(pairs);
  ASSERT_EQ(pairs->size(), 1U);
  EXPECT_EQ(pairs->front().reference.t_s, 0.105);
}

TEST(Association, of_disjoint_times_is_an_error_that_names_both) {
  const auto pairs =
      associate(read("0 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n", "ground_truth"), read("5 0 0 0 0 0 0 1\n", "mine"), {});
  ASSERT_FALSE(pairs);
  EXPECT_EQ(pairs.error().code, "recording.overlap");
  EXPECT_NE(pairs.error().message.find("ground_truth from 0 to 1 s, mine from 5 to 5 s"), std::string::npos);
}

TEST(Trajectory, of_a_quaternion_has_its_heading) {
  const Trajectory turned = read("0 1 2 0 0 0 0.7071067811865476 0.7071067811865476\n");
  EXPECT_NEAR(turned.poses[0].pose().heading_rad, 1.5707963267948966, 1e-12);
  EXPECT_NEAR(stamped(0.0, {0.0, 0.0, 1.2}).pose().heading_rad, 1.2, 1e-15);
}

TEST(Trajectory, as_euroc_and_kitti_is_the_same_pose) {
  const Trajectory euroc = read("#timestamp,p_x,p_y,p_z,q_w,q_x,q_y,q_z,v\n1403636580838555648,1,2,3,1,0,0,0,9\n");
  EXPECT_DOUBLE_EQ(euroc.poses[0].t_s, 1403636580.838555648);
  EXPECT_EQ(euroc.poses[0].p_m, (std::array{1.0, 2.0, 3.0}));
  EXPECT_EQ(read("timestamp,x,y,z,qw,qx,qy,qz\n5000000000,1,2,3,1,0,0,0\n").poses[0].t_s, 5.0);
  // A quarter turn to the left about z, 1.2.3.
  const Trajectory kitti = read("0 -1 0 1 1 0 0 2 0 0 1 3\n1 0 0 4 0 1 0 5 0 0 1 6\n");
  ASSERT_EQ(kitti.poses.size(), 2U);
  EXPECT_EQ(kitti.poses[1].t_s, 1.0);
  EXPECT_EQ(kitti.poses[0].p_m, (std::array{1.0, 2.0, 3.0}));
  EXPECT_NEAR(kitti.poses[0].pose().heading_rad, 1.5707963267948966, 1e-12);
  // Half a turn, where the quaternion's w is zero.
  EXPECT_NEAR(std::fabs(read("-1 0 0 0 0 -1 0 0 0 0 1 0\n").poses[0].pose().heading_rad), 3.14159265358979, 1e-9);
}

TEST(Trajectory, written_as_tum_reads_back_to_the_same_bits) {
  const Trajectory one = read(estimate_text);
  EXPECT_EQ(write_tum(read(write_tum(one))), write_tum(one));
  EXPECT_EQ(read(write_tum(one)).poses[5].p_m, one.poses[5].p_m);
}

TEST(Trajectory, that_is_invalid_is_refused_with_its_line) {
  EXPECT_EQ(refusal("0 0 0 0 0 0 0 1\n0 1 0 0 0 0 0 1\n"), "recording.stamp bad.txt:2");
  EXPECT_EQ(refusal("1 0 0 0 0 0 0 1\n0 1 0 0 0 0 0 1\n"), "recording.stamp bad.txt:2");
  EXPECT_EQ(refusal("nan 0 0 0 0 0 0 1\n"), "recording.number bad.txt:1");
  EXPECT_EQ(refusal("0 0 0 inf 0 0 0 1\n"), "recording.number bad.txt:1");
  EXPECT_EQ(refusal("0 0 0\n"), "recording.width bad.txt:1");
  EXPECT_EQ(refusal("0 0 0 0 0 0 0 0\n"), "recording.rotation bad.txt:1");
  EXPECT_EQ(refusal("5 0 0 0 0 5 0 0 0 0 5 0\n"), "recording.rotation bad.txt:1");
  EXPECT_EQ(refusal("# nothing\n\n"), "recording.empty bad.txt");
  EXPECT_EQ(refusal("1000.5,0,0,0,1,0,0,0\n"), "recording.stamp bad.txt:1");  // seconds instead of EuRoC's nanoseconds
  EXPECT_EQ(refusal("timestamp,p_x\nword,0,0,0,1,0,0,0\n"), "recording.number bad.txt:2");
  EXPECT_EQ(refusal("nan,0,0,0,1,0,0,0\n"), "recording.number bad.txt:1");
}

TEST(TimeOffset, of_a_late_estimate_is_found) {
  Trajectory reference;
  Trajectory estimate;
  for (int i = 0; i < 400; ++i) {
    const double t = 0.02 * i;
    const auto x = [](double s) { return 0.4 * s + 0.1 * std::sin(3.0 * s); };
    reference.poses.push_back(stamped(t, {x(t), 0.0, 0.0}));
    estimate.poses.push_back(stamped(t, {x(t - 0.03), 0.0, 0.0}));
  }
  EXPECT_NEAR(time_offset_s(*associate(reference, estimate, {})), 0.03, 1e-3);
  EXPECT_EQ(time_offset_s({}), 0.0);
}

}  // namespace
}  // namespace cosiva::experiments
