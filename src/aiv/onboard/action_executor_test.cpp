#include "cosiva/aiv/onboard/action_executor.h"

#include "cosiva/aiv/onboard/test_instructions.h"

namespace cosiva::aiv {
namespace {

using test::lacet4;
using wire::ActionStatus;

struct ActionExecutorTest : test::InstructionTest {};

TEST_F(ActionExecutorTest, performs_only_stateRequest_before_a_zone_is_known) {
  act(action::state_request, "a", nullptr);
  EXPECT_EQ(last_status(), ActionStatus::finished);
  act(action::start_pause, "b", nullptr);
  EXPECT_EQ(last_status(), ActionStatus::failed);
}

TEST_F(ActionExecutorTest, performs_each_type_of_the_factsheet) {
  for (const auto& supported : make_factsheet(lacet4(), {}).actions) {
    effects.clear();
    act(supported.type, "of " + supported.type, &context);
    const std::string& result = actions.book().states().back().result_description;
    EXPECT_EQ(result.find("not supported"), std::string::npos) << supported.type;
  }
}

TEST_F(ActionExecutorTest, fails_unsupported_actions_with_a_warning) {
  act("fly", "a", &context);
  EXPECT_EQ(last_status(), ActionStatus::failed);
  ASSERT_EQ(reporter.warnings().all().size(), 1U);
  EXPECT_EQ(reporter.warnings().all()[0].type, "instantActionError");
}

TEST_F(ActionExecutorTest, finishes_a_pause_of_a_vehicle_that_is_stopped_at_once) {
  act(action::start_pause, "a", &context);
  EXPECT_EQ(last_status(), ActionStatus::finished);
  EXPECT_TRUE(context.vehicle().holds().has(Hold::paused));
  act(action::stop_pause, "b", &context);
  EXPECT_FALSE(context.vehicle().holds().has(Hold::paused));
}

TEST_F(ActionExecutorTest, performs_no_action_twice) {
  act(action::start_pause, "a", &context);
  act(action::stop_pause, "b", &context);
  act(action::start_pause, "a", &context);
  EXPECT_FALSE(context.vehicle().holds().has(Hold::paused));
  EXPECT_EQ(actions.book().states().size(), 2U);
}

}  // namespace
}  // namespace cosiva::aiv
