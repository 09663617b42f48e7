#include "cosiva/journal/store/retention.h"

#include <gtest/gtest.h>

namespace cosiva::journal {
namespace {

using namespace std::chrono_literals;

constexpr SimTime start{1'000'000s};

/// Segments of ten records and 100 bytes, one per hour, with a checkpoint in each.
std::deque<SegmentSummary> hourly(std::size_t count) {
  std::deque<SegmentSummary> segments;
  for (std::size_t i = 0; i < count; ++i) {
    const RecordNumber first = 1 + 10 * i;
    segments.push_back({segment_name(first), first, first + 10, 100, 100, start + (i + 1) * 1h, first + 5});
  }
  return segments;
}

TEST(Retention, removes_nothing_without_a_limit) { EXPECT_EQ(removable(hourly(5), {}, start + 1'000h), 0U); }

TEST(Retention, removes_segments_whose_last_record_is_too_old) {
  const Keep keep{.age = 2h, .bytes = {}};
  EXPECT_EQ(removable(hourly(5), keep, start + 3h), 0U);
  EXPECT_EQ(removable(hourly(5), keep, start + 3h + 1s), 1U);
  EXPECT_EQ(removable(hourly(5), keep, start + 4h + 1s), 2U);
}

TEST(Retention, removes_the_oldest_segments_until_the_others_fit) {
  EXPECT_EQ(removable(hourly(5), {.age = {}, .bytes = 500}, start), 0U);
  EXPECT_EQ(removable(hourly(5), {.age = {}, .bytes = 499}, start), 1U);
  EXPECT_EQ(removable(hourly(5), {.age = {}, .bytes = 250}, start), 3U);
}

TEST(Retention, keeps_the_last_checkpoint_and_what_follows_whatever_the_limits_are) {
  EXPECT_EQ(removable(hourly(5), {.age = 1s, .bytes = 0}, start + 1'000h), 4U);
  auto segments = hourly(5);
  for (std::size_t i = 2; i < segments.size(); ++i) segments[i].checkpoint.reset();
  EXPECT_EQ(removable(segments, {.age = 1s, .bytes = 0}, start + 1'000h), 1U);
}

TEST(Retention, keeps_a_store_without_a_checkpoint) {
  auto segments = hourly(3);
  for (SegmentSummary& segment : segments) segment.checkpoint.reset();
  EXPECT_EQ(removable(segments, {.age = 1s, .bytes = 0}, start + 1'000h), 0U);
}

}  // namespace
}  // namespace cosiva::journal
