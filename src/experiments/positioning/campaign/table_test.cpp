#include "cosiva/experiments/positioning/campaign/table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sqlite3.h>

#include <limits>

#include "cosiva/experiments/positioning/campaign/result.h"
#include "cosiva/experiments/positioning/campaign/result_tables.h"
#include "cosiva/experiments/positioning/campaign/table_sqlite.h"
#include "cosiva/experiments/positioning/campaign/test_campaign.h"

namespace cosiva::experiments {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

ResultTable sample() {
  using Kind = ResultTable::Column::Kind;
  return {
      "sample",
      {{"n", Kind::whole, [](std::size_t row) { return TableValue{static_cast<std::int64_t>(row)}; }},
       {"error_m", Kind::number,
        [](std::size_t row) {
          return TableValue{row == 1 ? std::numeric_limits<double>::quiet_NaN() : 0.1 * static_cast<double>(row)};
        }},
       {"name", Kind::text, [](std::size_t row) { return TableValue{std::string(row == 2 ? "a \"b\", c" : "x")}; }}},
      3};
}

TEST(ResultTable, as_CSV_quotes_special_characters_and_leaves_NaN_empty) {
  EXPECT_EQ(to_csv(sample()), "n,error_m,name\n0,0,x\n1,,x\n2,0.2,\"a \"\"b\"\", c\"\n");
}

/// The first column of a query's result.
std::vector<std::string> requested(std::string bytes, const std::string& query) {
  sqlite3* database = nullptr;
  EXPECT_EQ(sqlite3_open(":memory:", &database), SQLITE_OK);
  EXPECT_EQ(sqlite3_deserialize(database, "main", reinterpret_cast<unsigned char*>(bytes.data()),
                                static_cast<sqlite3_int64>(bytes.size()), static_cast<sqlite3_int64>(bytes.size()),
                                SQLITE_DESERIALIZE_READONLY),
            SQLITE_OK);
  std::vector<std::string> responses;
  const auto take = [](void* context, int, char** values, char**) {
    static_cast<std::vector<std::string>*>(context)->emplace_back(values[0] != nullptr ? values[0] : "NULL");
    return 0;
  };
  char* error = nullptr;
  EXPECT_EQ(sqlite3_exec(database, query.c_str(), take, &responses, &error), SQLITE_OK)
      << (error != nullptr ? error : "");
  sqlite3_free(error);
  sqlite3_close(database);
  return responses;
}

TEST(ResultTable, as_SQLite_can_be_queried_and_has_the_same_bytes_each_time) {
  const auto bytes = to_sqlite({sample()});
  ASSERT_TRUE(bytes) << to_string(bytes.error());
  EXPECT_TRUE(bytes->starts_with("SQLite format 3"));
  EXPECT_EQ(*to_sqlite({sample()}), *bytes);
  EXPECT_THAT(requested(*bytes, "SELECT name FROM sample ORDER BY n DESC"), ElementsAre("a \"b\", c", "x", "x"));
  EXPECT_THAT(requested(*bytes, "SELECT error_m FROM sample"), ElementsAre("0.0", "NULL", "0.2"));
  EXPECT_THAT(requested(*bytes, "SELECT typeof(n) FROM sample LIMIT 1"), ElementsAre("integer"));
}

TEST(Tables, of_a_campaign_have_units_in_their_names_and_a_row_for_each_vote) {
  const CampaignWork work = testing::work_of(testing::small_plan);
  std::vector<UnitRecord> records;
  for (std::size_t i = 0; i < work.units(); ++i) records.push_back(*work.done(i));
  AloneWorker alone;
  const CampaignSummary summary = sum_up(work, records, alone);
  const CampaignResult result{work, records, summary};
  const std::string runs = to_csv(runs_table(result));
  EXPECT_TRUE(runs.starts_with("cell,run,seed,speed_mps,odometry_noise_m,reading_noise_m,missed_ratio,")) << runs;
  EXPECT_EQ(std::ranges::count(runs, '\n'), 61);
  EXPECT_EQ(std::ranges::count(to_csv(cells_table(result)), '\n'), 13);
  const auto bytes =
      to_sqlite({campaign_table(result), runs_table(result), cells_table(result), pitches_table(result)});
  ASSERT_TRUE(bytes);
  EXPECT_THAT(requested(*bytes, "SELECT count(*) FROM runs JOIN cells USING (cell, algorithm)"), ElementsAre("60"));
  // The table of cells equals the aggregation of the table of runs.
  EXPECT_THAT(requested(*bytes,
                        "SELECT max(abs(rmse_m * rmse_m - together)) < 1e-15 FROM cells JOIN (SELECT "
                        "cell, avg(rmse_m * rmse_m) AS together FROM runs GROUP BY cell) USING (cell)"),
              ElementsAre("1"));
  EXPECT_THAT(requested(*bytes, "SELECT value FROM campaign WHERE key = 'digest'"), ElementsAre(summary.digest));
  EXPECT_THAT(requested(*bytes, "SELECT count(*) FROM pitches"), ElementsAre("4"));
}

}  // namespace
}  // namespace cosiva::experiments
