#include "cosiva/adapters/store/store_keeper.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cosiva/journal/store/segment_log.h"
#include "cosiva/journal/store/simulated_disk.h"

namespace cosiva::adapters {
namespace {

using namespace std::chrono_literals;

/// Five segments of one checkpoint each.
std::shared_ptr<journal::SimulatedDisk> five_segments() {
  auto disk = std::make_shared<journal::SimulatedDisk>(1);
  journal::SegmentLog log{*disk, {0x5EED, 1, {}}, 1'000};
  for (int i = 0; i < 5; ++i) {
    journal::Batch batch;
    batch.add({SimTime{1s}, wire::InputKind::persisted, {}, "state", true});
    EXPECT_TRUE(log.write(batch));
    log.end_segment();
  }
  return disk;
}

TEST(StoreKeeper, removes_verified_segments_that_are_too_old) {
  EventLoop loop;
  std::size_t removed = 0;
  const StoreKeeper keeper{
      loop, five_segments(), {.age = 24h, .bytes = {}}, {{}, [&](std::size_t count) { removed += count; }}};
  EXPECT_TRUE(loop.run_until([&] { return removed == 3; }, 5s));
}

TEST(StoreKeeper, reports_damage_and_removes_nothing_behind_it) {
  EventLoop loop;
  const auto disk = five_segments();
  disk->flip_bit(journal::segment_name(2), 8 * 130);
  std::string location;
  const StoreKeeper keeper{
      loop, disk, {.age = 24h, .bytes = {}}, {[&](const Error& error) { location = error.location; }, {}}};
  EXPECT_TRUE(loop.run_until([&] { return !location.empty(); }, 5s));
  EXPECT_THAT(location, ::testing::StartsWith(journal::segment_name(2)));
  EXPECT_EQ(disk->names().value().size(), 5U);
}

TEST(StoreKeeper, tries_again_where_the_disk_cannot_be_read) {
  EventLoop loop;
  const auto disk = five_segments();
  std::atomic<int> refusals{3};
  disk->set_faults([&](journal::SimulatedDisk::Call call, const std::string&) {
    return std::string{call == journal::SimulatedDisk::Call::read && refusals-- > 0 ? "disk.io" : ""};
  });
  std::size_t removed = 0;
  const StoreKeeper keeper{
      loop, disk, {.age = 24h, .bytes = {}}, {{}, [&](std::size_t count) { removed += count; }}, 1ms};
  EXPECT_TRUE(loop.run_until([&] { return removed == 3; }, 5s));
}

}  // namespace
}  // namespace cosiva::adapters
