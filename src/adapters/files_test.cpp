#include "cosiva/adapters/files.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/stat.h>
#include <unistd.h>

#include "cosiva/adapters/test_fixture.h"

namespace cosiva::adapters {
namespace {

using namespace std::chrono_literals;
using testing::Scratch;
using testing::timeout;

/// A disk that stalls: bytes written here wait until the pipe is read.
std::string pipe_in(const Scratch& scratch, std::string_view name) {
  std::string file = scratch / name;
  EXPECT_EQ(::mkfifo(file.c_str(), 0600), 0);
  return file;
}

struct Descriptor {
  explicit Descriptor(int fd_) : fd{fd_} {}
  ~Descriptor() { ::close(fd); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  /// What can be read now.
  [[nodiscard]] std::string take() const {
    std::string bytes(64 * 1024, '\0');
    const ssize_t got = ::read(fd, bytes.data(), bytes.size());
    bytes.resize(got > 0 ? static_cast<std::size_t>(got) : 0);
    return bytes;
  }
  int fd;
};

TEST(JournalFile, holds_what_was_appended_within_100_ms_and_at_the_end) {
  Scratch scratch;
  EventLoop loop;
  auto journal = JournalFile::create(loop, scratch / "run.journal", {}).value();
  journal->append("first");
  EXPECT_TRUE(loop.run_until([&] { return read_file(scratch / "run.journal").value() == "first"; }, timeout));
  journal->append("-last");
  journal.reset();
  EXPECT_EQ(read_file(scratch / "run.journal").value(), "first-last");
}

TEST(JournalFile, that_cannot_be_created_is_an_error_before_anything_runs) {
  EventLoop loop;
  const auto created = JournalFile::create(loop, "/nonexistent/run.journal", {});
  ASSERT_FALSE(created);
  EXPECT_EQ(created.error().code, "journal.open");
}

TEST(JournalFile, on_a_full_disk_stops_with_one_clear_error) {
  EventLoop loop;
  std::vector<Error> errors;
  auto journal = JournalFile::create(loop, "/dev/full", [&](const Error& error) { errors.push_back(error); }).value();
  journal->append("lost");
  journal->flush();
  journal->append("not even tried");
  journal->flush();
  EXPECT_TRUE(journal->broken());
  loop.run_for(50ms);
  ASSERT_EQ(errors.size(), 1U);
  EXPECT_EQ(errors.front().code, "journal.write");
  EXPECT_THAT(errors.front().message, ::testing::HasSubstr("No space left"));
}

TEST(JournalFile, on_a_stalled_disk_delays_no_caller) {
  Scratch scratch;
  const std::string file = pipe_in(scratch, "run.journal");
  const Descriptor reader{::open(file.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC)};
  EventLoop loop;
  auto journal = JournalFile::create(loop, file, {}).value();
  const std::string much(1U << 20U, 'x');  // a pipe takes 64 KiB, and then nothing until it is read
  journal->append(much);
  int heartbeats = 0;
  Timer timer{loop};
  timer.every(5ms, [&] { ++heartbeats; });
  EXPECT_TRUE(loop.run_until([&] { return heartbeats == 20; }, timeout));
  journal->append("behind it");
  std::string got;
  EXPECT_TRUE(loop.run_until([&] { return (got += reader.take()).size() == much.size() + 9; }, timeout));
  EXPECT_EQ(got, much + "behind it");
}

TEST(WriteFile, leaves_the_old_file_where_the_new_one_fails) {
  Scratch scratch;
  const std::string file = scratch.write("summary.json", "old");
  std::filesystem::create_directory(scratch / "summary.json.new");  // blocks the temporary file
  EXPECT_FALSE(write_file(file, "new"));
  EXPECT_EQ(read_file(file).value(), "old");
}

}  // namespace
}  // namespace cosiva::adapters
