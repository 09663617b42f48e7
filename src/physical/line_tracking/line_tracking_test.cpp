#include "cosiva/physical/line_tracking/line_tracking.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "cosiva/base/math.h"
#include "cosiva/base/random.h"

namespace cosiva::physical {
namespace {

constexpr lt_geometry geometry{8'000, 60'000, 19'000};
using Readings = std::array<std::uint8_t, LT_SENSORS>;

/// What sensors with a field as wide as the pitch read over a line at this offset.
Readings over(double line_m) {
  Readings readings{};
  for (std::size_t i = 0; i < LT_SENSORS; ++i) {
    const double sensor_m = 0.008 * (static_cast<double>(i) - 3.5);
    const double covered = (0.0095 + 0.004 - std::fabs(sensor_m - line_m)) / 0.008;
    readings[i] = static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(covered, 0.0, 1.0)));
  }
  return readings;
}

/// A line of straights and arcs, and a kinematic vehicle that follows it: body 20 ms behind its steering.
struct Track {
  struct Piece {
    double length_m;
    double curvature_per_m;
  };
  std::vector<Piece> pieces;

  [[nodiscard]] double length_m() const {
    double sum_m = 0.0;
    for (const Piece& piece : pieces) sum_m += piece.length_m;
    return sum_m;
  }
  [[nodiscard]] double curvature_at(double s_m) const {
    for (const Piece& piece : pieces) {
      if (s_m < piece.length_m) return piece.curvature_per_m;
      s_m -= piece.length_m;
    }
    return 0.0;
  }
  /// To the left of the tangent at s, at this distance from s.
  [[nodiscard]] double left_m(double s_m, double distance_m) const {
    constexpr int parts = 24;
    const double part_m = distance_m / parts;
    double left_m = 0.0;
    double slope = 0.0;
    for (int i = 0; i < parts; ++i) {
      const double kappa = curvature_at(s_m + (i + 0.5) * part_m);
      left_m += part_m * (slope + 0.5 * part_m * kappa);
      slope += part_m * kappa;
    }
    return left_m;
  }
};

struct Disturbance {
  double line_sd_m{0.0};
  int stuck{-1};  ///< this sensor always reads 255
  double gap_from_m{-1.0};
  double gap_to_m{-1.0};
  double start_offset_m{0.0};
};

struct Drive {
  double rms_m{};
  double worst_m{};
  double last_m{};
  double lost_from_m{-1.0};
  double implausible{};  ///< part of the steps
  std::vector<std::int32_t> curvatures;
};

Drive follow(const std::string& algorithm, const Track& track, double speed_mps, const Disturbance& disturbance = {}) {
  constexpr double dt_s = 0.02;
  constexpr double lag_s = 0.02;
  const lt_algorithm* with = lt_find(algorithm.c_str());
  EXPECT_NE(with, nullptr);
  lt_state state;
  with->init(&state, &geometry);
  Random random{3, "paint"};
  Drive run;
  double s_m = 0.0;
  double left_m = disturbance.start_offset_m;
  double heading_rad = 0.0;
  double turn_radps = 0.0;
  double paint_m = 0.0;
  double squares = 0.0;
  int steps = 0;
  for (; s_m < track.length_m() && std::fabs(left_m) < 0.2; ++steps) {
    const double step_m = speed_mps * dt_s;
    const double keep = 0.05 / (0.05 + step_m);
    paint_m = keep * paint_m + std::sqrt(1.0 - keep * keep) * random.gaussian(0.0, disturbance.line_sd_m);
    const double row_s_m = s_m + 0.06;
    Readings readings = over(track.left_m(s_m, 0.06) - left_m - 0.06 * std::sin(heading_rad) + paint_m);
    if (row_s_m > disturbance.gap_from_m && row_s_m < disturbance.gap_to_m) readings.fill(0);
    if (disturbance.stuck >= 0) readings[static_cast<std::size_t>(disturbance.stuck)] = 255;
    run.implausible += lt_implausible(&geometry, readings.data()) != 0 ? 1.0 : 0.0;
    lt_input in{{}, static_cast<std::int32_t>(std::lround(1e3 * speed_mps)), 20'000};
    std::ranges::copy(readings, in.reading);
    lt_output out;
    with->step(&state, &in, &out);
    run.curvatures.push_back(out.curvature_per_km);
    if (out.line_lost != 0 && run.lost_from_m < 0.0) run.lost_from_m = row_s_m;
    turn_radps += (speed_mps * 1e-3 * out.curvature_per_km - turn_radps) * (1.0 - std::exp(-dt_s / lag_s));
    const double kappa = track.curvature_at(s_m);
    heading_rad += (turn_radps - kappa * speed_mps) * dt_s;
    left_m += step_m * std::sin(heading_rad);
    s_m += step_m * std::cos(heading_rad) / (1.0 - kappa * left_m);
    squares += left_m * left_m;
    run.worst_m = std::max(run.worst_m, std::fabs(left_m));
  }
  run.rms_m = std::sqrt(squares / steps);
  run.last_m = left_m;
  run.implausible /= steps;
  return run;
}

/// A lap of lacet4: four straights of 1.5 m, joined by four loops of 270° to the right, of 0.6 m radius.
Track lacet4() {
  Track track;
  for (int i = 0; i < 4; ++i) {
    track.pieces.push_back({1.5, 0.0});
    track.pieces.push_back({0.6 * 1.5 * pi, -1.0 / 0.6});
  }
  return track;
}
Track straight(double length_m) { return {{{length_m, 0.0}}}; }

std::vector<std::string> names() {
  std::vector<std::string> all;
  for (const lt_algorithm& algorithm : lt_algorithms) all.emplace_back(algorithm.name);
  return all;
}

TEST(LineTracking, finds_its_algorithms_by_name) {
  EXPECT_THAT(names(), testing::ElementsAre("centroid_pd", "path_observer", "threshold"));
  for (const std::string& name : names()) EXPECT_EQ(lt_find(name.c_str())->name, name);
  for (const char* other : {"", "centroid", "centroid_pd2", "PD"}) EXPECT_EQ(lt_find(other), nullptr) << other;
}

TEST(LineTracking, locates_the_line_to_half_a_millimetre_wherever_it_is_wholly_under_the_row) {
  // The row ends 28 mm from its centre, a sensor's field 4 mm beyond, half the line before.
  for (double line_m = -0.022; line_m <= 0.022; line_m += 0.0003) {
    std::int32_t offset_um = 0;
    ASSERT_EQ(lt_locate(&geometry, over(line_m).data(), &offset_um), 1) << line_m;
    EXPECT_NEAR(1e-6 * offset_um, line_m, 0.0005);
  }
}

TEST(LineTracking, locates_no_line_on_a_bare_floor_however_bright_that_is) {
  std::int32_t offset_um = 77;
  for (const std::uint8_t level : {std::uint8_t{0}, std::uint8_t{10}, std::uint8_t{24}}) {
    Readings floor{};
    floor.fill(level);
    EXPECT_EQ(lt_locate(&geometry, floor.data(), &offset_um), 0);
  }
  EXPECT_EQ(lt_locate(&geometry, over(0.045).data(), &offset_um), 0);
  EXPECT_EQ(offset_um, 77);
}

TEST(LineTracking, keeps_to_a_lap_of_lacet4_with_every_algorithm_at_every_speed) {
  for (const std::string& name : names()) {
    for (const double speed_mps : {0.2, 0.4, 0.6, 0.8}) {
      const Drive run = follow(name, lacet4(), speed_mps, {0.0005});
      EXPECT_LT(run.worst_m, 0.005) << name << " at " << speed_mps;
      EXPECT_GT(run.rms_m, 0.0001) << "and is no train on rails";
      EXPECT_LT(run.lost_from_m, 0.0) << name;
      EXPECT_EQ(run.implausible, 0.0);
    }
  }
}

TEST(LineTracking, is_the_better_the_more_an_algorithm_makes_of_the_readings) {
  const Disturbance paint{0.0005};
  const double threshold_m = follow("threshold", lacet4(), 0.4, paint).rms_m;
  EXPECT_LT(follow("centroid_pd", lacet4(), 0.4, paint).rms_m, 0.6 * threshold_m);
  EXPECT_LT(follow("path_observer", lacet4(), 0.4, paint).rms_m, 0.8 * threshold_m);
}

TEST(LineTracking, returns_to_a_line_that_is_15_mm_to_one_side) {
  for (const std::string& name : names()) {
    for (const double side : {-1.0, 1.0}) {
      const Drive run = follow(name, straight(1.5), 0.3, {.line_sd_m = 0.0, .start_offset_m = side * 0.015});
      EXPECT_LT(std::fabs(run.last_m), 0.003) << name;
      EXPECT_LT(run.worst_m, 0.016) << name << ": without overshooting to the other side";
    }
  }
}

TEST(LineTracking, steers_the_mirrored_line_with_the_mirrored_curvature) {
  EXPECT_TRUE(rc::check("left and right are the same", [] {
    const std::string name = *rc::gen::elementOf(names());
    const auto speed_mmps = *rc::gen::inRange(50, 1200);
    lt_state left;
    lt_state right;
    lt_find(name.c_str())->init(&left, &geometry);
    lt_find(name.c_str())->init(&right, &geometry);
    for (int i = 0; i < 50; ++i) {
      const Readings readings = over(1e-4 * *rc::gen::inRange(-200, 201));
      lt_input in{{}, speed_mmps, 20'000};
      lt_input mirrored = in;
      std::ranges::copy(readings, in.reading);
      std::ranges::reverse_copy(readings, mirrored.reading);
      lt_output out;
      lt_output mirrored_out;
      lt_find(name.c_str())->step(&left, &in, &out);
      lt_find(name.c_str())->step(&right, &mirrored, &mirrored_out);
      RC_ASSERT(out.offset_um == -mirrored_out.offset_um);
      // Integer division rounds towards zero in either case.
      RC_ASSERT(std::abs(out.curvature_per_km + mirrored_out.curvature_per_km) <= 40);
    }
  }));
}

TEST(LineTracking, gives_the_same_results_for_the_same_readings) {
  for (const std::string& name : names())
    EXPECT_EQ(follow(name, lacet4(), 0.5, {0.0005}).curvatures, follow(name, lacet4(), 0.5, {0.0005}).curvatures);
}

TEST(LineTracking, never_exceeds_its_limits_whatever_it_reads) {
  EXPECT_TRUE(rc::check("any readings, any speed", [] {
    const std::string name = *rc::gen::elementOf(names());
    lt_state state;
    lt_find(name.c_str())->init(&state, &geometry);
    for (int i = 0; i < 100; ++i) {
      lt_input in{{}, *rc::gen::inRange(0, 3001), *rc::gen::inRange(1, 50'001)};
      for (std::uint8_t& reading : in.reading) reading = *rc::gen::arbitrary<std::uint8_t>();
      lt_output out;
      lt_find(name.c_str())->step(&state, &in, &out);
      RC_ASSERT(std::abs(out.curvature_per_km) <= LT_CURVATURE_MAX_PER_KM);
      RC_ASSERT(std::abs(out.offset_um) <= 28'000);
    }
  }));
}

TEST(LineTracking, bridges_a_gap_of_20_mm_and_reports_a_longer_one_after_30_mm) {
  for (const std::string& name : names()) {
    const Drive bridged = follow(name, straight(2.0), 0.3, {.gap_from_m = 1.0, .gap_to_m = 1.02});
    EXPECT_LT(bridged.lost_from_m, 0.0) << name;
    EXPECT_LT(bridged.worst_m, 0.003) << name;
    const Drive lost = follow(name, straight(2.0), 0.3, {.gap_from_m = 1.0, .gap_to_m = 1.5});
    EXPECT_NEAR(lost.lost_from_m, 1.03, 0.012) << name << ": at most two steps of 6 mm";
  }
}

TEST(LineTracking, reports_the_line_as_lost_before_it_has_detected_any) {
  for (const std::string& name : names()) {
    lt_state state;
    lt_find(name.c_str())->init(&state, &geometry);
    const lt_input in{{}, 0, 20'000};
    lt_output out;
    lt_find(name.c_str())->step(&state, &in, &out);
    EXPECT_EQ(out.line_lost, 1) << name;
    EXPECT_EQ(out.curvature_per_km, 0) << name;
  }
}

TEST(LineTracking, finds_readings_with_a_stuck_sensor_implausible) {
  for (int sensor = 0; sensor < LT_SENSORS; ++sensor) {
    for (const std::uint8_t stuck_at : {std::uint8_t{0}, std::uint8_t{255}}) {
      Readings readings = over(0.0);
      readings[static_cast<std::size_t>(sensor)] = stuck_at;
      // The line is under sensors 2 to 5. A dark sensor at its edge only makes it narrower, and one outside has no
      // effect; a bright one among those under the line neither.
      const bool inside = sensor == 3 || sensor == 4;
      const bool expected = stuck_at == 0 ? inside : !inside;
      EXPECT_EQ(lt_implausible(&geometry, readings.data()) != 0, expected) << sensor << " at " << int{stuck_at};
    }
  }
}

TEST(LineTracking, with_a_stuck_sensor_drives_off_centre_by_what_the_centroid_moves) {
  // The centroid is zero where the line balances the stuck sensor: 28 mm times the part 8/19 of a sensor in the line.
  const Drive run = follow("centroid_pd", straight(2.0), 0.3, {.stuck = 7});
  EXPECT_NEAR(std::fabs(run.last_m), 0.0118, 0.004);
  EXPECT_GT(run.implausible, 0.9);
}

}  // namespace
}  // namespace cosiva::physical
