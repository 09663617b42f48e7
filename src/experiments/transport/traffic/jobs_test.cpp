#include "cosiva/experiments/transport/traffic/jobs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "cosiva/experiments/transport/traffic/test_zone.h"

namespace cosiva::experiments {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;

TEST(PoissonJobs, have_the_requested_rate_and_exponential_intervals) {
  const auto jobs = poisson_jobs(*yard(), 600.0, 100.0 * 3600.0, 7);
  ASSERT_TRUE(jobs);
  const auto n = static_cast<double>(jobs->size());
  EXPECT_NEAR(n, 60'000.0, 4.0 * std::sqrt(60'000.0));
  double sum = 0.0;
  double squares = 0.0;
  double late = 0.0;
  double before = 0.0;
  for (const Job& job : *jobs) {
    const double gap_s = job.due_s - before;
    ASSERT_GE(gap_s, 0.0);
    sum += gap_s;
    squares += gap_s * gap_s;
    late += gap_s > 6.0 ? 1.0 : 0.0;
    before = job.due_s;
  }
  // Exponential gaps of mean 6 s: their deviation is the mean, and e⁻¹ of them are longer.
  const double mean_s = sum / n;
  EXPECT_NEAR(mean_s, 6.0, 0.1);
  EXPECT_NEAR(std::sqrt(squares / n - mean_s * mean_s), 6.0, 0.15);
  EXPECT_NEAR(late / n, std::exp(-1.0), 0.01);
}

TEST(PoissonJobs, lead_between_all_different_stops_but_to_no_charger) {
  const auto jobs = poisson_jobs(*yard(), 1000.0, 3600.0, 1);
  ASSERT_TRUE(jobs);
  std::set<std::pair<std::size_t, std::size_t>> pairs;
  for (const Job& job : *jobs) pairs.emplace(job.from, job.to);
  EXPECT_THAT(pairs, SizeIs(6)) << "three stops";
  for (const auto& [from, to] : pairs) {
    EXPECT_NE(from, to);
    EXPECT_EQ(yard()->stations[from].kind, zone::StationKind::stop);
    EXPECT_EQ(yard()->stations[to].kind, zone::StationKind::stop);
  }
}

TEST(PoissonJobs, are_equal_for_equal_seeds_only) {
  EXPECT_EQ(*poisson_jobs(*yard(), 60.0, 3600.0, 3), *poisson_jobs(*yard(), 60.0, 3600.0, 3));
  EXPECT_NE(*poisson_jobs(*yard(), 60.0, 3600.0, 3), *poisson_jobs(*yard(), 60.0, 3600.0, 4));
}

TEST(PoissonJobs, are_refused_where_impossible) {
  EXPECT_EQ(poisson_jobs(*yard(), 0.0, 3600.0, 1).error().code, "jobs.rate");
  EXPECT_EQ(poisson_jobs(*yard(), std::nan(""), 3600.0, 1).error().code, "jobs.rate");
  EXPECT_EQ(poisson_jobs(*yard(), 1e12, 3600.0, 1).error().code, "jobs.rate");
  EXPECT_EQ(poisson_jobs(*cycle(), 10.0, 3600.0, 1).error().code, "jobs.stations");
}

TEST(JobsFromCsv, are_read_by_column_names_in_any_order_and_sorted_by_time) {
  const auto jobs =
      jobs_from_csv(*yard(), "to, priority,from,time_s\r\nship,5,dock,60\n\n rack ,0,ship,12.5\n", "jobs.csv");
  ASSERT_TRUE(jobs) << to_string(jobs.error());
  EXPECT_THAT(*jobs, ElementsAre(Job{12.5, 2, 1, 0}, Job{60.0, 0, 2, 5}));
  EXPECT_TRUE(jobs_from_csv(*yard(), "\xEF\xBB\xBFtime_s,from,to", "jobs.csv")->empty());
}

TEST(JobsFromCsv, may_have_their_values_in_quotation_marks) {
  const auto jobs = jobs_from_csv(*yard(), "\"time_s\",\"from\",to\r\n\"12.5\", \"rack\" ,\"ship\"\r\n", "jobs.csv");
  ASSERT_TRUE(jobs) << to_string(jobs.error());
  EXPECT_THAT(*jobs, ElementsAre(Job{12.5, 1, 2, 0}));
}

struct BadCsv {
  const char* text;
  const char* location;
  const char* expected;
};
class OfBadCsv : public ::testing::TestWithParam<BadCsv> {};
TEST_P(OfBadCsv, reports_the_line_and_what_is_wrong_in_it) {
  const auto jobs = jobs_from_csv(*yard(), GetParam().text, "jobs.csv");
  ASSERT_FALSE(jobs);
  EXPECT_EQ(jobs.error().code, "jobs.csv");
  EXPECT_EQ(jobs.error().location, GetParam().location);
  EXPECT_THAT(jobs.error().message, HasSubstr(GetParam().expected));
}
INSTANTIATE_TEST_SUITE_P(
    Jobs, OfBadCsv,
    ::testing::Values(BadCsv{"", "jobs.csv:0", "the file is empty"},
                      BadCsv{"time_s,from\n", "jobs.csv:1", "'to' is missing"},
                      BadCsv{"time_s,from,to,when\n", "jobs.csv:1", "'when'"},
                      BadCsv{"time_s,from,to,to\n", "jobs.csv:1", "twice"},
                      BadCsv{"time_s,from,to\n1,dock\n", "jobs.csv:2", "2 values for 3 columns"},
                      BadCsv{"time_s,from,to\nsoon,dock,ship\n", "jobs.csv:2", "'soon'"},
                      BadCsv{"time_s,from,to\n-1,dock,ship\n", "jobs.csv:2", "from 0, not"},
                      BadCsv{"time_s,from,to\nnan,dock,ship\n", "jobs.csv:2", "time_s"},
                      BadCsv{"time_s,from,to\n1,dock,moon\n", "jobs.csv:2", "no station 'moon'"},
                      BadCsv{"time_s,from,to\n1,\"dock, left\",ship\n", "jobs.csv:2", "'dock, left'"},
                      BadCsv{"time_s,from,to\n1,dock,\"ship\n", "jobs.csv:2", "'\"ship'"},
                      BadCsv{"time_s,from,to\n1,dock,dock\n", "jobs.csv:2", "the same station"},
                      BadCsv{"time_s,from,to,priority\n\n1,dock,ship,1000\n", "jobs.csv:3", "0 to 999"}));

}  // namespace
}  // namespace cosiva::experiments
