#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <sstream>
#include <string>

#include "cosiva/aiv/estimation/registry.h"
#include "cosiva/base/math.h"
#include "cosiva/experiments/positioning/recording/recording.h"
#include "cosiva/experiments/positioning/recording/replayed.h"
#include "cosiva/experiments/positioning/recording/test_folders.h"
#include "cosiva/experiments/statistics/sample.h"

// Recordings with implausible data.
namespace cosiva::experiments {
namespace {

/// A vehicle on a circle of 5 m at 1 m/s for 60 s, ten samples per second.
struct Drive {
  double speed_mps{1.0};
  std::function<double(double)> heading = [](double course_rad) { return course_rad; };
  std::function<bool(double)> counts = [](double) { return true; };
  /// Whether the first increment after a gap in odometry includes the distance during the gap.
  bool adds_up{false};
  bool reports_speeds{false};

  [[nodiscard]] RecordingFiles files() const {
    std::ostringstream odometry;
    std::ostringstream ground_truth;
    odometry << (reports_speeds ? "time_s,speed_mps,turn_radps\n" : "time_s,delta_distance_m,delta_heading_rad\n");
    ground_truth << "time_s,x_m,y_m,heading_rad\n";
    double since = 0.0;
    for (int i = 0; i <= 600; ++i) {
      const double t_s = 0.1 * i;
      const double angle_rad = 0.2 * speed_mps * t_s;
      const SinCos at = sincos(angle_rad);
      ground_truth << t_s << "," << 5.0 * at.cos << "," << 5.0 * at.sin << "," << heading(angle_rad + 0.5 * pi) << "\n";
      if (i == 0) continue;
      since += 0.1;
      if (!counts(t_s)) continue;
      const double counted_s = reports_speeds ? 1.0 : (adds_up ? since : 0.1);
      odometry << t_s << "," << counted_s * speed_mps << "," << counted_s * 0.2 * speed_mps << "\n";
      since = 0.0;
    }
    return {{"odometry.csv", odometry.str()}, {"groundtruth.csv", ground_truth.str()}};
  }
  [[nodiscard]] Recording recording() const {
    auto read = read_recording("drive", files());
    EXPECT_TRUE(read) << to_string(read.error());
    return std::move(*read);
  }
};

TEST(GroundTruthHeading, with_a_constant_offset_from_the_direction_of_motion_is_corrected_and_reported) {
  Drive drive;
  drive.heading = [](double course_rad) { return course_rad + pi; };
  const Recording recording = drive.recording();
  EXPECT_TRUE(recording.ground_truth_has_heading);
  EXPECT_NEAR(wrap_angle(recording.ground_truth[0].heading_rad - 0.5 * pi), 0.0, 0.01);
  ASSERT_EQ(recording.diagnostics.size(), 1U);
  EXPECT_EQ(recording.diagnostics[0].substr(0, 69),
            "the ground truth's heading is 180 degrees off the direction of motion");
}

TEST(GroundTruthHeading, is_unchanged_within_the_start_s_uncertainty_and_for_backward_driving) {
  for (const double off_rad : {0.0, 0.1, -0.1}) {
    Drive drive;
    drive.heading = [off_rad](double course_rad) { return course_rad + off_rad; };
    const Recording recording = drive.recording();
    EXPECT_TRUE(recording.diagnostics.empty()) << off_rad;
    EXPECT_NEAR(recording.ground_truth[0].heading_rad, 0.5 * pi + off_rad, 1e-5);
  }
  // The body's heading is along the circle in one direction, and the motion in the other.
  Drive backwards;
  backwards.speed_mps = -1.0;
  EXPECT_TRUE(backwards.recording().diagnostics.empty());
  EXPECT_TRUE(backwards.recording().ground_truth_has_heading);
}

TEST(GroundTruthHeading, that_does_not_follow_the_direction_of_motion_is_left_out_and_reported) {
  const std::vector<std::function<double(double)>> hands{
      [](double course_rad) { return course_rad * 180.0 / pi; },  // degrees
      [](double course_rad) { return 0.5 * pi - course_rad; },    // a compass
      [](double) { return 0.0; },                                 // an empty column
  };
  for (std::size_t hand = 0; hand < hands.size(); ++hand) {
    Drive drive;
    drive.heading = hands[hand];
    const Recording recording = drive.recording();
    EXPECT_FALSE(recording.ground_truth_has_heading) << hand;
    ASSERT_EQ(recording.diagnostics.size(), 1U) << hand;
    EXPECT_EQ(recording.diagnostics[0].substr(0, 66),
              "the ground truth's heading does not follow the direction of motion");
    EXPECT_GT(replayed(recording)->setting.start_heading_sigma_rad, 1.0);
  }
}

bool unresponsive_once(double t_s) { return t_s < 29.95 || t_s > 34.95; }

const Recording::Step& longest(const Recording& recording) {
  return *std::ranges::max_element(recording.odometry, {}, &Recording::Step::duration_s);
}

TEST(Silence, of_odometry_is_bridged_by_the_vehicle_s_usual_motion) {
  for (const bool speeds : {false, true}) {
    Drive drive;
    drive.counts = unresponsive_once;
    drive.reports_speeds = speeds;
    const Recording recording = drive.recording();
    const Recording::Step& step = longest(recording);
    EXPECT_NEAR(step.duration_s, 5.1, 1e-6);
    EXPECT_NEAR(step.distance_m, 5.1, 0.01);
    EXPECT_NEAR(step.turn_rad, 1.02, 0.01);
    // The vehicle always moves like this, so the uncertainty is small except for the bend.
    EXPECT_LT(step.turn_variance_rad2, 1e-3);
    ASSERT_EQ(recording.diagnostics.size(), 1U);
    EXPECT_EQ(recording.diagnostics[0].substr(0, 67),
              "odometry is missing 1 time, for 5 s at most; the vehicle is assumed");
  }
}

TEST(Silence, followed_by_a_complete_increment_keeps_the_increment) {
  Drive drive;
  drive.counts = unresponsive_once;
  drive.adds_up = true;
  const Recording recording = drive.recording();
  EXPECT_NEAR(longest(recording).distance_m, 5.1, 1e-6);
  EXPECT_EQ(longest(recording).distance_variance_m2, 0.0);
  ASSERT_EQ(recording.diagnostics.size(), 1U);
  EXPECT_NE(recording.diagnostics[0].find("is used for the whole gap"), std::string::npos);
}

TEST(Silence, of_a_short_drive_leaves_the_vehicle_anywhere_within_its_reach) {
  Drive drive;
  drive.counts = [](double t_s) { return t_s < 1.95 || (t_s > 51.95 && t_s < 53.95); };
  const Recording recording = drive.recording();
  const Recording::Step& step = longest(recording);
  EXPECT_GE(std::sqrt(step.distance_variance_m2), 50.0);
  EXPECT_GE(std::sqrt(step.turn_variance_rad2), 3.0);
}

TEST(RecordedStatistics, mower_with_nine_odometry_gaps_of_20_s_is_located_again_with_valid_regions) {
  RecordingFiles files = testing::folder(testing::recorded() + "plaza1");
  std::stringstream lines(files["odometry.csv"]);
  std::string line;
  std::getline(lines, line);
  std::string holey = line + "\n";
  for (double began_s = -1.0; std::getline(lines, line);) {
    const double t_s = std::stod(line);
    if (began_s < 0.0) began_s = t_s;
    if (t_s - began_s < 200.0 || std::fmod(t_s - began_s, 200.0) >= 20.0) holey += line + "\n";
  }
  files["odometry.csv"] = holey;
  const auto recording = read_recording("holey", files);
  ASSERT_TRUE(recording) << to_string(recording.error());
  const auto trial = replayed(*recording);
  ASSERT_TRUE(trial);
  const estimation::Registry registry;
  for (const auto& [name, rmse_m] : {std::pair{"calibrating", 3.0}, std::pair{"smoother", 1.5}}) {
    Trace trace;
    ASSERT_TRUE(apply(**registry.make(name, trial->setting), *trial, trace));
    // Estimators that assumed standstill meanwhile were 20 m off, and their regions covered 26 and 5 %.
    EXPECT_LT(statistics::root_mean_square(trace.error_m), rmse_m) << name;
    EXPECT_GE(statistics::ratio_below(trace.nees, 5.991), 0.88) << name;
  }
}

}  // namespace
}  // namespace cosiva::experiments
