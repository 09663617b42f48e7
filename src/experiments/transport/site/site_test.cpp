#include "cosiva/experiments/transport/site/site.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <thread>

#include "cosiva/base/json_value.h"
#include "cosiva/base/test_paths.h"
#include "cosiva/base/test_ranks.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::experiments {
namespace {

std::shared_ptr<const zone::TrafficZone> ready(const std::string& name) {
  const std::string path = source_dir() + "/zones/" + name + ".toml";
  std::ifstream file(path);
  std::stringstream text;
  text << file.rdbuf();
  auto rtm = zone::Rtm::initialise({"toml", path, text.str(), {}});
  EXPECT_TRUE(rtm) << to_string(rtm.error());
  return rtm ? rtm->shared_zone() : nullptr;
}

SiteOptions site_of(const std::string& list, std::size_t aivs) {
  SiteOptions options;
  auto plan = site_plan_of_list(list, aivs, 10.0);
  EXPECT_TRUE(plan) << to_string(plan.error());
  options.plan = std::move(*plan);
  static const auto lacet4 = ready("lacet4");
  static const auto indus8 = ready("indus8");
  for (const auto& zone : options.plan.zones) options.zones.push_back(zone.file == "lacet4" ? lacet4 : indus8);
  options.jobs_per_hour = 120.0;
  options.away_ratio = 0.5;
  options.duration_s = 900.0;
  options.rules = aiv::AgentRules::built_in();
  return options;
}

Result<SiteMetrics> run(const SiteOptions& options, Ranks& ranks) {
  auto site = SiteRun::make(options, ranks);
  if (!site) return tl::unexpected(site.error());
  AloneWorker alone;
  while (site->advance(alone)) {
  }
  return site->metrics();
}

std::vector<Result<SiteMetrics>> run_on(const SiteOptions& options, std::size_t ranks) {
  cosiva::testing::ThreadRanks::Room room{ranks};
  std::vector<Result<SiteMetrics>> results(ranks, SiteMetrics{});
  std::vector<std::thread> threads;
  for (std::size_t r = 0; r < ranks; ++r)
    threads.emplace_back([&, r] {
      cosiva::testing::ThreadRanks mine{room, r};
      results[r] = run(options, mine);
    });
  for (std::thread& thread : threads) thread.join();
  return results;
}

TEST(Site, vehicles_carry_loads_from_zone_to_zone_without_loss_or_duplication) {
  const SiteOptions options = site_of("lacet4,indus8", 8);
  OneRank alone;
  const auto metrics = run(options, alone);
  ASSERT_TRUE(metrics) << to_string(metrics.error());
  ASSERT_EQ(metrics->zones.size(), 2U);
  EXPECT_GT(metrics->zones[0].came, 3U);
  EXPECT_GT(metrics->zones[1].came, 3U);
  EXPECT_EQ(metrics->zones[0].aivs + metrics->zones[1].aivs + metrics->in_transfer, 16U);
  // A vehicle that has left one zone and not entered the other is in transfer.
  EXPECT_EQ(metrics->zones[0].left + metrics->zones[1].left,
            metrics->zones[0].came + metrics->zones[1].came + metrics->in_transfer);
  EXPECT_TRUE(metrics->good());
  EXPECT_GT(metrics->zones[0].jobs_done, 0U);
  // The totals come first.
  JsonWriter json;
  write_json(json, *metrics);
  const auto read = JsonValue::parse(json.take(), 1U << 20U);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->number("jobs_done"), metrics->zones[0].jobs_done + metrics->zones[1].jobs_done);
  EXPECT_EQ(read->number("transferPoints"), metrics->zones[0].came + metrics->zones[1].came);
  for (const char* none : {"collisions", "near_misses", "stuck"}) EXPECT_EQ(read->number(none), 0.0) << none;
}

TEST(Site, any_number_of_ranks_gives_the_digest_of_one) {
  const SiteOptions options = site_of("lacet4,indus8,2*lacet4", 6);
  OneRank alone;
  const auto one = run(options, alone);
  ASSERT_TRUE(one) << to_string(one.error());
  for (const std::size_t ranks : {2U, 3U, 4U, 6U}) {
    for (const auto& each : run_on(options, ranks)) {
      ASSERT_TRUE(each) << to_string(each.error());
      EXPECT_EQ(each->digest, one->digest) << ranks << " ranks";
    }
  }
  SiteOptions other = options;
  other.seed = 2;
  EXPECT_NE(run(other, alone)->digest, one->digest);
}

TEST(Site, an_error_of_one_rank_is_reported_by_all) {
  SiteOptions options = site_of("lacet4,lacet4,lacet4", 4);
  options.plan.zones[2].aivs = 100'000;  // too many vehicles; that zone is the last rank's
  for (const auto& each : run_on(options, 3)) {
    ASSERT_FALSE(each);
    EXPECT_EQ(each.error().code, "traffic.room");
    EXPECT_NE(each.error().message.find("3_lacet4"), std::string::npos) << each.error().message;
  }
}

TEST(Site, a_transfer_point_at_an_unknown_station_is_refused_by_name) {
  SiteOptions options = site_of("lacet4,indus8", 4);
  options.plan.transfer_points[0].to_station = "nowhere";
  OneRank alone;
  const auto site = SiteRun::make(options, alone);
  ASSERT_FALSE(site);
  EXPECT_EQ(site.error().code, "site.transfer_point");
  EXPECT_NE(site.error().message.find("nowhere"), std::string::npos);
}

}  // namespace
}  // namespace cosiva::experiments
