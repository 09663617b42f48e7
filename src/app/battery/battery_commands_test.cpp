#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <string>

#include "cosiva/adapters/files.h"
#include "cosiva/adapters/test_fixture.h"
#include "cosiva/app/command_line_fixture.h"
#include "cosiva/base/json_value.h"
#include "cosiva/base/test_paths.h"
#include "cosiva/battery/type.h"
#include "cosiva/battery/type_json.h"

namespace cosiva::app {
namespace {

using adapters::testing::Scratch;
using fixture::CommandOutput;
using fixture::cosiva;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

std::string data(const std::string& name) { return source_dir() + "/src/battery/testdata/" + name; }

TEST(BatterySampled, gives_the_autonomy_and_its_drift) {
  const CommandOutput output = cosiva({"battery", "sampled", "--repeat", "3", "--measure", "20", "--json"});
  EXPECT_EQ(output.status, 0) << output.standard_error;
  const auto json = JsonValue::parse(output.data);
  ASSERT_TRUE(json);
  // 80 % of 2.2 Ah at about 7.7 V are 48 kJ, and a vehicle takes 3.3 W.
  EXPECT_NEAR(*json->find("autonomy_s")->number("mean"), 14500.0, 1000.0);
  ASSERT_EQ(json->find("batteries")->array()->size(), 1U);
  EXPECT_EQ(json->find("records")->array()->size(), 3U);
  EXPECT_NE(json->find("slope_per_run")->number("p"), std::nullopt);
  EXPECT_THAT(output.standard_error, HasSubstr("run 3: put battery 1, full, into AIV1"));
}

TEST(BatteryFleet, writes_report_result_and_curves_and_repeats_them_exactly) {
  const Scratch scratch;
  const std::string out = scratch / "report";
  const auto run = [&](const std::string& to) {
    return cosiva({"battery", "fleet", "--aivs", "3", "--measure", "20", "--scale", "0.5", "--series", "2", "--json",
                   "--out", to});
  };
  const CommandOutput output = run(out);
  ASSERT_EQ(output.status, 0) << output.standard_error;
  const auto json = JsonValue::parse(output.data);
  ASSERT_TRUE(json);
  const JsonValue* autonomy = json->find("autonomy_s");
  EXPECT_GT(*autonomy->number("mean"), 1000.0);
  EXPECT_GT(*autonomy->number("sd"), 0.0);
  EXPECT_EQ(autonomy->find("ci95")->array()->size(), 2U);
  EXPECT_EQ(json->find("batteries")->array()->size(), 3U);
  const std::string html = *adapters::read_file(out + "/report.html");
  EXPECT_THAT(html, HasSubstr("Statement"));
  EXPECT_THAT(html, HasSubstr("Kaplan and Meier"));
  EXPECT_THAT(html, HasSubstr("cosiva battery fleet --zone oval"));
  EXPECT_EQ(*adapters::read_file(out + "/result.json"), output.data.substr(0, output.data.find('\n')));
  EXPECT_THAT(*adapters::read_file(out + "/curves.csv"), StartsWith("battery_id,run,vehicle,test_time_second"));
  EXPECT_EQ(run(scratch / "again").data, output.data);
  // The curves have the format of other logs: a pack's type can be fitted to them.
  const CommandOutput fit = cosiva({"battery", "fit", out + "/curves.csv", "--json"});
  EXPECT_EQ(fit.status, 0) << fit.standard_error;
  EXPECT_LT(*JsonValue::parse(fit.data)->number("rms_v"), 0.05);
}

TEST(BatteryFleet, can_run_with_the_whole_platform_in_the_loop) {
  const CommandOutput output = cosiva(
      {"battery", "fleet", "--aivs", "2", "--whole", "--scale", "0.3", "--series", "2", "--floor", "80", "--json"});
  ASSERT_EQ(output.status, 0) << output.standard_error;
  EXPECT_THAT(output.data, HasSubstr("\"stop\":\"floor\""));
  EXPECT_EQ(cosiva({"battery", "fleet", "--aivs", "2", "--whole", "--state", "x"}).status, 2);
}

TEST(BatteryFleet, reports_the_rate_of_the_whole_platform_in_the_loop) {
  const std::vector<std::string> command{"battery", "fleet",    "--aivs", "2",       "--whole", "--scale",
                                         "0.3",     "--series", "2",      "--floor", "90",      "--json"};
  const auto with = [&](std::vector<std::string> more) {
    std::vector<std::string> all = command;
    all.insert(all.end(), more.begin(), more.end());
    return cosiva(all);
  };
  const CommandOutput usual = with({});
  EXPECT_EQ(usual.status, 0) << usual.standard_error;
  EXPECT_EQ(with({"--hz", "50"}).data, usual.data);
  const CommandOutput slower = with({"--hz", "10"});
  EXPECT_EQ(slower.status, 0) << slower.standard_error;
  EXPECT_NE(slower.data, usual.data);
  EXPECT_EQ(with({"--hz", "9"}).status, 2);
  EXPECT_EQ(with({"--hz", "51"}).status, 2);
  const CommandOutput nothing_to_pace = cosiva({"battery", "fleet", "--aivs", "2", "--hz", "10"});
  EXPECT_EQ(nothing_to_pace.status, 2);
  EXPECT_THAT(nothing_to_pace.standard_error, HasSubstr("--whole"));
}

TEST(BatteryFleet, continues_from_its_state_and_refuses_the_state_of_another_test) {
  const Scratch scratch;
  const std::string state = scratch / "state";
  const std::vector<std::string> command{"battery", "fleet", "--aivs", "2",       "--measure", "20",
                                         "--scale", "0.5",   "--json", "--state", state};
  const CommandOutput first = cosiva(command);
  ASSERT_EQ(first.status, 0) << first.standard_error;
  const CommandOutput again = cosiva(command);  // the test is finished: no run is repeated
  EXPECT_EQ(again.data, first.data);
  EXPECT_THAT(again.standard_error, HasSubstr("continues from"));
  std::vector<std::string> other = command;
  other.insert(other.end(), {"--seed", "9"});
  EXPECT_EQ(cosiva(other).status, 2);
  EXPECT_THAT(cosiva(other).standard_error, HasSubstr("of another test"));
}

TEST(BatteryTest, refuses_invalid_options) {
  EXPECT_THAT(cosiva({"battery", "fleet", "--floor", "0.2"}).standard_error,
              HasSubstr("seems to be a fraction; give percent, such as 20.0"));
  EXPECT_EQ(cosiva({"battery", "fleet", "--floor", "0.2"}).status, 2);
  EXPECT_EQ(cosiva({"battery", "fleet", "--floor", "120"}).status, 2);
  EXPECT_EQ(cosiva({"battery", "fleet", "--floor", "99"}).status, 2);
  EXPECT_THAT(cosiva({"battery", "sampled", "--type", "leaf3"}).standard_error, HasSubstr("did you mean 'leaf33'?"));
  EXPECT_EQ(cosiva({"battery", "sampled", "--type", "gone.json"}).status, 2);
  EXPECT_EQ(cosiva({"battery", "sampled", "--gauge", "magic"}).status, 2);
  EXPECT_EQ(cosiva({"battery", "sampled", "--zone", "nowhere"}).status, 2);
  EXPECT_THAT(cosiva({"battery", "sampled", "--ambient", "-10"}).standard_error,
              HasSubstr("would refuse every battery"));
  EXPECT_EQ(cosiva({"battery", "fleet", "--aivs", "1"}).status, 2);
  EXPECT_EQ(cosiva({"battery"}).status, 2);
}

TEST(BatteryFleet, ends_after_the_run_that_reached_the_requested_certainty_of_the_mean) {
  const auto fleet = [](const char* half_width) {
    return cosiva({"battery", "fleet", "--aivs", "5", "--repeat", "3", "--measure", "20", "--scale", "0.3",
                   "--half-width", half_width});
  };
  const CommandOutput loose = fleet("20");
  ASSERT_EQ(loose.status, 0) << loose.standard_error;
  EXPECT_THAT(loose.standard_error,
              HasSubstr("the test ends after run 1 of 3: the mean is known as well as was wanted"));
  EXPECT_THAT(loose.data, HasSubstr("after 5 batteries: no more are needed, nor more runs than the 1 of 3 that were"));
  const CommandOutput strict = fleet("0.01");
  ASSERT_EQ(strict.status, 0) << strict.standard_error;
  EXPECT_THAT(strict.data, HasSubstr("5 batteries, 15 runs"));
  EXPECT_THAT(strict.data, HasSubstr("the mean is not known to 0.01 % yet"));
}

TEST(BatteryFit, reports_residuals_and_predicts_logs_that_were_not_fitted) {
  const CommandOutput output = cosiva({"battery", "fit", data("leaf_hppc_25C.csv"), "--predict",
                                       data("leaf_1C_first.csv"), "--predict", data("leaf_2C_first.csv"), "--json"});
  ASSERT_EQ(output.status, 0) << output.standard_error;
  const auto json = JsonValue::parse(output.data);
  ASSERT_TRUE(json);
  EXPECT_LT(*json->number("rms_v"), 0.003);
  ASSERT_EQ(json->find("predictions")->array()->size(), 2U);
  for (const JsonValue& one : *json->find("predictions")->array())
    EXPECT_NEAR(*one.number("predicted_s") / *one.number("measured_s"), 1.0, 0.005);
  const CommandOutput series = cosiva({"battery", "fit", data("lipo_pouch_rates_25C.csv"), "--predict", "rate=2C"});
  EXPECT_THAT(series.data, HasSubstr("foretold:\n"));
  EXPECT_THAT(series.data, HasSubstr("note: assumed"));
}

TEST(BatteryFit, excludes_one_discharge_of_a_file_with_several) {
  const Scratch scratch;
  // Two rates in one file, as a tester writes them: charged in between, with the tester's column names, in
  // milliamperes.
  std::string text = "Test_Time(s),Voltage(V),Current(mA)\n";
  double at_s = 0.0;
  double used_ah = 0.0;
  const auto go = [&](double ampere, double until_ah) {
    while ((until_ah - used_ah) * ampere > 0.0) {
      at_s += 10.0;
      used_ah += ampere * 10.0 / 3600.0;
      text += std::to_string(at_s) + "," + std::to_string(4.2 - used_ah - 0.05 * std::max(0.0, ampere)) + "," +
              std::to_string(-1000.0 * ampere) + "\n";
    }
  };
  go(0.2, 0.95);
  go(-0.5, 0.0);
  go(1.0, 0.95);
  go(-0.5, 0.0);
  go(0.5, 0.95);
  const std::string file = scratch / "all.csv";
  ASSERT_TRUE(adapters::write_file(file, text));
  const CommandOutput output = cosiva({"battery", "fit", file, "--predict", "discharge 2", "--json"});
  ASSERT_EQ(output.status, 0) << output.standard_error;
  const auto json = JsonValue::parse(output.data);
  ASSERT_TRUE(json);
  EXPECT_EQ(json->find("residuals")->array()->size(), 2U);
  ASSERT_EQ(json->find("predictions")->array()->size(), 1U);
  const JsonValue& foretold = json->find("predictions")->array()->front();
  EXPECT_THAT(*foretold.text("log"), HasSubstr("all.csv, discharge 2"));
  EXPECT_NEAR(*foretold.number("predicted_s") / *foretold.number("measured_s"), 1.0, 0.02);
  EXPECT_TRUE(json->number("charge_uncertain_percent"));
  const std::string standard_error = cosiva({"battery", "fit", file, "--predict", "discharge 2"}).data;
  EXPECT_THAT(standard_error, HasSubstr("'Current(mA)' as current_ampere"));
  EXPECT_THAT(standard_error, HasSubstr("predicted at 2.0 times the largest current"));
  EXPECT_EQ(cosiva({"battery", "fit", file, "--predict", "discharge 4"}).status, 2);
}

TEST(BatteryFit, writes_a_usable_type) {
  const Scratch scratch;
  const std::string file = scratch / "mine.json";
  EXPECT_THAT(cosiva({"battery", "fit", data("leaf_hppc_25C.csv"), "--out", file}).standard_error,
              HasSubstr("--licence"));
  EXPECT_FALSE(std::filesystem::exists(file));
  ASSERT_EQ(
      cosiva({"battery", "fit", data("leaf_hppc_25C.csv"), "--out", file, "--licence", "MIT", "--name", "mine"}).status,
      0);
  const auto type = battery::read_type(*adapters::read_file(file), file);
  ASSERT_TRUE(type) << to_string(type.error());
  EXPECT_EQ(type->licence, "MIT");
  EXPECT_THAT(type->source, HasSubstr("leaf_hppc_25C.csv"));
  EXPECT_THAT(cosiva({"battery", "check", file, "leaf33"}).data, HasSubstr("good: mine, 30.5"));
}

TEST(BatteryFit, refuses_misleading_logs) {
  const Scratch scratch;
  const auto refused = [&](const std::string& text) {
    const std::string file = scratch / "log.csv";
    EXPECT_TRUE(adapters::write_file(file, text));
    const CommandOutput output = cosiva({"battery", "fit", file});
    EXPECT_EQ(output.status, 2);
    return output.standard_error;
  };
  EXPECT_THAT(refused("test_time_second,voltage,current_ampere\n"), HasSubstr("'voltage' lacks its unit"));
  std::string turned = *adapters::read_file(data("leaf_2C_first.csv"));
  for (std::size_t at = turned.find(",-"); at != std::string::npos; at = turned.find(",-")) turned.erase(at + 1, 1);
  EXPECT_THAT(refused(turned), HasSubstr("the other sign"));
  EXPECT_EQ(cosiva({"battery", "fit", data("lipo_pouch_rates_25C.csv"), "--predict", "rate=9C"}).status, 2);
  EXPECT_EQ(cosiva({"battery", "fit", data("lipo_pouch_rates_25C.csv"), "--only", "rate=9C"}).status, 2);
  EXPECT_EQ(cosiva({"battery", "fit", "gone.csv"}).status, 2);
}

// Chen and Rincón-Mora's closed form, and the Leaf's measured times (ORNL, doi 10.5281/zenodo.2580327), to 3.0 V.
TEST(BatteryDischarge, reports_the_published_and_the_measured_times) {
  const auto seconds = [](const std::vector<std::string>& load) {
    std::vector<std::string> command{"battery", "discharge", "--floor", "3.0", "--json"};
    command.insert(command.end(), load.begin(), load.end());
    const CommandOutput output = cosiva(command);
    EXPECT_EQ(output.status, 0) << output.standard_error;
    const auto json = JsonValue::parse(output.data);
    return json ? json->find("discharges")->array()->front().number("lasted_s").value_or(0.0) : 0.0;
  };
  EXPECT_NEAR(seconds({"lipo850", "--current", "0.85"}), 3498.0, 0.002 * 3498.0);
  EXPECT_NEAR(seconds({"lipo850", "--current", "0.17"}), 17708.0, 0.002 * 17708.0);
  EXPECT_NEAR(seconds({"lipo850", "--power", "2"}), 5564.0, 0.002 * 5564.0);
  EXPECT_NEAR(seconds({"leaf33", "--current", "30.6"}), 3568.8, 0.005 * 3568.8);
  EXPECT_NEAR(seconds({"leaf33", "--current", "61.2"}), 1762.3, 0.005 * 1762.3);
  // Two cells of half the size in parallel equal one.
  EXPECT_NEAR(seconds({"leaf33", "--current", "30.6", "--parallel", "2", "--scale", "0.5"}), 3560.0, 10.0);
  EXPECT_THAT(cosiva({"battery", "discharge", "leaf33"}).data, HasSubstr("Peukert's exponent between them 1.0"));
  EXPECT_THAT(cosiva({"battery", "discharge", "lipo850", "--power", "500"}).data, HasSubstr("ends by brown-out"));
  EXPECT_EQ(cosiva({"battery", "discharge", "leaf3"}).status, 2);
  EXPECT_EQ(cosiva({"battery", "discharge", "leaf33", "--current", "-1"}).status, 2);
}

TEST(BatteryDischarge, writes_logs_from_which_a_fit_recovers_the_battery) {
  const Scratch scratch;
  for (const char* rate : {"0.2", "1", "2"})
    ASSERT_EQ(
        cosiva({"battery", "discharge", "leaf33", "--rate", rate, "--csv", scratch / (std::string(rate) + ".csv")})
            .status,
        0);
  const CommandOutput fit =
      cosiva({"battery", "fit", scratch / "0.2.csv", scratch / "2.csv", "--predict", scratch / "1.csv", "--json"});
  ASSERT_EQ(fit.status, 0) << fit.standard_error;
  const auto json = JsonValue::parse(fit.data);
  const JsonValue& found = json->find("predictions")->array()->front();
  EXPECT_NEAR(*found.number("predicted_s"), *found.number("measured_s"), 0.005 * *found.number("measured_s"));
  EXPECT_EQ(cosiva({"battery", "discharge", "leaf33", "--csv", scratch / "all.csv"}).status, 2);  // of which load?
}

TEST(BatteryAnalyse, reproduces_the_published_metrics_of_third_party_measurements) {
  const std::string csv = data("lghg2_fleet_figures.csv");
  const CommandOutput both = cosiva({"battery", "analyse", csv});
  ASSERT_EQ(both.status, 0) << both.standard_error;
  EXPECT_THAT(both.data, HasSubstr("fleet_first_run: 9 batteries, 9 runs, 0 failed"));
  EXPECT_THAT(both.data, HasSubstr("(3605.5 s, equation (4)), 95 % interval 3567.3 to 3643.7 s"));
  EXPECT_THAT(both.data, HasSubstr("1 is an outlier (Grubbs), kept: 2.309 > 2.215, robust score -4.3"));
  EXPECT_THAT(both.data, HasSubstr("same_cell_repeat: 5 batteries, 20 runs"));
  EXPECT_THAT(both.data, HasSubstr("slope -10.2"));
  const CommandOutput failed = cosiva(
      {"battery", "analyse", csv, "--only", "fleet_first_run", "--failed", "6=2000", "--failed", "9=3000", "--json"});
  const auto json = JsonValue::parse(failed.data);
  ASSERT_TRUE(json);
  EXPECT_NEAR(*json->find("autonomy_s")->number("mean"), 3602.0, 1.0);
  EXPECT_EQ(json->number("failed"), 2.0);
  EXPECT_EQ(cosiva({"battery", "analyse", csv, "--only", "gone"}).status, 2);
  EXPECT_EQ(cosiva({"battery", "analyse", csv, "--failed", "6=2000"}).status, 2);  // of which series?
  EXPECT_EQ(cosiva({"battery", "analyse", csv, "--only", "fleet_first_run", "--failed", "six"}).status, 2);
  EXPECT_EQ(cosiva({"battery", "analyse", "gone.csv"}).status, 2);
}

TEST(BatteryAnalyse, combines_results_of_own_tests_and_writes_a_report) {
  const Scratch scratch;
  const auto fleet = [&](const char* seed) {
    const std::string file = scratch / (std::string(seed) + ".json");
    const CommandOutput output =
        cosiva({"battery", "fleet", "--aivs", "3", "--measure", "20", "--scale", "0.3", "--json", "--seed", seed});
    EXPECT_TRUE(adapters::write_file(file, output.data));
    return file;
  };
  const std::string out = scratch / "both";
  const CommandOutput output =
      cosiva({"battery", "analyse", fleet("1"), fleet("2"), "--half-width", "20", "--json", "--out", out});
  ASSERT_EQ(output.status, 0) << output.standard_error;
  const auto json = JsonValue::parse(output.data);
  ASSERT_TRUE(json);
  EXPECT_GE(*json->number("n"), 3.0);
  EXPECT_EQ(json->find("records")->array()->size(), 6U);
  EXPECT_THAT(*adapters::read_file(out + "/report.html"), HasSubstr("Statement"));
}

TEST(BatteryCheck, reports_what_is_wrong_and_where) {
  const Scratch scratch;
  std::string text = battery::to_json(*battery::shipped_type("leaf33"));
  text.replace(text.find("capacity_ampere_hour"), 20, "capacity");
  ASSERT_TRUE(adapters::write_file(scratch / "bad.json", text));
  const CommandOutput output = cosiva({"battery", "check", scratch / "bad.json"});
  EXPECT_EQ(output.status, 2);
  EXPECT_THAT(output.data, HasSubstr("bad.json: 'capacity': lacks its unit"));
}

TEST(BatteryPlan, reports_how_many_batteries_a_test_needs_and_the_swaps) {
  const CommandOutput output =
      cosiva({"battery", "plan", "--cv", "1.4", "--half-width", "1", "--aivs", "4", "--difference", "2"});
  EXPECT_EQ(output.status, 0);
  EXPECT_THAT(output.data, StartsWith("11 batteries for the mean to ± 1.00 %"));
  EXPECT_THAT(output.data, HasSubstr("run 4:"));
  EXPECT_THAT(output.data, HasSubstr("of each type to detect a difference of 2.00 %"));
  const auto json = JsonValue::parse(cosiva({"battery", "plan", "--cv", "0.3", "--json"}).data);
  EXPECT_EQ(json->number("batteries"), 3.0);
}

TEST(BatteryCompare, reports_which_battery_lasts_longer_and_how_certain_that_is) {
  const Scratch scratch;
  const auto result = [&](const std::string& name, double mean) {
    std::string text = R"({"batteries":[)";
    for (int i = 0; i < 6; ++i)
      text += std::string(i > 0 ? "," : "") + R"({"battery":)" + std::to_string(i + 1) +
              R"(,"ended":true,"autonomy_s":)" + std::to_string(mean + 10.0 * i) + "}";
    text += R"(,{"battery":9,"ended":false,"autonomy_s":1.0}]})";
    EXPECT_TRUE(adapters::write_file(scratch / name, text));
    return scratch / name;
  };
  const std::string a = result("a.json", 3600.0);
  const std::string b = result("b.json", 3650.0);
  const auto json = JsonValue::parse(cosiva({"battery", "compare", a, b, "--json"}).data);
  ASSERT_TRUE(json);
  EXPECT_NEAR(*json->number("difference_s"), 50.0, 1e-9);
  EXPECT_LT(*json->number("p"), 0.01);
  EXPECT_THAT(cosiva({"battery", "compare", a, b}).data, StartsWith("the second lasts 50.0 s longer"));
  EXPECT_EQ(cosiva({"battery", "compare", a, a}).status, 0);
  EXPECT_EQ(cosiva({"battery", "compare", a}).status, 2);
  ASSERT_TRUE(adapters::write_file(scratch / "c.json", "{}"));
  EXPECT_EQ(cosiva({"battery", "compare", a, scratch / "c.json"}).status, 2);
}

}  // namespace
}  // namespace cosiva::app
