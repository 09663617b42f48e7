#include "cosiva/aiv/v2x/intent.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "cosiva/aiv/testing/test_graphs.h"
#include "cosiva/aiv/testing/test_orders.h"
#include "cosiva/aiv/testing/test_zone.h"

namespace cosiva::aiv {
namespace {

using test::at;
using test::lacet4;
using test::order;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr zone::SpeedProfile medium{0.40, 0.5, 0.8};

std::vector<CrossingSpan> spans_of(zone::TrackPosition here, double reach_m, std::size_t count_max = 8) {
  static const CrossingFinder crossing_spans{lacet4()};
  std::vector<CrossingSpan> out;
  crossing_spans.ahead(here, reach_m, count_max, out);
  return out;
}

// The clover's straights are 1.5 m long and cross others 0.6 m and 0.9 m from their starts, too close to stop between.

TEST(CrossingFinder, finds_the_two_crossings_of_a_straight_as_one_chain) {
  const auto spans = spans_of(at(lacet4(), "east", 0.1), 1.0);
  ASSERT_THAT(spans, SizeIs(2));
  EXPECT_GT(spans[0].entry_m, 0.25);
  EXPECT_LT(spans[0].entry_m, 0.5);
  EXPECT_GT(spans[0].exit_m, 0.5);
  EXPECT_GT(spans[1].entry_m, spans[0].entry_m);
  EXPECT_GT(spans[1].exit_m, 0.8);
  EXPECT_EQ(spans[0].chain_exit_m, spans[1].exit_m);
  EXPECT_EQ(spans[1].chain_exit_m, spans[1].exit_m);
  EXPECT_NE(spans[0].crossing, spans[1].crossing);
}

TEST(CrossingFinder, follows_a_chain_beyond_its_reach_and_finds_none_outside_it) {
  EXPECT_THAT(spans_of(at(lacet4(), "east", 0.1), 0.35), SizeIs(2));
  EXPECT_THAT(spans_of(at(lacet4(), "east", 0.1), 0.10), IsEmpty());
  EXPECT_THAT(spans_of(at(lacet4(), "east", 1.2), 1.0), IsEmpty()) << "behind the vehicle";
  EXPECT_THAT(spans_of(at(lacet4(), "east", 0.1), 3.0, 1), SizeIs(1));
}

TEST(CrossingFinder, begins_at_the_vehicle_inside_a_crossing) {
  const auto spans = spans_of(at(lacet4(), "east", 0.6), 0.1);
  ASSERT_THAT(spans, SizeIs(2));
  EXPECT_EQ(spans[0].entry_m, 0.0);
  EXPECT_GT(spans[0].exit_m, 0.0);
}

TEST(EarliestArrival, follows_from_speed_and_acceleration) {
  EXPECT_EQ(earliest_s(0.0, 0.3, medium), 0.0);
  EXPECT_EQ(earliest_s(-1.0, 0.3, medium), 0.0);
  EXPECT_DOUBLE_EQ(earliest_s(0.8, 0.4, medium), 2.0);
  EXPECT_DOUBLE_EQ(earliest_s(0.8, 0.5, medium), 1.6) << "a faster vehicle is not counted as slower";
  // From standstill 0.8 s and 0.16 m until 0.4 m/s is reached.
  EXPECT_NEAR(earliest_s(0.16, 0.0, medium), 0.8, 1e-12);
  EXPECT_NEAR(earliest_s(0.56, 0.0, medium), 1.8, 1e-12);
  EXPECT_NEAR(earliest_s(0.04, 0.0, medium), 0.4, 1e-12);
}

TEST(EarliestArrival, is_later_further_away_and_earlier_at_speed) {
  EXPECT_TRUE(rc::check([] {
    const auto number = [](double high) { return 1e-4 * high * *rc::gen::inRange(0, 10'001); };
    const double distance_m = number(3.0);
    const double speed_mps = number(0.5);
    RC_ASSERT(earliest_s(distance_m + number(1.0), speed_mps, medium) >= earliest_s(distance_m, speed_mps, medium));
    RC_ASSERT(earliest_s(distance_m, speed_mps + number(0.2), medium) <=
              earliest_s(distance_m, speed_mps, medium) + 1e-12);
  }));
}

struct Speaker {
  Agent agent{lacet4()};
  CrossingFinder crossing_spans{lacet4()};

  explicit Speaker(double s_m) { agent.vehicle().estimator().position_at(at(lacet4(), "east", s_m)); }
  Speaker& take(const wire::Order& text) {
    EXPECT_TRUE(agent.vehicle().take_order(text));
    static_cast<void>(agent.decide());
    return *this;
  }
  [[nodiscard]] wire::Intent compose() const { return compose_intent(agent, lacet4(), crossing_spans); }
};

TEST(ComposeIntent, states_the_position_and_the_next_crossings) {
  const wire::Intent intent =
      Speaker{0.1}.take(order("O-1").through({"east@0", "east@190", "east@380"}).then({"east@1120"})).compose();
  EXPECT_EQ(intent.map_id, "lacet4");
  EXPECT_EQ(intent.position, (wire::Intent::OnLine{"east", 0.1}));
  EXPECT_NEAR(intent.pose.y_m, -0.15, 1e-9);
  EXPECT_THAT(intent.route, ElementsAre("loop_se"));
  ASSERT_GE(intent.crossings.size(), 2U);
  EXPECT_FALSE(intent.crossings[0].may_enter) << "its base ends at the stop line";
  EXPECT_FALSE(intent.crossings[1].may_enter);
  EXPECT_GT(intent.crossings[0].arrival_s, 0.5);
  EXPECT_GT(intent.crossings[0].departure_s, intent.crossings[0].arrival_s);
  EXPECT_TRUE(wire::intent_from_json(to_json(intent)) || intent.vehicle.serial_number.empty());
}

TEST(ComposeIntent, states_that_the_vehicle_may_enter_when_its_base_leads_through) {
  const wire::Intent intent =
      Speaker{0.1}.take(order("O-1").through({"east@0", "east@380", "east@1120", "east@1310"})).compose();
  ASSERT_GE(intent.crossings.size(), 2U);
  EXPECT_TRUE(intent.crossings[0].may_enter);
  EXPECT_TRUE(intent.crossings[1].may_enter);
}

TEST(ComposeIntent, requests_no_crossing_while_the_vehicle_is_held_or_has_no_order) {
  EXPECT_THAT(Speaker{0.1}.compose().crossings, IsEmpty());
  Speaker paused{0.1};
  paused.take(order("O-1").through({"east@0", "east@190", "east@380"}).then({"east@1120"}));
  paused.agent.vehicle().hold(Hold::paused, true);
  EXPECT_THAT(paused.compose().crossings, IsEmpty());
  Speaker inside{0.6};
  const auto crossings = inside.compose().crossings;
  ASSERT_FALSE(crossings.empty()) << "the crossing under the vehicle is listed in any case";
  EXPECT_TRUE(crossings[0].may_enter);
  EXPECT_EQ(crossings[0].entry_m, 0.0);
}

TEST(ComposeIntent, of_an_off_path_vehicle_states_only_its_pose) {
  Speaker speaker{0.1};
  speaker.agent.vehicle().estimator().set_off_path({0.3, 0.0, 0.5});
  const wire::Intent intent = speaker.compose();
  EXPECT_FALSE(intent.position);
  EXPECT_THAT(intent.crossings, IsEmpty());
  EXPECT_EQ(intent.pose, (Pose2{0.3, 0.0, 0.5}));
}

double in_thousandths(double value) { return std::nearbyint(1e3 * value) / 1e3; }

TEST(ComposeIntent, lists_each_crossing_with_its_distances_and_earliest_times) {
  struct Case {
    std::optional<Profile> imposed;
    std::optional<double> speed_mps_max;
    zone::SpeedProfile pace;
  };
  const zone::SpeedProfiles& profiles = lacet4().profiles;
  zone::SpeedProfile limited = profiles.medium;
  limited.speed_mps = 0.2;
  for (const Case& one : {Case{{}, {}, profiles.medium},
                          {Profile::slow, {}, profiles.slow},
                          {Profile::fast, {}, profiles.fast},
                          {Profile::stop, {}, profiles.medium},
                          {{}, 0.2, limited},
                          {{}, 2.0, profiles.medium}}) {
    Speaker speaker{0.1234567};
    speaker.take(order("O-1").through({"east@0", "east@380", "east@1120", "east@1310"}));
    speaker.agent.instructions().imposed = one.imposed;
    speaker.agent.instructions().speed_mps_max = one.speed_mps_max;
    const wire::Intent intent = speaker.compose();
    EXPECT_EQ(intent.position, (wire::Intent::OnLine{"east", 0.123}));
    EXPECT_EQ(intent.pose.x_m, in_thousandths(lacet4().circuit.pose_at(at(lacet4(), "east", 0.1234567)).x_m));
    EXPECT_EQ(intent.pose.heading_rad, 0.0);
    EXPECT_EQ(intent.speed_mps, 0.0);
    const auto spans = spans_of(at(lacet4(), "east", 0.1234567), 3.0);
    ASSERT_GE(intent.crossings.size(), 2U);
    for (std::size_t i = 0; i < 2; ++i) {
      const wire::CrossingIntent& crossing = intent.crossings[i];
      EXPECT_EQ(crossing.name, lacet4().crossings[spans[i].crossing].name);
      EXPECT_EQ(crossing.entry_m, in_thousandths(spans[i].entry_m));
      EXPECT_EQ(crossing.exit_m, in_thousandths(spans[i].exit_m));
      EXPECT_EQ(crossing.arrival_s, in_thousandths(earliest_s(spans[i].entry_m, 0.0, one.pace)));
      EXPECT_EQ(crossing.departure_s, in_thousandths(earliest_s(spans[i].exit_m, 0.0, one.pace)));
      EXPECT_TRUE(crossing.may_enter);
    }
  }
}

TEST(ComposeIntent, states_no_time_beyond_an_hour) {
  Speaker speaker{0.1};
  speaker.take(order("O-1").through({"east@0", "east@380", "east@1120", "east@1310"}));
  speaker.agent.instructions().speed_mps_max = 1e-5;
  ASSERT_FALSE(speaker.compose().crossings.empty());
  EXPECT_EQ(speaker.compose().crossings[0].arrival_s, 3600.0);
}

TEST(ComposeIntent, states_the_sections_within_three_metres) {
  // East is 1.5 m long, the loop 2.83 m: 3 m beyond 0.1 m end on the loop, beyond 1.4 m on the section after it.
  EXPECT_THAT(Speaker{0.1}.compose().route, ElementsAre("loop_se"));
  const auto route = Speaker{1.4}.compose().route;
  ASSERT_EQ(route.size(), 2U);
  EXPECT_EQ(route[0], "loop_se");
  EXPECT_EQ(route[1], "north");
  EXPECT_THAT(Speaker{1.32}.compose().route, SizeIs(1));
}

TEST(EarliestArrival, is_that_of_a_simulated_vehicle) {
  // Small steps of 0.1 ms with constant acceleration up to the profile's speed.
  const zone::SpeedProfile by{0.6, 0.3, 0.8};
  for (const double start_mps : {-0.1, 0.0, 0.25, 0.6, 0.7}) {
    for (const double distance_m : {0.05, 0.4, 1.5}) {
      double speed_mps = std::fmax(0.0, start_mps);
      double left_m = distance_m;
      double seconds = 0.0;
      constexpr double dt_s = 1e-4;
      while (left_m > 0.0) {
        const double next_mps = std::fmax(speed_mps, std::fmin(by.speed_mps, speed_mps + by.acceleration_mps2 * dt_s));
        left_m -= 0.5 * (speed_mps + next_mps) * dt_s;
        speed_mps = next_mps;
        seconds += dt_s;
      }
      EXPECT_NEAR(earliest_s(distance_m, start_mps, by), seconds, 2e-4) << start_mps << " " << distance_m;
    }
  }
}

bool is_news(const wire::Intent& published, const Speaker& speaker) {
  return aiv::is_news(published, speaker.agent, lacet4(), speaker.crossing_spans);
}

TEST(News, are_changes_that_others_react_to_and_not_the_progress_on_the_path) {
  const auto up_to_crossing = order("O-1").through({"east@0", "east@190", "east@380"}).then({"east@1120"});
  Speaker speaker{0.1};
  speaker.take(up_to_crossing);
  const wire::Intent published = speaker.compose();
  EXPECT_FALSE(is_news(published, speaker));
  Speaker further{0.15};
  further.take(up_to_crossing);
  ASSERT_NE(further.compose().position, published.position);
  EXPECT_FALSE(is_news(published, further));

  Speaker granted{0.1};
  granted.take(order("O-1").through({"east@0", "east@380", "east@1120", "east@1310"}));
  EXPECT_TRUE(is_news(published, granted)) << "the vehicle may enter";
  EXPECT_TRUE(is_news(granted.compose(), speaker)) << "the vehicle may no longer enter";
  EXPECT_TRUE(is_news(published, Speaker{0.1})) << "no crossing is requested";
  EXPECT_TRUE(is_news(Speaker{1.3}.compose(), speaker)) << "the vehicle approaches crossings";
  Speaker neighbour{0.1};
  neighbour.agent.vehicle().estimator().set_off_path({0.3, 0.0, 0.5});
  EXPECT_TRUE(is_news(published, neighbour));
  EXPECT_FALSE(is_news(neighbour.compose(), neighbour));
  wire::Intent other = published;
  other.braking = !published.braking;
  EXPECT_TRUE(is_news(other, speaker));
  other = published;
  other.map_id = "indus8";
  EXPECT_TRUE(is_news(other, speaker));
}

/// What a vehicle at 0.5 m on a lane of 5 m publishes: a crossing leads from 1.0 m to 1.5 m, the base ends at `end_m`.
wire::Intent on_lane(double end_m, bool more_announced, const std::string& section = "lane",
                     const std::string& crossing = "X") {
  zone::TrafficZone zone =
      test::graph("map", {{section, {}, 5.0, 0.0, {}}}, {{"here", {0, 0.5}}, {"end", {0, end_m}}, {"on", {0, 4.5}}});
  zone.crossings.push_back({crossing, {}, {{0, 1.0, 1.5}}});
  Agent agent{zone};
  agent.vehicle().estimator().position_at({0, 0.5});
  auto text = order("O-1").through({"here", "end"});
  if (more_announced) text.then({"on"});
  EXPECT_TRUE(agent.vehicle().take_order(text));
  return compose_intent(agent, zone, CrossingFinder{zone});
}

TEST(ComposeIntent, may_enter_a_crossing_with_a_base_up_to_five_millimetres_before_its_exit) {
  const auto may_enter = [](double end_m) {
    const auto crossings = on_lane(end_m, true).crossings;
    EXPECT_EQ(crossings.size(), 1U) << end_m;
    return !crossings.empty() && crossings.front().may_enter;
  };
  EXPECT_TRUE(may_enter(1.496));
  EXPECT_FALSE(may_enter(1.494));
  EXPECT_FALSE(may_enter(1.2)) << "the vehicle could not leave";
  const wire::CrossingIntent crossing = on_lane(1.494, true).crossings.front();
  EXPECT_EQ(crossing.name, "X");
  EXPECT_EQ(crossing.entry_m, 0.5);
  EXPECT_EQ(crossing.exit_m, 1.0);
}

TEST(ComposeIntent, enters_a_crossing_in_which_its_order_ends_and_requests_none_behind_its_end) {
  ASSERT_EQ(on_lane(1.01, false).crossings.size(), 1U);
  EXPECT_TRUE(on_lane(1.01, false).crossings.front().may_enter);
  EXPECT_THAT(on_lane(1.0, false).crossings, IsEmpty());
  EXPECT_THAT(on_lane(0.99, false).crossings, IsEmpty());
}

TEST(ComposeIntent, leaves_out_names_of_more_than_128_bytes) {
  const std::string longest(128, 'n');
  const std::string too_long(129, 'n');
  const wire::Intent named = on_lane(2.0, true, longest, longest);
  ASSERT_TRUE(named.position);
  EXPECT_EQ(named.position->section, longest);
  ASSERT_EQ(named.crossings.size(), 1U);
  EXPECT_EQ(named.crossings.front().name, longest);
  EXPECT_FALSE(on_lane(2.0, true, too_long).position);
  EXPECT_THAT(on_lane(2.0, true, "lane", too_long).crossings, IsEmpty());
}

/// The route that a vehicle publishes at this distance along a section of 4 m, which another one of 1 m follows.
std::vector<std::string> route_from(double s_m, const std::string& next) {
  const zone::TrafficZone zone =
      test::graph("map", {{"lane", {}, 4.0, 0.0, {1}}, {next, {4.0, 0.0, 0.0}, 1.0, 0.0, {}}}, {});
  Agent agent{zone};
  agent.vehicle().estimator().position_at({0, s_m});
  return compose_intent(agent, zone, CrossingFinder{zone}).route;
}

TEST(ComposeIntent, states_sections_that_begin_less_than_three_metres_away_and_have_a_short_name) {
  EXPECT_THAT(route_from(1.0, "next"), IsEmpty());
  EXPECT_THAT(route_from(1.125, "next"), ElementsAre("next"));
  EXPECT_THAT(route_from(3.5, std::string(128, 'n')), ElementsAre(std::string(128, 'n')));
  EXPECT_THAT(route_from(3.5, std::string(129, 'n')), IsEmpty());
}

TEST(News, are_a_crossing_more_and_a_crossing_less) {
  Speaker speaker{0.1};
  speaker.take(order("O-1").through({"east@0", "east@190", "east@380"}).then({"east@1120"}));
  wire::Intent published = speaker.compose();
  ASSERT_GE(published.crossings.size(), 2U);
  wire::Intent one_less = published;
  one_less.crossings.pop_back();
  EXPECT_TRUE(is_news(one_less, speaker));
  wire::Intent one_more = published;
  one_more.crossings.push_back(published.crossings.front());
  EXPECT_TRUE(is_news(one_more, speaker));
  wire::Intent renamed = published;
  renamed.crossings[1].name = "another";
  EXPECT_TRUE(is_news(renamed, speaker));
  EXPECT_FALSE(is_news(published, speaker));
}

}  // namespace
}  // namespace cosiva::aiv
