#include "cosiva/app/platform/live_scenario.h"

#include <gmock/gmock.h>

namespace cosiva::app {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr std::chrono::seconds timeout{30};

class Live : public ::testing::Test {
 protected:
  /// Three steps: at once, after 50 ms, after 100 ms.
  static experiments::Scenario scenario() {
    const auto read = experiments::scenario_from_toml(
        "name = \"t\"\n[[at]]\nt_s = 0\nremove = \"a\"\n[[at]]\nt_s = 0.05\nremove = \"b\"\n[[at]]\nt_s = 0.1\nremove "
        "= "
        "\"c\"\n",
        "t.toml");
    EXPECT_TRUE(read);
    return *read;
  }
  LiveScenario::Handlers handlers() {
    return {[this](std::string command) { given.push_back(std::move(command)); },
            [this](std::uint64_t number, SimDuration at, const experiments::Scenario::Step& step) {
              numbers.push_back(number);
              EXPECT_GE(at, step.at) << "no step is played early";
            }};
  }

  adapters::EventLoop loop;
  adapters::WallClock clock;
  std::vector<std::string> given;
  std::vector<std::uint64_t> numbers;
};

TEST_F(Live, plays_nothing_before_the_fleet_is_complete_and_then_each_step_once_in_order) {
  LiveScenario live{loop, scenario(), 0, handlers()};
  loop.run_for(150ms);
  EXPECT_THAT(given, IsEmpty());
  live.begin(clock.now());
  EXPECT_EQ(given.size(), 1U);
  ASSERT_TRUE(loop.run_until([&] { return given.size() == 3; }, timeout));
  loop.run_for(100ms);
  EXPECT_THAT(given, ElementsAre(R"({"command":"remove","id":"a"})", R"({"command":"remove","id":"b"})",
                                 R"({"command":"remove","id":"c"})"));
  EXPECT_THAT(numbers, ElementsAre(1, 2, 3));
}

TEST_F(Live, continues_after_the_steps_that_a_previous_run_played) {
  LiveScenario live{loop, scenario(), 2, handlers()};
  live.begin(clock.now() - 10s);
  EXPECT_THAT(given, ElementsAre(R"({"command":"remove","id":"c"})")) << "an overdue step is played late";
  EXPECT_THAT(numbers, ElementsAre(3));
}

TEST_F(Live, plays_no_step_after_a_previous_run_played_all) {
  for (const std::uint64_t done : {3U, 30U}) {
    LiveScenario live{loop, scenario(), done, handlers()};
    live.begin(clock.now() - 10s);
    loop.run_for(20ms);
    EXPECT_THAT(given, IsEmpty());
  }
}

}  // namespace
}  // namespace cosiva::app
