#include "cosiva/base/digest.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

namespace cosiva {
namespace {

template <typename... Parts>
std::uint64_t digest_of(const Parts&... parts) {
  Digest digest;
  (digest.add(parts), ...);
  return digest.value();
}

TEST(Digest, of_equal_histories_is_equal) {
  EXPECT_EQ(digest_of(std::uint64_t{1}, 2.5, std::string_view{"three"}),
            digest_of(std::uint64_t{1}, 2.5, std::string_view{"three"}));
}

TEST(Digest, depends_on_the_order) {
  EXPECT_NE(digest_of(std::uint64_t{1}, std::uint64_t{2}), digest_of(std::uint64_t{2}, std::uint64_t{1}));
}

TEST(Digest, depends_on_every_bit_of_a_number) {
  std::set<std::uint64_t> detected{digest_of(std::uint64_t{0})};
  for (unsigned bit = 0; bit < 64; ++bit) EXPECT_TRUE(detected.insert(digest_of(std::uint64_t{1} << bit)).second);
  EXPECT_NE(digest_of(0.0), digest_of(-0.0));
}

TEST(Digest, depends_on_where_one_text_ends_and_the_next_begins) {
  EXPECT_NE(digest_of(std::string_view{"ab"}, std::string_view{"c"}),
            digest_of(std::string_view{"a"}, std::string_view{"bc"}));
  EXPECT_NE(digest_of(std::string_view{""}), Digest{}.value());
  EXPECT_NE(digest_of(std::string_view{"\0", 1}), digest_of(std::string_view{"\0\0", 2}));
}

TEST(Digest, of_texts_of_every_length_differ) {
  std::set<std::uint64_t> detected;
  for (std::size_t length = 0; length < 40; ++length)
    EXPECT_TRUE(detected.insert(digest_of(std::string(length, 'x'))).second);
}

TEST(Digest, of_a_short_text_is_that_of_its_length_and_of_its_bytes_as_one_word_with_the_first_byte_lowest) {
  const std::string text{"\x81\x92\xA3\xB4\xC5\xD6\xE7"};
  std::uint64_t word = 0;
  for (std::size_t length = 1; length <= text.size(); ++length) {
    word |= static_cast<std::uint64_t>(static_cast<unsigned char>(text[length - 1])) << (8U * (length - 1));
    EXPECT_EQ(digest_of(std::string_view{text}.substr(0, length)), digest_of(std::uint64_t{length}, word)) << length;
  }
}

TEST(Digest, is_written_as_sixteen_hexadecimal_digits) {
  EXPECT_EQ(Digest{}.hex(), "6a09e667f3bcc908");
  EXPECT_EQ(Digest{}.hex().size(), 16U);
}

TEST(Digest, of_a_time_equals_that_of_its_nanoseconds) {
  EXPECT_EQ(digest_of(virtual_epoch), digest_of(std::int64_t{1'689'033'600'000'000'000}));
}

}  // namespace
}  // namespace cosiva
