#include "cosiva/battery/type.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>
#include <utility>

#include "cosiva/base/test_paths.h"
#include "cosiva/battery/type_json.h"

namespace cosiva::battery {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;

std::string text_of(const std::string& name) {
  std::ifstream file{std::string(source_dir() + "/batteries/") + name + ".json", std::ios::binary};
  return {std::istreambuf_iterator<char>{file}, {}};
}

/// The error for the Leaf's file with one text replaced by another.
std::string refusal(const std::string& from, const std::string& to) {
  std::string text = text_of("leaf33");
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  text.replace(at, from.size(), to);
  const auto type = read_type(text, "my.json");
  if (type) return "taken";
  EXPECT_EQ(type.error().code, "battery.type");
  return to_string(type.error());
}

TEST(BatteryType, files_of_the_platform_are_valid_and_state_their_sources) {
  EXPECT_THAT(shipped_types(), ElementsAre("leaf33", "lipo850"));
  for (const std::string& name : shipped_types()) {
    const auto type = shipped_type(name);
    ASSERT_TRUE(type) << to_string(type.error());
    EXPECT_EQ(type->name, name);
    EXPECT_FALSE(type->source.empty());
    EXPECT_FALSE(type->licence.empty());
    EXPECT_EQ(read_type(text_of(name), name), type);
  }
  EXPECT_THAT(to_string(shipped_type("aa").error()), HasSubstr("there are leaf33, lipo850"));
}

TEST(BatteryType, is_the_same_after_writing_and_reading) {
  for (const std::string& name : shipped_types()) {
    const auto type = shipped_type(name);
    EXPECT_EQ(read_type(to_json(*type), name), type);
  }
}

TEST(BatteryType, without_a_unit_is_rejected_with_the_missing_unit) {
  EXPECT_THAT(refusal("\"capacity_ampere_hour\"", "\"capacity\""),
              StartsWith("my.json: 'capacity': lacks its unit, or has another: expected 'capacity_ampere_hour' or "));
  EXPECT_THAT(refusal("\"series_ohm\"", "\"series_milliohm\""),
              HasSubstr("or has another: expected 'series_cells' or 'series_ohm'"));
  EXPECT_THAT(refusal("\"fast_second\"", "\"fast\""), HasSubstr("'fast': lacks its unit"));
  EXPECT_THAT(refusal("\"voltage_floor_volt\"", "\"voltage_floor_mv\""), HasSubstr("expected 'voltage_floor_volt'"));
}

TEST(BatteryType, needs_a_source_and_a_licence) {
  EXPECT_THAT(refusal("\"licence\"", "\"chemistry_note\""), HasSubstr("'chemistry_note'"));
  EXPECT_THAT(refusal("  \"licence\": \"MIT (the data); the fit is part of this project\",\n", ""),
              HasSubstr("'licence': is missing"));
  EXPECT_THAT(refusal("MIT (the data); the fit is part of this project", "  "), HasSubstr("must not be empty"));
}

TEST(BatteryType, with_a_decreasing_open_circuit_voltage_is_rejected_at_the_row) {
  EXPECT_EQ(refusal("3.307, 3.483", "3.507, 3.483"),
            "my.json: 'open_circuit_volt[2]': 3.483 is not above the 3.507 before it");
  EXPECT_THAT(refusal("3.307, 3.483", "3.483, 3.483"), HasSubstr("'open_circuit_volt[2]'"));
}

TEST(BatteryType, with_a_negative_resistance_is_rejected_at_the_row) {
  EXPECT_EQ(refusal("0.0019, 0.0018", "0.0019, -0.0018"),
            "my.json: 'series_ohm[1]': -0.0018 is out of range: expected more than 0");
  EXPECT_THAT(refusal("0.00194, 0.0,", "-0.00194, 0.0,"), HasSubstr("'fast_ohm[0]': -0.00194 is out of range"));
}

TEST(BatteryType, with_percent_for_a_fraction_is_rejected) {
  EXPECT_THAT(refusal("[0, 0.02, 0.05", "[0, 2, 5"), HasSubstr("'charge_fraction[1]': 2 is out of range"));
  EXPECT_THAT(refusal("[0, 0.02, 0.05", "[0, 2, 5"), HasSubstr("a fraction, not percent"));
  EXPECT_THAT(refusal("\"coulombic_efficiency_fraction\": 0.999", "\"coulombic_efficiency_fraction\": 99.9"),
              HasSubstr("99.9 is out of range"));
}

TEST(BatteryType, with_inconsistent_tables_is_rejected) {
  EXPECT_THAT(refusal("[0, 0.02, ", "[0, "), HasSubstr("has 14 rows, 'charge_fraction' 13"));
  EXPECT_THAT(refusal("[0, 0.02, ", "[0.01, 0.02, "), HasSubstr("must go from 0 to 1"));
  EXPECT_THAT(refusal("0.9, 0.95, 1]", "0.95, 0.9, 1]"), HasSubstr("'charge_fraction[12]'"));
  EXPECT_THAT(refusal("\"voltage_floor_volt\": 3.0", "\"voltage_floor_volt\": 4.3"), HasSubstr("must be below"));
}

TEST(BatteryType, with_invalid_fields_is_rejected) {
  EXPECT_THAT(refusal("cosiva-battery-type/1", "cosiva-battery-type/2"), HasSubstr("'format'"));
  EXPECT_THAT(refusal("\"name\": \"leaf33\"", "\"name\": 33"), HasSubstr("'name': expected a text"));
  EXPECT_THAT(refusal("30.5", "\"30.5\""), HasSubstr("'capacity_ampere_hour': expected a number"));
  EXPECT_THAT(refusal("30.5", "1e999"), HasSubstr("my.json"));
  EXPECT_THAT(refusal("\"name\"", "\"colour\": 1, \"name\""), HasSubstr("'colour': is no key of a battery type"));
  EXPECT_THAT(refusal("\"name\"", "\"name\": \"a\", \"name\""), HasSubstr("twice"));
  EXPECT_FALSE(read_type("[]", "x"));
  EXPECT_FALSE(read_type("", "x"));
}

}  // namespace
}  // namespace cosiva::battery
