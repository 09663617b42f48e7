#include "cosiva/base/json_text.h"

#include <gtest/gtest.h>

namespace cosiva {
namespace {

TEST(JsonText, gives_back_a_document_in_its_order) {
  const std::string text = R"({"b":[1.5,true,null,"x\"y"],"a":{"c":[],"d":{}},"e":-3})";
  const auto value = JsonValue::parse(text);
  ASSERT_TRUE(value);
  EXPECT_EQ(to_text(*value), text);
}

TEST(JsonText, copies_a_part_into_a_document_that_is_being_written) {
  const auto value = JsonValue::parse(R"({"part":{"x":[1,2]}})");
  ASSERT_TRUE(value);
  JsonWriter json;
  write_json(json.begin_object().key("copy"), *value->find("part"));
  EXPECT_EQ(json.end_object().take(), R"({"copy":{"x":[1,2]}})");
}

}  // namespace
}  // namespace cosiva
