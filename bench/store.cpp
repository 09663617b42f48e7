// The server's store at full load: messages made durable per second, with the hash and the checksums, compared with a
// bare loop that writes the same records, encoded before, with write and fdatasync. Both in turn, on the same file
// system. A sync of either makes about as many messages durable: the numbers of both are printed.
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
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

/// Messages that one sync makes durable.
constexpr std::uint32_t portion = 4'096;

/// Of one run.
struct Run {
  double messages_per_s;
  std::uint32_t syncs;
};

double seconds_since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

wire::Input message_of(std::uint32_t bytes) {
  std::string payload(bytes, 'x');
  for (std::size_t i = 0; i < payload.size(); ++i) payload[i] = static_cast<char>('0' + (i * 7919) % 75);
  return {SimTime{}, wire::InputKind::message, "uagv/v2/CoSiVA/AIV1/state", std::move(payload), false};
}

/// Invariant: `syncs` counts the successful ones of this file.
class CountedFile final : public journal::DiskFile {
 public:
  CountedFile(std::unique_ptr<journal::DiskFile> file, std::uint32_t& syncs) : file_{std::move(file)}, syncs_{syncs} {}
  Result<void> append(std::string_view bytes) override { return file_->append(bytes); }
  Result<void> sync() override {
    auto synced = file_->sync();
    if (synced) ++syncs_;
    return synced;
  }

 private:
  std::unique_ptr<journal::DiskFile> file_;
  std::uint32_t& syncs_;
};

/// Invariant: every file that is written counts its syncs.
class CountedDisk final : public journal::Disk {
 public:
  CountedDisk(std::unique_ptr<journal::Disk> disk, std::uint32_t& syncs) : disk_{std::move(disk)}, syncs_{syncs} {}
  Result<std::vector<std::string>> names() const override { return disk_->names(); }
  Result<std::string> read(const std::string& name) const override { return disk_->read(name); }
  Result<std::unique_ptr<journal::DiskFile>> create(const std::string& name) override {
    auto file = disk_->create(name);
    if (file) *file = std::make_unique<CountedFile>(std::move(*file), syncs_);
    return file;
  }
  Result<void> replace(const std::string& name, std::string_view bytes) override { return disk_->replace(name, bytes); }
  Result<void> cut(const std::string& name, std::size_t bytes) override { return disk_->cut(name, bytes); }
  Result<void> remove(const std::string& name) override { return disk_->remove(name); }

 private:
  std::unique_ptr<journal::Disk> disk_;
  std::uint32_t& syncs_;
};

/// The store is as fast as its thread: the appending side waits while one portion is written and another one is full.
Result<Run> run_store(const Options& options) {
  adapters::EventLoop loop;
  auto disk = adapters::PosixDisk::open(options.folder);
  if (!disk) return tl::unexpected<Error>(disk.error());
  std::uint32_t syncs = 0;
  const wire::Input message = message_of(options.bytes);
  constexpr std::uint64_t waiting_max = 2 * portion;
  adapters::GroupCommitOptions commit_options;
  commit_options.period = std::chrono::milliseconds{1};
  const auto begin = Clock::now();
  {
    adapters::GroupCommit commit{
        loop, std::make_shared<CountedDisk>(std::move(*disk), syncs), {0x5EED, 1, {}}, {}, commit_options};
    journal::Batch batch;
    for (std::uint64_t i = 1; i <= options.messages; ++i) {
      batch.add(message);
      commit.append(batch);
      batch.clear();
      while (i % 64 == 0 && i + 1 - commit.durable() > waiting_max)
        std::this_thread::sleep_for(std::chrono::microseconds{200});
    }
    commit.drain();
    if (commit.durable() != options.messages + 1) return fail("bench.store", "records are missing");
  }
  return Run{options.messages / seconds_since(begin), syncs};
}

/// A loop that writes portions of records and syncs each.
Result<Run> run_bare(const Options& options) {
  journal::Batch records;
  for (std::uint32_t i = 0; i < portion; ++i) records.add(message_of(options.bytes));
  const std::string file = options.folder + "/bare";
  const int fd = ::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  if (fd < 0) return fail("bench.store", "cannot be created", file);
  const auto begin = Clock::now();
  std::uint32_t syncs = 0;
  bool failed = false;
  for (; syncs * portion < options.messages && !failed; ++syncs)
    failed = adapters::write_all(fd, records.records()) != 0 || ::fdatasync(fd) != 0;
  const double rate = syncs * portion / seconds_since(begin);
  ::close(fd);
  if (failed) return fail("bench.store", "cannot be written", file);
  return Run{rate, syncs};
}

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

int measure(const Options& options) {
  std::vector<double> store;
  std::vector<double> ratios;
  std::vector<double> syncs;
  std::uint32_t bare_syncs = 0;
  for (std::uint32_t round = 0; round < options.rounds; ++round) {
    std::error_code error;
    std::filesystem::remove_all(options.folder, error);
    std::filesystem::create_directories(options.folder, error);
    const auto bare = run_bare(options);
    if (!bare) return app::report_error(bare.error());
    const auto stored = run_store(options);
    if (!stored) return app::report_error(stored.error());
    store.push_back(stored->messages_per_s);
    ratios.push_back(stored->messages_per_s / bare->messages_per_s);
    syncs.push_back(stored->syncs);
    bare_syncs = bare->syncs;
    std::filesystem::remove_all(options.folder, error);
  }
  const char* format = options.json
                           ? "{\"messages_per_s\":%.0f,\"ratio\":%.3f,\"bytes\":%u,\"messages\":%u,\"syncs\":%.0f,"
                             "\"bare_syncs\":%u}\n"
                           : "%.0f messages per second, %.2f of a bare loop of write and fdatasync (medians); %u "
                             "bytes each, %u messages; %.0f syncs, of the bare loop %u\n";
  std::printf(format, median(store), median(ratios), options.bytes, options.messages, median(syncs), bare_syncs);
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
