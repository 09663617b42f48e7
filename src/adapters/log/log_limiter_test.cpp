#include "cosiva/adapters/log/log_limiter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <vector>

namespace cosiva::adapters {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::SizeIs;

struct Limited {
  std::vector<std::string> lines;
  LogLimiter limiter{[this](char level, const std::string& text) { lines.push_back(std::string{level} + ' ' + text); }};
  SimTime now{virtual_epoch};
};

TEST(LogLimiter, passes_lines_that_are_few) {
  Limited log;
  log.limiter.log(log.now, 'i', "CoSiVA/AIV1: registered with display number 1");
  log.limiter.log(log.now, 'w', "no route to the station");
  EXPECT_THAT(log.lines, ElementsAre("i CoSiVA/AIV1: registered with display number 1", "w no route to the station"));
}

TEST(LogLimiter, counts_the_lines_of_one_source_and_kind_beyond_ten_in_ten_seconds) {
  Limited log;
  for (int i = 0; i < 67; ++i)
    log.limiter.log(log.now + i * 100ms, 'w', "CoSiVA/AIV1: follows update " + std::to_string(i) + " up to 'n7'");
  EXPECT_THAT(log.lines, SizeIs(10));
  log.limiter.tick(log.now + 9s);
  EXPECT_THAT(log.lines, SizeIs(10)) << "the window is not over";
  log.limiter.tick(log.now + 10s);
  ASSERT_THAT(log.lines, SizeIs(11));
  EXPECT_EQ(log.lines.back(), "w … 57 more in 10 s like: CoSiVA/AIV1: follows update 66 up to 'n7'");
  log.limiter.log(log.now + 11s, 'w', "CoSiVA/AIV1: follows update 99 up to 'n7'");
  EXPECT_THAT(log.lines, SizeIs(12)) << "another window";
}

TEST(LogLimiter, keeps_the_lines_of_different_sources_and_of_different_kinds_apart) {
  Limited log;
  for (int i = 0; i < 20; ++i) {
    log.limiter.log(log.now, 'w', "CoSiVA/AIV1: arrived at dock");
    log.limiter.log(log.now, 'w', "CoSiVA/AIV2: arrived at dock");
    log.limiter.log(log.now, 'w', "CoSiVA/AIV1: no route");
  }
  EXPECT_THAT(log.lines, SizeIs(30));
}

TEST(LogLimiter, bounds_the_lines_of_one_kind_from_invented_sources) {
  Limited log;
  for (int i = 0; i < 100'000; ++i)
    log.limiter.log(log.now, 'i', "Forged/X" + std::to_string(i) + ": registered with display number 1");
  EXPECT_THAT(log.lines, SizeIs(250));
  log.limiter.flush();
  EXPECT_THAT(log.lines, SizeIs(251));
  EXPECT_EQ(log.lines.back(), "i … 99750 more in 10 s like: Forged/X99999: registered with display number 1");
}

TEST(LogLimiter, bounds_the_lines_of_invented_kinds) {
  Limited log;
  std::string kind;
  for (int i = 0; i < 50'000; ++i) {
    kind.clear();
    for (int n = i; n > 0; n /= 20) kind += static_cast<char>('a' + n % 20);
    log.limiter.log(log.now, 'w', "X: " + kind);
  }
  EXPECT_LE(log.lines.size(), LogLimiter::keys_max + LogLimiter::lines_max);
}

TEST(LogLimiter, ignores_digits_and_quoted_text_in_a_kind) {
  EXPECT_EQ(LogLimiter::kind_of("A/B: follows 'x1' up to 12.5 m"),
            LogLimiter::kind_of("C/D: follows 'y' up to 3.75 m"));
  EXPECT_NE(LogLimiter::kind_of("A/B: follows"), LogLimiter::kind_of("A/B: leads"));
}

TEST(LogLimiter, gives_the_same_log_for_the_same_times) {
  Limited first;
  Limited second;
  for (Limited* log : {&first, &second}) {
    for (int i = 0; i < 500; ++i) {
      log->limiter.log(log->now + i * 50ms, 'w', "CoSiVA/AIV" + std::to_string(i % 3) + ": late");
      log->limiter.tick(log->now + i * 50ms);
    }
  }
  EXPECT_EQ(first.lines, second.lines);
  EXPECT_LT(first.lines.size(), 120U);
}

TEST(LogLimiter, takes_a_time_before_the_last_one_as_the_last_one) {
  Limited log;
  log.limiter.log(log.now + 20s, 'i', "X: a");
  log.limiter.log(log.now, 'i', "X: a");
  log.limiter.tick(log.now);
  EXPECT_THAT(log.lines, SizeIs(2));
}

}  // namespace
}  // namespace cosiva::adapters
