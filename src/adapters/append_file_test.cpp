#include "cosiva/adapters/append_file.h"

#include <gtest/gtest.h>

#include "cosiva/adapters/files.h"
#include "cosiva/adapters/test_fixture.h"

namespace cosiva::adapters {
namespace {

TEST(AppendFile, grows_over_several_openings_and_can_be_cut) {
  const testing::Scratch scratch;
  const std::string path = scratch / "new/folder/state";
  {
    auto file = AppendFile::open(path);
    ASSERT_TRUE(file) << to_string(file.error());
    EXPECT_TRUE((*file)->append("one\ntwo\nthr"));
  }
  auto file = AppendFile::open(path);
  ASSERT_TRUE(file);
  EXPECT_TRUE((*file)->cut(8));
  EXPECT_TRUE((*file)->append("three\n"));
  EXPECT_EQ(*read_file(path), "one\ntwo\nthree\n");
}

TEST(AppendFile, has_one_writer) {
  const testing::Scratch scratch;
  auto file = AppendFile::open(scratch / "state");
  ASSERT_TRUE(file);
  const auto second = AppendFile::open(scratch / "state");
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, "file.taken");
  file->reset();
  EXPECT_TRUE(AppendFile::open(scratch / "state"));
}

TEST(AppendFile, reports_the_path_that_cannot_be_written) {
  const auto nowhere = AppendFile::open("/proc/nothing/state");
  ASSERT_FALSE(nowhere);
  EXPECT_EQ(nowhere.error().code, "file.write");
  auto full = AppendFile::open("/dev/full");
  ASSERT_TRUE(full) << to_string(full.error());
  const auto written = (*full)->append("x");
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().location, "/dev/full");
}

}  // namespace
}  // namespace cosiva::adapters
