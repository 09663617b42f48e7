#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <limits>

#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/base/random.h"

namespace cosiva {
namespace {

std::string as_json(std::string_view text) {
  std::string out;
  append_json_string(out, text);
  return out;
}

JsonValue parsed(std::string_view text) {
  auto value = JsonValue::parse(text);
  EXPECT_TRUE(value) << text;
  return value ? std::move(*value) : JsonValue{};
}

// Writing
// -----------------------------------------------------------------------------------------------------------------

TEST(JsonWriter, writes_in_the_order_of_the_calls) {
  JsonWriter json;
  json.begin_object()
      .field("matched", 4)
      .key("list")
      .begin_array()
      .value(1.5)
      .value(true)
      .null()
      .value("x")
      .end_array();
  json.key("empty").begin_object().end_object().end_object();
  EXPECT_EQ(json.text(), R"({"matched":4,"list":[1.5,true,null,"x"],"empty":{}})");
  EXPECT_TRUE(json.complete());
}

TEST(JsonWriter, indents_when_requested) {
  JsonWriter json{2};
  json.begin_object()
      .field("a", 1)
      .key("b")
      .begin_array()
      .value(2)
      .value(3)
      .end_array()
      .key("c")
      .begin_array()
      .end_array();
  json.end_object();
  EXPECT_EQ(json.text(), "{\n  \"a\": 1,\n  \"b\": [\n    2,\n    3\n  ],\n  \"c\": []\n}");
}

TEST(JsonWriter, writes_whole_numbers_in_full) {
  JsonWriter json;
  json.begin_array();
  json.value(std::numeric_limits<std::int64_t>::min()).value(std::numeric_limits<std::uint64_t>::max());
  json.value(std::uint8_t{200}).end_array();
  EXPECT_EQ(json.text(), "[-9223372036854775808,18446744073709551615,200]");
}

TEST(JsonWriter, writes_numbers_so_that_they_read_back_to_the_same_bits) {
  EXPECT_TRUE(rc::check([] {
    Random random{*rc::gen::arbitrary<std::uint64_t>(), "json_test"};
    const double number = std::ldexp(random.uniform(-1.0, 1.0), static_cast<int>(random.below(600)) - 300);
    JsonWriter json;
    json.value(number);
    const JsonValue back = parsed(json.text());
    RC_ASSERT(back.number() != nullptr && *back.number() == number);
  }));
}

TEST(JsonWriter, writes_large_numbers_so_that_no_reader_takes_them_for_integers) {
  for (const double number : {9.2e17, 1e18, -9.21067857610312515584e20, 1e22, 1.7e308}) {
    JsonWriter json;
    json.value(number);
    EXPECT_EQ(*parsed(json.text()).number(), number) << json.text();
  }
}

TEST(JsonWriter, writes_null_for_non_finite_numbers) {
  JsonWriter json;
  json.begin_array().value(std::numeric_limits<double>::quiet_NaN());
  json.value(std::numeric_limits<double>::infinity()).value(-0.0).end_array();
  EXPECT_EQ(json.text(), "[null,null,-0]");
}

TEST(JsonWriter, escapes_special_characters) {
  EXPECT_EQ(as_json("a\"b\\c\n\r\t\x01\x1F"), R"("a\"b\\c\n\r\t\u0001\u001f")");
  EXPECT_EQ(as_json("é€😀"), "\"é€😀\"");
}

TEST(JsonWriter, replaces_invalid_utf8) {
  const std::string bad = "\xEF\xBF\xBD";
  EXPECT_EQ(as_json("\xFF"), '"' + bad + '"');
  EXPECT_EQ(as_json("\xC3"), '"' + bad + '"');            // truncated
  EXPECT_EQ(as_json("\xC0\xAF"), '"' + bad + bad + '"');  // overlong '/'
  EXPECT_EQ(as_json("\xE0\x80\xAF"), '"' + bad + bad + bad + '"');
  EXPECT_EQ(as_json("\xED\xA0\x80"), '"' + bad + bad + bad + '"');            // a surrogate
  EXPECT_EQ(as_json("\xF4\x90\x80\x80"), '"' + bad + bad + bad + bad + '"');  // beyond U+10FFFF
  EXPECT_EQ(as_json("\xC3(x"), '"' + bad + "(x\"");
}

TEST(JsonWriter, always_writes_valid_json) {
  EXPECT_TRUE(rc::check([] {
    Random random{*rc::gen::arbitrary<std::uint64_t>(), "json_test"};
    std::string text(random.below(40), ' ');
    for (char& c : text) c = static_cast<char>(random.below(256));
    RC_ASSERT(JsonValue::parse(as_json(text)).has_value());
  }));
}

TEST(JsonWriterDeathTest, aborts_on_misuse) {
  EXPECT_DEATH(JsonWriter{}.begin_object().value(1), "expectation");
  EXPECT_DEATH(JsonWriter{}.begin_array().key("a"), "expectation");
  EXPECT_DEATH(JsonWriter{}.begin_array().end_object(), "expectation");
  EXPECT_DEATH(JsonWriter{}.begin_object().key("a").end_object(), "expectation");
  EXPECT_DEATH(JsonWriter{}.value(1).value(2), "expectation");
}

// Reading
// -----------------------------------------------------------------------------------------------------------------

TEST(JsonValue, reads_every_kind) {
  const JsonValue value =
      parsed(R"({"n":-1.5e3,"i":7,"u":18446744073709551615,"t":"é\u0041","f":false,"z":null,"a":[1,[2]]})");
  EXPECT_EQ(value.number("n"), -1500.0);
  EXPECT_EQ(value.number("i"), 7.0);
  EXPECT_EQ(value.number("u"), 18446744073709551615.0);
  EXPECT_EQ(value.text("t"), "éA");
  EXPECT_EQ(value.flag("f"), false);
  ASSERT_NE(value.find("z"), nullptr);
  EXPECT_TRUE(value.find("z")->is_null());
  EXPECT_EQ(value.find("a")->array()->size(), 2U);
}

TEST(JsonValue, preserves_the_order_of_members) {
  const JsonValue value = parsed(R"({"b":1,"a":2})");
  EXPECT_EQ(value.object()->front().first, "b");
}

TEST(JsonValue, finds_nothing_for_members_that_are_missing_or_of_another_kind) {
  const JsonValue value = parsed(R"({"n":1,"t":"x"})");
  EXPECT_EQ(value.find("m"), nullptr);
  EXPECT_EQ(value.number("t"), std::nullopt);
  EXPECT_EQ(value.text("n"), std::nullopt);
  EXPECT_EQ(value.flag("n"), std::nullopt);
  EXPECT_EQ(parsed("[1]").find("n"), nullptr);
}

TEST(JsonValue, rejects_invalid_documents) {
  for (const char* bad :
       {"", " ", "{", "[1,]", "{\"a\":}", "{'a':1}", "nul", "1 2", "{} {}", "[1", "\"\x01\"", "\"\xFF\"", "01"}) {
    const auto value = JsonValue::parse(bad);
    ASSERT_FALSE(value) << bad;
    EXPECT_EQ(value.error().code, "json.syntax");
  }
}

TEST(JsonValue, rejects_documents_that_are_too_large_or_too_deep) {
  EXPECT_TRUE(JsonValue::parse("[1,2]", 5));
  EXPECT_FALSE(JsonValue::parse("[1,2]", 4));
  EXPECT_TRUE(JsonValue::parse(std::string(60, '[') + std::string(60, ']')));
  EXPECT_FALSE(JsonValue::parse(std::string(100, '[') + std::string(100, ']')));
  EXPECT_FALSE(JsonValue::parse(std::string(1'000'000, '[')));
}

}  // namespace
}  // namespace cosiva
