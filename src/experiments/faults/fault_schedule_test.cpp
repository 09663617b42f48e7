#include "cosiva/experiments/faults/fault_schedule.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

namespace cosiva::experiments {
namespace {

using std::chrono::minutes;
using std::chrono::seconds;

FaultScheduleOptions options_of(SimDuration duration) {
  FaultScheduleOptions options;
  options.duration = duration;
  options.sections = {"east", "north"};
  return options;
}

std::string text_of(const std::vector<Fault>& faults) {
  std::string text;
  for (const Fault& fault : faults) text += to_string(fault) + "\n";
  return text;
}

TEST(FaultSchedule, follows_from_its_seed) {
  const auto options = options_of(minutes{10});
  EXPECT_EQ(text_of(draw_fault_schedule(7, options)), text_of(draw_fault_schedule(7, options)));
  EXPECT_NE(text_of(draw_fault_schedule(7, options)), text_of(draw_fault_schedule(8, options)));
}

TEST(FaultSchedule, is_sorted_numbered_and_within_its_duration) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    const auto faults = draw_fault_schedule(seed, options_of(minutes{1}));
    EXPECT_TRUE(std::ranges::is_sorted(faults, {}, &Fault::at));
    for (std::size_t i = 0; i < faults.size(); ++i) {
      EXPECT_EQ(faults[i].number, i + 1);
      EXPECT_GE(faults[i].at, seconds{0}) << to_string(faults[i]);
      EXPECT_LE(faults[i].at, minutes{1}) << to_string(faults[i]);
    }
  }
}

TEST(FaultSchedule, contains_every_class_at_the_rates_of_the_requirements) {
  FaultCounts counts{};
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const auto faults = draw_fault_schedule(seed, options_of(minutes{1}));
    const FaultCounts one = count_kinds(faults);
    for (std::size_t i = 0; i < fault_kinds; ++i) counts.at(i) += one.at(i);
    for (const Fault& fault : faults) {
      EXPECT_LE(fault.loss, 0.3);
      EXPECT_LE(fault.duplication, 0.5);
      EXPECT_LE(fault.delay_max, seconds{2});
      if (fault.kind == FaultKind::partition) {
        EXPECT_LE(fault.lasts, seconds{60});
      }
    }
  }
  for (std::size_t i = 0; i < fault_kinds; ++i) EXPECT_GE(counts.at(i), 40U) << to_string(static_cast<FaultKind>(i));
}

/// A class with less than one fault in two simulations is drawn, too.
TEST(FaultSchedule, has_the_same_rates_in_short_simulations) {
  FaultCounts counts{};
  for (std::uint64_t seed = 1; seed <= 1000; ++seed) {
    const FaultCounts one = count_kinds(draw_fault_schedule(seed, options_of(seconds{30})));
    for (std::size_t i = 0; i < fault_kinds; ++i) counts.at(i) += one.at(i);
  }
  const std::uint64_t bit_flips = counts.at(static_cast<std::size_t>(FaultKind::bit_flip));
  EXPECT_GE(bit_flips, 110U)
      << "0.3 in a minute are 150 in 1000 simulations of half a minute; some leave the class out";
  EXPECT_LE(bit_flips, 190U);
}

TEST(FaultSchedule, leaves_one_class_out_of_some_seeds) {
  int without_crashes = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const FaultCounts counts = count_kinds(draw_fault_schedule(seed, options_of(minutes{10})));
    if (counts.at(static_cast<std::size_t>(FaultKind::crash)) == 0) ++without_crashes;
  }
  EXPECT_GT(without_crashes, 0);
  EXPECT_LT(without_crashes, 40);
}

}  // namespace
}  // namespace cosiva::experiments
