// The server's store at full load: messages made durable per second, with the hash and the checksums, compared with a
// bare loop that writes the same bytes in the same portions with write and fdatasync. Both in turn, on the same file
// system.
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "cosiva/adapters/event_loop.h"
#include "cosiva/adapters/files.h"
#include "cosiva/adapters/store/group_commit.h"
#include "cosiva/adapters/store/posix_disk.h"
#include "cosiva/app/cli/console.h"
#include "cosiva/app/cli/options.h"
#include "cosiva/journal/store/store_reading.h"

namespace {

using namespace cosiva;
using Clock = std::chrono::steady_clock;

struct Options {
  std::string folder;
  std::uint32_t messages{200'000};
  std::uint32_t bytes{2'500};
  std::uint32_t rounds{5};
  bool json{false};
};

/// Messages that wait for the disk together.
constexpr std::uint32_t portion = 4'096;

double seconds_since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

wire::Input message_of(std::uint32_t bytes) {
  std::string payload(bytes, 'x');
  for (std::size_t i = 0; i < payload.size(); ++i) payload[i] = static_cast<char>('0' + (i * 7919) % 75);
  return {SimTime{}, wire::InputKind::message, "uagv/v2/CoSiVA/AIV1/state", std::move(payload), false};
}

/// Messages per second of the store, which is as fast as its thread: the appending side waits when much waits there.
Result<double> store_rate(const Options& options) {
  adapters::EventLoop loop;
  auto disk = adapters::PosixDisk::open(options.folder);
  if (!disk) return tl::unexpected<Error>(disk.error());
  const wire::Input message = message_of(options.bytes);
  constexpr std::uint64_t waiting_max = portion;
  adapters::GroupCommitOptions commit_options;
  commit_options.period = std::chrono::milliseconds{1};
  const auto begin = Clock::now();
  {
    adapters::GroupCommit commit{loop, std::move(*disk), {0x5EED, 1, {}}, {}, commit_options};
    for (std::uint64_t i = 1; i <= options.messages; ++i) {
      journal::Batch batch;
      batch.add(message);
      commit.append(batch);
      while (i % 1024 == 0 && i + 1 - commit.durable() > waiting_max)
        std::this_thread::sleep_for(std::chrono::microseconds{50});
    }
    commit.drain();
    if (commit.durable() != options.messages + 1) return fail("bench.store", "records are missing");
  }
  return options.messages / seconds_since(begin);
}

/// Messages per second of a loop that writes portions of as many messages as wait in the store.
Result<double> bare_rate(const Options& options) {
  const std::string bytes(std::size_t{portion} * options.bytes, 'x');
  const std::string file = options.folder + "/bare";
  const int fd = ::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  if (fd < 0) return fail("bench.store", "cannot be created", file);
  const auto begin = Clock::now();
  std::uint32_t written = 0;
  bool failed = false;
  for (; written < options.messages && !failed; written += portion)
    failed = adapters::write_all(fd, bytes) != 0 || ::fdatasync(fd) != 0;
  const double rate = written / seconds_since(begin);
  ::close(fd);
  if (failed) return fail("bench.store", "cannot be written", file);
  return rate;
}

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

int measure(const Options& options) {
  std::vector<double> store;
  std::vector<double> ratios;
  for (std::uint32_t round = 0; round < options.rounds; ++round) {
    std::error_code error;
    std::filesystem::remove_all(options.folder, error);
    std::filesystem::create_directories(options.folder, error);
    const auto bare = bare_rate(options);
    if (!bare) return app::report_error(bare.error());
    const auto stored = store_rate(options);
    if (!stored) return app::report_error(stored.error());
    store.push_back(*stored);
    ratios.push_back(*stored / *bare);
    std::filesystem::remove_all(options.folder, error);
  }
  const char* format = options.json
                           ? "{\"messages_per_s\":%.0f,\"ratio\":%.3f,\"bytes\":%u,\"messages\":%u}\n"
                           : "%.0f messages per second, %.2f of a bare loop of write and fdatasync (medians); %u "
                             "bytes each, %u messages\n";
  std::printf(format, median(store), median(ratios), options.bytes, options.messages);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  options.folder =
      (std::filesystem::temp_directory_path() / ("cosiva-bench-store-" + std::to_string(::getpid()))).string();
  const app::CommandLine line{"Measures how many messages per second the server's store makes durable"};
  const app::Command command = line.root();
  command.add_option("--folder", options.folder, "On the disk to be measured; made, and removed").show_default();
  command.add_option("--messages", options.messages, "In each round").show_default().in_range(1, 100'000'000);
  command.add_option("--bytes", options.bytes, "Of a message").show_default().in_range(1, 1'000'000);
  command.add_option("--rounds", options.rounds, "Of both, in turn; medians are printed")
      .show_default()
      .in_range(1, 1000);
  command.add_flag("--json", options.json, "Print the metrics as JSON");
  if (const auto status = line.parse(argc, argv)) return *status;
  return measure(options);
}
