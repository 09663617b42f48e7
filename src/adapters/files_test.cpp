#include "adapters/files.h"

#include <gmock/gmock.h>

#include "adapters/test_bench.h"

namespace cosiva::adapters {
namespace {

using namespace std::chrono_literals;
using testing::patience;
using testing::Scratch;

TEST(JournalFile, holds_what_was_appended_within_100_ms_and_at_the_end) {
  Scratch scratch;
  EventLoop loop;
  auto journal = JournalFile::create(loop, scratch / "run.journal", {}).value();
  journal->append("first");
  EXPECT_TRUE(loop.run_until([&] { return read_file(scratch / "run.journal").value() == "first"; }, patience));
  journal->append("-last");
  journal.reset();
  EXPECT_EQ(read_file(scratch / "run.journal").value(), "first-last");
}

TEST(JournalFile, where_it_cannot_be_written_is_an_error_before_anything_runs) {
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
  ASSERT_EQ(errors.size(), 1U);
  EXPECT_EQ(errors.front().code, "journal.write");
  EXPECT_THAT(errors.front().message, ::testing::HasSubstr("No space left"));
}

TEST(MemoryFile, gives_back_the_last_bytes_stored) {
  Scratch scratch;
  MemoryFile memory{scratch / "memory"};
  EXPECT_FALSE(memory.load());
  ASSERT_TRUE(memory.store("one"));
  ASSERT_TRUE(memory.store(std::string("t\0o", 3)));
  EXPECT_EQ(MemoryFile{scratch / "memory"}.load(), std::string("t\0o", 3));
}

TEST(MemoryFile, that_cannot_be_written_says_so) {
  MemoryFile memory{"/nonexistent/memory"};
  const auto stored = memory.store("x");
  ASSERT_FALSE(stored);
  EXPECT_EQ(stored.error().code, "file.write");
}

TEST(WriteFile, leaves_the_old_file_where_the_new_one_fails) {
  Scratch scratch;
  const std::string file = scratch.write("summary.json", "old");
  std::filesystem::create_directory(scratch / "summary.json.new");  // in the way of the temporary
  EXPECT_FALSE(write_file(file, "new"));
  EXPECT_EQ(read_file(file).value(), "old");
}

}  // namespace
}  // namespace cosiva::adapters
