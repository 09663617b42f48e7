#include "cosiva/adapters/v2x/key_file.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

namespace cosiva::adapters {
namespace {

struct KeyFileTest : ::testing::Test {
  std::string file{std::filesystem::temp_directory_path() / ("cosiva_key_" + std::to_string(::getpid()))};
  ~KeyFileTest() override { ::unlink(file.c_str()); }
  void write(std::size_t size, mode_t mode = 0600) const {
    std::ofstream{file, std::ios::binary} << std::string(size, 'k');
    ASSERT_EQ(::chmod(file.c_str(), mode), 0);
  }
};

TEST_F(KeyFileTest, has_exactly_32_bytes) {
  write(32);
  const auto key = read_key_file(file);
  ASSERT_TRUE(key);
  EXPECT_EQ(key->front(), 'k');
  EXPECT_EQ(key->back(), 'k');
  for (const std::size_t size : {0U, 31U, 33U, 64U}) {
    write(size);
    const auto wrong = read_key_file(file);
    ASSERT_FALSE(wrong) << size;
    EXPECT_EQ(wrong.error().code, "v2x.key");
    EXPECT_EQ(wrong.error().location, file);
    EXPECT_NE(to_string(wrong.error()).find(std::to_string(size) + " bytes"), std::string::npos);
  }
}

TEST_F(KeyFileTest, is_refused_where_others_may_access_it) {
  for (const mode_t mode : {0640U, 0604U, 0660U, 0601U, 0610U}) {
    write(32, mode);
    const auto open = read_key_file(file);
    ASSERT_FALSE(open) << mode;
    EXPECT_NE(to_string(open.error()).find("chmod 600"), std::string::npos);
  }
  write(32, 0400);
  EXPECT_TRUE(read_key_file(file));
}

TEST_F(KeyFileTest, is_a_file_that_exists) {
  EXPECT_FALSE(read_key_file(file));
  EXPECT_FALSE(read_key_file(std::filesystem::temp_directory_path()));
  ASSERT_EQ(::mkfifo(file.c_str(), 0600), 0);
  EXPECT_FALSE(read_key_file(file)) << "a pipe";
}

}  // namespace
}  // namespace cosiva::adapters
