#include "cosiva/zone/rtm/rtm.h"

#include <gtest/gtest.h>

namespace cosiva::zone {
namespace {

TEST(ZoneConfiguration, travels_as_JSON_byte_for_byte) {
  const ZoneConfiguration sent{"toml", "zones/\"odd\".toml", "name = \"é\"\n\t# ±\n"};
  JsonWriter json;
  write_json(json, sent);
  EXPECT_EQ(zone_configuration_from_json(JsonValue::parse(json.text()).value()).value(), sent);
}

TEST(ZoneConfiguration, is_refused_without_its_format_or_text) {
  for (const char* text : {"null", "{}", R"({"format":"toml"})", R"({"text":"x"})", R"({"format":1,"text":"x"})"}) {
    const auto read = zone_configuration_from_json(JsonValue::parse(text).value());
    ASSERT_FALSE(read.has_value()) << text;
    EXPECT_EQ(read.error().code, "zone.configuration");
  }
}

}  // namespace
}  // namespace cosiva::zone
