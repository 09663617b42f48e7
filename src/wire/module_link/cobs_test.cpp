#include "cosiva/wire/module_link/cobs.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <initializer_list>
#include <vector>

namespace cosiva::wire::module_link {
namespace {

using namespace std::string_literals;

std::string stuffed(const std::vector<std::uint8_t>& content) {
  std::string frame;
  append_cobs(frame, content);
  return frame;
}

std::optional<std::vector<std::uint8_t>> content_of(std::string_view frame) {
  const auto content = from_cobs(frame);
  if (!content) return std::nullopt;
  return std::vector<std::uint8_t>(content->view().begin(), content->view().end());
}

TEST(Cobs, replaces_each_zero_by_the_distance_to_the_next_one) {
  // The examples of Cheshire and Baker 1999, "Consistent Overhead Byte Stuffing", without the delimiter.
  EXPECT_EQ(stuffed({}), "\x01");
  EXPECT_EQ(stuffed({0}), "\x01\x01");
  EXPECT_EQ(stuffed({0, 0}), "\x01\x01\x01");
  EXPECT_EQ(stuffed({0x11, 0x22, 0, 0x33}), "\x03\x11\x22\x02\x33");
  EXPECT_EQ(stuffed({0x11, 0, 0, 0}), "\x02\x11\x01\x01\x01");
}

TEST(Cobs, appends_to_what_there_is) {
  std::string frames = "x";
  append_cobs(frames, std::vector<std::uint8_t>{1});
  append_cobs(frames, std::vector<std::uint8_t>{2});
  EXPECT_EQ(frames, "x\x02\x01\x02\x02");
}

TEST(Cobs, reads_back_any_content_of_at_most_126_bytes) {
  EXPECT_TRUE(rc::check([] {
    auto content = *rc::gen::arbitrary<std::vector<std::uint8_t>>();
    if (content.size() > 126) content.resize(126);
    const std::string frame = stuffed(content);
    RC_ASSERT(frame.size() == content.size() + 1);
    RC_ASSERT(frame.find('\0') == std::string::npos);
    RC_ASSERT(content_of(frame) == content);
  }));
  for (const std::uint8_t byte : std::initializer_list<std::uint8_t>{0, 1, 255}) {
    const std::vector<std::uint8_t> longest(126, byte);
    EXPECT_EQ(content_of(stuffed(longest)), longest);
  }
}

TEST(Cobs, refuses_a_frame_that_is_empty_too_long_or_ends_within_a_code) {
  EXPECT_FALSE(from_cobs(""));
  EXPECT_TRUE(from_cobs(std::string(127, '\x01')));
  EXPECT_FALSE(from_cobs(std::string(128, '\x01')));
  EXPECT_TRUE(from_cobs("\x03\x11\x22"));
  EXPECT_FALSE(from_cobs("\x04\x11\x22"));
  EXPECT_FALSE(from_cobs("\x02\x11\x03\x22"));
  EXPECT_FALSE(from_cobs("\xFF"));
}

TEST(Cobs, refuses_a_zero_as_code_or_as_content) {
  EXPECT_FALSE(from_cobs("\0"s));
  EXPECT_FALSE(from_cobs("\x02\x11\0"s));
  EXPECT_FALSE(from_cobs("\x03\x11\0"s));
  EXPECT_FALSE(from_cobs("\x03\0\x11"s));
}

TEST(CobsDeathTest, takes_no_content_of_more_than_126_bytes) {
  EXPECT_DEATH(static_cast<void>(stuffed(std::vector<std::uint8_t>(127, 1))), "content_bytes_max");
}

}  // namespace
}  // namespace cosiva::wire::module_link
