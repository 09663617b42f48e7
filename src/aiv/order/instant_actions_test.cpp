#include "cosiva/aiv/order/instant_actions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace cosiva::aiv {
namespace {

using testing::ElementsAre;
using testing::SizeIs;
using wire::ActionStatus;

struct InstantActionBookTest : ::testing::Test {
  InstantActionBook book;

  bool begin(std::string_view type, const std::string& id) {
    return book.begin({std::string(type), id, "", wire::BlockingType::none, {}});
  }
  [[nodiscard]] std::vector<std::string> ids() const {
    std::vector<std::string> all;
    for (const wire::ActionState& state : book.states()) all.push_back(state.action_id);
    return all;
  }
};

TEST_F(InstantActionBookTest, lists_a_new_action_as_waiting) {
  EXPECT_TRUE(begin(action::start_pause, "a"));
  EXPECT_THAT(book.states(), ElementsAre(wire::ActionState{"a", "startPause", ActionStatus::waiting, ""}));
  EXPECT_FALSE(begin(action::stop_pause, "a")) << "the same id again";
  EXPECT_THAT(book.states(), SizeIs(1));
}

TEST_F(InstantActionBookTest, sets_status_and_result_of_one_action_only) {
  ASSERT_TRUE(begin(action::start_pause, "a"));
  ASSERT_TRUE(begin(action::start_pause, "b"));
  book.set("b", ActionStatus::failed, "why");
  book.set("c", ActionStatus::failed, "no such action");
  EXPECT_THAT(book.states(), ElementsAre(wire::ActionState{"a", "startPause", ActionStatus::waiting, ""},
                                         wire::ActionState{"b", "startPause", ActionStatus::failed, "why"}));
}

TEST_F(InstantActionBookTest, ends_the_running_actions_of_a_type_or_of_all_types) {
  for (const char* id : {"a", "b", "c", "d"})
    ASSERT_TRUE(begin(*id == 'c' ? action::back_up : action::start_pause, id));
  for (const char* id : {"a", "b", "c"}) book.set(id, ActionStatus::running);
  EXPECT_TRUE(book.running(action::start_pause));
  EXPECT_TRUE(book.running(action::back_up));
  EXPECT_FALSE(book.running(action::join_line));
  book.end_running(action::start_pause, ActionStatus::finished, "done");
  EXPECT_FALSE(book.running(action::start_pause)) << "an action that waits does not run";
  EXPECT_TRUE(book.running(action::back_up));
  book.end_running({}, ActionStatus::failed, "over");
  EXPECT_THAT(book.states(), ElementsAre(wire::ActionState{"a", "startPause", ActionStatus::finished, "done"},
                                         wire::ActionState{"b", "startPause", ActionStatus::finished, "done"},
                                         wire::ActionState{"c", "backUp", ActionStatus::failed, "over"},
                                         wire::ActionState{"d", "startPause", ActionStatus::waiting, ""}));
}

TEST_F(InstantActionBookTest, preserves_at_a_new_order_what_runs_or_waits_and_the_last_speed_limit) {
  for (const char* id : {"limit 1", "limit 2"}) {
    ASSERT_TRUE(begin(action::set_speed_limit, id));
    book.set(id, ActionStatus::finished);
  }
  for (const char* id : {"finished", "failed", "running", "waiting"}) ASSERT_TRUE(begin(action::back_up, id));
  book.set("finished", ActionStatus::finished);
  book.set("failed", ActionStatus::failed);
  book.set("running", ActionStatus::running);
  book.on_new_order();
  EXPECT_THAT(ids(), ElementsAre("limit 2", "running", "waiting"));
}

TEST_F(InstantActionBookTest, preserves_at_a_new_order_no_other_action_that_has_ended) {
  for (const char* id : {"a", "b"}) ASSERT_TRUE(begin(action::back_up, id));
  book.set("a", ActionStatus::finished);
  book.set("b", ActionStatus::failed);
  book.on_new_order();
  EXPECT_THAT(book.states(), SizeIs(0));
}

TEST_F(InstantActionBookTest, shows_32_actions_and_drops_the_oldest_that_has_ended) {
  for (int i = 0; i < 32; ++i) ASSERT_TRUE(begin(action::back_up, std::to_string(i)));
  EXPECT_THAT(book.states(), SizeIs(32));
  book.set("5", ActionStatus::finished);
  book.set("9", ActionStatus::failed);
  ASSERT_TRUE(begin(action::back_up, "32"));
  EXPECT_THAT(book.states(), SizeIs(32));
  EXPECT_THAT(ids(), testing::Not(testing::Contains("5")));
  ASSERT_TRUE(begin(action::back_up, "33"));
  EXPECT_THAT(ids(), testing::Not(testing::Contains("9")));
  EXPECT_EQ(ids().front(), "0");
  ASSERT_TRUE(begin(action::back_up, "34"));
  EXPECT_EQ(ids().front(), "1") << "none has ended: the oldest";
}

TEST_F(InstantActionBookTest, recognises_the_last_128_ids) {
  for (int i = 0; i < 128; ++i) ASSERT_TRUE(begin(action::state_request, std::to_string(i)));
  EXPECT_FALSE(begin(action::state_request, "0"));
  ASSERT_TRUE(begin(action::state_request, "128"));
  EXPECT_FALSE(begin(action::state_request, "1"));
  EXPECT_TRUE(begin(action::state_request, "0")) << "the oldest is forgotten";
}

}  // namespace
}  // namespace cosiva::aiv
