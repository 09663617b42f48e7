#include "cosiva/experiments/positioning/campaign/campaign_run.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

#include "cosiva/base/test_ranks.h"
#include "cosiva/experiments/positioning/campaign/result.h"
#include "cosiva/experiments/positioning/campaign/test_campaign.h"

namespace cosiva::experiments {
namespace {

using cosiva::testing::ThreadRanks;
using ::testing::HasSubstr;
using testing::small_plan;
using testing::work_of;

/// Runs each part on a separate thread, the last part first.
class HastyWorkers final : public Workers {
 protected:
  void run(std::size_t count, Call call, void* context) override {
    std::vector<std::thread> threads;
    for (std::size_t i = count; i-- > 0;) threads.emplace_back([=] { call(context, i); });
    for (std::thread& thread : threads) thread.join();
  }
};

const auto keep_nothing = [](std::string_view) { return Result<void>{}; };
const auto no_hurry = [] { return false; };

std::string digest_of(const CampaignWork& work, std::vector<UnitRecord> records) {
  AloneWorker alone;
  return sum_up(work, records, alone).digest;
}

/// Runs everything on one rank; stored lines are added to `state`.
std::string digest_alone(const CampaignWork& work, Workers& workers, std::string* state = nullptr) {
  OneRank one;
  auto run = CampaignRun::make(work, std::vector<UnitRecord>{}, one);
  EXPECT_TRUE(run);
  const auto keep = [&](std::string_view lines) {
    if (state != nullptr) state->append(lines);
    return Result<void>{};
  };
  for (bool more = true; more;) {
    const auto round = run->advance(workers, no_hurry, keep);
    EXPECT_TRUE(round);
    more = round && *round;
  }
  EXPECT_EQ(run->cost_done(), run->cost_all());
  return digest_of(work, run->take_records());
}

TEST(CampaignRun, gives_one_digest_on_any_number_of_threads_and_ranks) {
  const CampaignWork work = work_of(small_plan);
  AloneWorker alone;
  HastyWorkers hasty;
  const std::string digest = digest_alone(work, alone);
  EXPECT_EQ(digest_alone(work, hasty), digest);
  for (const std::size_t count : {2U, 3U, 4U, 9U}) {
    ThreadRanks::Room room{count};
    std::vector<std::string> digests(count);
    std::vector<std::thread> threads;
    for (std::size_t r = 0; r < count; ++r) {
      threads.emplace_back([&, r] {
        ThreadRanks mine{room, r};
        AloneWorker worker;
        auto run = CampaignRun::make(work, std::vector<UnitRecord>{}, mine);
        // In a hurry: each rank does one unit a round.
        for (bool more = true; more;)
          more = *run->advance(
              worker, [] { return true; }, keep_nothing);
        if (r == 0) digests[r] = digest_of(work, run->take_records());
      });
    }
    for (std::thread& thread : threads) thread.join();
    EXPECT_EQ(digests[0], digest) << count << " ranks";
  }
}

TEST(CampaignRun, continues_after_any_interruption_to_the_same_digest) {
  const CampaignWork work = work_of(small_plan);
  AloneWorker alone;
  std::string lines;
  const std::string digest = digest_alone(work, alone, &lines);
  const std::string whole = state_header(work) + lines;
  for (std::size_t bytes = 0; bytes <= whole.size(); bytes += 997) {
    auto state = read_state(whole.substr(0, bytes), work, "state");
    ASSERT_TRUE(state);
    OneRank one;
    auto run = CampaignRun::make(work, std::move(state->records), one);
    ASSERT_TRUE(run);
    const std::size_t known = run->units_done();
    std::size_t kept = 0;
    const auto count = [&](std::string_view some) {
      kept += static_cast<std::size_t>(std::ranges::count(some, '\n'));
      return Result<void>{};
    };
    while (*run->advance(alone, no_hurry, count)) {
    }
    EXPECT_EQ(kept, work.units() - known) << "no unit is done twice";
    EXPECT_EQ(digest_of(work, run->take_records()), digest) << bytes;
  }
}

TEST(CampaignRun, finished_has_nothing_left_to_do) {
  const CampaignWork work = work_of("runs = 2\ndistance_m = 3\n[vary]\n");
  OneRank one;
  AloneWorker alone;
  auto run = CampaignRun::make(work, std::vector<UnitRecord>{*work.done(0)}, one);
  ASSERT_TRUE(run);
  const auto more = run->advance(alone, no_hurry, [](std::string_view) -> Result<void> {
    ADD_FAILURE();
    return {};
  });
  ASSERT_TRUE(more);
  EXPECT_FALSE(*more);
}

/// The outcome on each of several ranks.
std::vector<Result<bool>> outcomes(std::size_t count, const std::function<Result<bool>(Ranks&)>& of) {
  ThreadRanks::Room room{count};
  std::vector<Result<bool>> all(count, false);
  std::vector<std::thread> threads;
  for (std::size_t r = 0; r < count; ++r)
    threads.emplace_back([&, r] {
      ThreadRanks mine{room, r};
      all[r] = of(mine);
    });
  for (std::thread& thread : threads) thread.join();
  return all;
}

TEST(CampaignRun, fails_on_all_ranks_when_the_first_cannot_read_its_state) {
  const CampaignWork work = work_of(small_plan);
  for (const auto& outcome : outcomes(3, [&](Ranks& ranks) -> Result<bool> {
         Result<std::vector<UnitRecord>> known{std::vector<UnitRecord>{}};
         if (ranks.rank() == 0) known = fail("campaign.state", "it is damaged", "out/campaign.state:7");
         const auto run = CampaignRun::make(work, std::move(known), ranks);
         if (!run) return tl::unexpected(run.error());
         return true;
       })) {
    ASSERT_FALSE(outcome);
    EXPECT_EQ(to_string(outcome.error()), "out/campaign.state:7: it is damaged");
  }
}

TEST(CampaignRun, fails_on_all_ranks_when_the_disk_is_full) {
  const CampaignWork work = work_of(small_plan);
  for (const auto& outcome : outcomes(3, [&](Ranks& ranks) -> Result<bool> {
         auto run = CampaignRun::make(work, std::vector<UnitRecord>{}, ranks);
         AloneWorker alone;
         return run->advance(alone, no_hurry,
                             [](std::string_view) { return Result<void>{fail("file.write", "no space left")}; });
       })) {
    ASSERT_FALSE(outcome);
    EXPECT_EQ(outcome.error().code, "file.write");
  }
}

TEST(CampaignRun, fails_on_all_ranks_when_one_has_another_plan) {
  const CampaignWork work = work_of(small_plan);
  const CampaignWork other = work_of("seed = 3\n" + small_plan);
  for (const auto& outcome : outcomes(3, [&](Ranks& ranks) -> Result<bool> {
         const auto run = CampaignRun::make(ranks.rank() == 1 ? other : work, std::vector<UnitRecord>{}, ranks);
         if (!run) return tl::unexpected(run.error());
         return true;
       })) {
    ASSERT_FALSE(outcome);
    EXPECT_EQ(outcome.error().code, "campaign.ranks");
    EXPECT_THAT(outcome.error().message, HasSubstr("number 1 differs"));
  }
}

}  // namespace
}  // namespace cosiva::experiments
