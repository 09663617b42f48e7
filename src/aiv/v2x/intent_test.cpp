#include "cosiva/aiv/v2x/intent.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

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

std::vector<CrossingSpan> ahead_of(zone::TrackPosition here, double reach_m, std::size_t count_max = 8) {
  static const CrossingFinder crossing_spans{lacet4()};
  std::vector<CrossingSpan> out;
  crossing_spans.ahead(here, reach_m, count_max, out);
  return out;
}

// The clover's straights are 1.5 m long and cross others 0.6 m and 0.9 m from their starts, too close to stop between.

TEST(CrossingFinder, finds_the_two_crossings_of_a_straight_as_one_chain) {
  const auto ahead = ahead_of(at(lacet4(), "east", 0.1), 1.0);
  ASSERT_THAT(ahead, SizeIs(2));
  EXPECT_GT(ahead[0].entry_m, 0.25);
  EXPECT_LT(ahead[0].entry_m, 0.5);
  EXPECT_GT(ahead[0].exit_m, 0.5);
  EXPECT_GT(ahead[1].entry_m, ahead[0].entry_m);
  EXPECT_GT(ahead[1].exit_m, 0.8);
  EXPECT_EQ(ahead[0].chain_exit_m, ahead[1].exit_m);
  EXPECT_EQ(ahead[1].chain_exit_m, ahead[1].exit_m);
  EXPECT_NE(ahead[0].crossing, ahead[1].crossing);
}

TEST(CrossingFinder, follows_a_chain_beyond_its_reach_and_finds_none_outside_it) {
  EXPECT_THAT(ahead_of(at(lacet4(), "east", 0.1), 0.35), SizeIs(2));
  EXPECT_THAT(ahead_of(at(lacet4(), "east", 0.1), 0.10), IsEmpty());
  EXPECT_THAT(ahead_of(at(lacet4(), "east", 1.2), 1.0), IsEmpty()) << "behind the vehicle";
  EXPECT_THAT(ahead_of(at(lacet4(), "east", 0.1), 3.0, 1), SizeIs(1));
}

TEST(CrossingFinder, begins_at_the_vehicle_inside_a_crossing) {
  const auto ahead = ahead_of(at(lacet4(), "east", 0.6), 0.1);
  ASSERT_THAT(ahead, SizeIs(2));
  EXPECT_EQ(ahead[0].entry_m, 0.0);
  EXPECT_GT(ahead[0].exit_m, 0.0);
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

}  // namespace
}  // namespace cosiva::aiv
