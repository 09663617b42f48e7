#include "cosiva/virtual/server/registry/reported_position.h"

#include <gtest/gtest.h>

#include <limits>

namespace cosiva::virtual_side {
namespace {

using namespace std::chrono_literals;
using Order = ReportedPosition::Order;

constexpr Pose2 here{1.0, 2.0, 0.5};

ReportedPosition known_at(SimDuration time) {
  ReportedPosition position;
  position.on_position(virtual_epoch + time, "yard", here);
  return position;
}

TEST(ReportedPosition, is_unknown_before_the_first_report) {
  const ReportedPosition position;
  EXPECT_FALSE(position.known());
  EXPECT_FALSE(position.pose());
  EXPECT_EQ(position.map_id(), "");
  EXPECT_FALSE(position.lost_for_longer_than(0s, virtual_epoch)) << "never reported is not lost";
  EXPECT_EQ(position.order_of(virtual_epoch), Order::newer);
}

TEST(ReportedPosition, is_known_with_its_map_once_it_is_reported) {
  const ReportedPosition position = known_at(0s);
  EXPECT_TRUE(position.known());
  EXPECT_EQ(position.pose(), here);
  EXPECT_EQ(position.map_id(), "yard");
}

TEST(ReportedPosition, is_ordered_by_the_clock_of_the_vehicle) {
  const ReportedPosition position = known_at(10s);
  EXPECT_EQ(position.order_of(virtual_epoch + 10001ms), Order::newer);
  EXPECT_EQ(position.order_of(virtual_epoch + 10s), Order::same);
  EXPECT_EQ(position.order_of(virtual_epoch + 9999ms), Order::overtaken);
  EXPECT_EQ(position.order_of(virtual_epoch + 5s), Order::newer) << "the clock was set";
}

TEST(ReportedPosition, is_lost_since_the_first_report_without_it) {
  ReportedPosition position = known_at(0s);
  position.on_lost(virtual_epoch + 1s, "yard", virtual_epoch + 1s);
  position.on_lost(virtual_epoch + 2s, "yard", virtual_epoch + 2s);
  EXPECT_FALSE(position.known());
  EXPECT_EQ(position.pose(), here) << "the last known one stays";
  EXPECT_FALSE(position.lost_for_longer_than(1s, virtual_epoch + 2s));
  EXPECT_TRUE(position.lost_for_longer_than(1s, virtual_epoch + 2001ms));
  position.on_position(virtual_epoch + 3s, "yard", here);
  EXPECT_TRUE(position.known());
  EXPECT_FALSE(position.lost_for_longer_than(0s, virtual_epoch + 9s));
}

TEST(ReportedPosition, stays_when_the_next_report_is_implausible) {
  ReportedPosition position = known_at(0s);
  position.on_implausible(virtual_epoch + 1s, "moon");
  EXPECT_TRUE(position.known());
  EXPECT_EQ(position.pose(), here);
  EXPECT_EQ(position.map_id(), "moon");
  EXPECT_EQ(position.order_of(virtual_epoch + 1s), Order::same);
}

TEST(ReportedPosition, is_plausible_up_to_a_hundred_kilometres) {
  EXPECT_TRUE(ReportedPosition::plausible({1e5, -1e5, 0.0}));
  EXPECT_FALSE(ReportedPosition::plausible({100001.0, 0.0, 0.0}));
  EXPECT_FALSE(ReportedPosition::plausible({0.0, -100001.0, 0.0}));
  EXPECT_FALSE(ReportedPosition::plausible({std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0}));
}

TEST(ReportedPosition, is_unknown_in_a_new_session_though_its_pose_and_map_stay) {
  ReportedPosition position = known_at(10s);
  position.on_session();
  EXPECT_FALSE(position.known());
  EXPECT_EQ(position.pose(), here);
  EXPECT_EQ(position.map_id(), "yard");
  EXPECT_EQ(position.order_of(virtual_epoch + 9s), Order::newer) << "time stamps may start again";
  position.on_lost(virtual_epoch + 9s, "yard", virtual_epoch);
  position.on_session();
  EXPECT_FALSE(position.lost_for_longer_than(0s, virtual_epoch + 9s));
}

TEST(ReportedPosition, is_known_after_a_handover_without_a_time_stamp) {
  ReportedPosition position;
  position.on_handover(here);
  EXPECT_TRUE(position.known());
  EXPECT_EQ(position.pose(), here);
  EXPECT_EQ(position.order_of(virtual_epoch), Order::newer);
}

TEST(ReportedPosition, of_a_retired_vehicle_is_not_lost) {
  ReportedPosition position;
  position.on_lost(virtual_epoch, "yard", virtual_epoch);
  position.on_retired();
  EXPECT_FALSE(position.lost_for_longer_than(0s, virtual_epoch + 9s));
}

TEST(ReportedPosition, knows_when_it_was_sent_to_the_vehicle) {
  ReportedPosition position = known_at(0s);
  EXPECT_FALSE(position.initialised_within(5s, virtual_epoch));
  position.on_initialisation_sent(virtual_epoch);
  EXPECT_TRUE(position.initialised_within(5s, virtual_epoch + 4999ms));
  EXPECT_FALSE(position.initialised_within(5s, virtual_epoch + 5s));
}

TEST(ReportedPosition, refuses_what_the_callers_must_have_checked) {
  ReportedPosition position = known_at(10s);
  EXPECT_DEATH(position.on_position(virtual_epoch + 10s, "yard", here), "order_of");
  EXPECT_DEATH(position.on_lost(virtual_epoch + 9s, "yard", virtual_epoch), "order_of");
  EXPECT_DEATH(position.on_position(virtual_epoch + 11s, "yard", {1e6, 0.0, 0.0}), "plausible");
  ReportedPosition unknown;
  EXPECT_DEATH(unknown.on_initialisation_sent(virtual_epoch), "pose_");
}

TEST(ReportedPosition, is_plausible_only_in_both_coordinates) {
  constexpr double no_number = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(ReportedPosition::plausible({-1e5, 1e5, 0.0}));
  EXPECT_FALSE(ReportedPosition::plausible({-100001.0, 0.0, 0.0}));
  EXPECT_FALSE(ReportedPosition::plausible({0.0, 100001.0, 0.0}));
  EXPECT_FALSE(ReportedPosition::plausible({0.0, no_number, 0.0}));
}

TEST(ReportedPosition, is_lost_until_it_is_known_again_even_where_an_implausible_one_is_reported) {
  ReportedPosition position = known_at(0s);
  position.on_lost(virtual_epoch + 1s, "yard", virtual_epoch + 1s);
  position.on_implausible(virtual_epoch + 2s, "yard");
  EXPECT_FALSE(position.known());
  EXPECT_TRUE(position.lost_for_longer_than(1s, virtual_epoch + 3s));
  position.on_handover({3.0, 4.0, 0.0});
  EXPECT_TRUE(position.known());
  EXPECT_EQ(position.pose(), (Pose2{3.0, 4.0, 0.0}));
  EXPECT_FALSE(position.lost_for_longer_than(0s, virtual_epoch + 9s));
  position.on_lost(virtual_epoch + 4s, "yard", virtual_epoch + 8s);
  EXPECT_FALSE(position.lost_for_longer_than(1s, virtual_epoch + 9s)) << "a new loss";
}

}  // namespace
}  // namespace cosiva::virtual_side
