#include "cosiva/aiv/onboard/v2x_participant.h"

#include <gtest/gtest.h>

#include "cosiva/aiv/testing/test_zone.h"

namespace cosiva::aiv {
namespace {

using std::chrono::milliseconds;
using test::lacet4;

struct V2xParticipantTest : ::testing::Test {
  wire::VehicleId id{"CoSiVA", "AIV1"};
  V2xParticipant v2x{id, true};
  DrivingContext context{lacet4(), {}};
  Session session{id, wire::default_interface};
  wire::Effects effects;

  V2xParticipantTest() {
    session.set_online(true);
    context.vehicle().estimator().position_at(test::at(lacet4(), "loop_se", 0.5));
  }
  std::size_t intents_at(int ms) {
    effects.clear();
    v2x.publish_intent(SimTime{milliseconds{ms}}, context, session, effects);
    return effects.size();
  }
};

TEST_F(V2xParticipantTest, subscribes_around_its_cell_once_it_knows_its_pose) {
  DrivingContext lost{lacet4(), {}};
  EXPECT_FALSE(v2x.update_cell(lost));
  EXPECT_TRUE(v2x.filters().empty());
  EXPECT_TRUE(v2x.update_cell(context));
  EXPECT_FALSE(v2x.filters().empty());
  EXPECT_FALSE(v2x.update_cell(context)) << "the same cell";
}

TEST_F(V2xParticipantTest, publishes_once_a_second_while_it_is_alone) {
  EXPECT_EQ(intents_at(0), 0U) << "there is no cell yet";
  ASSERT_TRUE(v2x.update_cell(context));
  EXPECT_EQ(intents_at(0), 1U);
  EXPECT_EQ(intents_at(990), 0U);
  EXPECT_EQ(intents_at(1000), 1U);
}

TEST_F(V2xParticipantTest, neither_publishes_nor_subscribes_when_it_is_disabled) {
  V2xParticipant disabled{id, false};
  EXPECT_FALSE(disabled.update_cell(context));
  EXPECT_TRUE(disabled.filters().empty());
  disabled.publish_intent(SimTime{}, context, session, effects);
  EXPECT_TRUE(effects.empty());
}

TEST_F(V2xParticipantTest, logs_an_intent_that_cannot_be_read_once) {
  ASSERT_TRUE(v2x.update_cell(context));
  const wire::Input input{SimTime{}, wire::InputKind::message,
                          wire::v2x_topic("lacet4", wire::Cell{0, 0}, {"CoSiVA", "AIV2"}), "{", false};
  v2x.on_intent(SimTime{}, input, context, effects);
  v2x.on_intent(SimTime{}, input, context, effects);
  EXPECT_EQ(effects.size(), 1U);
  v2x.on_zone_switched();
  v2x.on_intent(SimTime{}, input, context, effects);
  EXPECT_EQ(effects.size(), 2U);
}

}  // namespace
}  // namespace cosiva::aiv
