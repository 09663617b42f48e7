#include "cosiva/app/platform/virtual_page.h"

#include <gmock/gmock.h>

#include "cosiva/base/test_paths.h"

namespace cosiva::app {
namespace {

using namespace std::chrono_literals;

constexpr std::chrono::seconds timeout{60};

class Virtual : public ::testing::Test {
 protected:
  std::unique_ptr<VirtualPage> open(std::optional<double> duration_s = std::nullopt, double speed = 1.0) {
    UpArguments arguments;
    arguments.zone = source_dir() + "/zones/lacet4.toml";
    arguments.aivs = 1;
    arguments.given.aivs = true;
    arguments.virtual_time = arguments.page = arguments.headless = true;
    arguments.port = 0;
    arguments.duration_s = duration_s;
    arguments.speed = speed;
    auto plan = plan_run(arguments);
    EXPECT_TRUE(plan) << (plan ? "" : to_string(plan.error()));
    auto made = VirtualRun::make(std::move(*plan));
    EXPECT_TRUE(made);
    run = std::move(*made);
    auto page = VirtualPage::open(loop, *run, [this] { ++ended; });
    EXPECT_TRUE(page) << (page ? "" : to_string(page.error()));
    return std::move(*page);
  }

  adapters::EventLoop loop;
  std::unique_ptr<VirtualRun> run;
  int ended{0};
};

TEST_F(Virtual, time_runs_until_it_is_stopped) {
  const auto page = open();
  EXPECT_NE(page->port(), 0);
  EXPECT_TRUE(page->clock().is_virtual);
  EXPECT_TRUE(page->clock().running);
  ASSERT_TRUE(loop.run_until([&] { return run->elapsed() > 200ms; }, timeout));
  page->set_clock(false, 1.0);
  EXPECT_FALSE(page->clock().running);
  const SimDuration stopped_at = run->elapsed();
  loop.run_for(100ms);
  EXPECT_EQ(run->elapsed(), stopped_at);
}

TEST_F(Virtual, a_step_has_exactly_its_duration) {
  const auto page = open();
  page->set_clock(false, 1.0);
  const SimDuration before = run->elapsed();
  page->step(1234ms);
  loop.run_for(60ms);
  EXPECT_EQ(run->elapsed(), before + 1234ms);
}

TEST_F(Virtual, more_speed_than_the_machine_reaches_keeps_the_page_responsive_and_is_reported) {
  const auto page = open(std::nullopt, 100.0);
  EXPECT_EQ(page->clock().speed, 100.0);
  bool acknowledged = false;
  loop.post([&] { acknowledged = true; });
  ASSERT_TRUE(loop.run_until([&] { return acknowledged && run->elapsed() > 5s; }, timeout));
  EXPECT_GT(page->clock().speed, 0.0);
  EXPECT_LE(page->clock().speed, 100.0);
  page->set_clock(true, 2.0);
  EXPECT_EQ(page->clock().speed, 2.0);
}

TEST_F(Virtual, ends_exactly_at_its_duration_and_only_once) {
  const auto page = open(1.5, 20.0);
  ASSERT_TRUE(loop.run_until([&] { return ended > 0; }, timeout));
  EXPECT_EQ(run->elapsed(), 1500ms);
  page->set_clock(true, 1.0);
  EXPECT_FALSE(page->clock().running) << "a finished run does not start again";
  page->step(1s);
  loop.run_for(50ms);
  EXPECT_EQ(run->elapsed(), 1500ms);
  EXPECT_EQ(ended, 1);
}

TEST_F(Virtual, a_step_beyond_the_end_stops_at_the_end) {
  const auto page = open(2.0);
  page->set_clock(false, 1.0);
  page->step(10s);
  EXPECT_EQ(run->elapsed(), 2s);
  EXPECT_EQ(ended, 1);
}

}  // namespace
}  // namespace cosiva::app
