#include "cosiva/adapters/store/group_commit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <thread>

#include "cosiva/journal/store/simulated_disk.h"
#include "cosiva/journal/store/store_reading.h"

namespace cosiva::adapters {
namespace {

using namespace std::chrono_literals;
using journal::RecordNumber;
using journal::SimulatedDisk;
using Call = SimulatedDisk::Call;

constexpr journal::SegmentStart first_start{0x5EED, 1, {}};

const wire::Input command{SimTime{}, wire::InputKind::command, "page", R"({"command":"stop"})", false};

journal::Batch one_record() {
  journal::Batch batch;
  batch.add(command);
  return batch;
}

/// A disk that the test keeps while a GroupCommit owns this one.
class SharedDisk final : public journal::Disk {
 public:
  explicit SharedDisk(std::shared_ptr<SimulatedDisk> disk) : disk_{std::move(disk)} {}
  Result<std::vector<std::string>> names() const override { return disk_->names(); }
  Result<std::string> read(const std::string& name) const override { return disk_->read(name); }
  Result<std::unique_ptr<journal::DiskFile>> create(const std::string& name) override { return disk_->create(name); }
  Result<void> replace(const std::string& name, std::string_view bytes) override { return disk_->replace(name, bytes); }
  Result<void> cut(const std::string& name, std::size_t bytes) override { return disk_->cut(name, bytes); }
  Result<void> remove(const std::string& name) override { return disk_->remove(name); }

 private:
  std::shared_ptr<SimulatedDisk> disk_;
};

std::size_t records_on(const SimulatedDisk& disk) {
  std::size_t count = 0;
  const auto content = journal::read_store(disk, [&](RecordNumber, const journal::RecordView&) { ++count; });
  EXPECT_TRUE(content);
  return count;
}

/// A disk that is full for these calls, as long as `full` is true.
SimulatedDisk::Faults refusing(Call refused, const std::atomic<bool>& full) {
  return [refused, &full](Call call, const std::string&) {
    return std::string{full && call == refused ? "disk.full" : ""};
  };
}

TEST(GroupCommit, makes_records_durable_within_its_period) {
  EventLoop loop;
  const auto disk = std::make_shared<SimulatedDisk>(1);
  GroupCommit commit{loop, std::make_unique<SharedDisk>(disk), first_start, {}};
  commit.append(one_record());
  commit.append(one_record());
  EXPECT_TRUE(loop.run_until([&] { return commit.durable() == 3; }, 5s));
  EXPECT_EQ(records_on(*disk), 2U);
}

TEST(GroupCommit, lets_records_gather_until_a_proposal_arrives) {
  EventLoop loop;
  const auto disk = std::make_shared<SimulatedDisk>(1);
  GroupCommitOptions options;
  options.period = 10min;
  GroupCommit commit{loop, std::make_unique<SharedDisk>(disk), first_start, {}, options};
  commit.append(one_record());
  loop.run_for(50ms);
  EXPECT_EQ(commit.durable(), 1U);
  bool accepted = false;
  commit.propose(command, [&](const Result<void>& result) { accepted = result.has_value(); });
  EXPECT_TRUE(loop.run_until([&] { return accepted; }, 5s));
  EXPECT_EQ(records_on(*disk), 2U);
}

TEST(GroupCommit, writes_what_came_during_a_long_sync_as_soon_as_that_is_over) {
  EventLoop loop;
  const auto disk = std::make_shared<SimulatedDisk>(1);
  std::atomic<bool> syncing{false};
  std::atomic<bool> stalled{true};
  disk->set_faults([&](Call call, const std::string&) {
    if (call == Call::sync) syncing = true;
    while (call == Call::sync && stalled) std::this_thread::sleep_for(1ms);
    return std::string{};
  });
  GroupCommitOptions options;
  options.period = 1s;
  GroupCommit commit{loop, std::make_unique<SharedDisk>(disk), first_start, {}, options};
  commit.append_now(one_record(), [] {});
  ASSERT_TRUE(loop.run_until([&] { return syncing.load(); }, 5s));
  commit.append(one_record());
  loop.run_for(options.period);
  EXPECT_EQ(commit.durable(), 1U);
  stalled = false;
  EXPECT_TRUE(loop.run_until([&] { return commit.durable() == 3; }, options.period - 50ms));
}

TEST(GroupCommit, decides_a_proposal_only_when_its_record_is_durable) {
  EventLoop loop;
  const auto disk = std::make_shared<SimulatedDisk>(1);
  std::atomic<int> syncs{0};
  disk->set_faults([&](Call call, const std::string&) {
    if (call == Call::sync) ++syncs;
    return std::string{};
  });
  GroupCommit commit{loop, std::make_unique<SharedDisk>(disk), first_start, {}};
  int syncs_before_decision = 0;
  commit.propose(command, [&](const Result<void>&) { syncs_before_decision = syncs; });
  EXPECT_TRUE(loop.run_until([&] { return syncs_before_decision > 0; }, 5s));
}

TEST(GroupCommit, refuses_a_proposal_with_the_reason_of_the_disk_and_forgets_it) {
  EventLoop loop;
  const auto disk = std::make_shared<SimulatedDisk>(1);
  std::atomic<bool> full{true};
  disk->set_faults(refusing(Call::sync, full));
  GroupCommitOptions options;
  options.retry = 1ms;
  GroupCommit commit{loop, std::make_unique<SharedDisk>(disk), first_start, {}, options};
  commit.append(one_record());
  std::string code;
  commit.propose(command, [&](const Result<void>& result) { code = result ? "accepted" : result.error().code; });
  EXPECT_TRUE(loop.run_until([&] { return !code.empty(); }, 5s));
  EXPECT_EQ(code, "disk.full");
  full = false;
  EXPECT_TRUE(loop.run_until([&] { return commit.durable() == 2; }, 5s));
  EXPECT_EQ(records_on(*disk), 1U);
}

TEST(GroupCommit, reports_a_refusing_disk_once_and_loses_nothing_when_it_works_again) {
  EventLoop loop;
  const auto disk = std::make_shared<SimulatedDisk>(1);
  std::atomic<bool> full{true};
  disk->set_faults(refusing(Call::append, full));
  std::vector<std::string> refusals;
  int recoveries = 0;
  GroupCommitOptions options;
  options.retry = 1ms;
  GroupCommit commit{loop,
                     std::make_unique<SharedDisk>(disk),
                     first_start,
                     {[&](const Error& error) { refusals.push_back(error.code); }, [&] { ++recoveries; }, {}},
                     options};
  commit.append(one_record());
  commit.drain();
  EXPECT_EQ(commit.durable(), 1U);
  commit.append(one_record());
  loop.run_for(50ms);
  EXPECT_THAT(refusals, ::testing::ElementsAre("disk.full"));
  full = false;
  EXPECT_TRUE(loop.run_until([&] { return recoveries == 1 && commit.durable() == 3; }, 5s));
  EXPECT_EQ(records_on(*disk), 2U);
}

TEST(GroupCommit, writes_an_urgent_record_at_once_and_reports_when_it_is_durable) {
  EventLoop loop;
  const auto disk = std::make_shared<SimulatedDisk>(1);
  GroupCommitOptions options;
  options.period = 10min;
  GroupCommit commit{loop, std::make_unique<SharedDisk>(disk), first_start, {}, options};
  bool durable = false;
  commit.append_now(one_record(), [&] { durable = true; });
  EXPECT_TRUE(loop.run_until([&] { return durable; }, 5s));
  EXPECT_EQ(records_on(*disk), 1U);
}

TEST(GroupCommit, reports_an_urgent_record_as_durable_only_after_a_refusing_disk_works_again) {
  EventLoop loop;
  const auto disk = std::make_shared<SimulatedDisk>(1);
  std::atomic<bool> full{true};
  disk->set_faults(refusing(Call::sync, full));
  GroupCommitOptions options;
  options.retry = 1ms;
  bool refused = false;
  GroupCommit commit{
      loop, std::make_unique<SharedDisk>(disk), first_start, {[&](const Error&) { refused = true; }, {}, {}}, options};
  int durable = 0;
  commit.append_now(one_record(), [&] { ++durable; });
  EXPECT_TRUE(loop.run_until([&] { return refused; }, 5s));
  EXPECT_EQ(durable, 0);
  full = false;
  EXPECT_TRUE(loop.run_until([&] { return durable > 0; }, 5s));
  EXPECT_EQ(durable, 1);
}

TEST(GroupCommit, gives_up_more_records_than_it_may_hold_until_a_checkpoint) {
  EventLoop loop;
  const auto disk = std::make_shared<SimulatedDisk>(1);
  std::atomic<bool> full{true};
  disk->set_faults(refusing(Call::create, full));
  std::uint32_t given_up = 0;
  GroupCommitOptions options;
  options.retry = 1ms;
  options.waiting_bytes_max = 10 * one_record().records().size();
  GroupCommit commit{loop,
                     std::make_unique<SharedDisk>(disk),
                     first_start,
                     {{}, {}, [&](std::uint32_t count) { given_up += count; }},
                     options};
  for (int i = 0; i < 30; ++i) commit.append(one_record());
  EXPECT_TRUE(loop.run_until([&] { return given_up > 0; }, 5s));
  EXPECT_GE(given_up, 11U);
  bool refused = false;
  commit.propose(command, [&](const Result<void>& kept) { refused = !kept; });
  EXPECT_TRUE(loop.run_until([&] { return refused; }, 5s));
  full = false;
  commit.append(one_record());
  commit.append_checkpoint(one_record());
  commit.append(one_record());
  EXPECT_TRUE(loop.run_until([&] { return commit.durable() == 3; }, 5s));
  EXPECT_EQ(records_on(*disk), 2U);
}

TEST(GroupCommit, makes_everything_durable_before_it_ends) {
  EventLoop loop;
  const auto disk = std::make_shared<SimulatedDisk>(1);
  {
    GroupCommit commit{loop, std::make_unique<SharedDisk>(disk), first_start, {}};
    for (int i = 0; i < 100; ++i) commit.append(one_record());
  }
  EXPECT_EQ(records_on(*disk), 100U);
}

TEST(GroupCommit, ends_while_the_disk_refuses) {
  EventLoop loop;
  const auto disk = std::make_shared<SimulatedDisk>(1);
  disk->set_faults([](Call call, const std::string&) { return std::string{call == Call::create ? "disk.io" : ""}; });
  {
    GroupCommit commit{loop, std::make_unique<SharedDisk>(disk), first_start, {}};
    commit.append(one_record());
  }
  EXPECT_EQ(records_on(*disk), 0U);
}

}  // namespace
}  // namespace cosiva::adapters
