#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <csignal>
#include <functional>
#include <sstream>
#include <string>
#include <vector>

#include "cosiva/adapters/live_shell.h"
#include "cosiva/adapters/store/listing_core_fixture.h"
#include "cosiva/adapters/store/live_store.h"
#include "cosiva/adapters/store/posix_disk.h"
#include "cosiva/adapters/test_fixture.h"
#include "cosiva/journal/store/store_reading.h"

/// `kill -9` of a process that writes a store, at every call by which it changes the disk.
namespace cosiva::adapters {
namespace {

using namespace std::chrono_literals;

/// At which call of the disk the process ends, and when: `within` the call, which has then performed half of its work,
/// or `after` it, before its caller knows.
struct Death {
  enum class When : std::uint8_t { within, after };
  std::uint64_t call{0};
  When when{When::within};
};

[[noreturn]] void die() {
  ::kill(::getpid(), SIGKILL);
  for (;;) ::pause();
}

enum class Call : std::uint8_t { create, append, sync, replace, cut, remove, count };

/// The calls of all disks of a process.
class Calls {
 public:
  explicit Calls(Death death) : death_{death} {}

  /// Performs a call: all of it, or half and then the end of the process.
  template <typename Whole, typename Half>
  auto perform(Call kind, const Whole& whole, const Half& half) {
    const std::uint64_t call = ++count_;
    kinds_ |= 1U << static_cast<unsigned>(kind);
    if (call == death_.call && death_.when == Death::When::within) {
      half();
      die();
    }
    auto result = whole();
    if (call == death_.call) die();
    return result;
  }
  /// Whether the next append is to fail: once, so that the store cuts a segment.
  [[nodiscard]] bool refuse_append() { return ++appends_ == 3; }
  /// Whether there have been calls of each kind.
  [[nodiscard]] bool complete() const { return kinds_ == (1U << static_cast<unsigned>(Call::count)) - 1; }

 private:
  Death death_;
  std::atomic<std::uint64_t> count_{0};
  std::atomic<std::uint64_t> appends_{0};
  std::atomic<unsigned> kinds_{0};
};

class CountedFile final : public journal::DiskFile {
 public:
  CountedFile(std::unique_ptr<journal::DiskFile> file, Calls& calls) : file_{std::move(file)}, calls_{calls} {}
  Result<void> append(std::string_view bytes) override {
    const auto half = [&] { return file_->append(bytes.substr(0, bytes.size() / 2)); };
    if (calls_.refuse_append()) {
      EXPECT_TRUE(half());
      return fail("disk.full", "the test refuses this append", {});
    }
    return calls_.perform(
        Call::append, [&] { return file_->append(bytes); }, half);
  }
  Result<void> sync() override {
    return calls_.perform(
        Call::sync, [&] { return file_->sync(); }, [] {});
  }

 private:
  std::unique_ptr<journal::DiskFile> file_;
  Calls& calls_;
};

class CountedDisk final : public journal::Disk {
 public:
  CountedDisk(std::unique_ptr<PosixDisk> disk, Calls& calls) : disk_{std::move(disk)}, calls_{calls} {}

  Result<std::vector<std::string>> names() const override { return disk_->names(); }
  Result<std::string> read(const std::string& name) const override { return disk_->read(name); }
  Result<std::unique_ptr<journal::DiskFile>> create(const std::string& name) override {
    auto file = calls_.perform(
        Call::create, [&] { return disk_->create(name); }, [] {});
    if (!file) return file;
    return std::make_unique<CountedFile>(std::move(*file), calls_);
  }
  Result<void> replace(const std::string& name, std::string_view bytes) override {
    // PosixDisk writes the bytes to a file of this name first.
    return calls_.perform(
        Call::replace, [&] { return disk_->replace(name, bytes); },
        [&] { static_cast<void>((*disk_->create(name + ".new"))->append(bytes.substr(0, 30))); });
  }
  Result<void> cut(const std::string& name, std::size_t bytes) override {
    return calls_.perform(
        Call::cut, [&] { return disk_->cut(name, bytes); }, [] {});
  }
  Result<void> remove(const std::string& name) override {
    return calls_.perform(
        Call::remove, [&] { return disk_->remove(name); }, [] {});
  }

 private:
  std::unique_ptr<PosixDisk> disk_;
  Calls& calls_;
};

/// Small, so that a few commands fill segments, write checkpoints and have segments removed.
LiveStoreOptions small_store() {
  LiveStoreOptions options;
  options.checkpoint_period = 6;
  options.keep.bytes = 1'500;
  options.commit.period = 1ms;
  options.commit.retry = 1ms;
  options.commit.segment_bytes = 700;
  return options;
}

std::string numbered(int number) { return "c" + std::to_string(number); }

/// A process with a core and its store, which is given commands one after the other.
class Process {
 public:
  explicit Process(std::shared_ptr<journal::Disk> disk) {
    LiveOptions live;
    live.kind = "server";
    live.options = "{}";
    auto store = LiveStore::open(loop_, std::move(disk), small_store());
    EXPECT_TRUE(store) << to_string(store.error());
    if (!store) return;
    live.store = std::move(*store);
    shell_ = std::make_unique<LiveShell>(loop_, core_, std::move(live));
    EXPECT_TRUE(shell_->start());
  }

  /// Returns when the command is durable: one that the disk refuses is given again. Every third command is a Stop.
  bool give(int number) {
    bool durable = false;
    bool refused = false;
    const auto on_durable = [&] { durable = true; };
    const auto on_decided = [&](const Result<void>& kept) { (kept ? durable : refused) = true; };
    for (int attempt = 0; !durable && attempt < 1'000; ++attempt) {
      refused = false;
      if (number % 3 == 0)
        shell_->urgent_command("test", numbered(number), {}, on_durable);
      else
        shell_->command("test", numbered(number), {}, on_decided);
      if (!loop_.run_until([&] { return durable || refused; }, testing::timeout)) return false;
      if (refused) loop_.run_for(1ms);
    }
    return durable;
  }

  bool run_until(const std::function<bool()>& reached) { return loop_.run_until(reached, testing::timeout); }

  /// The numbers of the commands that the core has been given, by this process and those before.
  std::vector<int> given() const {
    std::vector<int> numbers;
    std::istringstream state{core_.state};
    for (std::string each; std::getline(state, each, ';');)
      if (each.starts_with('c')) numbers.push_back(std::stoi(each.substr(1)));
    return numbers;
  }

 private:
  EventLoop loop_;
  ListingCore core_;
  std::unique_ptr<LiveShell> shell_;
};

std::unique_ptr<PosixDisk> disk_in(const std::string& folder) {
  auto disk = PosixDisk::open(folder);
  EXPECT_TRUE(disk) << to_string(disk.error());
  return std::move(*disk);
}

constexpr int processes = 3;
constexpr int commands_per_process = 6;

/// What the process does that may be killed: it gives commands, ends, and starts again on the same store. Each number
/// that is durable is written to the pipe.
[[noreturn]] void write_store(const std::string& folder, Death death, int pipe) {
  Calls calls{death};
  int number = 0;
  for (int start = 0; start < processes; ++start) {
    Process process{std::make_shared<CountedDisk>(disk_in(folder), calls)};
    for (int i = 0; i < commands_per_process; ++i) {
      if (!process.give(++number) || ::write(pipe, &number, sizeof number) != sizeof number) ::_exit(1);
    }
    // Another thread removes old segments.
    const bool last = start + 1 == processes;
    if (last && !process.run_until([&] { return calls.complete(); })) ::_exit(1);
  }
  ::_exit(::testing::Test::HasFailure() ? 1 : 0);
}

struct Ended {
  int status{};
  int durable{0};  ///< the last command that was reported to be durable
};

Ended run_to_its_end(const std::string& folder, Death death) {
  std::array<int, 2> pipe{};
  EXPECT_EQ(::pipe(pipe.data()), 0);
  const pid_t child = ::fork();
  if (child == 0) write_store(folder, death, pipe[1]);
  ::close(pipe[1]);
  Ended ended;
  for (int number = 0; ::read(pipe[0], &number, sizeof number) == sizeof number;) ended.durable = number;
  ::close(pipe[0]);
  EXPECT_EQ(::waitpid(child, &ended.status, 0), child);
  return ended;
}

void expect_intact(const std::string& folder, bool may_be_torn) {
  const auto disk = PosixDisk::open(folder, PosixDisk::Use::read);
  ASSERT_TRUE(disk);
  const auto content = journal::read_store(**disk);
  ASSERT_TRUE(content) << to_string(content.error());
  EXPECT_FALSE(content->damage) << to_string(*content->damage);
  EXPECT_TRUE(may_be_torn || !content->torn);
}

/// The commands reported as durable are given to the next process, each once and in their order, and perhaps the one
/// that followed; and the next process goes on.
void expect_continued(const std::string& folder, int durable) {
  Process next{disk_in(folder)};
  next.give(100);
  std::vector<int> given = next.given();
  ASSERT_FALSE(given.empty());
  EXPECT_EQ(given.back(), 100);
  given.pop_back();
  ASSERT_THAT(given.size(), ::testing::AnyOf(durable, durable + 1));
  for (std::size_t i = 0; i < given.size(); ++i) EXPECT_EQ(given[i], static_cast<int>(i) + 1);
}

void die_at_every_call(Death::When when, std::uint64_t calls_min) {
  std::uint64_t call = 1;
  for (;; ++call) {
    SCOPED_TRACE("call " + std::to_string(call));
    const testing::Scratch scratch;
    const std::string folder = scratch / "store";
    const Ended ended = run_to_its_end(folder, {call, when});
    const bool was_killed = WIFSIGNALED(ended.status) && WTERMSIG(ended.status) == SIGKILL;
    ASSERT_TRUE(was_killed || (WIFEXITED(ended.status) && WEXITSTATUS(ended.status) == 0)) << ended.status;
    expect_intact(folder, true);
    expect_continued(folder, ended.durable);
    expect_intact(folder, false);
    if (::testing::Test::HasFailure()) return;
    if (was_killed) continue;
    EXPECT_EQ(ended.durable, processes * commands_per_process);
    break;
  }
  EXPECT_GT(call, calls_min) << "calls of a process that was not killed";
}

TEST(KilledProcess, loses_nothing_durable_where_it_ends_within_any_call_of_the_disk) {
  die_at_every_call(Death::When::within, 40);
}

TEST(KilledProcess, loses_nothing_durable_where_it_ends_after_any_call_of_the_disk) {
  die_at_every_call(Death::When::after, 40);
}

}  // namespace
}  // namespace cosiva::adapters
