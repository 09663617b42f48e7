#include "cosiva/aiv/perception/sighting.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace cosiva::aiv {
namespace {

constexpr double nothing = std::numeric_limits<double>::infinity();
constexpr int centre = 6;  ///< of thirteen beams

wire::Ranges no_ranges() { return {0, -84, 14, std::vector<std::uint16_t>(13, wire::no_echo)}; }

/// What a fan of sectors at the origin measures of a disc at p: per beam the disc's nearest point in the beam's sector.
wire::Ranges fan_on(Point2 p, double radius_m) {
  wire::Ranges ranges = no_ranges();
  for (std::size_t beam = 0; beam < 13; ++beam) {
    double nearest_m = nothing;
    for (int i = 0; i <= 20; ++i) {
      const double bearing = -0.84 - 0.07 + 0.14 * (static_cast<double>(beam) + i / 20.0);
      const double along_m = p.x_m * std::cos(bearing) + p.y_m * std::sin(bearing);
      const double off2 = p.x_m * p.x_m + p.y_m * p.y_m - along_m * along_m;
      if (along_m > 0.0 && off2 < radius_m * radius_m)
        nearest_m = std::min(nearest_m, along_m - std::sqrt(radius_m * radius_m - off2));
    }
    if (nearest_m < 2.0) ranges.range_mm[beam] = static_cast<std::uint16_t>(std::lround(1e3 * nearest_m));
  }
  return ranges;
}
std::size_t nearest_beam(const wire::Ranges& ranges) {
  const auto nearest = std::min_element(ranges.range_mm.begin(), ranges.range_mm.end());
  return static_cast<std::size_t>(nearest - ranges.range_mm.begin());
}

TEST(BodyInBeams, lies_behind_its_nearest_point_by_its_radius) {
  for (const double away_m : {0.25, 0.4, 0.6, 0.9}) {
    for (const double bearing : {-0.3, -0.1, 0.0, 0.15, 0.4}) {
      for (const double radius_m : {0.03, 0.06, 0.10}) {
        const Point2 p{away_m * std::cos(bearing), away_m * std::sin(bearing)};
        const wire::Ranges ranges = fan_on(p, radius_m);
        const auto obstacle = body_in_beams({0.3, nearest_beam(ranges)}, ranges, {});
        // The lateral resolution of such a fan is half a beam.
        EXPECT_LT(distance({obstacle.x_m, obstacle.y_m}, p), 0.075 * away_m + 0.04)
            << away_m << " " << bearing << " " << radius_m;
        EXPECT_NEAR(obstacle.radius_m, radius_m, 0.07 * away_m + 0.03) << away_m << " " << bearing << " " << radius_m;
      }
    }
  }
}

TEST(BodyInBeams, is_reported_in_the_map_frame) {
  wire::Ranges ranges = no_ranges();
  ranges.range_mm[centre] = 400;
  const auto obstacle = body_in_beams({0.4, centre}, ranges, {1.0, 2.0, pi / 2});
  EXPECT_NEAR(obstacle.x_m, 1.0, 1e-9);
  EXPECT_NEAR(obstacle.y_m, 2.0 + 0.4 + obstacle.radius_m, 1e-9);
  EXPECT_EQ(obstacle.distance_m, 0.4);
}

TEST(BodyInBeams, does_not_grow_by_a_body_behind_it) {
  wire::Ranges ranges = no_ranges();
  ranges.range_mm[centre] = 400;
  const double alone_m = body_in_beams({0.4, centre}, ranges, {}).radius_m;
  ranges.range_mm[centre + 1] = 700;
  ranges.range_mm[centre - 1] = 650;
  EXPECT_EQ(body_in_beams({0.4, centre}, ranges, {}).radius_m, alone_m);
  ranges.range_mm[centre + 1] = 430;
  ranges.range_mm[centre - 1] = 430;
  EXPECT_GT(body_in_beams({0.4, centre}, ranges, {}).radius_m, alone_m + 0.04);
}

TEST(BodyInBeams, stays_finite_with_a_wall_in_every_beam_and_with_none_at_all_between) {
  wire::Ranges wall = no_ranges();
  wall.range_mm.assign(13, 300);
  const auto obstacle = body_in_beams({0.3, centre}, wall, {});
  EXPECT_LE(obstacle.radius_m, 0.15);
  const wire::Ranges touching{0, 0, 14, {0}};
  EXPECT_NEAR(body_in_beams({0.0, 0}, touching, {}).x_m, 0.02, 1e-9);
}

/// Frames 60 ms apart.
struct Sensors {
  Sighting sighting;
  SimTime now{virtual_epoch};
  int reported{0};
  std::optional<wire::DetectedObstacleReport> last;

  bool frame(double gap_m) {
    now += std::chrono::milliseconds{60};
    wire::Ranges ranges = no_ranges();
    if (gap_m < 2.0) ranges.range_mm[centre] = static_cast<std::uint16_t>(std::lround(1e3 * gap_m));
    const auto detected = sighting.on_frame(now, {gap_m, centre}, ranges, {}, 1.2);
    if (detected) last = detected;
    reported += detected ? 1 : 0;
    return detected.has_value();
  }
};

TEST(Sighting, reports_a_new_obstacle_at_once_and_then_ten_times_a_second) {
  Sensors sensors;
  EXPECT_TRUE(sensors.frame(0.5));
  ASSERT_TRUE(sensors.last->obstacle);
  EXPECT_EQ(sensors.last->clear_m, 0.5);
  sensors.reported = 0;
  for (int i = 0; i < 50; ++i) static_cast<void>(sensors.frame(0.5));  // three seconds
  EXPECT_GE(sensors.reported, 24);
  EXPECT_LE(sensors.reported, 30);
}

TEST(Sighting, reports_the_end_of_a_detection_three_times_and_then_nothing) {
  Sensors sensors;
  static_cast<void>(sensors.frame(0.5));
  int frames = 0;
  while (!sensors.frame(nothing)) ASSERT_LT(++frames, 5);
  EXPECT_FALSE(sensors.last->obstacle);
  EXPECT_EQ(sensors.last->clear_m, 1.2) << "the whole reach";
  sensors.reported = 1;
  for (int i = 0; i < 50; ++i) static_cast<void>(sensors.frame(nothing));
  EXPECT_EQ(sensors.reported, 3);
}

TEST(Sighting, keeps_an_obstacle_over_two_missing_echoes) {
  Sensors sensors;
  for (int i = 0; i < 60; ++i) {
    static_cast<void>(sensors.frame(i % 3 == 0 ? 0.5 : nothing));
    ASSERT_TRUE(sensors.last->obstacle) << i;
  }
}

TEST(Sighting, reports_no_obstacle_more_than_a_metre_away) {
  Sensors sensors;
  for (int i = 0; i < 10; ++i) EXPECT_FALSE(sensors.frame(1.01));
  static_cast<void>(sensors.frame(0.99));
  for (int i = 0; i < 5; ++i) static_cast<void>(sensors.frame(1.05));
  EXPECT_FALSE(sensors.last->obstacle);
  EXPECT_EQ(sensors.last->clear_m, 1.05);
}

TEST(Sighting, reports_nothing_before_a_first_detection) {
  Sensors sensors;
  for (int i = 0; i < 20; ++i) EXPECT_FALSE(sensors.frame(nothing));
}

TEST(BodyInBeams, lies_at_the_centre_of_its_beams_as_wide_as_they_are) {
  // Beams of 0.14 rad; number six leads straight on.
  struct Case {
    std::vector<std::pair<std::size_t, std::uint16_t>> beams;
    std::size_t nearest;
    double bearing_rad;
    double range_m;
    double half_rad;  ///< between the outer beams
  };
  for (const Case& one : {Case{{{6, 400}}, 6, 0.0, 0.4, 0.0},
                          {{{6, 400}, {7, 450}}, 6, 0.07, 0.4, 0.07},
                          {{{6, 400}, {7, 451}}, 6, 0.0, 0.4, 0.0},
                          {{{5, 430}, {6, 400}, {7, 440}}, 6, 0.0, 0.4, 0.14},
                          {{{0, 430}, {1, 400}}, 1, -0.77, 0.4, 0.07},
                          {{{11, 430}, {12, 400}}, 12, 0.77, 0.4, 0.07},
                          {{{5, 380}, {6, 400}}, 6, -0.07, 0.38, 0.07},  // nearer along the path, not from the sensor
                          {{{4, 400}, {6, 400}}, 6, 0.0, 0.4, 0.0}}) {   // a gap between the two
    wire::Ranges ranges = no_ranges();
    for (const auto& [beam, range_mm] : one.beams) ranges.range_mm[beam] = range_mm;
    const auto obstacle = body_in_beams({0.25, one.nearest}, ranges, {});
    const double ratio = std::sin(one.half_rad);
    const double radius_m = std::fmax(0.02, one.range_m * ratio / (1.0 - ratio));
    EXPECT_NEAR(obstacle.radius_m, radius_m, 1e-9);
    EXPECT_NEAR(obstacle.x_m, (one.range_m + radius_m) * std::cos(one.bearing_rad), 1e-9);
    EXPECT_NEAR(obstacle.y_m, (one.range_m + radius_m) * std::sin(one.bearing_rad), 1e-9);
    EXPECT_EQ(obstacle.distance_m, 0.25);
  }
}

TEST(BodyInBeams, is_no_wider_than_a_quarter_turn_and_15_centimetres) {
  wire::Ranges wall = no_ranges();
  wall.range_mm.assign(13, 50);  // 1.68 rad between the outer beams
  const double ratio = std::sin(0.25 * pi);
  EXPECT_NEAR(body_in_beams({0.05, centre}, wall, {}).radius_m, 0.05 * ratio / (1.0 - ratio), 1e-9);
  wall.range_mm.assign(13, 300);
  EXPECT_EQ(body_in_beams({0.3, centre}, wall, {}).radius_m, 0.15);
}

/// Which of these frames are reported, "x" with an obstacle and "o" without; times in milliseconds.
std::string reports(const std::vector<std::pair<int, double>>& frames) {
  Sighting sighting;
  std::string text;
  for (const auto& [at_ms, gap_m] : frames) {
    wire::Ranges ranges = no_ranges();
    ranges.range_mm[centre] = 400;
    const auto report =
        sighting.on_frame(virtual_epoch + std::chrono::milliseconds{at_ms}, {gap_m, centre}, ranges, {}, 1.2);
    text += !report ? "." : report->obstacle ? "x" : "o";
  }
  return text;
}

TEST(Sighting, reports_at_the_period_and_anew_after_an_end) {
  EXPECT_EQ(reports({{0, 1.0}, {99, 1.0}, {100, 1.0}, {150, 1.0}, {200, 1.0}}), "x.x.x");
  EXPECT_EQ(reports({{0, 1.001}, {100, 1.001}}), "..");
  // The end is reported at the third frame without it at once, then at the period, three times in all.
  EXPECT_EQ(reports({{0, 0.5},
                     {10, nothing},
                     {20, nothing},
                     {30, nothing},
                     {129, nothing},
                     {130, nothing},
                     {230, nothing},
                     {330, nothing},
                     {430, nothing}}),
            "x..o.oo..");
  // A new obstacle within the period of the last report.
  EXPECT_EQ(reports({{0, 0.5}, {10, nothing}, {20, nothing}, {30, nothing}, {40, 0.5}, {50, 0.5}, {140, 0.5}}),
            "x..ox.x");
  // A frame with the obstacle counts the misses from zero, and each end has three reports.
  EXPECT_EQ(reports({{0, 0.5},
                     {10, nothing},
                     {20, nothing},
                     {30, 0.5},
                     {40, nothing},
                     {50, nothing},
                     {60, nothing},
                     {160, nothing},
                     {170, 0.5},
                     {180, nothing},
                     {190, nothing},
                     {200, nothing},
                     {300, nothing},
                     {400, nothing},
                     {500, nothing}}),
            "x.....oox..ooo.");
  // A clock that was set back does not silence the reports.
  EXPECT_EQ(reports({{1000, 0.5}, {500, 0.5}, {550, 0.5}}), "xx.");
}

TEST(Sighting, state_is_part_of_the_digest) {
  const auto digest_after = [](const std::vector<double>& frames_m) {
    Sighting sighting;
    SimTime now = virtual_epoch;
    wire::Ranges ranges = no_ranges();
    ranges.range_mm[centre] = 400;
    for (const double gap_m : frames_m) {
      now += std::chrono::milliseconds{200};
      static_cast<void>(sighting.on_frame(now, {gap_m, centre}, ranges, {}, 1.2));
    }
    Digest digest;
    sighting.fold(digest);
    return digest.value();
  };
  const auto none = digest_after({});
  const auto there = digest_after({0.5});
  const auto missed = digest_after({0.5, nothing});
  const auto ended = digest_after({0.5, nothing, nothing, nothing});
  const auto ended_twice = digest_after({0.5, nothing, nothing, nothing, nothing});
  EXPECT_NE(none, there);
  EXPECT_NE(there, missed);
  EXPECT_NE(missed, ended);
  EXPECT_NE(ended, ended_twice);
  EXPECT_EQ(there, digest_after({0.5, 0.5}));
}

}  // namespace
}  // namespace cosiva::aiv
