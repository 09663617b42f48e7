#include "cosiva/experiments/positioning/metrology/reference_budget.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cosiva/base/json_value.h"

namespace cosiva::experiments {
namespace {

using ::testing::HasSubstr;

constexpr const char* whole = R"({"format": "cosiva.reference_budget.v1", "parts": [
  {"name": "floor fit", "uncertainty_m": 0.003, "source": "left-out blocks"},
  {"name": "time stamp", "time_s": 0.008, "speed_mps": 0.5, "source": "gvs track --against"},
  {"name": "tag height", "height_error_m": 0.0048, "tag_height_m": 0.1, "camera_height_m": 1.1, "from_foot_m": 2.5,
   "source": "a ruler"},
  {"name": "mounting", "uncertainty_m": null, "source": "not measured"}]})";

std::string refusal(const std::string& parts) {
  const auto read =
      read_reference_budget(R"({"format": "cosiva.reference_budget.v1", "parts": )" + parts + "}", "u.json");
  EXPECT_FALSE(read) << parts;
  return read ? "" : to_string(read.error());
}

TEST(ReferenceBudget, is_the_root_of_the_sum_of_its_parts_squares) {
  const auto budget = read_reference_budget(whole, "u.json");
  ASSERT_TRUE(budget) << to_string(budget.error());
  ASSERT_EQ(budget->parts.size(), 4U);
  // 8 ms at half a metre a second; 4.8 mm of height, a metre below the camera and 2.5 m out.
  EXPECT_NEAR(*budget->parts[1].uncertainty_m, 4e-3, 1e-15);
  EXPECT_NEAR(*budget->parts[2].uncertainty_m, 12e-3, 1e-15);
  EXPECT_NEAR(budget->total_m(), 13e-3, 1e-15);
  EXPECT_NEAR(budget->ratio_percent(budget->parts[0]), 100.0 * 9.0 / 169.0, 1e-12);
  EXPECT_EQ(budget->ratio_percent(budget->parts[3]), 0.0);
  EXPECT_EQ(budget->untold(), 1U);
  EXPECT_EQ(text_of(*budget), "u 13 mm: floor fit 3, time stamp 4, tag height 12; not given: mounting");
  EXPECT_EQ(ReferenceBudget{}.total_m(), 0.0);
}

TEST(ReferenceBudget, of_a_wrong_height_is_the_residual_of_the_correction) {
  // Observed at ρ·H/(H − h), corrected with a wrong h: the difference to ρ, to first order in δh.
  const double detected_m = 2.5 * 3.3 / (3.3 - 0.10);
  const double put_m = detected_m * (3.3 - 0.101) / 3.3;
  EXPECT_NEAR(height_uncertainty_m(2.5, 0.001, 0.10, 3.3), 2.5 - put_m, 1e-12);
}

TEST(ReferenceBudget, written_reads_back_and_lists_each_part_with_its_source) {
  const auto budget = read_reference_budget(whole, "u.json");
  const std::string text = to_json(*budget);
  const auto again = read_reference_budget(text, "again.json");
  ASSERT_TRUE(again) << to_string(again.error());
  EXPECT_EQ(to_json(*again), text);
  const auto json = JsonValue::parse(text);
  EXPECT_NEAR(*json->number("uncertainty_m"), 13e-3, 1e-15);
  const auto& parts = *json->find("parts")->array();
  EXPECT_EQ(parts[1].text("source"), "gvs track --against");
  EXPECT_TRUE(parts[3].find("uncertainty_m")->is_null());
}

TEST(ReferenceBudget, that_is_invalid_is_refused_with_its_part_and_field) {
  EXPECT_EQ(read_reference_budget("nonsense", "u.json").error().code, "reference.budget");
  EXPECT_THAT(read_reference_budget("{}", "u.json").error().message, HasSubstr("cosiva.reference_budget.v1"));
  EXPECT_THAT(refusal("[]"), HasSubstr("u.json: 'parts'"));
  EXPECT_THAT(refusal("[3]"), HasSubstr("u.json: part 1"));
  EXPECT_THAT(refusal(R"([{"name": "a", "source": "b", "uncertainty_m": -1}])"),
              HasSubstr("u.json: part 1: 'uncertainty_m'"));
  EXPECT_THAT(refusal(R"([{"name": "a", "source": "b", "uncertainty_m": "1"}])"), HasSubstr("'uncertainty_m'"));
  EXPECT_THAT(refusal(R"([{"name": "a", "source": "b"}])"), HasSubstr("expected one of"));
  EXPECT_THAT(refusal(R"([{"name": "a", "source": "b", "uncertainty_m": 1, "time_s": 1}])"), HasSubstr("expected one"));
  EXPECT_THAT(refusal(R"([{"name": "a", "source": "b", "time_s": 1}])"), HasSubstr("'speed_mps'"));
  EXPECT_THAT(refusal(R"([{"name": "a", "uncertainty_m": 1}])"), HasSubstr("'source'"));
  EXPECT_THAT(refusal(R"([{"name": "a", "source": "b", "height_error_m": 1, "tag_height_m": 2, "camera_height_m": 2,
                           "from_foot_m": 1}])"),
              HasSubstr("above the tag"));
  EXPECT_THAT(refusal(R"([{"name": "a", "source": "b", "uncertainty_m": 1},
                          {"name": "a", "source": "c", "uncertainty_m": 1}])"),
              HasSubstr("twice"));
}

TEST(ReferenceBudget, is_removed_from_the_observed_error) {
  EXPECT_NEAR(without_reference_m(0.05, 0.03), 0.04, 1e-15);
  EXPECT_EQ(without_reference_m(0.02, 0.03), 0.0);
}

}  // namespace
}  // namespace cosiva::experiments
