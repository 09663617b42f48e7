#include "cosiva/experiments/faults/ownership_monitor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "cosiva/wire/messages/topics.h"
#include "cosiva/wire/own/control_areas.h"

namespace cosiva::experiments {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::HasSubstr;

constexpr Process a = server_process;
constexpr Process b = first_other_server;
const wire::VehicleId aiv{"CoSiVA", "AIV1"};

wire::Publish owner_message(const std::string& area) {
  return {wire::own_topic(wire::owner_topic_prefix, aiv), wire::to_json(wire::Owner{area, 1, {}, {}, {}}), 1, true};
}
wire::Publish order() { return {wire::vda_topic(aiv, "order"), "{}", 0, false}; }

class OwnershipMonitorTest : public ::testing::Test {
 protected:
  void receives(Process server, const std::string& area) {
    const wire::Publish message = owner_message(area);
    monitor_.on_received(server, {{}, wire::InputKind::message, message.topic, message.payload, false});
  }

  OwnershipMonitor monitor_{{{a, "a"}, {b, "b"}}};
};

TEST_F(OwnershipMonitorTest, permits_messages_of_the_owner_only) {
  EXPECT_TRUE(monitor_.on_published(a, order())) << "no owner is known yet";
  receives(a, "a");
  receives(b, "a");
  EXPECT_FALSE(monitor_.on_published(a, order()));
  const Finding finding = monitor_.on_published(b, order());
  ASSERT_TRUE(finding);
  EXPECT_EQ(finding->invariant, "I4");
  EXPECT_THAT(finding->text, HasSubstr("control area b sends order to CoSiVA/AIV1, which it does not own"));
}

TEST_F(OwnershipMonitorTest, permits_no_message_after_the_owner_has_handed_the_vehicle_over) {
  receives(a, "a");
  EXPECT_FALSE(monitor_.on_published(a, owner_message("b")));
  const Finding finding = monitor_.on_published(a, order());
  ASSERT_TRUE(finding);
  EXPECT_THAT(finding->text, HasSubstr("which it has handed over"));
}

TEST_F(OwnershipMonitorTest, permits_messages_where_a_new_connection_may_have_lost_the_hand_over) {
  receives(a, "a");
  EXPECT_FALSE(monitor_.on_published(a, owner_message("b")));
  monitor_.on_link(a);
  EXPECT_FALSE(monitor_.on_published(a, order()));
}

TEST_F(OwnershipMonitorTest, begins_again_with_a_server_that_starts) {
  receives(a, "a");
  monitor_.on_killed(a);
  EXPECT_TRUE(monitor_.on_published(a, order()));
}

TEST_F(OwnershipMonitorTest, counts_the_vehicles_that_were_released) {
  receives(a, "a");
  receives(b, "a");
  receives(a, "b");
  receives(b, "b");
  receives(b, "b");
  EXPECT_EQ(monitor_.released(), 1U);
}

TEST_F(OwnershipMonitorTest, finds_two_servers_that_command_one_vehicle_for_longer_than_permitted) {
  const SimTime begin{seconds{1}};
  EXPECT_FALSE(monitor_.step(begin, {{a, {"AIV1", "AIV2"}}, {b, {"AIV1"}}}));
  EXPECT_FALSE(monitor_.step(begin + OwnershipMonitor::both_max, {{a, {"AIV1"}}, {b, {"AIV1"}}}));
  const Finding finding =
      monitor_.step(begin + OwnershipMonitor::both_max + milliseconds{20}, {{a, {"AIV1"}}, {b, {"AIV1"}}});
  ASSERT_TRUE(finding);
  EXPECT_THAT(finding->text, HasSubstr("two servers have commanded AIV1"));
}

TEST_F(OwnershipMonitorTest, measures_each_time_of_two_servers_for_itself) {
  const SimTime begin{seconds{1}};
  for (int i = 0; i < 20; ++i) {
    EXPECT_FALSE(monitor_.step(begin + seconds{i}, {{a, {"AIV1"}}, {b, {"AIV1"}}}));
    EXPECT_FALSE(monitor_.step(begin + seconds{i} + milliseconds{500}, {{a, {"AIV1"}}, {b, {}}}));
  }
  EXPECT_EQ(monitor_.both_longest(), SimDuration::zero());
}

}  // namespace
}  // namespace cosiva::experiments
