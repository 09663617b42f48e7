#include "cosiva/adapters/input_queue.h"

#include <gmock/gmock.h>

#include <string>
#include <vector>

namespace cosiva::adapters {
namespace {

using ::testing::ElementsAre;

wire::Input named(const std::string& name) { return {SimTime{}, wire::InputKind::command, name, {}}; }

TEST(InputQueue, handles_each_input_at_once) {
  std::vector<std::string> handled;
  InputQueue queue{[&](const wire::Input& input, const InputQueue::Durable&) { handled.push_back(input.source); }};
  queue.push(named("a"));
  EXPECT_THAT(handled, ElementsAre("a"));
  queue.push(named("b"));
  EXPECT_THAT(handled, ElementsAre("a", "b"));
  EXPECT_EQ(queue.handled(), 2U);
}

TEST(InputQueue, handles_an_input_that_another_one_causes_after_that_one) {
  std::vector<std::string> handled;
  InputQueue* inputs = nullptr;
  std::vector<bool> last;
  InputQueue queue{[&](const wire::Input& input, const InputQueue::Durable&) {
    if (input.source == "a") {
      inputs->push(named("b"));
      inputs->push(named("c"));
    }
    handled.push_back(input.source);
    last.push_back(inputs->empty());
  }};
  inputs = &queue;
  queue.push(named("a"));
  EXPECT_THAT(handled, ElementsAre("a", "b", "c"));
  EXPECT_THAT(last, ElementsAre(false, false, true));
}

TEST(InputQueue, handles_nothing_that_waited_when_it_was_closed) {
  std::vector<std::string> handled;
  InputQueue* inputs = nullptr;
  InputQueue queue{[&](const wire::Input& input, const InputQueue::Durable&) {
    handled.push_back(input.source);
    inputs->push(named("waits"));
    inputs->close();
    inputs->push(named("late"));
  }};
  inputs = &queue;
  queue.push(named("a"));
  queue.push(named("b"));
  EXPECT_THAT(handled, ElementsAre("a"));
  EXPECT_EQ(queue.handled(), 1U);
  EXPECT_TRUE(queue.closed());
}

}  // namespace
}  // namespace cosiva::adapters
