#include "cosiva/battery/fit/log.h"
#include "cosiva/battery/fit/discharge.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>

namespace cosiva::battery {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

/// A discharge of 1 A every 10 s, rested before and after; `line` may change or drop one.
std::string log_text(const std::function<std::string(int second, std::string line)>& line = {},
                     const std::string& header = "test_time_second,voltage_volt,current_ampere") {
  std::string text = header + "\n";
  for (int t = 0; t <= 3000; t += 10) {
    const bool load = t > 100 && t <= 2500;
    const double volt = 4.2 - (load ? 0.1 : 0.0) - 0.0003 * std::max(0, std::min(t, 2500) - 100);
    const std::string usual = std::to_string(t) + "," + std::to_string(volt) + "," + (load ? "-1.0" : "0.0");
    const std::string published = line ? line(t, usual) : usual;
    if (!published.empty()) text += published + "\n";
  }
  return text;
}

std::string code_of(const std::string& text) {
  const auto logs = read_logs(text, "my.csv");
  return logs ? "read" : logs.error().code;
}
std::string refusal(const std::string& text) {
  const auto logs = read_logs(text, "my.csv");
  return logs ? "read" : to_string(logs.error());
}

TEST(Log, is_read_with_positive_discharge) {
  const auto logs = read_logs(log_text(), "my.csv");
  ASSERT_TRUE(logs) << to_string(logs.error());
  ASSERT_EQ(logs->size(), 1U);
  const Log& log = logs->front();
  EXPECT_EQ(log.name, "my.csv");
  EXPECT_EQ(log.time_s.size(), 301U);
  EXPECT_EQ(log.current_a[50], 1.0);
  EXPECT_EQ(log.current_a[0], 0.0);
}

TEST(Log, may_have_the_format_s_other_names_and_a_bom) {
  EXPECT_EQ(code_of(log_text({}, "\xEF\xBB\xBFTest Time / s,Voltage / V,Current / A")), "read");
}

TEST(Log, of_several_series_is_several_logs) {
  const auto with = [](const std::string& series) {
    return log_text([&](int, const std::string& line) { return line + "," + series; },
                    "test_time_second,voltage_volt,current_ampere,cell_id");
  };
  const std::string second = with("B2");
  const auto logs = read_logs(with("B1") + second.substr(second.find('\n') + 1), "my.csv");
  ASSERT_TRUE(logs) << to_string(logs.error());
  ASSERT_EQ(logs->size(), 2U);
  EXPECT_EQ(logs->back().name, "my.csv, cell_id=B2");
}

TEST(Log, may_have_any_other_columns) {
  const auto logs = read_logs(
      log_text(
          [](int t, const std::string& line) {
            return line + "," + std::to_string(0.001 * t) + ",step " + std::to_string(t / 500) + ",2026-01-01";
          },
          "test_time_second,voltage_volt,current_ampere,discharging_capacity_ah,step_type,date"),
      "my.csv");
  ASSERT_TRUE(logs) << to_string(logs.error());
  EXPECT_EQ(logs->size(), 1U);
}

TEST(Log, is_one_series_if_other_columns_count_samples_or_steps) {
  for (const char* column : {"record_number", "data_id", "step_name", "cycle_number", "c_rate", "step_index"}) {
    const auto logs =
        read_logs(log_text([](int t, const std::string& line) { return line + "," + std::to_string(t / 10); },
                           std::string("test_time_second,voltage_volt,current_ampere,") + column),
                  "my.csv");
    ASSERT_TRUE(logs) << column << ": " << to_string(logs.error());
    ASSERT_EQ(logs->size(), 1U) << column;
    EXPECT_EQ(logs->front().name, "my.csv") << column;
  }
}

TEST(Log, begins_another_series_if_the_time_restarts_and_a_counter_has_changed) {
  const auto with = [](const std::string& number) {
    return log_text([&](int, const std::string& line) { return line + "," + number; },
                    "test_time_second,voltage_volt,current_ampere,discharge_number");
  };
  const std::string second = with("2");
  const std::string rows = second.substr(second.find('\n') + 1);
  const auto logs = read_logs(with("1") + rows, "my.csv");
  ASSERT_TRUE(logs) << to_string(logs.error());
  ASSERT_EQ(logs->size(), 2U);
  EXPECT_EQ(logs->back().name, "my.csv, discharge_number=2");
  EXPECT_EQ(code_of(second + rows), "log.time");  // nothing indicates another series
}

TEST(Log, of_batteries_with_mixed_rows_is_one_log_for_each) {
  const auto logs = read_logs(log_text([](int, const std::string& line) { return line + ",B1\n" + line + ",B2"; },
                                       "test_time_second,voltage_volt,current_ampere,cell_id"),
                              "my.csv");
  ASSERT_TRUE(logs) << to_string(logs.error());
  ASSERT_EQ(logs->size(), 2U);
  EXPECT_EQ(logs->front().time_s.size(), 301U);
  EXPECT_EQ(logs->front().line[1], 4U);
}

TEST(Log, of_implausibly_many_batteries_is_rejected) {
  std::string text = "test_time_second,voltage_volt,current_ampere,cell_id\n";
  for (int i = 0; i < 1001; ++i) text += "1,4,-1,B" + std::to_string(i) + "\n";
  EXPECT_EQ(refusal(text), "my.csv:1002: columns that name a battery contain more than 1000 names");
}

TEST(Log, with_hours_in_a_column_of_seconds_is_rejected) {
  const auto hours = [](int t, const std::string& line) {
    return t <= 100
               ? std::string{}
               : std::to_string(t / 3600.0) + "," + std::to_string(4.2 - 0.0005 * t) + line.substr(line.rfind(','));
  };
  EXPECT_EQ(code_of(log_text(hours)), "log.unit");
  EXPECT_THAT(refusal(log_text(hours)), HasSubstr("it holds hours or minutes, not seconds"));
}

TEST(Log, without_a_sign_or_with_a_spike_is_rejected_at_its_line) {
  // Charged and discharged by turns, with the magnitude of the current only.
  const auto sizes = log_text([](int t, const std::string&) {
    const int turn = t / 100 % 4;  // rest, discharge, rest, charge
    const double volt = 3.8 + (turn == 1 ? -0.1 : turn == 3 ? 0.1 : 0.0);
    return std::to_string(t) + "," + std::to_string(volt) + (turn % 2 == 0 ? ",0" : ",1");
  });
  EXPECT_EQ(code_of(sizes), "log.sign");
  EXPECT_THAT(refusal(sizes), HasSubstr("it has no sign"));
  const auto spike =
      log_text([](int t, const std::string& line) { return t == 1000 ? std::string("1000,9.0,-1.0") : line; });
  EXPECT_THAT(refusal(spike), StartsWith("my.csv:102: voltage_volt jumps from"));
}

TEST(Log, s_temperatures_may_be_missing_occasionally_but_must_not_be_kelvin) {
  const auto warm = [](const char* even) {
    return log_text([=](int t, const std::string& line) { return line + "," + (t % 20 == 0 ? even : ""); },
                    "test_time_second,voltage_volt,current_ampere,temperature_t1_celsius");
  };
  const auto logs = read_logs(warm("31.5"), "my.csv");
  ASSERT_TRUE(logs) << to_string(logs.error());
  EXPECT_EQ(logs->front().temperature_c[7], 31.5);
  EXPECT_THAT(refusal(warm("298")), HasSubstr("my.csv:2: the temperature is 298 °C at 0 s; kelvin?"));
}

TEST(Log, with_a_gap_under_load_is_rejected_with_its_time) {
  const auto without = [](int from, int to) {
    return log_text([=](int t, const std::string& line) { return t > from && t < to ? std::string{} : line; });
  };
  EXPECT_THAT(refusal(without(1000, 1400)), HasSubstr("nothing between 1000 s and 1400 s, under up to 1 A"));
  EXPECT_THAT(refusal(without(1000, 1400)), StartsWith("my.csv:103:"));
  EXPECT_EQ(code_of(without(1000, 1400)), "log.gap");
  EXPECT_EQ(code_of(without(2600, 2900)), "read");  // at rest no charge flows
  // From a rest into a load that may have started long ago: these rests are logged every 10 s.
  const auto late = log_text([](int t, const std::string& line) {
    const bool again = t > 1000 && t <= 1500;  // a rest within the discharge, whose end and the following load are not
                                               // sampled
    const std::string usual = again ? line.substr(0, line.rfind(',')) + ",0.0" : line;
    return t > 1400 && t < 2100 ? std::string{} : usual;
  });
  EXPECT_EQ(code_of(late), "log.gap");
  EXPECT_EQ(code_of(without(2000, 3001)), "read");  // the log ends earlier
}

TEST(Log, with_the_wrong_sign_is_rejected) {
  const auto turned = [](int, std::string line) {
    const std::size_t minus = line.find('-');
    if (minus != std::string::npos) line.erase(minus, 1);
    return line;
  };
  EXPECT_EQ(code_of(log_text(turned)), "log.sign");
  EXPECT_THAT(refusal(log_text(turned)), HasSubstr("it has the other sign"));
  // Also without a step: under load from the first sample to the last.
  const auto steady = [](const char* sign) {
    return log_text([=](int t, const std::string& line) {
      return t <= 100 || t > 2500 ? std::string{} : line.substr(0, line.rfind(',')) + "," + sign + "1.0";
    });
  };
  EXPECT_EQ(code_of(steady("")), "log.sign");
  EXPECT_EQ(code_of(steady("-")), "read");
}

TEST(Log, with_fractions_in_a_percent_column_is_rejected_and_the_reverse) {
  const auto charge = [](const char* name, double scale) {
    return log_text(
        [=](int t, const std::string& line) { return line + "," + std::to_string(scale * (1.0 - t / 3100.0)); },
        std::string("test_time_second,voltage_volt,current_ampere,") + name);
  };
  EXPECT_EQ(code_of(charge("state_of_charge_percent", 1.0)), "log.percent");
  EXPECT_THAT(refusal(charge("state_of_charge_percent", 1.0)), HasSubstr("fractions, not percent"));
  EXPECT_EQ(code_of(charge("state_of_charge_percent", 100.0)), "read");
  EXPECT_EQ(code_of(charge("state_of_charge_fraction", 100.0)), "log.percent");
  EXPECT_EQ(code_of(charge("state_of_charge_fraction", 1.0)), "read");
}

TEST(Log, without_a_column_or_its_unit_is_rejected) {
  EXPECT_EQ(refusal(log_text({}, "test_time_second,voltage_volt,current_milliampere")),
            "my.csv:1: column 'current_milliampere' lacks its unit or has another: expected 'current_ampere'");
  EXPECT_THAT(refusal(log_text({}, "test_time,voltage_volt,current_ampere")), HasSubstr("'test_time' lacks its unit"));
  EXPECT_THAT(refusal(log_text({}, "test_time_second,power_watt,current_ampere")),
              HasSubstr("'voltage_volt' is missing; there are test_time_second, power_watt"));
}

TEST(Log, with_an_invalid_line_is_rejected_there) {
  const auto at_1000 = [](const std::string& instead) {
    return log_text([=](int t, const std::string& line) { return t == 1000 ? instead : line; });
  };
  EXPECT_THAT(refusal(at_1000("1000,abc,-1")), StartsWith("my.csv:102: voltage_volt is 'abc'"));
  EXPECT_THAT(refusal(at_1000("1000,4.0")), StartsWith("my.csv:102: has 2 fields, the header 3"));
  EXPECT_EQ(code_of(at_1000("1000,nan,-1")), "log.number");
  EXPECT_EQ(code_of(at_1000("1000,-4.0,-1")), "log.number");
  EXPECT_EQ(refusal(at_1000("900,4.0,-1")), "my.csv:102: the time goes back from 990 s to 900 s");
  EXPECT_EQ(code_of(""), "log.column");
  EXPECT_EQ(code_of("test_time_second,voltage_volt,current_ampere\n"), "log.short");
  EXPECT_EQ(code_of("test_time_second,voltage_volt,current_ampere\n1,4,-1\n"), "log.short");
}

/// Rows of steps of 500 s, with the time within each step or since the test's start as given by `time`.
std::string stepped(const std::function<std::string(int second, int step)>& time, bool with_step = true) {
  return log_text(
      [&](int t, const std::string& line) {
        const int step = t / 500;
        return time(t, step) + line.substr(line.find(',')) + (with_step ? "," + std::to_string(step) : "");
      },
      with_step ? "test_time_second,voltage_volt,current_ampere,step_index"
                : "test_time_second,voltage_volt,current_ampere");
}

TEST(Log, whose_time_restarts_with_each_step_is_joined) {
  const auto within = [](int t, int step) { return std::to_string(t - 500 * step); };
  const auto logs = read_logs(stepped(within), "my.csv");
  ASSERT_TRUE(logs) << to_string(logs.error());
  ASSERT_EQ(logs->size(), 1U);
  // The first sample of a step is at its start: the ten seconds before it are not in the file.
  EXPECT_NEAR(logs->front().time_s.back(), 3000.0 - 6 * 10.0, 1e-9);
  EXPECT_THAT(logs->front().diagnostics, ::testing::ElementsAre(HasSubstr("restarts with each step")));
  EXPECT_EQ(code_of(stepped(within, false)), "log.time");  // nothing indicates that steps are the reason
}

TEST(Log, with_time_zero_at_a_step_s_first_sample_is_read) {
  const auto zero = [](int t, int step) { return std::to_string(t == 500 * step ? 0 : t); };
  const auto logs = read_logs(stepped(zero), "my.csv");
  ASSERT_TRUE(logs) << to_string(logs.error());
  ASSERT_EQ(logs->size(), 1U);
  EXPECT_EQ(logs->front().time_s[50], 490.0);
  EXPECT_EQ(logs->front().time_s[51], 510.0);
  EXPECT_THAT(logs->front().diagnostics,
              ::testing::ElementsAre(HasSubstr("5 steps begin with a sample whose time goes")));
}

TEST(Log, of_an_infrequently_sampled_charge_has_no_gap) {
  const auto charge = [](bool falls) {
    std::string text = "test_time_second,voltage_volt,current_ampere\n";
    for (int t = 0; t <= 3000; t += t < 2000 ? 10 : 500) {
      const double volt = 3.0 + 0.0004 * t - (falls && t > 2000 ? 0.5 : 0.0);
      text += std::to_string(t) + "," + std::to_string(volt) + ",1\n";
    }
    return text;
  };
  EXPECT_EQ(code_of(charge(false)), "read");
  EXPECT_EQ(code_of(charge(true)), "log.gap");  // another event happened in between
}

TEST(Log, of_a_pulse_test_may_have_a_hundredfold_sampling_rate_in_its_pulses) {
  std::string text = "test_time_second,voltage_volt,current_ampere\n";
  double t = 0.0;
  double volt = 4.2;
  const auto add = [&](double step_s, int count, double ampere) {
    for (int i = 0; i < count; ++i) {
      t += step_s;
      volt -= 1e-4 * ampere * step_s;
      text += std::to_string(t) + "," + std::to_string(volt - 0.05 * ampere) + "," + std::to_string(-ampere) + "\n";
    }
  };
  for (int i = 0; i < 8; ++i) {
    add(60.0, 5, 0.0);
    add(0.1, 300, 2.0);
    add(120.0, 5, 0.5);
  }
  EXPECT_EQ(code_of(text), "read");
}

TEST(Log, of_a_constant_voltage_phase_has_the_right_sign) {
  const auto held = log_text([](int t, const std::string& line) {
    if (t <= 2400 || t > 2500) return t > 2500 ? std::string{} : line;
    // The current decreases, and the voltage drifts in the other direction by the regulation error of the tester.
    return std::to_string(t) + "," + std::to_string(3.41 - 0.00001 * (t - 2400)) + "," +
           std::to_string(-1.0 + 0.009 * (t - 2400));
  });
  EXPECT_EQ(code_of(held), "read");
}

TEST(Log, of_many_years_is_rejected) {
  const auto text = log_text(
      [](int t, const std::string& line) { return std::to_string(t) + "00000" + line.substr(line.find(',')); });
  EXPECT_EQ(code_of(text), "log.unit");
  EXPECT_THAT(refusal(text), HasSubstr("7.61035 years by test_time_second: it holds milliseconds"));
}

TEST(Log, with_a_charge_count_in_another_unit_is_rejected) {
  const auto counted = [](double factor) {
    return log_text(
        [=](int t, const std::string& line) {
          return line + "," + std::to_string(factor * std::max(0, std::min(t, 2500) - 100) / 3600.0) + ",0";
        },
        "test_time_second,voltage_volt,current_ampere,discharging_capacity_ah,charging_capacity_ah");
  };
  EXPECT_EQ(code_of(counted(1.0)), "read");
  EXPECT_EQ(code_of(counted(0.001)), "log.unit");
  EXPECT_THAT(refusal(counted(1000.0)), HasSubstr("current times time is 0.666667 Ah, the tester's own column"));
}

TEST(Discharge, begins_full_counts_its_charge_and_interpolates_between_samples) {
  const auto logs = read_logs(log_text(), "my.csv");
  const auto all = discharges_from_full(logs->front(), 4.2);
  ASSERT_EQ(all.size(), 1U);
  EXPECT_EQ(load_on_s(all[0]), 100.0);
  EXPECT_NEAR(all[0].used_ah.back(), 2400.0 / 3600.0, 1e-9);
  // 4.1 − 0.0003 (t − 100) = 3.8005 at 1098.33 s.
  EXPECT_NEAR(seconds_to_voltage(all[0], 3.8005), 998.33, 0.01);
  EXPECT_TRUE(std::isnan(seconds_to_voltage(all[0], 2.0)));
  EXPECT_TRUE(discharges_from_full(logs->front(), 5.0).empty());
}

TEST(Discharge, after_an_infrequently_sampled_rest_begins_with_its_load) {
  // The rest's last sample is 60 s back, those of the load are 10 s apart.
  const auto logs = read_logs(
      log_text([](int t, const std::string& line) { return t > 50 && t <= 100 ? std::string{} : line; }), "my.csv");
  ASSERT_TRUE(logs);
  const auto all = discharges_from_full(logs->front(), 4.2);
  ASSERT_EQ(all.size(), 1U);
  EXPECT_EQ(load_on_s(all[0]), 100.0);
  EXPECT_NEAR(all[0].used_ah.back(), 2400.0 / 3600.0, 1e-9);
}

}  // namespace
}  // namespace cosiva::battery
