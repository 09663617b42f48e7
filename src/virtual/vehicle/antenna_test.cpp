#include "cosiva/virtual/vehicle/antenna.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include "cosiva/aiv/testing/test_zone.h"
#include "cosiva/base/random.h"

namespace cosiva::virtual_side {
namespace {

using aiv::test::at;
using aiv::test::lacet4;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

/// One straight section of 10 m along x, with the fiducials that a test puts on the floor.
struct Floor {
  zone::TrafficZone zone = lacet4();
  Antenna antenna;
  double x_m{0.0};

  Floor() {
    zone.circuit = aiv::test::lay({{10.0}}, false);
    zone.tags.clear();
    zone.beacons.reset();
  }
  void start(double s_m) {
    x_m = s_m;
    antenna.put(zone, {0, s_m}, {s_m, 0.0});
  }
  std::vector<zone::TagNumber> drive_to(double s_m, double step_m = 0.008) {
    std::vector<Antenna::Reading> readings;
    while (x_m != s_m) {
      const double next_m = s_m > x_m ? std::min(s_m, x_m + step_m) : std::max(s_m, x_m - step_m);
      antenna.move(zone, {0, x_m}, {0, next_m}, {x_m, 0.0}, {next_m, 0.0}, readings);
      x_m = next_m;
    }
    std::vector<zone::TagNumber> numbers;
    for (const auto& reading : readings) numbers.push_back(reading.number);
    return numbers;
  }
};

TEST(Antenna, reads_each_tag_once_as_it_passes) {
  Floor floor;
  floor.zone.tags = {{1, {0, 0.5}}, {2, {0, 0.9}}};
  floor.start(0.0);
  EXPECT_THAT(floor.drive_to(0.45), IsEmpty());
  EXPECT_THAT(floor.drive_to(0.5), ElementsAre(1));
  EXPECT_THAT(floor.drive_to(0.5), IsEmpty()) << "the antenna is on it";
  EXPECT_THAT(floor.drive_to(1.5), ElementsAre(2));
  EXPECT_THAT(floor.drive_to(0.0), ElementsAre(2, 1)) << "and driving back";
}

TEST(Antenna, reports_how_long_ago_the_tag_entered_the_field) {
  Floor floor;
  floor.zone.tags = {{1, {0, 0.5}}};
  floor.start(0.47);
  std::vector<Antenna::Reading> readings;
  floor.antenna.move(floor.zone, {0, 0.47}, {0, 0.485}, {0.47, 0.0}, {0.485, 0.0}, readings);
  ASSERT_EQ(readings.size(), 1U);
  EXPECT_NEAR(readings[0].before_end_m, 0.005, 1e-9);
}

TEST(Antenna, does_not_read_a_tag_that_is_in_its_field_from_the_beginning) {
  Floor floor;
  floor.zone.tags = {{1, {0, 0.5}}};
  floor.start(0.49);
  EXPECT_THAT(floor.drive_to(0.51), IsEmpty());
  floor.zone.tags = {{1, {0, 0.51}}, {2, {0, 0.8}}};
  floor.start(0.51);
  EXPECT_THAT(floor.drive_to(1.0), ElementsAre(2));
}

TEST(Antenna, reads_only_beacons_within_two_centimetres_of_its_path) {
  Floor floor;
  floor.zone.beacons = zone::BeaconGrid{0.30, {0.15, 0.0}, 10, 3, 1'000'000};
  floor.start(0.0);
  EXPECT_THAT(floor.drive_to(0.8), ElementsAre(1'000'000, 1'000'001, 1'000'002));
  floor.zone.beacons->origin = {0.15, 0.019};
  floor.start(0.0);
  EXPECT_THAT(floor.drive_to(0.3), ElementsAre(1'000'000));
  floor.zone.beacons->origin = {0.15, 0.021};
  floor.start(0.0);
  EXPECT_THAT(floor.drive_to(1.0), IsEmpty());
}

TEST(Antenna, misses_no_tag_at_any_speed) {
  EXPECT_TRUE(rc::check([](std::uint64_t seed) {
    Random random{seed, "tags"};
    Floor floor;
    std::vector<zone::TagNumber> all;
    for (zone::TagNumber i = 1; i <= 10; ++i) {
      floor.zone.tags.push_back({i, {0, 0.2 + 0.5 * i + random.uniform(-0.2, 0.2)}});
      all.push_back(i);
    }
    floor.start(0.0);
    RC_ASSERT(floor.drive_to(9.0, random.uniform(0.0005, 0.03)) == all);
  }));
}

}  // namespace
}  // namespace cosiva::virtual_side
