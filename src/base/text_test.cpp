#include "cosiva/base/text.h"

#include <gtest/gtest.h>

namespace cosiva {
namespace {

TEST(Lines, have_no_line_ends_and_are_counted) {
  Lines lines{"a\r\n\nb"};
  std::string_view line;
  ASSERT_TRUE(lines.next(line));
  EXPECT_EQ(line, "a");
  ASSERT_TRUE(lines.next(line));
  EXPECT_EQ(line, "");
  ASSERT_TRUE(lines.next(line));
  EXPECT_EQ(line, "b");
  EXPECT_EQ(lines.number(), 3U);
  EXPECT_FALSE(lines.next(line));
}

TEST(Lines, start_after_a_bom) {
  Lines lines{"\xEF\xBB\xBFtime_s\n\xEF\xBB\xBF"};
  std::string_view line;
  ASSERT_TRUE(lines.next(line));
  EXPECT_EQ(line, "time_s");
  ASSERT_TRUE(lines.next(line));
  EXPECT_EQ(line, "\xEF\xBB\xBF");  // inside a text the bytes are no BOM
}

TEST(Fields, are_one_more_than_commas_and_trimmed_of_the_given_blanks) {
  EXPECT_EQ(cut_at_commas(" a\t,,b c "), (std::vector<std::string_view>{"a", "", "b c"}));
  EXPECT_EQ(cut_at_commas("\"a\",b", " \""), (std::vector<std::string_view>{"a", "b"}));
  EXPECT_EQ(cut_at_commas(""), (std::vector<std::string_view>{""}));
  EXPECT_EQ(trimmed(" \t "), "");
}

TEST(NumberOf, accepts_only_a_whole_finite_number) {
  EXPECT_EQ(number_of<double>("-2.5e3"), -2500.0);
  EXPECT_EQ(number_of<int>("12"), 12);
  for (const char* text : {"", " 1", "1 ", "1x", "nan", "inf", "+1", "1e999"})
    EXPECT_FALSE(number_of<double>(text)) << text;
  for (const char* text : {"1.0", "99999999999", "0x1"}) EXPECT_FALSE(number_of<int>(text)) << text;
}

}  // namespace
}  // namespace cosiva
