#include "cosiva/aiv/v2x/base_watch.h"

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "cosiva/aiv/testing/test_orders.h"
#include "cosiva/aiv/testing/test_senses.h"
#include "cosiva/aiv/testing/test_zone.h"

namespace cosiva::aiv {
namespace {

using namespace std::chrono_literals;
using test::at;
using test::lacet4;
using test::order;

/// A vehicle at the beginning of the clover's eastward straight, with a base of 1.12 m through both crossings.
struct BaseWatchTest : ::testing::Test {
  Agent agent{lacet4()};
  std::optional<BaseWatch> watch{std::in_place, lacet4()};
  SimTime now{virtual_epoch};
  std::uint32_t header{0};

  BaseWatchTest() {
    agent.vehicle().estimator().position_at(at(lacet4(), "east", 0.0));
    EXPECT_TRUE(agent.vehicle().take_order(order("O-1").through({"east@0", "east@380", "east@1120"})));
    static_cast<void>(agent.decide());
  }
  void receive(const std::string& serial, zone::TrackPosition position, const std::string& crossing = "") {
    wire::Intent intent;
    intent.header_id = ++header;
    intent.map_id = "lacet4";
    intent.vehicle = {"CoSiVA", serial};
    intent.pose = lacet4().circuit.pose_at(position);
    if (!crossing.empty()) intent.crossings.push_back({crossing, 0.2, 0.6, 0.5, 1.5, true});
    watch->on_intent(now, std::make_shared<const wire::Intent>(std::move(intent)));
  }
  [[nodiscard]] bool may_finish() { return watch->may_finish(now, agent); }
};

TEST_F(BaseWatchTest, lets_a_vehicle_that_knows_no_other_finish_its_base) { EXPECT_TRUE(may_finish()); }

TEST_F(BaseWatchTest, needs_an_intent_younger_than_300_ms_of_a_vehicle_on_the_base) {
  receive("AIV2", at(lacet4(), "east", 0.9));
  now += 299ms;
  EXPECT_TRUE(may_finish());
  now += 1ms;
  EXPECT_FALSE(may_finish()) << "exactly 300 ms";
  receive("AIV2", at(lacet4(), "east", 0.9));
  EXPECT_TRUE(may_finish());
}

TEST_F(BaseWatchTest, keeps_an_unresponsive_vehicle_for_a_minute) {
  receive("AIV2", at(lacet4(), "east", 0.9));
  now += 60s;
  EXPECT_FALSE(may_finish());
  now += 1ms;
  EXPECT_TRUE(may_finish());
  EXPECT_EQ(watch->size(), 0U);
}

TEST_F(BaseWatchTest, is_not_concerned_with_an_unresponsive_vehicle_elsewhere) {
  receive("AIV2", at(lacet4(), "west", 0.2));
  now += 10s;
  EXPECT_TRUE(may_finish());
}

TEST_F(BaseWatchTest, counts_an_unresponsive_vehicle_that_listed_a_crossing_of_the_base) {
  receive("AIV2", at(lacet4(), "north", 0.1), "X1");
  receive("AIV3", at(lacet4(), "west", 0.2), "X3");
  now += 1s;
  const bool both_unresponsive = may_finish();
  receive("AIV2", at(lacet4(), "north", 0.1), "X1");
  const bool other_unresponsive = may_finish();
  // Of the four crossings the eastward straight leads through two, one of them X1 or X3, or both.
  EXPECT_FALSE(both_unresponsive);
  receive("AIV3", at(lacet4(), "west", 0.2), "X3");
  EXPECT_TRUE(may_finish());
  EXPECT_TRUE(other_unresponsive) << "X3 is not on the eastward straight";
}

TEST_F(BaseWatchTest, needs_all_of_several_vehicles) {
  receive("AIV2", at(lacet4(), "east", 0.5));
  receive("AIV3", at(lacet4(), "east", 0.9));
  now += 400ms;
  receive("AIV3", at(lacet4(), "east", 0.9));
  EXPECT_FALSE(may_finish()) << "one neighbour is unresponsive";
  receive("AIV2", at(lacet4(), "east", 0.5));
  EXPECT_TRUE(may_finish());
}

TEST_F(BaseWatchTest, does_not_finish_where_the_sensors_detect_a_body_that_no_intent_explains) {
  // A body 0.60 m ahead of the sensor, in three frames of DOBS.
  const Pose2 X_MB = lacet4().circuit.pose_at(at(lacet4(), "east", 0.0));
  const Point2 body = X_MB * Point2{0.5 * lacet4().vehicle.length_m + 0.60, 0.0};
  for (int i = 0; i < 3; ++i) agent.vehicle().on_ranges(test::ranges_to({body}, X_MB));
  ASSERT_LT(agent.vehicle().watch().ahead_m(agent.vehicle().position()), 0.7);
  EXPECT_FALSE(may_finish()) << "an unknown vehicle";
  receive("AIV2", at(lacet4(), "east", lacet4().vehicle.length_m + 0.60));
  EXPECT_TRUE(may_finish()) << "this vehicle reports that it is there";
  now += 300ms;
  EXPECT_FALSE(may_finish());
}

TEST_F(BaseWatchTest, does_not_finish_without_a_base_or_a_position) {
  Agent without{lacet4()};
  EXPECT_FALSE(watch->may_finish(now, without));
  without.vehicle().estimator().position_at(at(lacet4(), "east", 0.0));
  EXPECT_FALSE(watch->may_finish(now, without)) << "there is no order";
}

TEST_F(BaseWatchTest, does_not_finish_where_it_cannot_keep_all_vehicles) {
  BaseWatch::Model model;
  model.count_max = 2;
  watch.emplace(lacet4(), model);
  for (const char* serial : {"AIV2", "AIV3"}) receive(serial, at(lacet4(), "west", 0.2));
  EXPECT_TRUE(may_finish());
  receive("AIV4", at(lacet4(), "west", 0.2));
  EXPECT_FALSE(may_finish());
  EXPECT_EQ(watch->size(), 2U);
  now += 61s;
  EXPECT_TRUE(may_finish());
}

TEST_F(BaseWatchTest, forgets_an_intent_from_before_the_clock_was_set_back) {
  receive("AIV2", at(lacet4(), "east", 0.9));
  now -= 1s;
  EXPECT_TRUE(may_finish());
  EXPECT_EQ(watch->size(), 0U);
}

}  // namespace
}  // namespace cosiva::aiv
