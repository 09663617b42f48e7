#include "cosiva/aiv/estimation/track.h"

#include <gtest/gtest.h>

#include "cosiva/aiv/estimation/test_tracks.h"

namespace cosiva::estimation {
namespace {

TEST(Track, unrolls_its_rounds) {
  const auto oval = testing::oval();
  const double round_m = 6.0 + 2.0 * pi * 0.8;
  EXPECT_NEAR(oval->length_m(), round_m, 1e-12);
  EXPECT_NEAR(oval->pose_at(2.0 * round_m + 1.5).x_m, 1.5, 1e-9);
  EXPECT_NEAR(oval->pose_at(-0.1).x_m, oval->pose_at(round_m - 0.1).x_m, 1e-12);
  EXPECT_NEAR(oval->curvature_at(3.5), 1.25, 1e-12);
}

TEST(Track, that_ends_goes_no_further) {
  const auto straight = testing::straight();
  EXPECT_EQ(straight->pose_at(12.0).x_m, 10.0);
  EXPECT_EQ(straight->pose_at(-1.0).x_m, 0.0);
}

TEST(Track, finds_the_foot_of_a_point_in_the_intended_round) {
  const auto oval = testing::oval();
  EXPECT_NEAR(*oval->foot({2.0, 0.03}, 2.3, 1.0), 2.0, 1e-12);
  EXPECT_NEAR(*oval->foot({2.0, 0.03}, oval->length_m() + 1.8, 1.0), oval->length_m() + 2.0, 1e-9);
  EXPECT_FALSE(oval->foot({2.0, 0.3}, 2.0, 1.0));  // off the path
  EXPECT_FALSE(oval->foot({2.0, 0.0}, 5.0, 1.0));  // beyond the reach
}

TEST(Track, gives_the_arc_length_of_a_position_and_none_for_a_position_off_the_track) {
  const auto circuit = testing::oval_circuit();
  const auto half = testing::track(circuit, {1, 2}, false);
  EXPECT_NEAR(*half->along_of({2, 0.5}), pi * 0.8 + 0.5, 1e-12);
  EXPECT_FALSE(half->along_of({0, 0.5}));
}

TEST(Track, follows_the_loop_under_the_vehicle_and_by_default_the_first_one) {
  auto zone = std::make_shared<zone::TrafficZone>(
      zone::TrafficZone{"test", *testing::oval_circuit(), {}, {}, {}, {}, {}, {}, {}, {}});
  EXPECT_NEAR(Track::round(zone)->length_m(), 6.0 + 1.6 * pi, 1e-12);
  zone->loops = {{"whole", {0, 1, 2, 3}}, {"late", {2, 3, 0, 1}}};
  EXPECT_EQ(Track::round(zone)->position_at(0.0).section, 0U);
  zone->loops.front().sections = {0, 1};
  EXPECT_EQ(Track::round(zone, zone::SectionId{3})->position_at(0.0).section, 2U);
  EXPECT_FALSE(Track::round(zone, zone::SectionId{1}));  // 0 does not follow 1
}

TEST(Track, prefers_a_foot_at_right_angles_to_the_end_of_the_section_before) {
  // 5 cm beyond the joint; the estimate is still before it, and so is the end that would be nearer.
  const auto oval = testing::oval();
  const Point2 fiducial = position(oval->pose_at(3.05));
  EXPECT_NEAR(*oval->foot(fiducial, 2.98, 1.0), 3.05, 1e-9);
}

TEST(Track, of_sections_that_do_not_follow_each_other_is_refused) {
  const auto circuit = testing::oval_circuit();
  EXPECT_EQ(Track::make(circuit, {0, 2}, false).error().code, "track.gap");
  EXPECT_EQ(Track::make(circuit, {0, 1}, true).error().code, "track.gap");
  EXPECT_EQ(Track::make(circuit, {}, true).error().code, "track.empty");
  EXPECT_TRUE(Track::make(circuit, {0, 1}, false));
}

TEST(Track, of_a_loop_omits_sections_that_only_lead_into_it) {
  std::vector<zone::Circuit::Part> parts;
  parts.push_back(testing::part("in", {-2.0, 0.0, 0.0}, 2.0, 0.0, {1}));
  parts.push_back(testing::part("half", {0.0, 0.0, 0.0}, pi, 1.0, {2}));
  parts.push_back(testing::part("other", parts.back().section.end(), pi, 1.0, {1}));
  const auto loop = Track::of_loop(testing::circuit(std::move(parts)));
  ASSERT_TRUE(loop);
  EXPECT_TRUE(loop->closed());
  EXPECT_NEAR(loop->length_m(), 2.0 * pi, 1e-12);
  EXPECT_FALSE(Track::of_loop(testing::straight()->shared_circuit())->closed());
}

}  // namespace
}  // namespace cosiva::estimation
