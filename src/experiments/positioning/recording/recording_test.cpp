#include "cosiva/experiments/positioning/recording/recording.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <sstream>
#include <string>

#include "cosiva/aiv/estimation/planar.h"
#include "cosiva/aiv/estimation/registry.h"
#include "cosiva/base/math.h"
#include "cosiva/experiments/positioning/recording/replayed.h"
#include "cosiva/experiments/positioning/recording/test_folders.h"
#include "cosiva/experiments/statistics/sample.h"

namespace cosiva::experiments {
namespace {

using testing::folder;
using testing::recorded;

RecordingFiles small() {
  return {{"odometry.csv", "time_s,delta_distance_m,delta_heading_rad\n1,0.5,0\n2,1.0,0\n3,1.0,0.1\n"},
          {"groundtruth.csv", "time_s,x_m,y_m,heading_rad\n0,0,0,0\n1,0.5,0,0\n2,1.5,0,0\n3,2.5,0.05,0.1\n"},
          {"beacons.csv", "beacon_id,x_m,y_m\n7,1,2\n"},
          {"ranges.csv", "time_s,sender_id,receiver_id,range_m\n1.25,1,7,2.0\n2,1,7,2.1\n"}};
}

std::string refusal(const RecordingFiles& files) {
  const auto recording = read_recording("bad", files);
  if (!recording) return recording.error().code + " " + recording.error().location;
  const auto trial = replayed(*recording);
  return trial ? "" : trial.error().code + " " + trial.error().location;
}

RecordingFiles with(const std::string& file, const std::string& text) {
  RecordingFiles files = small();
  files[file] = text;
  return files;
}

TEST(Recording, cuts_odometry_at_readings_between_its_stamps) {
  const auto recording = read_recording("small", small());
  ASSERT_TRUE(recording) << to_string(recording.error());
  const auto trial = replayed(*recording, {1.5, 0.05, 0.05});
  ASSERT_TRUE(trial) << to_string(trial.error());
  // Step to 1 s; to 1.25 s a quarter of 1 m, range; three quarters; to 2 s: range at its very end; step to 3 s.
  ASSERT_EQ(trial->events.size(), 6U);
  EXPECT_EQ(std::get<estimation::Odometry>(trial->events[1]).distance_m, 0.25);
  EXPECT_EQ(std::get<estimation::Range>(trial->events[2]).range_m, 2.0);
  EXPECT_EQ(std::get<estimation::Odometry>(trial->events[3]).distance_m, 0.75);
  EXPECT_EQ(std::get<estimation::Range>(trial->events[4]).station_M, (Point2{1.0, 2.0}));
  ASSERT_EQ(trial->moments.size(), 3U);
  EXPECT_EQ(trial->moments[1].events, 5U);
  EXPECT_EQ(trial->moments[1].since_fiducial_m, 0.0);
  EXPECT_EQ(trial->moments[2].travelled_m, 2.5);
  EXPECT_EQ(trial->setting.start, (Pose2{0.0, 0.0, 0.0}));
}

TEST(Recording, sorts_late_ranges_by_their_stamps_and_reports_it) {
  auto files = small();
  files["ranges.csv"] = "time_s,beacon_id,range_m\n2.5,7,2.0\n1.25,7,2.1\n";
  const auto recording = read_recording("small", files);
  ASSERT_TRUE(recording);
  EXPECT_EQ(recording->ranges.front().t_s, 1.25);
  ASSERT_EQ(recording->diagnostics.size(), 1U);
  EXPECT_EQ(recording->diagnostics[0].substr(0, 8), "1 ranges");
}

TEST(Recording, reads_speeds_and_libRSF_text) {
  const auto speeds = read_recording("s", with("odometry.csv", "time_s,speed_mps,turn_radps\n1,1,0\n1.5,2,0.4\n"));
  ASSERT_TRUE(speeds);
  EXPECT_DOUBLE_EQ(speeds->odometry[1].distance_m, 1.0);
  EXPECT_DOUBLE_EQ(speeds->odometry[1].turn_rad, 0.2);
  const auto rsf = read_recording("r", {{"A_Input.txt",
                                         "range2 0.1 2.9 0.01 -0.02 -0.01 105 0 \nodom2diff 0.1 1 1 0 0.1 1 1 1\n"
                                         "odom2diff 0.3 0.4 0.6 0 0.1 1 1 1\n"},
                                        {"A_GT.txt", "point2 0.1 1.5 2.5 0 0 0 0\npoint2 0.3 1.6 2.5 0 0 0 0\n"}});
  ASSERT_TRUE(rsf) << to_string(rsf.error());
  EXPECT_DOUBLE_EQ(rsf->odometry[1].distance_m, 0.1);
  EXPECT_DOUBLE_EQ(rsf->odometry[1].turn_rad, 0.2);
  EXPECT_EQ(rsf->beacons.at(105), (Point2{-0.02, -0.01}));
  EXPECT_FALSE(rsf->ground_truth_has_heading);
  EXPECT_GT(replayed(*rsf)->setting.start_heading_sigma_rad, 1.0);
}

TEST(Recording, of_libRSF_with_turns_after_motion_has_steps_with_the_same_ends) {
  const auto rsf = read_recording(
      "r", {{"A_Input.txt",
             "odom2 1 -1 0.1 0 1 1 1\nodom2 2 1 0.2 1.5707963267948966 1 1 1\n"
             "odom2 4 0.5 0 -3 1 1 1\n"},
            {"A_GT.txt", "point2 0 0 0 0 0 0 0\nangle 0 3.14 0\npoint2 1 1 0 0 0 0 0\nangle 1 3.14 0\n"}});
  ASSERT_TRUE(rsf) << to_string(rsf.error());
  EXPECT_TRUE(rsf->ground_truth_has_heading);
  EXPECT_EQ(rsf->ground_truth[1].heading_rad, 3.14);
  const std::vector<Pose2> ends{{-1.0, 0.1, 0.0}, {1.0, 0.2, 0.5 * pi}};
  for (std::size_t i = 0; i < ends.size(); ++i) {
    const Recording::Step& step = rsf->odometry[i];
    const Pose2 step_pose =
        estimation::step_of({step.distance_m, step.turn_rad, step.duration_s, 0.0, 0.0, step.left_m});
    EXPECT_NEAR(distance(step_pose, ends[i]), 0.0, 1e-12) << i;
    EXPECT_NEAR(step_pose.heading_rad, ends[i].heading_rad, 1e-12) << i;
  }
  EXPECT_EQ(rsf->odometry[2].distance_m, 1.0);  // nearly a full turn in one step: unchanged
  EXPECT_EQ(refusal({{"A_Input.txt", "odom2 1 1 0\n"}, {"A_GT.txt", "point2 0 0 0\n"}}),
            "recording.width A_Input.txt:1");
  EXPECT_EQ(refusal({{"A_Input.txt", "odom2 1 1 0 0\nodom2 1 1 0 0\n"}, {"A_GT.txt", "point2 0 0 0\n"}}),
            "recording.stamp A_Input.txt:2");
  EXPECT_EQ(refusal({{"A_Input.txt", "odom2 1 1 0 0\nodom2 2 1 0 0\n"}, {"A_GT.txt", "point2 0 0 0\nangle 0\n"}}),
            "recording.width A_GT.txt:2");
}

TEST(Recording, of_libRSF_may_include_its_sensors_parameters) {
  const auto rsf = read_recording("r", {{"A_Input.txt", "odom2 1 1 0 0\nodom2 2 1 0 0\n"},
                                        {"A_GT.txt", "point2 0 0 0\npoint2 1 1 0\n"},
                                        {"sensors.csv", "name,value\nturn_variance_per_m,0.0004\n"}});
  ASSERT_TRUE(rsf) << to_string(rsf.error());
  EXPECT_EQ(replayed(*rsf)->setting.sensors.turn_variance_per_m, 0.0004);
}

TEST(Recording, of_sideways_motion_includes_its_distance) {
  const auto files = with(
      "odometry.csv", "time_s,delta_distance_m,delta_left_m,delta_heading_rad\n1,0.5,0,0\n2,0.6,0.8,0\n3,1,0,0.1\n");
  const auto trial = replayed(*read_recording("s", files), {1.5, 0.05, 0.05});
  ASSERT_TRUE(trial);
  EXPECT_DOUBLE_EQ(std::get<estimation::Odometry>(trial->events[3]).left_m, 0.6);  // three quarters of it
  EXPECT_DOUBLE_EQ(trial->moments[1].travelled_m, 1.5);
  const auto speeds =
      read_recording("s", with("odometry.csv", "time_s,speed_mps,speed_left_mps,turn_radps\n1,1,0,0\n1.5,2,-1,0.4\n"));
  ASSERT_TRUE(speeds);
  EXPECT_DOUBLE_EQ(speeds->odometry[1].left_m, -0.5);
  EXPECT_EQ(refusal(with("odometry.csv", "time_s,delta_distance_m,delta_left_m,delta_heading_rad\n1,0.5,x,0\n")),
            "recording.number odometry.csv:2");
}

TEST(Recording, that_is_invalid_is_refused_with_its_location) {
  EXPECT_EQ(refusal({}), "recording.missing bad");
  EXPECT_EQ(refusal({{"odometry.csv", small()["odometry.csv"]}}), "recording.missing bad");
  EXPECT_EQ(refusal(with("odometry.csv", "time_s,delta_distance_m,delta_heading_rad\n2,1,0\n1,1,0\n")),
            "recording.stamp odometry.csv, row 2");
  EXPECT_EQ(refusal(with("odometry.csv", "time_s,delta_distance_m,delta_heading_rad\nnan,1,0\n")),
            "recording.number odometry.csv:2");
  EXPECT_EQ(refusal(with("odometry.csv", "time_s,delta_distance_m\n1,1\n")), "recording.column odometry.csv");
  EXPECT_EQ(refusal(with("odometry.csv", "1,2,3\n")), "recording.header odometry.csv:1");
  EXPECT_EQ(refusal(with("odometry.csv", "time_s,delta_distance_m,delta_heading_rad\n")),
            "recording.empty odometry.csv");
  EXPECT_EQ(refusal(with("odometry.csv", "time_s,delta_distance_m,delta_heading_rad\n1,1\n")),
            "recording.width odometry.csv:2");
  EXPECT_EQ(refusal(with("groundtruth.csv", "time_s,x_m,y_m\n1000,0,0\n1001,0,0\n")), "recording.overlap bad");
  EXPECT_EQ(refusal(with("beacons.csv", "beacon_id,x_m,y_m\n7,1,2\n7,1,3\n")), "recording.beacon beacons.csv");
  EXPECT_EQ(refusal(with("beacons.csv", "beacon_id,x_m,y_m\n8,1,2\n")), "recording.beacon bad");
  EXPECT_EQ(refusal(with("beacons.csv", "beacon_id,x_m,y_m\n7.5,1,2\n")), "recording.beacon beacons.csv");
  EXPECT_EQ(refusal(with("sensors.csv", "name,value\nmagic,1\n")), "recording.sensors bad/sensors.csv");
  EXPECT_EQ(refusal(with("sensors.csv", "name,value\nrange_sigma_m,-1\n")), "recording.sensors sensors.csv:2");
}

/// small(), as another program would have written it.
RecordingFiles rewritten(const std::function<std::string(std::string)>& rewrite) {
  RecordingFiles files = small();
  for (auto& [file, text] : files) text = rewrite(text);
  return files;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
  return text;
}

TEST(Recording, does_not_depend_on_the_notation_of_its_tables) {
  const auto plain = replayed(*read_recording("small", small()), {1.5, 0.05, 0.05});
  ASSERT_TRUE(plain);
  const std::vector<std::function<std::string(std::string)>> hands{
      [](const std::string& text) { return replaced(text, ",", ";"); },
      [](const std::string& text) { return replaced(text, ",", "\t"); },
      [](const std::string& text) { return replaced(text, ",", "  "); },
      [](const std::string& text) { return replaced(text, ",", " , "); },
      [](const std::string& text) { return replaced(text, "\n", "\r\n"); },
      [](const std::string& text) { return replaced(text, "\n", ",\n"); },
      [](const std::string& text) { return "\xEF\xBB\xBF" + text; },
      [](const std::string& text) { return "# " + text; },
      [](const std::string& text) { return "# a mower, on a lawn\n\n" + text + "\n \n"; },
      [](const std::string& text) {
        const std::string lines = text.substr(0, text.size() - 1);  // without the line end of the last line
        return "\"" + replaced(replaced(lines, ",", "\",\""), "\n", "\"\n\"") + "\"\n";
      },
  };
  for (std::size_t hand = 0; hand < hands.size(); ++hand) {
    const auto recording = read_recording("small", rewritten(hands[hand]));
    ASSERT_TRUE(recording) << hand << ": " << to_string(recording.error());
    const auto trial = replayed(*recording, {1.5, 0.05, 0.05});
    ASSERT_TRUE(trial) << hand << ": " << to_string(trial.error());
    ASSERT_EQ(trial->events.size(), plain->events.size()) << hand;
    for (std::size_t i = 0; i < plain->moments.size(); ++i) {
      EXPECT_EQ(trial->moments[i].t_s, plain->moments[i].t_s) << hand;
      EXPECT_EQ(trial->moments[i].ground_truth, plain->moments[i].ground_truth) << hand;
    }
  }
}

TEST(Recording, may_have_unused_text_columns_but_no_text_where_numbers_are_needed) {
  const auto phrase = read_recording(
      "s", with("odometry.csv", "mode,time_s,delta_distance_m,delta_heading_rad\nauto,1,0.5,0\nby hand,2,1,0\n"));
  ASSERT_TRUE(phrase) << to_string(phrase.error());
  EXPECT_EQ(phrase->odometry[1].distance_m, 1.0);
  EXPECT_EQ(refusal(with("odometry.csv", "time_s,delta_distance_m,delta_heading_rad\n1,0.5,0\n2,auto,0\n")),
            "recording.number odometry.csv:3");
  EXPECT_EQ(refusal(with("groundtruth.csv", "time_s,x_m,y_m,heading_rad\n0,0,0,nan\n1,1,0,0\n")),
            "recording.number groundtruth.csv:2");
  EXPECT_EQ(refusal(with("groundtruth.csv", "time_s,x_m,y_m\n0,0,\n1,1,0\n")), "recording.number groundtruth.csv:2");
  EXPECT_EQ(refusal(with("odometry.csv", std::string("t\0i\0m\0e\0", 8))), "recording.text odometry.csv");
}

TEST(Recording, leaves_out_invalid_ranges_and_reports_it) {
  const auto recording =
      read_recording("s", with("ranges.csv", "time_s,beacon_id,range_m\n1.25,7,-1\n1.5,7,0\n2.5,7,2.0\n"));
  ASSERT_TRUE(recording);
  ASSERT_EQ(recording->ranges.size(), 1U);
  EXPECT_EQ(recording->ranges[0].range_m, 2.0);
  ASSERT_EQ(recording->diagnostics.size(), 1U);
  EXPECT_EQ(recording->diagnostics[0], "2 ranges are no distances (0 or less); they are left out");
}

TEST(Recording, with_a_long_odometry_gap_reports_it) {
  std::string odometry = "time_s,delta_distance_m,delta_heading_rad\n";
  for (int i = 1; i < 20; ++i) odometry += std::to_string(i < 10 ? 0.1 * i : 0.1 * i + 12.0) + ",0.01,0\n";
  const auto recording = read_recording("s", with("odometry.csv", odometry));
  ASSERT_TRUE(recording);
  ASSERT_EQ(recording->diagnostics.size(), 1U);
  EXPECT_EQ(recording->diagnostics[0].substr(0, 46), "odometry is missing 1 time, for 12 s at most; ");
}

TEST(Recording, of_libRSF_may_have_comments_and_lines_of_other_kinds) {
  const auto rsf =
      read_recording("r", {{"A_Input.txt",
                            "# Control area 3, run 7\nimu3 0.1 a b c\nodom2diff 0.1 1 1 0 0.1 1 1 1\n"
                            "odom2diff 0.3 0.4 0.6 0 0.1 1 1 1\n"},
                           {"A_GT.txt", "% t x y\npoint2 0.1 1.5 2.5 0 0 0 0\npoint2 0.3 1.6 2.5 0 0 0 0\n"}});
  ASSERT_TRUE(rsf) << to_string(rsf.error());
  EXPECT_EQ(rsf->odometry.size(), 2U);
  EXPECT_EQ(refusal({{"A_Input.txt", "odom2diff 0.1 a 1 0 0.1 1 1 1\n"}, {"A_GT.txt", "point2 0 0 0\n"}}),
            "recording.number A_Input.txt:1");
}

struct Outcome {
  double rmse_m;
  double covered;
};

Outcome outcome_of(const Trial& trial, const std::string& name) {
  const estimation::Registry registry;
  Trace trace;
  apply(**registry.make(name, trial.setting), trial, trace);
  // Two degrees of freedom: 95 % are below 5.991.
  return {statistics::root_mean_square(trace.error_m), statistics::ratio_below(trace.nees, 5.991)};
}

Trial trial_of(const std::string& path) {
  const auto recording = read_recording(path, folder(path));
  EXPECT_TRUE(recording) << to_string(recording.error());
  auto trial = replayed(*recording);
  EXPECT_TRUE(trial) << to_string(trial.error());
  return *trial;
}

TEST(RecordedStatistics, mower_is_located_better_by_calibrating_filters_and_better_still_by_smoothers) {
  const Trial trial = trial_of(recorded() + "plaza1");
  EXPECT_GT(trial.moments.size(), 9600U);
  const Outcome filter = outcome_of(trial, "calibrating");
  const Outcome smoother = outcome_of(trial, "smoother");
  const Outcome ekf = outcome_of(trial, "ekf");
  EXPECT_LE(filter.rmse_m, 0.48);
  EXPECT_LE(smoother.rmse_m, 0.38);
  EXPECT_GT(ekf.rmse_m, 1.0);  // ranges 7 % too long, which the EKF assumes to be unbiased
  EXPECT_LT(ekf.covered, 0.5);
  for (const double covered : {filter.covered, smoother.covered}) {
    EXPECT_GE(covered, 0.90);
    EXPECT_LE(covered, 0.99);
  }
}

TEST(Recorded, robot_among_uwb_beacons_is_located_as_accurately_as_published_with_valid_regions) {
  const Trial trial = trial_of(recorded() + "labyrinth");
  const Outcome filter = outcome_of(trial, "calibrating");
  const Outcome smoother = outcome_of(trial, "smoother");
  EXPECT_LE(filter.rmse_m, 0.072);
  EXPECT_LE(smoother.rmse_m, 0.052);
  for (const double covered : {filter.covered, smoother.covered}) {
    EXPECT_GE(covered, 0.90);
    EXPECT_LE(covered, 0.99);
  }
}

TEST(Recorded, mower_with_every_tenth_range_has_its_range_noise_estimated_from_a_filter_s_innovations) {
  RecordingFiles files = folder(recorded() + "plaza1");
  std::stringstream lines(files["ranges.csv"]);
  std::string thin;
  std::string line;
  for (int i = 0; std::getline(lines, line); ++i) {
    if (i % 10 == 0) thin += line + "\n";
  }
  files["ranges.csv"] = thin;
  const auto recording = read_recording("thin", files);
  ASSERT_TRUE(recording) << to_string(recording.error());
  EXPECT_FALSE(range_noise_m(*recording));  // too far apart to be compared with each other
  const auto trial = replayed(*recording);
  ASSERT_TRUE(trial);
  // All of them scatter by about a metre; the data sheet of another radio would be ten times too optimistic.
  EXPECT_NEAR(trial->setting.sensors.range_sigma_m, 1.0, 0.6);
  const Outcome filter = outcome_of(*trial, "calibrating");
  EXPECT_LE(filter.rmse_m, 0.6);
  EXPECT_GE(filter.covered, 0.88);
  // Given sensor parameters take precedence.
  files["sensors.csv"] = "name,value\nrange_sigma_m,0.3\n";
  EXPECT_EQ(replayed(*read_recording("thin", files))->setting.sensors.range_sigma_m, 0.3);
}

}  // namespace
}  // namespace cosiva::experiments
