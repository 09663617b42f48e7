#include "cosiva/aiv/onboard/onboard_options.h"

#include <gtest/gtest.h>

#include <string>

namespace cosiva::aiv {
namespace {

using std::chrono::hours;
using std::chrono::milliseconds;

/// The field that is refused, or "accepted".
std::string location(const std::string& json) {
  const auto options = onboard_options_from_json(json);
  return options ? std::string("accepted") : options.error().location;
}

TEST(OnboardOptions, without_fields_are_those_of_the_first_vehicle) {
  const auto options = onboard_options_from_json("{}");
  ASSERT_TRUE(options);
  EXPECT_EQ(options->number, 1U);
  EXPECT_EQ(options->id, (wire::VehicleId{"CoSiVA", "AIV1"}));
  EXPECT_EQ(options->interface_name, "uagv");
  EXPECT_FALSE(options->zone);
  EXPECT_FALSE(options->start);
  EXPECT_EQ(options->cycle, milliseconds{20});
  EXPECT_EQ(options->visualization_period, milliseconds{100});
  EXPECT_EQ(options->state_period, milliseconds{1000});
  EXPECT_EQ(options->link_timeout, milliseconds{500});
  EXPECT_FALSE(options->as_values);
}

TEST(OnboardOptions, are_written_field_by_field) {
  OnboardOptions options;
  options.number = 7;
  options.id = {"Maker", "S-7"};
  options.interface_name = "twin";
  options.start = OnboardOptions::Start{"east", 0.125};
  options.v2x = false;
  options.cycle = milliseconds{50};
  options.visualization_period = milliseconds{125};
  options.state_period = milliseconds{250};
  options.link_timeout = milliseconds{500};
  const std::string json = to_json(options);
  EXPECT_TRUE(json.starts_with(R"({"number":7,"manufacturer":"Maker","serialNumber":"S-7","interfaceName":"twin",)"
                               R"("start":{"section":"east","s_m":0.125},"rules":)"))
      << json;
  EXPECT_TRUE(json.ends_with(R"("v2x":false,"cycle_ms":50,"visualization_period_ms":125,"state_period_ms":250,)"
                             R"("link_timeout_ms":500})"))
      << json;
  const auto back = onboard_options_from_json(json);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->cycle, milliseconds{50});
  EXPECT_EQ(back->visualization_period, milliseconds{125});
  EXPECT_EQ(back->state_period, milliseconds{250});
  EXPECT_EQ(back->link_timeout, milliseconds{500});
  EXPECT_EQ(back->start->section, "east");
  EXPECT_EQ(back->start->s_m, 0.125);
}

TEST(OnboardOptions, accept_a_number_from_one_to_a_million) {
  EXPECT_EQ(onboard_options_from_json(R"({"number":1})")->number, 1U);
  EXPECT_EQ(onboard_options_from_json(R"({"number":1000000})")->number, 1'000'000U);
  for (const char* bad : {"0", "-1", "0.5", "1.5", "1000001", "\"1\"", "null", "true"})
    EXPECT_EQ(location(R"({"number":)" + std::string(bad) + "}"), "number") << bad;
}

TEST(OnboardOptions, name_the_vehicle_by_its_number_where_no_serial_number_is_given) {
  EXPECT_EQ(onboard_options_from_json(R"({"number":12})")->id.serial_number, "AIV12");
  EXPECT_EQ(onboard_options_from_json(R"({"number":12,"serialNumber":"S"})")->id.serial_number, "S");
}

TEST(OnboardOptions, refuse_empty_or_invalid_names) {
  EXPECT_EQ(location(R"({"serialNumber":""})"), "serialNumber");
  EXPECT_EQ(location(R"({"serialNumber":"a/b"})"), "serialNumber");
  EXPECT_EQ(location(R"({"manufacturer":""})"), "manufacturer, interfaceName");
  EXPECT_EQ(location(R"({"interfaceName":""})"), "manufacturer, interfaceName");
  EXPECT_EQ(location(R"({"manufacturer":"M","interfaceName":"i"})"), "accepted");
}

TEST(OnboardOptions, accept_durations_from_a_millisecond_to_an_hour) {
  for (const char* field : {"cycle_ms", "visualization_period_ms", "state_period_ms", "link_timeout_ms"}) {
    const std::string key = R"({")" + std::string(field) + R"(":)";
    for (const char* good : {"1", "1.5", "3600000"}) EXPECT_EQ(location(key + good + "}"), "accepted") << field << good;
    for (const char* bad : {"0.999", "0", "-1", "3600001", "\"20\"", "null"})
      EXPECT_EQ(location(key + bad + "}"), field) << bad;
  }
  EXPECT_EQ(onboard_options_from_json(R"({"state_period_ms":3600000})")->state_period, hours{1});
  EXPECT_EQ(onboard_options_from_json(R"({"cycle_ms":1})")->cycle, milliseconds{1});
  EXPECT_EQ(onboard_options_from_json(R"({"cycle_ms":0})").error().message, "expected milliseconds from 1 to 3600000");
}

TEST(OnboardOptions, accept_a_start_of_section_and_distance_or_none) {
  EXPECT_EQ(location(R"({"start":null,"zone":null,"rules":null})"), "accepted");
  EXPECT_EQ(location(R"({"start":{"section":"east","s_m":-0.5}})"), "accepted");
  for (const char* bad : {R"({"section":"east"})", R"({"s_m":1})", R"({"section":7,"s_m":1})",
                          R"({"section":"east","s_m":"1"})", "7", "[]"})
    EXPECT_EQ(location(R"({"start":)" + std::string(bad) + "}"), "start") << bad;
}

TEST(OnboardOptions, enable_v2x_only_where_the_field_is_true) {
  EXPECT_TRUE(onboard_options_from_json(R"({"v2x":true})")->v2x);
  EXPECT_FALSE(onboard_options_from_json(R"({"v2x":false})")->v2x);
  EXPECT_FALSE(onboard_options_from_json("{}")->v2x) << "a journal from before V2X";
}

TEST(OnboardOptions, are_one_json_object) {
  for (const char* text : {"", "[]", "null", "7", "{"}) EXPECT_FALSE(onboard_options_from_json(text)) << text;
  EXPECT_EQ(onboard_options_from_json("[]").error().message, "expected an object");
  EXPECT_NE(location(R"({"rules":{"kind":"of thumb"}})"), "accepted");
  EXPECT_EQ(location(R"({"zone":{"format":"toml"}})"), "zone");
}

}  // namespace
}  // namespace cosiva::aiv
