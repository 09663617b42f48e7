#include "cosiva/adapters/log_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <filesystem>
#include <string>
#include <vector>

#include "cosiva/adapters/files.h"
#include "cosiva/adapters/test_fixture.h"

namespace cosiva::adapters {
namespace {

using ::testing::HasSubstr;
using testing::Scratch;
using ::testing::SizeIs;
using testing::timeout;

struct Logs {
  explicit Logs(LogLimits limits = {}) : files{loop, limits, [this](const Error& e) { errors.push_back(e); }} {}
  [[nodiscard]] static std::string text(const std::string& path) { return read_file(path).value_or("-"); }

  Scratch scratch;
  EventLoop loop;
  std::vector<Error> errors;
  LogFiles files;
};

TEST(LogFiles, append_to_what_an_earlier_run_has_written) {
  Logs logs;
  const std::string path = logs.scratch / "server.log";
  ASSERT_TRUE(write_file(path, "first\n"));
  ASSERT_TRUE(logs.files.open(path));
  logs.files.append(path, "second\n");
  logs.files.drain();
  EXPECT_EQ(Logs::text(path), "first\nsecond\n");
}

TEST(LogFiles, are_rotated_by_size_and_the_oldest_is_deleted) {
  Logs logs{{.file_bytes_max = 20, .files_max = 3}};
  const std::string path = logs.scratch / "aiv1.log";
  ASSERT_TRUE(logs.files.open(path));
  for (int line = 1; line <= 9; ++line) {
    logs.files.append(path, "line " + std::to_string(line) + " --\n");
    logs.files.drain();
  }
  EXPECT_EQ(Logs::text(path), "line 9 --\n");
  EXPECT_EQ(Logs::text(path + ".1"), "line 7 --\nline 8 --\n");
  EXPECT_EQ(Logs::text(path + ".2"), "line 5 --\nline 6 --\n");
  EXPECT_FALSE(std::filesystem::exists(path + ".3"));
}

TEST(LogFiles, occupy_no_more_than_their_limits_however_much_is_written) {
  Logs logs{{.file_bytes_max = 10'000, .files_max = 3}};
  const std::string path = logs.scratch / "plant.log";
  ASSERT_TRUE(logs.files.open(path));
  for (int line = 0; line < 20'000; ++line) {
    logs.files.append(path, "a line of fifty characters, as a flood writes them\n");
    if (line % 100 == 0) logs.files.drain();
  }
  logs.files.drain();
  std::uintmax_t bytes = 0;
  for (const auto& file : std::filesystem::directory_iterator(std::filesystem::path(path).parent_path()))
    bytes += file.file_size();
  EXPECT_LE(bytes, 30'000U);
}

TEST(LogFiles, without_older_files_begin_again) {
  Logs logs{{.file_bytes_max = 10, .files_max = 1}};
  const std::string path = logs.scratch / "gvs.log";
  ASSERT_TRUE(logs.files.open(path));
  for (const char* line : {"11111111\n", "22222222\n"}) {
    logs.files.append(path, line);
    logs.files.drain();
  }
  EXPECT_EQ(Logs::text(path), "22222222\n");
  EXPECT_FALSE(std::filesystem::exists(path + ".1"));
}

TEST(LogFiles, on_a_full_disk_report_it_once_and_do_not_stop) {
  Logs logs;
  ASSERT_TRUE(logs.files.open("/dev/full"));
  for (int line = 0; line < 100; ++line) {
    logs.files.append("/dev/full", "lost\n");
    logs.files.drain();
  }
  ASSERT_TRUE(logs.loop.run_until([&] { return !logs.errors.empty(); }, timeout));
  logs.loop.run_until([] { return false; }, std::chrono::milliseconds{20});
  ASSERT_THAT(logs.errors, SizeIs(1));
  EXPECT_EQ(logs.errors[0].code, "file.write");
  EXPECT_THAT(logs.errors[0].message, HasSubstr("No space left"));
  EXPECT_EQ(logs.errors[0].location, "/dev/full");
}

TEST(LogFiles, continue_when_the_disk_has_room_again_and_state_what_is_lost) {
  std::signal(SIGXFSZ, SIG_IGN);
  Logs logs;
  const std::string path = logs.scratch / "server.log";
  ASSERT_TRUE(logs.files.open(path));
  logs.files.append(path, "before\n");
  logs.files.drain();
  rlimit usual{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &usual), 0);
  const rlimit full{7, usual.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &full), 0);
  logs.files.append(path, "lost\n");
  logs.files.drain();
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &usual), 0);
  logs.files.append(path, "after\n");
  logs.files.drain();
  EXPECT_EQ(Logs::text(path), "before\n\n5 bytes of this log are lost: the disk was full or too slow\nafter\n");
}

TEST(LogFiles, cannot_be_opened_in_a_folder_that_does_not_exist) {
  Logs logs;
  const auto opened = logs.files.open("/no/such/folder/server.log");
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, "file.write");
}

TEST(LogFiles, refuse_a_log_that_is_not_open) {
  EXPECT_DEATH(
      {
        Logs logs;
        logs.files.append("other.log", "text");
      },
      "found");
}

}  // namespace
}  // namespace cosiva::adapters
