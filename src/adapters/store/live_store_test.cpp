#include "cosiva/adapters/store/live_store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <thread>

#include "cosiva/adapters/live_shell.h"
#include "cosiva/adapters/store/posix_disk.h"
#include "cosiva/adapters/test_fixture.h"
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

/// A core whose state is the commands and links that it was given, in their order.
class ListingCore final : public wire::Core {
 public:
  void handle(const wire::Input& input, wire::Effects& effects) override {
    if (input.kind == InputKind::configure) effects.emplace_back(wire::Listen{{"topic/#"}});
    if (input.kind != InputKind::command && input.kind != InputKind::link) return;
    state += input.payload + ";";
    effects.emplace_back(wire::Log{'i', input.payload});
  }
  [[nodiscard]] SimDuration tick_period() const override { return 20ms; }
  [[nodiscard]] std::vector<std::string> subscriptions() const override { return {}; }
  void fold(Digest& digest) const override { digest.add(std::string_view{state}); }
  [[nodiscard]] Result<std::string> snapshot() const override { return state; }
  Result<void> continue_from(std::string_view bytes) override {
    if (!continues) return fail("snapshot.format", "another format");
    state = bytes;
    return {};
  }

  std::string state;
  bool continues{true};
};

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
  options.checkpoint_period = 4;  // the fourth command waits for it
  ListingCore first;
  run(first, options, {"a", "b", "c", "d"});
  EXPECT_THAT(kinds(), ::testing::Contains("11"));
  ListingCore second;
  run(second, options, {"e"});
  EXPECT_EQ(second.state, "a;b;c;d;down;e;");
  ListingCore third;
  run(third, options, {});
  EXPECT_EQ(third.state, "a;b;c;d;down;e;down;");
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

}  // namespace
}  // namespace cosiva::adapters
