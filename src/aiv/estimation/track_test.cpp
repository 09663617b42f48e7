#include "cosiva/aiv/estimation/track.h"

#include <gtest/gtest.h>

#include <optional>

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

TEST(Track, passes_from_one_section_to_the_next_at_the_joint) {
  const auto oval = testing::oval();
  const double bend_m = pi * 0.8;
  struct Case {
    double along_m;
    zone::SectionId section;
    double s_m;
  };
  for (const Case& one : {Case{0.0, 0, 0.0},
                          {3.0, 1, 0.0},
                          {3.0 + bend_m, 2, 0.0},
                          {2.5, 0, 2.5},
                          {3.5, 1, 0.5},
                          {oval->length_m(), 0, 0.0},
                          {-1e-18, 0, 0.0},  // rounded to a whole round
                          {-0.5, 3, bend_m - 0.5},
                          {-oval->length_m() - 0.5, 3, bend_m - 0.5},
                          {3.0 * oval->length_m() + 1.0, 0, 1.0}}) {
    const zone::TrackPosition position = oval->position_at(one.along_m);
    EXPECT_EQ(position.section, one.section) << one.along_m;
    EXPECT_NEAR(position.s_m, one.s_m, 1e-9) << one.along_m;
  }
  const auto open = testing::track(testing::oval_circuit(), {0, 1}, false);
  EXPECT_EQ(open->position_at(3.0 + bend_m).section, 1U);
  EXPECT_NEAR(open->position_at(99.0).s_m, bend_m, 1e-12);
}

TEST(Track, foot_is_the_one_nearest_to_the_estimate_and_within_its_reach) {
  const auto oval = testing::oval();
  const double round_m = oval->length_m();
  // The foot is at 2 m of each round.
  struct Case {
    double near_m;
    double reach_m;
    std::optional<double> along_m;
  };
  for (const Case& one : {Case{2.5, 0.6, 2.0},
                          {2.5, 0.4, std::nullopt},
                          {1.5, 0.6, 2.0},
                          {1.5, 0.4, std::nullopt},
                          {2.0 + round_m - 0.4, 0.5, 2.0 + round_m},
                          {2.0 - round_m + 0.4, 0.5, 2.0 - round_m},
                          {-0.5, 3.0, 2.0},  // ahead, beyond the joint of rounds
                          {round_m - 0.5, 3.0, round_m + 2.0},
                          {2.0 + 0.4 * round_m, 2.0 * round_m, 2.0},  // nearest of several rounds
                          {2.0 + 0.6 * round_m, 2.0 * round_m, 2.0 + round_m}}) {
    const auto foot = oval->foot({2.0, 0.05}, one.near_m, one.reach_m);
    ASSERT_EQ(foot.has_value(), one.along_m.has_value()) << one.near_m << " " << one.reach_m;
    if (foot) {
      EXPECT_NEAR(*foot, *one.along_m, 1e-9) << one.near_m;
    }
  }
  // An open track does not come round.
  const auto open = testing::track(testing::oval_circuit(), {0, 1}, false);
  EXPECT_FALSE(open->foot({2.0, 0.0}, 2.0 + open->length_m(), 1.0));
  EXPECT_NEAR(*open->foot({2.0, 0.0}, 2.9, 1.0), 2.0, 1e-9);
}

TEST(Track, foot_is_off_the_path_by_ten_centimetres_at_most_unless_more_is_permitted) {
  const auto straight = testing::straight();
  EXPECT_TRUE(straight->foot({2.0, 0.099}, 2.0, 1.0));
  EXPECT_FALSE(straight->foot({2.0, 0.101}, 2.0, 1.0));
  EXPECT_TRUE(straight->foot({2.0, -0.299}, 2.0, 1.0, 0.3));
  EXPECT_FALSE(straight->foot({2.0, -0.301}, 2.0, 1.0, 0.3));
  // Beyond the end there is no foot at right angles, and the end serves.
  EXPECT_NEAR(*straight->foot({10.05, 0.0}, 9.9, 1.0), 10.0, 1e-12);
}

TEST(Track, along_of_a_position_counts_from_its_first_section) {
  const auto late = testing::track(testing::oval_circuit(), {1, 2, 3, 0}, true);
  EXPECT_NEAR(*late->along_of({1, 0.25}), 0.25, 1e-12);
  EXPECT_NEAR(*late->along_of({0, 0.25}), 3.0 + 1.6 * pi + 0.25, 1e-12);
}

TEST(Track, gap_is_named) {
  const auto error = Track::make(testing::oval_circuit(), {3, 0, 2}, false).error();
  EXPECT_NE(error.message.find("north"), std::string::npos);
  EXPECT_NE(to_string(error).find("south"), std::string::npos);
  const auto around = Track::make(testing::oval_circuit(), {0, 1, 2}, true).error();
  EXPECT_NE(around.message.find("south"), std::string::npos);
  EXPECT_NE(to_string(around).find("north"), std::string::npos);
}

TEST(Track, foot_may_be_off_by_exactly_as_much_as_is_permitted) {
  const auto straight = testing::straight();
  for (const double near_m : {1.5, 2.5}) {
    EXPECT_EQ(straight->foot({2.0, 0.125}, near_m, 0.5, 0.125), 2.0) << near_m;
    EXPECT_FALSE(straight->foot({2.0, 0.125}, near_m, 0.4999, 0.125)) << near_m;
    EXPECT_FALSE(straight->foot({2.0, 0.125}, near_m, 0.5, 0.1249)) << near_m;
  }
}

TEST(Track, that_is_open_is_no_longer_than_its_sections_and_closed_without_a_gap) {
  const auto circuit = testing::oval_circuit();
  const auto one = testing::track(circuit, {2}, false);
  EXPECT_NEAR(one->length_m(), 3.0, 1e-12);
  EXPECT_FALSE(one->closed());
  EXPECT_EQ(Track::make(circuit, {2}, true).error().code, "track.gap");
  EXPECT_TRUE(Track::make(circuit, {2, 3, 0, 1}, true));
}

}  // namespace
}  // namespace cosiva::estimation
