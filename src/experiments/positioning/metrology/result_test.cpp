#include "cosiva/experiments/positioning/metrology/result.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "cosiva/aiv/estimation/registry.h"
#include "cosiva/base/json_value.h"
#include "cosiva/experiments/positioning/metrology/evo_zip.h"
#include "cosiva/experiments/positioning/metrology/result_bars.h"
#include "cosiva/experiments/positioning/metrology/result_json.h"
#include "cosiva/experiments/positioning/metrology/result_page.h"
#include "cosiva/experiments/positioning/metrology/result_text.h"
#include "cosiva/experiments/positioning/metrology/simulate.h"
#include "cosiva/experiments/positioning/metrology/test_tracks.h"
#include "cosiva/experiments/reporting/chart.h"

namespace cosiva::experiments {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

Qualification small(Alignment alignment = Alignment::none, ReferenceBudget reference = {}) {
  static const estimation::Registry registry;
  Simulation simulation{testing::oval()};
  simulation.distance_m = 20.0;
  simulation.odometry_hz = 17.3;
  std::vector<Candidate> candidates;
  for (const std::string name : {"arc_kalman", "reset_rule"}) {
    candidates.push_back(
        {name, "", false, [name](const estimation::Setting& setting) { return registry.make(name, setting); }});
  }
  candidates.push_back(
      {"gone", "", false, [](const estimation::Setting&) -> Result<std::unique_ptr<estimation::Algorithm>> {
         return fail("algorithm.start", "it <does> not start", "gone");
       }});
  const auto source = [&](std::size_t index, Trial& room) -> Result<const Trial*> {
    simulate(simulation, index + 1, room);
    return &room;
  };
  QualificationOptions options;
  options.alignment = alignment;
  options.reference = std::move(reference);
  return *qualify(candidates, 8, source, options);
}

TEST(Result, as_json_has_the_documented_members) {
  const auto json = JsonValue::parse(to_json(small(), {"cosiva compare", "virtual time", {{"pitch_m", "0.5"}}, {}}));
  ASSERT_TRUE(json) << to_string(json.error());
  const auto& algorithms = *json->find("algorithms")->array();
  ASSERT_EQ(algorithms.size(), 3U);
  EXPECT_EQ(algorithms[0].text("name"), "arc_kalman");
  for (const char* key : {"rmse_m", "mean_m", "variance_m2", "precision", "p95_m", "limit_m", "gap_percent"})
    EXPECT_TRUE(algorithms[0].number(key)) << key;
  const auto& nis = *algorithms[0].find("nis");
  const double dimensions = *nis.number("dimensions");
  EXPECT_GE(dimensions, 8 * 38);  // forty beacons in each of eight runs
  // χ²/n for this number: 1 ± 1.96·√(2/n), to first order.
  EXPECT_NEAR(nis.find("band_95")->array()->front().number()[0], 1.0 - 1.96 * std::sqrt(2.0 / dimensions), 0.01);
  EXPECT_NEAR(nis.find("band_95")->array()->back().number()[0], 1.0 + 1.96 * std::sqrt(2.0 / dimensions), 0.01);
  EXPECT_TRUE(nis.find("inside_band"));
  const auto& cdf = *algorithms[0].find("cdf");
  ASSERT_EQ(cdf.find("ratio")->array()->size(), 50U);
  EXPECT_EQ(cdf.find("ratio")->array()->back().number()[0], 1.0);
  EXPECT_NEAR(cdf.find("error_m")->array()->back().number()[0], *algorithms[0].number("max_m"), 1e-7);
  const auto& interval = *algorithms[0].find("rmse_interval_m")->array();
  EXPECT_LT(*interval[0].number(), *algorithms[0].number("rmse_m"));
  EXPECT_GT(*interval[1].number(), *algorithms[0].number("rmse_m"));
  EXPECT_EQ(algorithms[2].find("failed")->text("code"), "algorithm.start");
  EXPECT_FALSE(algorithms[2].find("rmse_m"));
  EXPECT_EQ(json->find("comparisons")->array()->size(), 1U);
  EXPECT_TRUE(json->find("comparisons")->array()->front().text("verdict"));
  EXPECT_EQ(json->find("conditions")->text("pitch_m"), "0.5");
}

TEST(Result, as_text_names_failed_algorithms_with_the_others_metrics) {
  const std::string text = to_text(small());
  EXPECT_THAT(text, HasSubstr("arc_kalman"));
  EXPECT_THAT(text, HasSubstr("failed: gone: it <does> not start"));
  EXPECT_THAT(text, HasSubstr("reset_rule − arc_kalman"));
}

TEST(Result, as_a_page_is_self_contained_and_escapes_its_input) {
  const std::string html = to_html(small(), {"cosiva compare --runs 8", "virtual time", {}, {"a note"}});
  EXPECT_THAT(html, HasSubstr("<svg"));
  EXPECT_THAT(html, HasSubstr("cosiva compare --runs 8"));
  EXPECT_THAT(html, HasSubstr("it &lt;does&gt; not start"));
  EXPECT_THAT(html, HasSubstr("a note"));
  EXPECT_THAT(html, Not(HasSubstr("src=\"http")));
}

TEST(Result, draws_paths_on_the_lines_of_the_zone_where_there_is_one) {
  Conditions conditions;
  EXPECT_THAT(to_html(small(), conditions), Not(HasSubstr("class=\"line ground\"")));
  conditions.lines = {{{0.0, 0.0}, {3.0, 0.0}}, {{3.0, 0.0}, {3.5, 0.2}, {3.8, 0.8}}};
  const std::string html = to_html(small(), conditions);
  const std::size_t first = html.find("class=\"line ground\"");
  ASSERT_NE(first, std::string::npos);
  EXPECT_NE(html.find("class=\"line ground\"", first + 1), std::string::npos);
  EXPECT_THAT(html, HasSubstr("on the zone's lines (grey)"));
}

TEST(Result, draws_the_limit_of_each_bar_with_the_gap_in_percent) {
  const Qualification all = small();
  const std::string svg = limits_beside_bars(all);
  for (const std::size_t i : {0U, 1U}) {
    const Qualified& one = all.algorithms[i];
    EXPECT_THAT(svg, HasSubstr(">" + one.name + "</text>"));
    EXPECT_THAT(svg, HasSubstr("<title>limit " + readable(1e3 * *one.limit_m, 2) + " mm</title>"));
    EXPECT_THAT(svg, HasSubstr((*one.gap_percent > 0.0 ? ">+" : ">") + readable(*one.gap_percent, 1) + " %</text>"));
  }
  EXPECT_THAT(svg, HasSubstr("over the limit"));
  EXPECT_THAT(svg, Not(HasSubstr("logarithmic")));
  EXPECT_THAT(svg, Not(HasSubstr("gone")));  // it has no figures
  EXPECT_THAT(to_html(all, {}), HasSubstr(svg));
}

TEST(Result, draws_bars_without_a_limit_and_with_a_logarithmic_scale) {
  Qualification all = small(Alignment::se2);
  EXPECT_THAT(limits_beside_bars(all), Not(HasSubstr("limit")));
  all.algorithms[1].rmse_m.value *= 1000.0;
  EXPECT_THAT(limits_beside_bars(all), HasSubstr("logarithmic"));
  all.algorithms.clear();
  EXPECT_THAT(limits_beside_bars(all), HasSubstr("</svg>"));
}

TEST(Result, leaves_out_the_distance_since_the_last_fiducial_for_continuous_measurements) {
  Qualification all = small();
  EXPECT_THAT(to_html(all, {}), HasSubstr("Error by the distance since the last fiducial"));
  for (Qualified& one : all.algorithms) {
    for (std::size_t k = 1; k < one.by_distance.size(); ++k) one.by_distance[k] = {};
  }
  EXPECT_THAT(to_html(all, {}), Not(HasSubstr("Error by the distance since the last fiducial")));
}

TEST(Result, states_that_estimates_are_aligned) {
  const Qualification plain = small();
  EXPECT_THAT(to_json(plain, {}), HasSubstr("\"align\": \"none\""));
  EXPECT_THAT(to_json(plain, {}), Not(HasSubstr("alignment_by_run")));
  EXPECT_THAT(to_text(plain), Not(HasSubstr("ligned")));
  const Qualification aligned = small(Alignment::se2);
  const auto json = JsonValue::parse(to_json(aligned, {}));
  EXPECT_EQ(json->text("align"), "se2");
  const auto& algorithm = json->find("algorithms")->array()->front();
  EXPECT_EQ(algorithm.find("alignment_by_run")->array()->size(), 8U);
  EXPECT_TRUE(algorithm.find("limit_m")->is_null());
  EXPECT_THAT(to_text(aligned), HasSubstr("Aligned (se2)"));
  EXPECT_THAT(to_html(aligned, {}), HasSubstr("Aligned (se2), as requested"));
}

TEST(Result, lists_the_reference_s_error_part_by_part_with_its_sources) {
  EXPECT_THAT(to_html(small(), {}), Not(HasSubstr("The reference's own error")));
  const ReferenceBudget budget{{{"floor fit", 0.003, "left-out blocks"},
                                {"tag height", 0.004, "a ruler"},
                                {"mounting", std::nullopt, "not measured"}}};
  const Qualification all = small(Alignment::none, budget);
  const auto json = JsonValue::parse(to_json(all, {}));
  const JsonValue& reference = *json->find("reference");
  EXPECT_NEAR(*reference.number("uncertainty_m"), 0.005, 1e-15);
  const auto& parts = *reference.find("parts")->array();
  ASSERT_EQ(parts.size(), 3U);
  EXPECT_EQ(parts[1].text("source"), "a ruler");
  EXPECT_NEAR(*parts[1].number("percent"), 64.0, 1e-9);
  EXPECT_TRUE(parts[2].find("uncertainty_m")->is_null());
  const auto& algorithm = json->find("algorithms")->array()->front();
  const double detected = *algorithm.number("rmse_m");
  EXPECT_NEAR(*algorithm.number("rmse_without_reference_m"), std::sqrt(detected * detected - 25e-6), 1e-12);
  const std::string html = to_html(all, {});
  for (const char* phrase :
       {"The reference's own error", "left-out blocks", "a ruler", "not given", "u is more than this"})
    EXPECT_THAT(html, HasSubstr(phrase)) << phrase;
  EXPECT_THAT(to_text(all), HasSubstr("u 5 mm: floor fit 3, tag height 4; not given: mounting"));
}

TEST(Result, as_csv_has_a_line_per_vote) {
  const std::string csv = to_csv(small());
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + 2 * 8);
}

TEST(EvoZip, is_a_zip_with_the_files_that_evo_expects) {
  const std::string zip = evo_zip("mine", {0.0, 0.5}, {3.0, 4.0});
  EXPECT_EQ(zip.substr(0, 4), "PK\x03\x04");
  for (const char* name : {"info.json", "stats.json", "error_array.npy", "timestamps.npy"})
    EXPECT_THAT(zip, HasSubstr(name));
  EXPECT_THAT(zip, HasSubstr("\"sse\":25"));
  const std::size_t header = zip.find("\x93NUMPY");
  const auto length = static_cast<std::size_t>(static_cast<unsigned char>(zip[header + 8]));
  EXPECT_EQ((10 + length) % 64, 0U);
  double first = 0.0;
  std::memcpy(&first, zip.data() + header + 10 + length, 8);
  EXPECT_EQ(first, 3.0);
}

TEST(EvoZip, has_a_fixed_date_and_stores_without_compression) {
  const std::string zip = evo_zip("mine", {0.0, 0.5}, {3.0, 4.0});
  using namespace std::string_literals;
  EXPECT_EQ(zip.substr(6, 8), "\0\0\0\0\0\0\x21\0"s);  // flags, method "stored", time and date of 1980-01-01
  EXPECT_EQ(zip, evo_zip("mine", {0.0, 0.5}, {3.0, 4.0}));
}

}  // namespace
}  // namespace cosiva::experiments
