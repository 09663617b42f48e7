#include "cosiva/zone/lif/json_fault.h"

#include <gtest/gtest.h>

#include <string>
#include <string_view>

namespace cosiva::zone::lif {
namespace {

/// "line:column what", or "none".
std::string at(std::string_view text, std::size_t depth_max = 64) {
  const auto fault = find_json_fault(text, depth_max);
  return fault ? std::to_string(fault->line) + ":" + std::to_string(fault->column) + " " + fault->what : "none";
}

TEST(JsonFault, is_none_in_a_good_text) {
  for (const char* text : {"{}",
                           "[]",
                           " [1, -2.5e+3, true, null, \"a\\u00e4\\n\xC3\xA4\"] ",
                           "\"x\"",
                           "{\"a\":{\"b\":[{}]}}",
                           "0",
                           "-0",
                           "10",
                           "-0.5",
                           "1e9",
                           "1E-9",
                           "1.25E+02",
                           "[false,true,null]",
                           "[[],[[]]]",
                           "{\"\":\"\"}",
                           "\t\r\n {} \t\r\n",
                           "[\"\\\"\\\\\\/\\b\\f\\n\\r\\t\"]",
                           "\"\\u0123\\u4567\\u89ab\\ucdef\\uABCD\\uEF90\"",
                           "{\"a\":1,\"b\":2}",
                           "[{},{}]",
                           "\"\x7F\"",
                           "[1,2]\n"})
    EXPECT_EQ(at(text), "none") << text;
}

TEST(JsonFault, is_found_at_its_position) {
  EXPECT_EQ(at("[1,]"), "1:4 expected a value, found ']'");
  EXPECT_EQ(at("{\"a\":1,}"), "1:8 expected a name in quotes, found '}'");
  EXPECT_EQ(at("{\"a\":1\n\"b\":2}"), "2:1 expected ',' or '}', found '\"'");
  EXPECT_EQ(at("[01]"), "1:2 no valid JSON number");
  EXPECT_EQ(at("[1.]"), "1:2 no valid JSON number");
  EXPECT_EQ(at("[\"a\nb\"]"), "1:4 a line break or control character within a text in quotes");
  EXPECT_EQ(at("[\"abc"), "1:2 a text in quotes that never ends");
  EXPECT_EQ(at("[\"\\x\"]"), "1:3 a backslash that begins no escape");
  EXPECT_EQ(at("{} x"), "1:4 expected nothing more after the document's end");
  EXPECT_EQ(at("[1"), "1:3 the text ends here, where ',' or ']' is missing");
  EXPECT_EQ(at("// no\n{}"), "1:1 expected a value, found '/'");
}

TEST(JsonFault, counts_lines_from_one_and_columns_from_each_line_s_begin) {
  EXPECT_EQ(at("[\n\n  x"), "3:3 expected a value or ']', found 'x'");
  EXPECT_EQ(at("[1,\n2,\n,"), "3:1 expected a value, found ','");
  EXPECT_EQ(at("[\n"), "2:1 the text ends here, where a value or ']' is missing");
  EXPECT_EQ(at("[\r\n1 2"), "2:3 expected ',' or ']', found '2'");
  EXPECT_EQ(at("x\n\n"), "1:1 expected a value, found 'x'");
}

TEST(JsonFault, names_what_is_missing_at_the_end_of_the_text) {
  EXPECT_EQ(at(""), "1:1 the text ends here, where a value is missing");
  EXPECT_EQ(at("[1,"), "1:4 the text ends here, where a value is missing");
  EXPECT_EQ(at("["), "1:2 the text ends here, where a value or ']' is missing");
  EXPECT_EQ(at("{"), "1:2 the text ends here, where a name in quotes or '}' is missing");
  EXPECT_EQ(at("{\"a\":1,"), "1:8 the text ends here, where a name in quotes is missing");
  EXPECT_EQ(at("{\"a\""), "1:5 the text ends here, where ':' is missing");
  EXPECT_EQ(at("{\"a\":"), "1:6 the text ends here, where a value is missing");
  EXPECT_EQ(at("{\"a\":1"), "1:7 the text ends here, where ',' or '}' is missing");
  EXPECT_EQ(at("[{}"), "1:4 the text ends here, where ',' or ']' is missing");
}

TEST(JsonFault, names_what_is_expected_instead_of_what_is_found) {
  EXPECT_EQ(at("[}"), "1:2 expected a value or ']', found '}'");
  EXPECT_EQ(at("{]"), "1:2 expected a name in quotes or '}', found ']'");
  EXPECT_EQ(at("{1"), "1:2 expected a name in quotes or '}', found '1'");
  EXPECT_EQ(at("{\"a\" 1}"), "1:6 expected ':', found '1'");
  EXPECT_EQ(at("{\"a\":}"), "1:6 expected a value, found '}'");
  EXPECT_EQ(at("{\"a\":]"), "1:6 expected a value, found ']'");
  EXPECT_EQ(at("{\"a\":1]"), "1:7 expected ',' or '}', found ']'");
  EXPECT_EQ(at("[1}"), "1:3 expected ',' or ']', found '}'");
  EXPECT_EQ(at("{\"a\":1,2"), "1:8 expected a name in quotes, found '2'");
  EXPECT_EQ(at("[]]"), "1:3 expected nothing more after the document's end");
  EXPECT_EQ(at("1 2"), "1:3 expected nothing more after the document's end");
  EXPECT_EQ(at("[tru]"), "1:2 expected a value or ']', found 't'");
  EXPECT_EQ(at("[nul"), "1:2 expected a value or ']', found 'n'");
  // The first and the last printable character, and their neighbours.
  EXPECT_EQ(at("~"), "1:1 expected a value, found '~'");
  EXPECT_EQ(at("!"), "1:1 expected a value, found '!'");
  EXPECT_EQ(at("{\"a\"\x7F"), "1:5 expected ':', found no character that is allowed here");
  EXPECT_EQ(at("\x1F"), "1:1 expected a value, found no character that is allowed here");
  EXPECT_EQ(at("\xC3\xA4"), "1:1 expected a value, found no character that is allowed here");
}

TEST(JsonFault, is_a_nesting_deeper_than_allowed) {
  EXPECT_EQ(at("[[[]]]", 3), "none");
  EXPECT_EQ(at("[[[[", 3), "1:4 nested deeper than 3");
  EXPECT_EQ(at("{\"a\":[{", 2), "1:7 nested deeper than 2");
  EXPECT_EQ(at("[[],[],[[]]]", 3), "none");  // depth, not number
  EXPECT_EQ(at(std::string(64, '[') + std::string(64, ']')), "none");
  EXPECT_EQ(at(std::string(65, '[')), "1:65 nested deeper than 64");
}

TEST(JsonFault, is_a_number_in_another_form_than_json_s) {
  for (const char* number : {"-", "-x", "00", "01", "-01", "1.", "1.x", "-.5", "1e", "1e+", "1E-x", "1.5e", "0.e1"})
    EXPECT_EQ(at("[" + std::string(number) + "]"), "1:2 no valid JSON number") << number;
  EXPECT_EQ(at("[.5]"), "1:2 expected a value or ']', found '.'");
  EXPECT_EQ(at("[+5]"), "1:2 expected a value or ']', found '+'");
  EXPECT_EQ(at("[1e999]"), "1:2 a number that is too large");
  EXPECT_EQ(at("[1, -1E400]"), "1:5 a number that is too large");
  EXPECT_EQ(at("[1e308]"), "none");
  EXPECT_EQ(at("[0x1]"), "1:3 expected ',' or ']', found 'x'");
  EXPECT_EQ(at("[1 .5]"), "1:4 expected ',' or ']', found '.'");
}

TEST(JsonFault, is_an_escape_unknown_to_json) {
  for (const char* escape :
       {"\\x", "\\'", "\\0", "\\u", "\\u12", "\\u123", "\\u12g4", "\\U1234", "\\u123g", "\\ug1234"})
    EXPECT_EQ(at("[\"a" + std::string(escape) + "\"]"), "1:4 a backslash that begins no escape") << escape;
  EXPECT_EQ(at("\"\\"), "1:2 a backslash that begins no escape");
  EXPECT_EQ(at("\"\\u1234"), "1:1 a text in quotes that never ends");
  EXPECT_EQ(at("\"\\n"), "1:1 a text in quotes that never ends");
  // An escaped quote does not end the text.
  EXPECT_EQ(at("[\"a\\\""), "1:2 a text in quotes that never ends");
  EXPECT_EQ(at("{\"a\\\"\":1}"), "none");
}

TEST(JsonFault, is_a_control_character_in_quotes) {
  for (int c = 0; c < 0x20; ++c)
    EXPECT_EQ(at("\"" + std::string(1, static_cast<char>(c)) + "\""),
              "1:2 a line break or control character within a text in quotes")
        << c;
  EXPECT_EQ(at("\" \""), "none");
}

// RFC 3629: the shortest and the longest form of each length, and its neighbours.
TEST(JsonFault, is_a_text_that_is_not_utf_8) {
  for (const char* good :
       {"\xC2\x80", "\xDF\xBF", "\xE0\xA0\x80", "\xEF\xBF\xBD", "\xF0\x90\x80\x80", "\xF4\x8F\xBF\xBF"})
    EXPECT_EQ(at("\"" + std::string(good) + "\""), "none") << good;
  for (const char* bad :
       {"\x80", "\x80\x80", "\xBF", "\xC0\x80", "\xC1\xBF", "\xF5\x80\x80\x80", "\xFF", "\xC2", "\xC2z", "\xC2\xC0",
        "\xE0\xA0", "\xE0\xA0z", "\xE0z\x80", "\xF0\x90\x80", "\xF0\x90\x80z", "\xF0\x90z\x80"})
    EXPECT_EQ(at("\"" + std::string(bad) + "\""), "1:2 bytes that are not UTF-8; save the file as UTF-8") << bad;
  // Cut off within a character, at the end of the text.
  EXPECT_EQ(at("\"\xC2"), "1:2 bytes that are not UTF-8; save the file as UTF-8");
  EXPECT_EQ(at("\"\xF0\x90\x80"), "1:2 bytes that are not UTF-8; save the file as UTF-8");
  // A column counts bytes.
  EXPECT_EQ(at("[\"\xC3\xA4\", x]"), "1:8 expected a value, found 'x'");
}

TEST(JsonFault, is_a_character_that_goes_on_only_beyond_the_end_of_the_text) {
  const std::string utf8 = "bytes that are not UTF-8; save the file as UTF-8";
  EXPECT_EQ(at(std::string_view{"\"\xC3\xA4\""}.substr(0, 2)), "1:2 " + utf8);
  EXPECT_EQ(at(std::string_view{"\"\xE0\xA0\x80\""}.substr(0, 3)), "1:2 " + utf8);
  EXPECT_EQ(at(std::string_view{"\"\xC3\xA4\""}.substr(0, 3)), "1:1 a text in quotes that never ends");
}

TEST(JsonFault, is_no_number_that_is_too_small) {
  EXPECT_EQ(at("[1e-999]"), "none");
  EXPECT_EQ(at("[-1E-400, x]"), "1:11 expected a value, found 'x'");
}

}  // namespace
}  // namespace cosiva::zone::lif
