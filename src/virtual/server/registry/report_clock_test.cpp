#include "cosiva/virtual/server/registry/report_clock.h"

#include <gtest/gtest.h>

#include <initializer_list>

namespace cosiva::virtual_side {
namespace {

using namespace std::chrono_literals;

constexpr SimDuration after = 1s;

/// A report that describes the time of its arrival.
void report(ReportClock& clock, SimTime now) { clock.on_report(now, now); }

/// The clock of a vehicle that reported at these times.
ReportClock reported_at(std::initializer_list<SimDuration> times) {
  ReportClock clock;
  for (const SimDuration time : times) report(clock, virtual_epoch + time);
  return clock;
}

/// The clock of a vehicle that has reported at a constant rate until the rate is known; the last report is at the
/// epoch.
ReportClock steady(SimDuration gap) {
  ReportClock clock;
  for (int i = 200; i >= 0; --i) report(clock, virtual_epoch - i * gap);
  return clock;
}

TEST(ReportClock, never_counts_a_vehicle_without_reports_as_lost) {
  const ReportClock clock;
  EXPECT_FALSE(clock.first());
  EXPECT_FALSE(clock.lost(virtual_epoch + 1h, after));
}

TEST(ReportClock, knows_first_and_last_report) {
  const ReportClock clock = reported_at({1s, 2s, 4s});
  EXPECT_EQ(clock.first(), virtual_epoch + 1s);
  EXPECT_EQ(clock.last(), virtual_epoch + 4s);
}

TEST(ReportClock, assumes_the_slowest_rate_after_a_single_report) {
  EXPECT_EQ(reported_at({0s}).usual_gap(), ReportClock::gap_max);
}

TEST(ReportClock, takes_the_mean_of_the_first_gaps) {
  EXPECT_EQ(reported_at({0s, 1s}).usual_gap(), 3s) << "5 and 1";
  EXPECT_EQ(reported_at({0s, 1s, 4s}).usual_gap(), 3s) << "5, 1 and 3";
  EXPECT_EQ(reported_at({0s, 1s, 4s, 7s}).usual_gap(), 3s) << "5, 1, 3 and 3";
}

TEST(ReportClock, converges_to_a_constant_gap) {
  for (const SimDuration gap : {SimDuration{100ms}, SimDuration{2s}, SimDuration{4900ms}})
    EXPECT_NEAR(to_seconds(steady(gap).usual_gap()), to_seconds(gap), 1e-6);
}

TEST(ReportClock, follows_a_rate_that_changes_by_a_tenth_per_report) {
  ReportClock clock = steady(2s);
  report(clock, virtual_epoch + 3s);
  EXPECT_NEAR(to_seconds(clock.usual_gap()), 2.1, 1e-6);
  report(clock, virtual_epoch + 4s);
  EXPECT_NEAR(to_seconds(clock.usual_gap()), 1.99, 1e-6);
}

TEST(ReportClock, does_not_count_an_absence_as_a_gap) {
  ReportClock clock = steady(2s);
  const SimDuration before = clock.usual_gap();
  report(clock, virtual_epoch + ReportClock::gap_max);
  EXPECT_EQ(clock.usual_gap(), before);
  EXPECT_EQ(clock.last(), virtual_epoch + ReportClock::gap_max);
}

TEST(ReportClock, waits_for_three_usual_gaps_and_no_longer) {
  const ReportClock clock = steady(2s);
  EXPECT_NEAR(to_seconds(clock.longest_silence(after)), 6.0, 1e-6);
  EXPECT_FALSE(clock.lost(virtual_epoch + 5999ms, after));
  EXPECT_TRUE(clock.lost(virtual_epoch + 6001ms, after));
}

TEST(ReportClock, waits_for_at_least_the_given_time_where_reports_are_frequent) {
  const ReportClock clock = steady(100ms);
  EXPECT_EQ(clock.longest_silence(after), after);
  EXPECT_FALSE(clock.lost(virtual_epoch + after, after));
  EXPECT_TRUE(clock.lost(virtual_epoch + after + 1ms, after));
}

TEST(ReportClock, accepts_messages_in_pairs_from_the_first_pair) {
  // State and visualization of one instant: the gaps of 0 s and 3 s have a mean of 1.5 s, and three of these exceed 3
  // s.
  ReportClock clock;
  for (int i = 0; i < 100; ++i) {
    const SimTime now = virtual_epoch + i * 3s;
    EXPECT_FALSE(clock.lost(now, after)) << i;
    report(clock, now);
    report(clock, now + 1ms);
  }
}

TEST(ReportClock, knows_the_newest_time_that_a_report_describes) {
  ReportClock clock;
  clock.on_report(virtual_epoch + 1s, virtual_epoch);
  EXPECT_EQ(clock.reported_at(), virtual_epoch);
  clock.on_report(virtual_epoch + 2s, virtual_epoch + 2s);
  clock.on_report(virtual_epoch + 3s, virtual_epoch + 1s);
  EXPECT_EQ(clock.reported_at(), virtual_epoch + 2s) << "the last report took longer than the one before";
}

TEST(ReportClock, refuses_a_report_about_the_future) {
  ReportClock clock;
  EXPECT_DEATH(clock.on_report(virtual_epoch, virtual_epoch + 1ns), "reported_at <= now");
}

TEST(ReportClock, refuses_a_time_that_runs_backwards) {
  ReportClock clock = reported_at({2s});
  EXPECT_DEATH(report(clock, virtual_epoch + 1s), "now >= last_");
}

TEST(ReportClock, counts_two_reports_at_one_time_as_a_gap_of_zero) {
  EXPECT_EQ(reported_at({1s, 1s}).usual_gap(), 2500ms) << "5 and 0";
}

TEST(ReportClock, counts_a_gap_just_below_an_absence) {
  EXPECT_NEAR(to_seconds(reported_at({0s, 4s, 8s}).usual_gap()), 13.0 / 3.0, 1e-6) << "5, 4 and 4";
  const SimDuration longest = ReportClock::gap_max - 2ns;
  EXPECT_EQ(reported_at({0s, longest}).usual_gap(), ReportClock::gap_max - 1ns);
}

TEST(ReportClock, is_not_lost_at_exactly_its_longest_silence) {
  const ReportClock clock = reported_at({0s, 1s});
  ASSERT_EQ(clock.usual_gap(), 3s);
  EXPECT_EQ(clock.longest_silence(after), 9s);
  EXPECT_FALSE(clock.lost(virtual_epoch + 10s, after));
  EXPECT_TRUE(clock.lost(virtual_epoch + 10s + 1ns, after));
}

TEST(ReportClock, has_no_times_before_the_first_report) {
  const ReportClock clock;
  EXPECT_EQ(clock.last(), SimTime{});
  EXPECT_EQ(clock.reported_at(), SimTime{});
  EXPECT_EQ(clock.usual_gap(), 5s);
}

}  // namespace
}  // namespace cosiva::virtual_side
