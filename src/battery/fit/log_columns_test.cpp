#include "cosiva/battery/fit/log_columns.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "cosiva/battery/fit/log.h"

namespace cosiva::battery {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// A discharge of 1 A every 10 s from full on, each row as `row` writes its time, voltage and current.
template <class Row>
std::string table(const std::string& header, const Row& row) {
  std::string text = header + "\n";
  for (int t = 0; t <= 3000; t += 10) {
    const bool load = t > 100 && t <= 2500;
    const double volt = 4.2 - (load ? 0.1 : 0.0) - 0.0003 * std::max(0, std::min(t, 2500) - 100);
    text += row(t, volt, load ? -1.0 : 0.0) + "\n";
  }
  return text;
}
std::string plain_row(int t, double volt, double ampere) {
  return std::to_string(t) + "," + std::to_string(volt) + "," + std::to_string(ampere);
}
std::string refusal(const std::string& text) {
  const auto logs = read_logs(text, "my.csv");
  return logs ? "read" : to_string(logs.error());
}

TEST(Columns, with_testers_own_names_are_read_in_their_units) {
  const std::string text = table("Data_Point,Test_Time(s),Step_Time(s),Current [mA],Ecell/mV,Aux_Temperature_1(C)",
                                 [](int t, double volt, double ampere) {
                                   return "1," + std::to_string(t) + ",0," + std::to_string(1000.0 * ampere) + "," +
                                          std::to_string(1000.0 * volt) + ",31.5";
                                 });
  const auto logs = read_logs(text, "my.csv");
  ASSERT_TRUE(logs) << to_string(logs.error());
  EXPECT_EQ(logs->front().time_s[50], 500.0);
  EXPECT_NEAR(logs->front().voltage_v[50], 3.98, 1e-6);
  EXPECT_NEAR(logs->front().current_a[50], 1.0, 1e-9);
  EXPECT_EQ(logs->front().temperature_c[50], 31.5);
  EXPECT_THAT(logs->front().diagnostics, ElementsAre(HasSubstr("'Test_Time(s)' as test_time_second, 'Ecell/mV' as")));
}

TEST(Columns, with_the_format_s_own_names_need_no_diagnostic_and_take_precedence) {
  const auto columns = read_columns(
      "Time(h),test_time_second,voltage_volt,Voltage(mV),current_ampere,ambient_temperature_celsius", "a:1");
  ASSERT_TRUE(columns);
  EXPECT_EQ(columns->columns[0].at, 1U);
  EXPECT_EQ(columns->columns[1].at, 2U);
  EXPECT_EQ(columns->diagnostic, "");
  EXPECT_EQ(columns->temperature->at, 5U);
}

TEST(Columns, in_hours_or_kelvin_become_seconds_and_degrees) {
  const auto columns = read_columns("Time [h],Voltage [V],Current [A],Temperature [K]", "a:1");
  ASSERT_TRUE(columns);
  EXPECT_EQ(columns->columns[0].scale, 3600.0);
  EXPECT_EQ(columns->temperature->offset, -273.15);
}

TEST(Columns, without_a_unit_are_rejected_also_under_testers_names) {
  const auto columns = read_columns("Time,Voltage(V),Current(A)", "my.csv:1");
  ASSERT_FALSE(columns);
  EXPECT_EQ(to_string(columns.error()),
            "my.csv:1: column 'Time' lacks its unit or has another: expected 'test_time_second'");
}

TEST(Columns, may_be_named_below_a_tester_s_preamble) {
  const std::string text =
      table("cell model: X\nNominal capacity, 1.0 Ah\n\ntest_time_second,voltage_volt,current_ampere", plain_row);
  const auto logs = read_logs(text, "my.csv");
  ASSERT_TRUE(logs) << to_string(logs.error());
  EXPECT_EQ(logs->front().line.front(), 5U);
}

TEST(Columns, may_be_separated_by_semicolons_or_tabs_with_decimal_commas) {
  for (const char between : {';', '\t'}) {
    const auto row = [&](int t, double volt, double ampere) {
      std::string text = plain_row(t, volt, ampere);
      std::ranges::replace(text, ',', between);
      std::ranges::replace(text, '.', ',');
      return text;
    };
    const std::string header = std::string("Test Time / s") + between + "Voltage / V" + between + "Current / A";
    const auto logs = read_logs(table(header, row), "my.csv");
    ASSERT_TRUE(logs) << to_string(logs.error());
    EXPECT_NEAR(logs->front().voltage_v[50], 3.98, 1e-6);
  }
}

TEST(Columns, of_numbers_alone_are_distinguished_from_a_missing_column) {
  EXPECT_THAT(
      refusal("No,1.0,1,4.1,-91.8,REST\nNo,2.0,1,4.0,-91.8,REST\n"),
      HasSubstr("my.csv:1: column 'test_time_second' is missing: this line holds numbers, not names. Add a line"));
}

TEST(Columns, are_not_all_listed_if_there_are_many) {
  std::string header = "c0";
  for (int i = 1; i < 50; ++i) header += ",c" + std::to_string(i);
  EXPECT_THAT(refusal(header + "\n"), HasSubstr("c11 and 38 more"));
}

TEST(Fields, that_are_no_numbers_are_rejected_with_a_hint) {
  const auto with = [](const std::string& field) {
    return table("test_time_second,voltage_volt,current_ampere", [&](int t, double volt, double ampere) {
      const std::string usual = plain_row(t, volt, ampere);
      return t == 1000 ? field + usual.substr(usual.find(',')) : usual;
    });
  };
  EXPECT_THAT(refusal(with("0:16:40")),
              HasSubstr("my.csv:102: test_time_second is '0:16:40', not a number: seconds are"));
  EXPECT_THAT(refusal(with("\"1,000\"")), HasSubstr("is '1,000', not a number: write it without separators"));
  EXPECT_THAT(refusal(with("")), HasSubstr("my.csv:102: test_time_second is '', not a number"));
}

TEST(Fields, in_quotes_keep_their_commas_and_empty_ones_beyond_the_header_are_ignored) {
  EXPECT_THAT(cut_fields("1, \"rest, long\" ,3", ','), ElementsAre("1", "rest, long", "3"));
  const std::string text = table("test_time_second,voltage_volt,current_ampere",
                                 [](int t, double v, double a) { return plain_row(t, v, a) + ", ,"; });
  EXPECT_EQ(refusal(text), "read");
}

}  // namespace
}  // namespace cosiva::battery
