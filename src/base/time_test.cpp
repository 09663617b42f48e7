#include "cosiva/base/time.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include "cosiva/base/random.h"

namespace cosiva {
namespace {

using namespace std::chrono_literals;

SimTime parsed(std::string_view text) {
  const auto time = parse_iso8601(text);
  EXPECT_TRUE(time) << text;
  return time.value_or(SimTime{});
}

TEST(Time, virtual_time_starts_on_the_day_of_the_article) {
  EXPECT_EQ(to_iso8601(virtual_epoch), "2023-07-11T00:00:00.000Z");
}

TEST(Duration, in_milliseconds_is_the_nearest_number_and_within_a_bit_of_it_in_the_forms_of_the_messages) {
  static_assert(to_milliseconds(1500us) == 1.5);
  static_assert(to_milliseconds_scaled(SimTime{1500us}) == 1.5);
  static_assert(to_milliseconds_by_seconds(100ms) == 100.0);
  for (const SimDuration duration : {SimDuration{1ns}, SimDuration{20'000'001ns}, SimDuration{3h + 7ns}}) {
    const double nearest = to_milliseconds(duration);
    EXPECT_DOUBLE_EQ(to_milliseconds_scaled(duration), nearest);
    EXPECT_DOUBLE_EQ(to_milliseconds_by_seconds(duration), nearest);
  }
}

TEST(Time, is_written_with_milliseconds_rounded_down) {
  EXPECT_EQ(to_iso8601(SimTime{0ns}), "1970-01-01T00:00:00.000Z");
  EXPECT_EQ(to_iso8601(virtual_epoch + 23h + 59min + 59s + 999'999'999ns), "2023-07-11T23:59:59.999Z");
  EXPECT_EQ(to_iso8601(SimTime{} - 1ns), "1969-12-31T23:59:59.999Z");
}

TEST(Time, is_read_with_any_number_of_decimals) {
  const SimTime base = parsed("2023-07-11T12:30:45Z");
  EXPECT_EQ(base, virtual_epoch + 12h + 30min + 45s);
  EXPECT_EQ(parsed("2023-07-11T12:30:45.5Z"), base + 500ms);
  EXPECT_EQ(parsed("2023-07-11T12:30:45.12Z"), base + 120ms);
  EXPECT_EQ(parsed("2023-07-11T12:30:45.123Z"), base + 123ms);
  EXPECT_EQ(parsed("2023-07-11T12:30:45.123456789Z"), base + 123'456'789ns);
  EXPECT_EQ(parsed("2023-07-11T12:30:45.123456789999Z"), base + 123'456'789ns);
  EXPECT_EQ(parsed("2023-07-11T12:30:45.123+00:00"), base + 123ms);
}

TEST(Time, supports_leap_days_and_leap_seconds) {
  EXPECT_EQ(parsed("2024-02-29T00:00:00Z") + 24h, parsed("2024-03-01T00:00:00Z"));
  EXPECT_FALSE(parse_iso8601("2023-02-29T00:00:00Z"));
  EXPECT_EQ(parsed("2016-12-31T23:59:60Z"), parsed("2017-01-01T00:00:00Z"));
}

TEST(Time, that_is_invalid_is_rejected_with_the_expected_form) {
  for (const char* bad :
       {"", "now", "2023-07-11", "2023-07-11T12:30:45", "2023-07-11T12:30:45.", "2023-07-11T12:30:45+02:00",
        "2023-07-11 12:30:45Z", "2023-13-11T12:30:45Z", "2023-00-11T12:30:45Z", "2023-07-32T12:30:45Z",
        "2023-07-11T24:30:45Z", "2023-07-11T12:60:45Z", "2023-07-11T12:30:61Z", "1969-07-11T12:30:45Z",
        "9999-07-11T12:30:45Z", "2023-07-11T12:30:45Zx", "2023-07-11T12:30:4aZ", "+023-07-11T12:30:45Z",
        "2023-07-11T12:30:45.Z"}) {
    const auto time = parse_iso8601(bad);
    ASSERT_FALSE(time) << bad;
    EXPECT_EQ(time.error().code, "time.format");
    EXPECT_THAT(time.error().message, ::testing::HasSubstr("2023-07-11T00:00:00.000Z"));
  }
}

TEST(Time, reads_what_it_wrote) {
  EXPECT_TRUE(rc::check([] {
    Random random{*rc::gen::arbitrary<std::uint64_t>(), "time_test"};
    const SimTime time{std::chrono::milliseconds{random.below(7'000'000'000'000)}};
    RC_ASSERT(parse_iso8601(to_iso8601(time)) == time);
  }));
}

TEST(Time, seconds_become_the_nearest_nanosecond) {
  EXPECT_EQ(from_seconds(1.5), 1'500'000'000ns);
  EXPECT_EQ(from_seconds(-0.1), -100'000'000ns);
  EXPECT_EQ(from_seconds(0.4e-9), 0ns);
  EXPECT_EQ(from_seconds(0.6e-9), 1ns);
  EXPECT_EQ(from_seconds(-0.6e-9), -1ns);
  EXPECT_EQ(to_seconds(250ms), 0.25);
}

}  // namespace
}  // namespace cosiva
