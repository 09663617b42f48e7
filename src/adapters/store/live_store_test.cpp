#include "cosiva/adapters/store/live_store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <mutex>
#include <thread>

#include "cosiva/adapters/live_shell.h"
#include "cosiva/adapters/store/listing_core_fixture.h"
#include "cosiva/adapters/store/posix_disk.h"
#include "cosiva/adapters/test_fixture.h"
#include "cosiva/journal/store/segment_log.h"
#include "cosiva/journal/store/store_reading.h"

namespace cosiva::adapters {
namespace {

using namespace std::chrono_literals;
using wire::InputKind;

wire::Input tick() { return {SimTime{}, InputKind::tick, {}, {}, false}; }
wire::Input persisted(std::string state) { return {SimTime{}, InputKind::persisted, {}, std::move(state), false}; }
wire::Input proposal(std::string command) {
  return {SimTime{}, InputKind::proposal, "http", std::move(command), false};
}
wire::Input given(std::string command) { return {SimTime{}, InputKind::command, "http", std::move(command), true}; }

class Stored : public ::testing::Test {
 protected:
  std::unique_ptr<LiveStore> open(LiveStoreOptions options = {}) {
    options.on_log = [this](char level, const std::string& text) { log.push_back(level + (" " + text)); };
    auto store = LiveStore::open(loop, folder, std::move(options));
    EXPECT_TRUE(store);
    return std::move(*store);
  }
  /// Has a command accepted, and gives it where `give` is true.
  void accept(LiveStore& store, const std::string& command, bool give) {
    bool decided = false;
    store.propose(proposal(command), [&](const Result<void>& kept) {
      EXPECT_TRUE(kept);
      decided = true;
      if (!give) return;
      store.append(given(command));
      store.complete();
    });
    EXPECT_TRUE(loop.run_until([&] { return decided; }, 5s));
  }
  /// Starts the core with the store, gives it commands, and kills it.
  void run(wire::Core& core, const LiveStoreOptions& options, const std::vector<std::string>& commands) {
    LiveOptions live;
    live.kind = "server";
    live.options = "{}";
    live.store = open(options);
    LiveShell shell{loop, core, std::move(live), {}};
    ASSERT_TRUE(shell.start());
    for (const std::string& command : commands) {
      bool given = false;
      shell.command("test", command, {}, [&](const Result<void>&) { given = true; });
      ASSERT_TRUE(loop.run_until([&] { return given; }, 5s));
    }
    loop.run_for(50ms);  // a tick, with which a checkpoint that is due is written
  }
  static void handle(LiveStore& store, const std::vector<wire::Input>& inputs) {
    for (const wire::Input& input : inputs) store.append(input);
    store.complete();
  }
  std::vector<std::string> kinds() const {
    std::vector<std::string> kinds;
    const auto disk = PosixDisk::open(folder, PosixDisk::Use::read);
    EXPECT_TRUE(journal::read_store(**disk, [&](journal::RecordNumber, const journal::RecordView& record) {
      kinds.push_back(std::to_string(record.kind) + (record.flag ? "!" : ""));
    }));
    return kinds;
  }

  testing::Scratch scratch;
  std::string folder = scratch / "store";
  EventLoop loop;
  std::vector<std::string> log;
};

TEST_F(Stored, state_and_accepted_commands_are_left_to_the_next_process) {
  {
    const auto store = open();
    EXPECT_EQ(store->take_left().persisted, std::nullopt);
    handle(*store, {tick(), persisted("s1")});
    accept(*store, "a", true);
    accept(*store, "b", false);
  }
  const auto left = open()->take_left();
  EXPECT_EQ(left.persisted, "s1");
  ASSERT_EQ(left.accepted.size(), 1U);
  EXPECT_EQ(left.accepted[0].payload, "b");
}

TEST_F(Stored, state_is_written_again_after_the_period_and_a_restart_begins_there) {
  LiveStoreOptions options;
  options.checkpoint_period = 3;
  {
    const auto store = open(options);
    handle(*store, {tick(), persisted("s1")});
    for (int i = 0; i < 3; ++i) handle(*store, {tick()});
  }
  EXPECT_THAT(kinds(), ::testing::ElementsAre("7", "10", "7", "10!", "7", "7"));
  EXPECT_EQ(open(options)->take_left().persisted, "s1");
}

TEST_F(Stored, period_of_the_state_goes_on_over_a_restart) {
  LiveStoreOptions options;
  options.checkpoint_period = 3;
  for (int run = 0; run < 4; ++run) handle(*open(options), {tick()});
  EXPECT_THAT(kinds(), ::testing::ElementsAre("7", "7", "7", "10!", "7"));
}

TEST_F(Stored, commands_wait_for_a_checkpoint_that_is_due) {
  LiveStoreOptions options;
  options.checkpoint_period = 2;
  {
    const auto store = open(options);
    handle(*store, {tick()});
    handle(*store, {tick()});
    bool decided = false;
    store->propose(proposal("a"), [&](const Result<void>&) { decided = true; });
    loop.run_for(50ms);
    EXPECT_FALSE(decided);
    handle(*store, {tick()});
    EXPECT_TRUE(loop.run_until([&] { return decided; }, 5s));
  }
  EXPECT_EQ(open(options)->take_left().accepted.size(), 1U);
}

TEST_F(Stored, no_checkpoint_is_written_between_a_command_and_its_effect) {
  LiveStoreOptions options;
  options.checkpoint_period = 2;
  {
    const auto store = open(options);
    bool given_now = false;
    store->propose(proposal("a"), [&](const Result<void>&) {
      handle(*store, {given("a"), persisted("made by a")});
      given_now = true;
    });
    handle(*store, {tick()});
    handle(*store, {tick()});
    handle(*store, {tick()});
    EXPECT_TRUE(loop.run_until([&] { return given_now; }, 5s));
    handle(*store, {tick()});
  }
  // The disk's thread may write the proposal before any of the first ticks, which wait for others.
  std::vector<std::string> records = kinds();
  const auto proposed = std::ranges::find(records, "9");
  ASSERT_LT(proposed, std::ranges::find(records, "6!"));
  records.erase(proposed);
  EXPECT_THAT(records, ::testing::ElementsAre("7", "7", "7", "6!", "10", "10!", "7"));
}

TEST_F(Stored, core_continues_from_its_snapshot_and_the_inputs_after_it) {
  LiveStoreOptions options;
  options.checkpoint_period = 5;
  ListingCore first;
  run(first, options, {"a", "b", "c", "d", "e"});  // the last one waits for the checkpoint
  EXPECT_THAT(kinds(), ::testing::Contains("11"));
  ListingCore second;
  run(second, options, {"f"});
  EXPECT_EQ(second.state, "a;b;c;d;e;down;f;");
  ListingCore third;
  run(third, options, {});
  EXPECT_EQ(third.state, "a;b;c;d;e;down;f;down;");
}

TEST_F(Stored, young_core_continues_from_its_first_input) {
  ListingCore first;
  run(first, {}, {"a"});
  ListingCore second;
  run(second, {}, {});
  EXPECT_EQ(second.state, "a;down;");
}

TEST_F(Stored, snapshot_of_another_format_is_not_continued) {
  LiveStoreOptions options;
  options.checkpoint_period = 2;
  ListingCore first;
  run(first, options, {"a", "b"});
  ListingCore second;
  second.continues = false;
  run(second, options, {"c"});
  EXPECT_EQ(second.state, "c;");
}

TEST_F(Stored, commands_of_an_earlier_process_are_pending_until_the_core_has_handled_them) {
  {
    const auto store = open();
    accept(*store, "a", false);
    accept(*store, "b", false);
  }
  ListingCore core;
  core.ready = false;
  LiveOptions live;
  live.kind = "server";
  live.options = "{}";
  live.store = open();
  LiveShell shell{loop, core, std::move(live), {}};
  ASSERT_TRUE(shell.start());
  EXPECT_TRUE(shell.gives_earlier_commands());
  bool early = false;
  shell.after_input([&] { early = early || (!shell.gives_earlier_commands() && core.state != "a;b;"); });
  core.ready = true;
  EXPECT_TRUE(loop.run_until([&] { return !shell.gives_earlier_commands(); }, 5s));
  EXPECT_EQ(core.state, "a;b;");
  EXPECT_FALSE(early);
}

TEST_F(Stored, torn_tail_is_cut_off_and_reported) {
  handle(*open(), {tick(), persisted("s1")});
  for (const auto& entry : std::filesystem::directory_iterator{folder}) {
    if (entry.path().extension() == ".segment") std::filesystem::resize_file(entry, entry.file_size() - 1);
  }
  EXPECT_EQ(open()->take_left().persisted, std::nullopt);
  ASSERT_FALSE(log.empty());
  EXPECT_THAT(log.back(), ::testing::AllOf(::testing::StartsWith("w "), ::testing::HasSubstr("cut off")));
}

TEST_F(Stored, damage_is_refused_with_folder_and_file) {
  handle(*open(), {tick(), persisted("s1")});
  for (const auto& entry : std::filesystem::directory_iterator{folder}) {
    if (entry.path().extension() != ".segment") continue;
    std::FILE* file = std::fopen(entry.path().c_str(), "r+b");
    std::fseek(file, 110, SEEK_SET);
    std::fputc('?', file);
    std::fclose(file);
  }
  const auto store = LiveStore::open(loop, folder, {});
  ASSERT_FALSE(store);
  EXPECT_THAT(store.error().location, ::testing::StartsWith(folder));
}

TEST_F(Stored, second_process_waits_until_the_first_has_ended) {
  auto first = open();
  std::thread end{[&] {
    std::this_thread::sleep_for(200ms);
    first.reset();
  }};
  EXPECT_TRUE(LiveStore::open(loop, folder, {}));
  end.join();
}

TEST_F(Stored, second_process_is_refused) {
  const auto first = open();
  LiveStoreOptions options;
  options.wait_max = 100ms;
  const auto second = LiveStore::open(loop, folder, std::move(options));
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, "store.taken");
}

/// A disk that notes which segments are read by the thread that opens the store, and which by others.
class ObservedDisk final : public journal::Disk {
 public:
  struct Reads {
    std::vector<std::string> names;
    std::size_t bytes{0};
  };

  explicit ObservedDisk(std::unique_ptr<PosixDisk> disk) : disk_{std::move(disk)} {}
  Result<std::vector<std::string>> names() const override { return disk_->names(); }
  Result<std::string> read(const std::string& name) const override {
    auto bytes = disk_->read(name);
    const std::lock_guard lock{mutex_};
    Reads& reads = std::this_thread::get_id() == opener_ ? opening_ : background_;
    reads.names.push_back(name);
    if (bytes) reads.bytes += bytes->size();
    return bytes;
  }
  Result<std::unique_ptr<journal::DiskFile>> create(const std::string& name) override { return disk_->create(name); }
  Result<void> replace(const std::string& name, std::string_view bytes) override { return disk_->replace(name, bytes); }
  Result<void> cut(const std::string& name, std::size_t bytes) override { return disk_->cut(name, bytes); }
  Result<void> remove(const std::string& name) override { return disk_->remove(name); }

  Reads opening() const {
    const std::lock_guard lock{mutex_};
    return opening_;
  }
  Reads background() const {
    const std::lock_guard lock{mutex_};
    return background_;
  }

 private:
  std::unique_ptr<PosixDisk> disk_;
  std::thread::id opener_ = std::this_thread::get_id();
  mutable std::mutex mutex_;
  mutable Reads opening_;
  mutable Reads background_;
};

/// 30 segments of 8 MB, with checkpoints in the 9th and in the 28th; the names of the segments.
std::vector<std::string> write_large_store(PosixDisk& disk) {
  journal::SegmentLog log{disk, {0x5EED, 1, {}}, std::size_t{8} << 20U};
  journal::Batch batch;
  for (int i = 0; i < 128; ++i) batch.add({SimTime{}, InputKind::message, "topic", std::string(65'000, 'x'), false});
  journal::Batch checkpoint;
  checkpoint.add({SimTime{}, InputKind::persisted, {}, "state", true});
  for (std::size_t segment = 1; segment <= 30; ++segment) {
    EXPECT_TRUE(log.write(batch));
    const bool has_checkpoint = segment == 9 || segment == 28;
    EXPECT_TRUE(!has_checkpoint || log.write(checkpoint));
    log.end_segment();
  }
  return disk.names().value();
}

void flip_bit(const std::string& file, long offset) {
  std::FILE* const opened = std::fopen(file.c_str(), "r+b");
  ASSERT_NE(opened, nullptr);
  std::fseek(opened, offset, SEEK_SET);
  const int byte = std::fgetc(opened);
  std::fseek(opened, offset, SEEK_SET);
  std::fputc(byte ^ 1, opened);
  std::fclose(opened);
}

TEST_F(Stored, large_store_is_opened_by_reading_its_last_segments_once_and_verified_in_the_background) {
  auto posix = PosixDisk::open(folder);
  ASSERT_TRUE(posix);
  const std::vector<std::string> segments = write_large_store(**posix);
  ASSERT_EQ(segments.size(), 30U);
  const std::size_t bytes = std::filesystem::file_size(folder + "/" + segments[27]) +
                            std::filesystem::file_size(folder + "/" + segments[28]) +
                            std::filesystem::file_size(folder + "/" + segments[29]);
  flip_bit(folder + "/" + segments[20], 4'000'000);

  const auto disk = std::make_shared<ObservedDisk>(std::move(*posix));
  LiveStoreOptions options;
  options.on_log = [this](char level, const std::string& text) { log.push_back(level + (" " + text)); };
  const auto store = LiveStore::open(loop, disk, std::move(options));
  ASSERT_TRUE(store) << to_string(store.error());
  EXPECT_EQ((*store)->take_left().persisted, "state");
  EXPECT_THAT(disk->opening().names, ::testing::UnorderedElementsAre(segments[27], segments[28], segments[29]));
  EXPECT_EQ(disk->opening().bytes, bytes);
  EXPECT_LT(8 * bytes, 240U << 20U) << "of the whole store";

  EXPECT_TRUE(loop.run_until([this] { return !log.empty(); }, testing::timeout));
  EXPECT_THAT(log, ::testing::ElementsAre(::testing::HasSubstr(segments[20])));
  EXPECT_THAT(disk->background().names, ::testing::ElementsAreArray(segments.begin(), segments.begin() + 21));
}

}  // namespace
}  // namespace cosiva::adapters
