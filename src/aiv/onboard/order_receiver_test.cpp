#include "cosiva/aiv/onboard/order_receiver.h"

#include "cosiva/aiv/onboard/test_instructions.h"
#include "cosiva/aiv/testing/test_orders.h"

namespace cosiva::aiv {
namespace {

struct OrderReceiverTest : test::InstructionTest {
  OrderReceiver orders{{session, reporter, actions, drive_cycle, zones}, std::chrono::milliseconds{20}};

  void order(const wire::Order& order, DrivingContext* in) {
    orders.on_order({SimTime{}, wire::InputKind::message, "", wire::vda5050::encode(order), false}, in, effects);
  }
};

TEST_F(OrderReceiverTest, passes_an_order_to_the_agent_and_clears_old_warnings) {
  act("fly", "a", &context);
  order(test::order("O-1").through({"loop_se@0", "loop_se@283"}), &context);
  EXPECT_EQ(context.vehicle().order().ids().order_id, "O-1");
  EXPECT_TRUE(reporter.warnings().all().empty());
  EXPECT_TRUE(actions.book().states().empty());
}

TEST_F(OrderReceiverTest, refuses_an_order_before_a_zone_is_known) {
  order(test::order("O-1").through({"loop_se@0", "loop_se@283"}), nullptr);
  ASSERT_EQ(reporter.warnings().all().size(), 1U);
  EXPECT_EQ(reporter.warnings().all()[0].type, "noRouteError");
}

TEST_F(OrderReceiverTest, refuses_an_order_for_another_vehicle) {
  wire::Order other = test::order("O-1").through({"loop_se@0", "loop_se@283"});
  other.header.serial_number = "AIV2";
  order(other, &context);
  EXPECT_EQ(context.vehicle().order().ids().order_id, "");
  ASSERT_EQ(reporter.warnings().all().size(), 1U);
  EXPECT_EQ(reporter.warnings().all()[0].type, "validationError");
}

}  // namespace
}  // namespace cosiva::aiv
