#include "cosiva/base/archive_bytes.h"

#include <gtest/gtest.h>

#include <string>

namespace cosiva {
namespace {

TEST(ArchiveBytes, write_small_numbers_in_one_byte) {
  for (const auto& [elements, size] : {std::pair{0U, 1U}, {127U, 1U}, {128U, 2U}, {16'383U, 2U}, {16'384U, 3U}}) {
    std::string bytes;
    ArchiveBytes writing{bytes};
    EXPECT_EQ(writing.count(elements), elements);
    EXPECT_EQ(bytes.size(), size) << elements;
    bytes.append(elements, 'x');
    ArchiveBytes reading{std::string_view{bytes}};
    EXPECT_EQ(reading.count(0), elements);
  }
}

TEST(ArchiveBytes, state_the_first_failure) {
  ArchiveBytes archive{std::string_view{}};
  archive.fail("first");
  archive.fail("second");
  EXPECT_TRUE(archive.failed());
  const auto whole = archive.finish();
  ASSERT_FALSE(whole.has_value());
  EXPECT_EQ(whole.error().code, "archive");
  EXPECT_EQ(whole.error().message, "first");
}

TEST(ArchiveBytes, announce_no_more_elements_than_bytes_are_left) {
  const std::string bytes{"\x03xx"};
  ArchiveBytes archive{std::string_view{bytes}};
  EXPECT_EQ(archive.count(0), 0U);
  EXPECT_TRUE(archive.failed());
}

}  // namespace
}  // namespace cosiva
