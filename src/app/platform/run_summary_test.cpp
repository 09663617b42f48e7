#include "cosiva/app/platform/run_summary.h"

#include <gmock/gmock.h>

#include <algorithm>

#include "cosiva/base/json_value.h"

namespace cosiva::app {
namespace {

using ::testing::HasSubstr;

std::string server(int physical, int twins, int matched) {
  return R"({"bijection":{"physical":)" + std::to_string(physical) + R"(,"virtual":)" + std::to_string(twins) +
         R"(,"matched":)" + std::to_string(matched) +
         R"(,"orphans":[],"divergence_m":{"p99":0.0042},"age_ms":{"p99":101.5}},"aivs":[{"id":"CoSiVA/AIV1"}]})";
}
const std::string calm_plant = R"({"vehicles":[],"collisions":[],"laps":7,"longest_wait_s":3.5})";
const RunMetadata metadata{"lacet4", 2, 9, 60.0, "0123456789abcdef", ""};

TEST(RunSummary, writes_the_parts_metrics_under_the_documented_names) {
  const auto run = summarise(metadata, server(2, 2, 2), calm_plant);
  ASSERT_TRUE(run);
  EXPECT_EQ(run->json,
            R"({"bijection":{"physical":2,"virtual":2,"matched":2,"orphans":[],"divergence_m":{"p99":0.0042},)"
            R"("age_ms":{"p99":101.5}},"aivs":2,"collisions":0,"laps":7,"longest_wait_s":3.5,)"
            R"("digest":"0123456789abcdef","duration_s":60,"zone":"lacet4","seed":9})");
  EXPECT_TRUE(run->all_matched);
  EXPECT_FALSE(run->collided);
  EXPECT_THAT(run->text, HasSubstr("matched 2 of 2, divergence p99 4.2 mm, age p99 101.5 ms"));
}

TEST(RunSummary, distinguishes_a_missing_vehicle_from_an_extra_vehicle) {
  EXPECT_FALSE(summarise(metadata, server(1, 1, 1), calm_plant)->all_matched);
  EXPECT_FALSE(summarise(metadata, server(2, 3, 2), calm_plant)->all_matched);
  EXPECT_FALSE(summarise(metadata, server(3, 3, 3), calm_plant)->all_matched);
}

TEST(RunSummary, never_matches_more_vehicles_than_it_counts) {
  const auto text = [](int physical, int twins, int matched) {
    return summarise(metadata, server(physical, twins, matched), calm_plant)->text;
  };
  EXPECT_THAT(text(4, 4, 4), HasSubstr(": matched 4 of 4 (2 more than requested), divergence"));
  EXPECT_THAT(text(2, 3, 2), HasSubstr(": matched 2 of 3 (1 more than requested), divergence"));
  EXPECT_THAT(text(1, 1, 1), HasSubstr(": matched 1 of 2, divergence"));
  EXPECT_THAT(text(2, 1, 1), HasSubstr(": matched 1 of 2, divergence"));
}

TEST(RunSummary, counts_collisions) {
  const auto run = summarise(metadata, server(2, 2, 2), R"({"collisions":[{"a":"AIV1","b":"AIV2"}],"laps":0})");
  ASSERT_TRUE(run);
  EXPECT_TRUE(run->collided);
  EXPECT_EQ(JsonValue::parse(run->json)->number("collisions"), 1.0);
}

TEST(RunSummary, reports_deadlocks_and_unresolved_deadlocks) {
  const auto with = [](const std::string& deadlocks) {
    std::string text = server(2, 2, 2);
    text.insert(text.size() - 1, R"(,"deadlocks":)" + deadlocks);
    return *summarise(metadata, text, calm_plant);
  };
  const RunSummary one = with(R"({"rings":4,"detected":1,"resolved":1,"open":0,"longest_s":4.9})");
  EXPECT_THAT(one.text, HasSubstr("longest wait 3.5 s, 1 deadlock, digest"));
  EXPECT_THAT(one.json, HasSubstr(R"("deadlocks":{"rings":4,"detected":1,"resolved":1,"open":0,"longest_s":4.9})"));
  EXPECT_THAT(with(R"({"detected":3,"open":1})").text, HasSubstr("3 deadlocks (1 not resolved)"));
}

TEST(RunSummary, of_a_part_without_summary_is_an_error) {
  for (const char* bad : {"", "{}", "nonsense", R"({"collisions":3})"}) {
    const auto run = summarise(metadata, server(2, 2, 2), bad);
    ASSERT_FALSE(run) << bad;
    EXPECT_EQ(run.error().code, "run.summary");
  }
  EXPECT_FALSE(summarise(metadata, "{}", calm_plant));
}

TEST(RunSummary, reports_virtual_objects_in_a_separate_line) {
  EXPECT_EQ(std::ranges::count(summarise(metadata, server(2, 2, 2), calm_plant)->text, '\n'), 1);
  const auto run = summarise(metadata,
                             R"({"bijection":{"physical":2,"virtual":2,"matched":2,"augmented":3,"effects":{)"
                             R"("perceived_ms":{"count":7,"p99":12.5},"brakes_ms":{"count":2,"p99":20.0},)"
                             R"("shown_ms":{"count":0}}}})",
                             calm_plant);
  ASSERT_TRUE(run);
  EXPECT_THAT(run->text,
              HasSubstr("\n3 virtual AIVs, 7 times perceived in p99 12.5 ms, 2 times braked for in p99 20.0 ms"));
  EXPECT_THAT(run->text, ::testing::Not(HasSubstr("shown")));
}

TEST(RunSummary, reports_that_the_machine_was_late) {
  const auto text = [](const char* late_ms) {
    return summarise(metadata,
                     R"({"bijection":{"physical":2,"virtual":2,"matched":2,"late_ms":)" + std::string(late_ms) + "}}",
                     calm_plant)
        ->text;
  };
  EXPECT_THAT(text(R"({"count":9,"p99":120.5,"max":585.2})"),
              HasSubstr("\nthis machine was busy or stalled: the server woke up to 585 ms late (p99 120.5 ms)"));
  EXPECT_THAT(text(R"({"count":9,"p99":4.0,"max":585.2})"), ::testing::Not(HasSubstr("late")));
}

TEST(RunSummary, names_the_scenario_if_there_was_one) {
  RunMetadata with = metadata;
  with.scenario = "showroom";
  EXPECT_EQ(JsonValue::parse(summarise(with, server(2, 2, 2), calm_plant)->json)->text("scenario"), "showroom");
}

TEST(RunSummary, is_deadlocked_where_a_deadlock_is_not_resolved_at_the_end) {
  const auto with = [](const std::string& deadlocks) {
    std::string text = server(2, 2, 2);
    text.insert(text.size() - 1, R"(,"deadlocks":)" + deadlocks);
    return summarise(metadata, text, calm_plant)->deadlocked;
  };
  EXPECT_FALSE(with(R"({"detected":3,"open":0,"unresolved":0})"));
  EXPECT_FALSE(with(R"({"detected":3,"open":1,"unresolved":0})")) << "a vehicle is yielding";
  EXPECT_TRUE(with(R"({"detected":3,"open":1,"unresolved":1})"));
}

TEST(RunSummary, reports_waits_and_arrivals_of_planned_routes) {
  std::string text = server(2, 2, 2);
  text.insert(text.size() - 1,
              R"(,"routes":{"waits":7,"wait_p99_s":12,"longest_wait_s":12.5,"arrivals":9,"least_arrivals":4})");
  const auto run = summarise(metadata, text, calm_plant);
  ASSERT_TRUE(run);
  EXPECT_EQ(JsonValue::parse(run->json)->find("routes")->number("longest_wait_s"), 12.5);
  EXPECT_THAT(run->text, HasSubstr("longest wait 3.5 s (of a route 12.5 s, 99 % up to 12 s), 9 arrivals, at least 4 of "
                                   "each AIV"));
}

}  // namespace
}  // namespace cosiva::app
