#include "cosiva/adapters/store/posix_disk.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <filesystem>
#include <string>
#include <vector>

#include "cosiva/adapters/event_loop.h"
#include "cosiva/adapters/test_fixture.h"

namespace {

/// Files that were synced, by inode: in place of libc's function, which every caller in this program would use.
std::vector<ino_t>& synced_files() {
  static std::vector<ino_t> files;
  return files;
}

}  // namespace

extern "C" int fdatasync(int fd) {
  struct stat file {};
  if (::fstat(fd, &file) == 0) synced_files().push_back(file.st_ino);
  return static_cast<int>(::syscall(SYS_fdatasync, fd));
}

namespace cosiva::adapters {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class PosixDiskTest : public ::testing::Test {
 protected:
  std::unique_ptr<PosixDisk> open() {
    auto disk = PosixDisk::open(folder_);
    EXPECT_TRUE(disk) << to_string(disk.error());
    return disk ? std::move(*disk) : nullptr;
  }

  testing::Scratch scratch_;
  std::string folder_ = scratch_ / "store";
};

TEST_F(PosixDiskTest, makes_its_folder_and_is_empty) { EXPECT_THAT(*open()->names(), ElementsAre()); }

TEST_F(PosixDiskTest, reads_what_was_appended) {
  const auto disk = open();
  auto file = disk->create("b");
  ASSERT_TRUE(file);
  EXPECT_TRUE((*file)->append("one"));
  EXPECT_TRUE((*file)->append("two"));
  EXPECT_TRUE((*file)->sync());
  EXPECT_EQ(*disk->read("b"), "onetwo");
}

TEST_F(PosixDiskTest, returns_from_a_sync_only_after_the_kernel_has_synced_the_file) {
  const auto disk = open();
  auto file = disk->create("a");
  ASSERT_TRUE(file);
  ASSERT_TRUE((*file)->append("accepted"));
  synced_files().clear();
  ASSERT_TRUE((*file)->sync());
  struct stat status {};
  ASSERT_EQ(::stat((folder_ + "/a").c_str(), &status), 0);
  EXPECT_THAT(synced_files(), ElementsAre(status.st_ino));
}

TEST_F(PosixDiskTest, sorts_names_and_does_not_create_one_twice) {
  const auto disk = open();
  EXPECT_TRUE(disk->create("b"));
  EXPECT_TRUE(disk->create("a"));
  EXPECT_EQ(disk->create("a").error().code, "disk.exists");
  EXPECT_THAT(*disk->names(), ElementsAre("a", "b"));
}

TEST_F(PosixDiskTest, replaces_cuts_and_removes) {
  const auto disk = open();
  EXPECT_TRUE(disk->replace("a", "first"));
  EXPECT_TRUE(disk->replace("a", "second"));
  EXPECT_EQ(*disk->read("a"), "second");
  EXPECT_TRUE(disk->cut("a", 3));
  EXPECT_EQ(*disk->read("a"), "sec");
  EXPECT_TRUE(disk->remove("a"));
  EXPECT_THAT(*disk->names(), ElementsAre());
}

TEST_F(PosixDiskTest, is_full_at_the_limit_of_file_sizes_which_ends_no_program_with_an_event_loop) {
  const EventLoop loop;
  const auto disk = open();
  auto file = disk->create("a");
  ASSERT_TRUE(file);
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit limited{1000, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &limited), 0);
  const auto refused = (*file)->append(std::string(2000, 'a'));
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, "disk.full");
  EXPECT_TRUE((*file)->append("b"));
}

TEST_F(PosixDiskTest, names_the_file_that_is_missing) {
  const auto disk = open();
  EXPECT_THAT(disk->read("a").error().location, HasSubstr(folder_ + "/a"));
  EXPECT_EQ(disk->cut("a", 0).error().code, "disk.io");
  EXPECT_EQ(disk->remove("a").error().code, "disk.io");
}

TEST_F(PosixDiskTest, is_used_by_one_at_a_time) {
  auto disk = open();
  EXPECT_EQ(PosixDisk::open(folder_).error().code, "store.taken");
  disk.reset();
  EXPECT_TRUE(open());
}

TEST_F(PosixDiskTest, cannot_be_opened_where_there_is_a_file_of_its_name) {
  const auto disk = open();
  EXPECT_TRUE(disk->replace("a", ""));
  EXPECT_EQ(PosixDisk::open(folder_ + "/a").error().code, "store.open");
}

TEST_F(PosixDiskTest, distinguishes_a_full_disk_from_a_broken_one) {
  const auto disk = open();
  std::filesystem::create_symlink("/dev/full", folder_ + "/full");
  EXPECT_EQ(disk->create("full").error().code, "disk.exists");
  EXPECT_EQ(disk->replace("no_folder/a", "x").error().code, "disk.io");
}

}  // namespace
}  // namespace cosiva::adapters
