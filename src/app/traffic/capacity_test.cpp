#include "cosiva/app/traffic/capacity.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cosiva/app/command_line_fixture.h"
#include "cosiva/base/json_value.h"

namespace cosiva::app {
namespace {

using fixture::cosiva;
using ::testing::HasSubstr;

StepMetrics of(std::uint64_t vehicles, double p99_ms) { return {vehicles, 100, 0.5 * p99_ms, p99_ms, 200.0}; }

TEST(Capacity, reports_the_measured_capacity_and_the_expected_one_beyond) {
  const std::vector<StepMetrics> measured{of(1'000, 0.1), of(100'000, 8.0)};
  EXPECT_EQ(carried_at(measured, 1.0).sure, 100'000U);
  EXPECT_EQ(carried_at(measured, 1.0).expected, 1'200'000U) << "100 ms for 8 ms each, to two digits";
  EXPECT_EQ(carried_at(measured, 100.0).sure, 1'000U) << "8 ms is more than 1 ms";
  EXPECT_EQ(carried_at(measured, 100.0).expected, 12'000U);
  EXPECT_FALSE(carried_at(measured, 10'000.0).sure);
}

TEST(Capacity, takes_the_live_metrics_from_the_platform_s_own_summary) {
  const auto live = live_metrics(12, R"({"bijection":{"matched_ratio":1,"age_ms":{"p50":50,"p99":99},
    "divergence_m":{"p99":0.01}},"collisions":0})");
  ASSERT_TRUE(live);
  EXPECT_EQ(live->age_p99_ms, 99.0);
  EXPECT_EQ(live->divergence_p99_m, 0.01);
  for (const char* bad : {"", "{}", "[1]", R"({"bijection":{}})"})
    EXPECT_EQ(live_metrics(12, bad).error().code, "capacity.live") << bad;
}

TEST(Capacity, measures_this_machine) {
  const auto output = cosiva({"capacity", "--max", "1000", "--seconds", "0.05", "--live", "0", "--json"});
  ASSERT_EQ(output.status, 0) << output.standard_error;
  const auto json = JsonValue::parse(output.data, 1U << 16U);
  ASSERT_TRUE(json);
  ASSERT_EQ(json->find("fleet")->array()->size(), 2U);
  for (const JsonValue& one : *json->find("fleet")->array()) {
    EXPECT_GT(*one.number("step_p99_ms"), 0.0);
    EXPECT_GE(*one.number("step_p99_ms"), *one.number("step_p50_ms"));
  }
  EXPECT_EQ(*json->find("carries")->find("at_1x")->number("measured"), 1000.0);
  EXPECT_EQ(cosiva({"capacity", "--live", "0", "--zone", "nowhere"}).status, 2);
  EXPECT_THAT(cosiva({"capacity", "--max", "100", "--seconds", "0.05", "--live", "0"}).data,
              HasSubstr("capacity in real time"));
}

}  // namespace
}  // namespace cosiva::app
