#include "cosiva/adapters/state_file.h"

#include <gmock/gmock.h>
#include <sys/stat.h>

#include <filesystem>

#include "cosiva/adapters/files.h"
#include "cosiva/adapters/test_fixture.h"

namespace cosiva::adapters {
namespace {

using testing::Scratch;

std::optional<std::string> load(const std::string& file) { return StateFile{file}.load(); }

ino_t identity(const std::string& file) {
  struct stat there {};
  EXPECT_EQ(::stat(file.c_str(), &there), 0);
  return there.st_ino;
}

TEST(StateFile, restores_the_last_bytes_stored_while_it_is_written_and_after) {
  Scratch scratch;
  const std::string file = scratch / "state";
  EXPECT_FALSE(load(file));
  for (int process = 0; process < 3; ++process) {
    StateFile state_file{file};
    for (int i = 0; i < 5; ++i) {
      const std::string bytes = std::string("t\0o\n", 4) + std::to_string(process) + std::to_string(i);
      ASSERT_TRUE(state_file.store(bytes));
      EXPECT_EQ(load(file), bytes) << "by a process that comes after one that was killed";
    }
  }
}

TEST(StateFile, reads_a_file_without_slots_as_it_is) {
  Scratch scratch;
  const std::string file = scratch.write("state", "{\"version\":1}");
  EXPECT_EQ(load(file), "{\"version\":1}");
  ASSERT_TRUE(StateFile{file}.store("newer"));
  EXPECT_EQ(load(file), "newer");
}

TEST(StateFile, is_written_in_place_since_a_new_file_waits_for_the_disk) {
  Scratch scratch;
  const std::string file = scratch / "state";
  StateFile state_file{file};
  ASSERT_TRUE(state_file.store("first"));
  const ino_t first = identity(file);
  const auto size = std::filesystem::file_size(file);
  for (std::size_t i = 0; i < 100; ++i) ASSERT_TRUE(state_file.store(std::string(1000 + i, 'x')));
  ASSERT_TRUE(StateFile{file}.store("of the next process"));
  EXPECT_EQ(identity(file), first);
  EXPECT_EQ(std::filesystem::file_size(file), size);
}

TEST(StateFile, grows_for_bytes_that_do_not_fit) {
  Scratch scratch;
  const std::string file = scratch / "state";
  StateFile state_file{file};
  for (std::size_t bytes = 1; bytes < 1'000'000; bytes = bytes * 3 + 1) {
    ASSERT_TRUE(state_file.store(std::string(bytes, 'x')));
    EXPECT_EQ(load(file), std::string(bytes, 'x'));
    ASSERT_TRUE(state_file.store("small"));
    EXPECT_EQ(load(file), "small");
  }
}

TEST(StateFile, that_is_damaged_gives_the_last_bytes_or_those_before_or_nothing) {
  Scratch scratch;
  const std::string file = scratch / "state";
  StateFile state_file{file};
  for (const char* bytes : {"first", "before", "last"}) ASSERT_TRUE(state_file.store(bytes));
  const std::string whole = read_file(file).value();
  const auto expect_one_of_them = [&](const std::string& damaged, std::size_t at) {
    scratch.write("damaged", damaged);
    const auto found = load(scratch / "damaged");
    EXPECT_TRUE(!found || *found == "last" || *found == "before") << at << ": " << found->substr(0, 80);
    return found;
  };
  int still_last = 0;
  for (std::size_t at = 0; at < whole.size(); ++at) {
    if (whole[at] == '\0') continue;
    for (const unsigned bit : {1U, 2U, 64U}) {
      std::string flipped = whole;
      flipped[at] = static_cast<char>(static_cast<unsigned char>(flipped[at]) ^ bit);
      // A wrong first character in one slot leaves the other intact.
      still_last += expect_one_of_them(flipped, at) == "last" ? 1 : 0;
    }
    std::string cut = whole;
    std::fill(cut.begin() + static_cast<std::ptrdiff_t>(at), cut.end(), '\0');
    expect_one_of_them(cut, at);
  }
  EXPECT_GT(still_last, 0);
}

TEST(StateFile, that_is_shorter_than_it_states_gives_nothing) {
  Scratch scratch;
  for (const std::string text : {"cosiva-memory 1 ", "cosiva-memory 1 1 5", "cosiva-memory 1 1 99999999999999999999 x",
                                 "cosiva-memory 1 1 18446744073709551615 0123456789abcdef\n12345",
                                 "cosiva-memory 1 -1 5 0123456789abcdef\n12345"}) {
    EXPECT_FALSE(load(scratch.write("state", text))) << text;
    EXPECT_FALSE(load(scratch.write("state", text + std::string(text.size(), '\0')))) << text;
  }
}

TEST(StateFile, that_was_removed_is_created_anew) {
  Scratch scratch;
  const std::string file = scratch / "state";
  StateFile state_file{file};
  ASSERT_TRUE(state_file.store("first"));
  std::filesystem::remove(file);
  ASSERT_TRUE(state_file.store("second"));
  EXPECT_EQ(load(file), "second");
}

TEST(StateFile, that_cannot_be_written_is_an_error) {
  StateFile state_file{"/nonexistent/state"};
  const auto stored = state_file.store("x");
  ASSERT_FALSE(stored);
  EXPECT_EQ(stored.error().code, "file.write");
}

}  // namespace
}  // namespace cosiva::adapters
