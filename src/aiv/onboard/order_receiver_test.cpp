#include "cosiva/aiv/onboard/order_receiver.h"

#include <algorithm>

#include "cosiva/aiv/onboard/test_instructions.h"
#include "cosiva/aiv/testing/test_orders.h"

namespace cosiva::aiv {
namespace {

using test::lacet4;

struct OrderReceiverTest : test::InstructionTest {
  OrderReceiver orders{{server_proxy, reporter, actions, drive_cycle, zones, action_cycle},
                       std::chrono::milliseconds{20}};

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

TEST_F(OrderReceiverTest, refuses_an_order_that_it_cannot_read) {
  orders.on_order({SimTime{}, wire::InputKind::message, "", "{", false}, &context, effects);
  ASSERT_EQ(reporter.warnings().all().size(), 1U);
  EXPECT_EQ(reporter.warnings().all()[0].type, "validationError");
  EXPECT_EQ(reporter.warnings().all()[0].references, (std::vector<wire::Reference>{{"topic", "order"}}));
}

TEST_F(OrderReceiverTest, names_the_refused_order) {
  wire::Order bad = test::order("O-7", 3).through({"moon"});
  bad.header.header_id = 12;
  order(bad, &context);
  ASSERT_EQ(reporter.warnings().all().size(), 1U);
  EXPECT_EQ(reporter.warnings().all()[0].references,
            (std::vector<wire::Reference>{
                {"topic", "order"}, {"headerId", "12"}, {"orderId", "O-7"}, {"orderUpdateId", "3"}}));
}

TEST_F(OrderReceiverTest, logs_each_new_order_and_no_update) {
  order(test::order("O-1").through({"loop_se@0", "loop_se@283"}), &context);
  ASSERT_EQ(effects.size(), 1U);
  EXPECT_EQ(std::get<wire::Log>(effects[0]), (wire::Log{'i', "order O-1 from loop_se@0"}));
  reporter.refuse("orderUpdateError", "order", "late", {}, effects);
  effects.clear();
  order(test::order("O-1", 1).from_sequence(2).through({"loop_se@283", "loop_se@565"}), &context);
  EXPECT_EQ(context.vehicle().order().ids().order_update_id, 1U);
  EXPECT_TRUE(effects.empty());
  EXPECT_TRUE(reporter.warnings().all().empty()) << "the update removes the warnings about its forerunners";
  order(test::order("O-1", 1).from_sequence(2).through({"loop_se@283", "loop_se@565"}), &context);
  EXPECT_TRUE(effects.empty()) << "a repetition";
}

TEST_F(OrderReceiverTest, decides_at_once_where_the_cycle_is_long) {
  const auto commands = [&](SimDuration cycle) {
    DrivingContext fresh{lacet4(), {}};
    fresh.vehicle().estimator().position_at(test::at(lacet4(), "loop_se", 0.0));
    OrderReceiver receiver{{server_proxy, reporter, actions, drive_cycle, zones, action_cycle}, cycle};
    const auto count = [&](const wire::Order& order) {
      effects.clear();
      receiver.on_order({SimTime{}, wire::InputKind::message, "", wire::vda5050::encode(order), false}, &fresh,
                        effects);
      return std::ranges::count_if(effects,
                                   [](const auto& effect) { return std::holds_alternative<wire::SendBytes>(effect); });
    };
    const auto first = count(test::order("O-1").through({"loop_se@0", "loop_se@283"}));
    EXPECT_EQ(count(test::order("O-1").through({"loop_se@0", "loop_se@283"})), 0) << "a repetition";
    return first;
  };
  boards.on_port(wire::Board::PILS, true);
  EXPECT_EQ(commands(std::chrono::milliseconds{20}), 0);
  EXPECT_EQ(commands(std::chrono::milliseconds{21}), 1);
}

TEST_F(OrderReceiverTest, refuses_a_new_order_while_another_zone_is_pending_and_accepts_a_repetition) {
  const auto in_force = zones.on_announced(test::lacet4_configuration(), nullptr, nullptr, effects);
  zones.enforce(*in_force.rtm);
  order(test::order("O-1").through({"loop_se@0", "loop_se@283"}), &context);
  zone::ZoneConfiguration other = test::lacet4_configuration();
  other.text.replace(other.text.find("name = \"lacet4\""), 15, "name = \"other\"");
  ASSERT_EQ(zones.on_announced(other, nullptr, &test::lacet4(), effects).verdict, ZoneSelection::Verdict::pending);
  order(test::order("O-1").through({"loop_se@0", "loop_se@283"}), &context);
  EXPECT_TRUE(reporter.warnings().all().empty());
  order(test::order("O-1", 1).from_sequence(2).through({"loop_se@283", "loop_se@565"}), &context);
  order(test::order("O-2").through({"loop_se@0", "loop_se@283"}), &context);
  ASSERT_EQ(reporter.warnings().all().size(), 2U);
  EXPECT_EQ(reporter.warnings().all()[1].type, "noRouteError");
  EXPECT_EQ(reporter.warnings().all()[1].description, "zone 'other' follows as soon as the vehicle has stopped");
}

}  // namespace
}  // namespace cosiva::aiv
