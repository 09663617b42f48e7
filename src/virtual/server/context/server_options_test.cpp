#include "cosiva/virtual/server/context/server_options.h"

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <string>
#include <string_view>
#include <utility>

#include "cosiva/base/json_value.h"

namespace cosiva::virtual_side {
namespace {

using std::chrono::milliseconds;

/// Every option differs from its default.
ServerOptions unusual_options() {
  ServerOptions options;
  options.interface_name = "plant7";
  options.area = "south";
  options.zone = zone::ZoneConfiguration{"toml", "yard.toml", "name = 7", "[tags]"};
  options.drive = false;
  options.lost_after = milliseconds{2500};
  options.permitted_time = milliseconds{1500};
  options.cycle = milliseconds{100};
  options.contract = {0.25, 1.5, 2.5, 3.5, 4.5, 0.75};
  options.traces_max = 7;
  options.vehicles_max = 12;
  options.entries_expire_after = milliseconds{30'000};
  options.vehicle_messages_per_s_max = 40.5;
  options.map_download_link = "http://example.test/zone";
  options.v2x = false;
  options.convoys = false;
  options.anticipation = false;
  options.virtual_rules = {};
  return options;
}

Error options_error(const std::string& json) {
  const auto read = server_options_from_json(json);
  EXPECT_FALSE(read.has_value()) << json;
  return read ? Error{} : read.error();
}
ServerOptions options_read(const std::string& json) {
  const auto read = server_options_from_json(json);
  EXPECT_TRUE(read.has_value()) << json << ": " << (read ? "" : to_string(read.error()));
  return read.value_or(ServerOptions{});
}
/// The JSON of one field, which is `within` an object.
std::string json_of(std::string_view within, std::string_view field, const std::string& value) {
  const std::string one = "{\"" + std::string(field) + "\":" + value + "}";
  return within.empty() ? one : "{\"" + std::string(within) + "\":" + one + "}";
}

TEST(ServerOptionsJson, has_a_field_for_each_option) {
  const auto json = JsonValue::parse(to_json(unusual_options()));
  ASSERT_TRUE(json.has_value());
  EXPECT_EQ(json->object()->size(), 17U);
  EXPECT_EQ(json->text("interface"), "plant7");
  EXPECT_EQ(json->text("area"), "south");
  EXPECT_EQ(json->find("zone")->text("origin"), "yard.toml");
  EXPECT_EQ(json->flag("drive"), false);
  EXPECT_EQ(json->number("lost_after_ms"), 2500.0);
  EXPECT_EQ(json->number("permitted_time_ms"), 1500.0);
  EXPECT_EQ(json->number("cycle_ms"), 100.0);
  EXPECT_EQ(json->number("traces_max"), 7.0);
  EXPECT_EQ(json->number("vehicles_max"), 12.0);
  EXPECT_DOUBLE_EQ(json->number("entries_expire_after_ms").value_or(0.0), 30'000.0);
  EXPECT_EQ(json->number("vehicle_messages_per_s_max"), 40.5);
  EXPECT_EQ(json->text("map_download_link"), "http://example.test/zone");
  EXPECT_EQ(json->flag("v2x"), false);
  EXPECT_EQ(json->flag("convoys"), false);
  EXPECT_EQ(json->flag("anticipation"), false);
  EXPECT_EQ(json->text("virtual_rules"), "crisp");
  const JsonValue& contract = *json->find("contract");
  EXPECT_EQ(contract.object()->size(), 6U);
  EXPECT_EQ(contract.number("divergence_p99_m"), 0.25);
  EXPECT_EQ(contract.number("age_p99_ms"), 1.5);
  EXPECT_EQ(contract.number("command_p99_ms"), 2.5);
  EXPECT_EQ(contract.number("event_p99_ms"), 3.5);
  EXPECT_EQ(contract.number("effect_p99_ms"), 4.5);
  EXPECT_EQ(contract.number("actual_p99_m"), 0.75);
}

TEST(ServerOptionsJson, leaves_out_area_and_zone_where_there_are_none) {
  const auto json = JsonValue::parse(to_json(ServerOptions{}));
  ASSERT_TRUE(json.has_value());
  EXPECT_EQ(json->find("area"), nullptr);
  EXPECT_EQ(json->find("zone"), nullptr);
  EXPECT_EQ(json->object()->size(), 15U);
}

TEST(ServerOptionsJson, is_read_back) {
  const ServerOptions expected = unusual_options();
  const ServerOptions read = options_read(to_json(expected));
  EXPECT_EQ(read.interface_name, "plant7");
  EXPECT_EQ(read.area, "south");
  EXPECT_EQ(read.zone, expected.zone);
  EXPECT_FALSE(read.drive);
  EXPECT_EQ(read.lost_after, milliseconds{2500});
  EXPECT_EQ(read.permitted_time, milliseconds{1500});
  EXPECT_EQ(read.cycle, milliseconds{100});
  EXPECT_EQ(read.contract.divergence_p99_m, 0.25);
  EXPECT_EQ(read.contract.age_p99_ms, 1.5);
  EXPECT_EQ(read.contract.command_p99_ms, 2.5);
  EXPECT_EQ(read.contract.event_p99_ms, 3.5);
  EXPECT_EQ(read.contract.effect_p99_ms, 4.5);
  EXPECT_EQ(read.contract.actual_p99_m, 0.75);
  EXPECT_EQ(read.traces_max, 7U);
  EXPECT_EQ(read.vehicles_max, 12U);
  EXPECT_EQ(read.entries_expire_after, milliseconds{30'000});
  EXPECT_EQ(read.vehicle_messages_per_s_max, 40.5);
  EXPECT_EQ(read.map_download_link, "http://example.test/zone");
  EXPECT_FALSE(read.v2x);
  EXPECT_FALSE(read.convoys);
  EXPECT_FALSE(read.anticipation);
  EXPECT_EQ(read.virtual_rules.kind, aiv::SpeedRules::Kind::crisp);
}

TEST(ServerOptionsJson, without_fields_or_with_null_fields_means_the_defaults_of_old_journals) {
  for (const std::string json :
       {"{}", R"({"interface":null,"area":null,"zone":null,"drive":null,"lost_after_ms":null,"cycle_ms":null,)"
              R"("contract":null,"traces_max":null,"map_download_link":null,"v2x":null,"convoys":null,)"
              R"("virtual_rules":null})"}) {
    const ServerOptions read = options_read(json);
    EXPECT_EQ(read.interface_name, "");
    EXPECT_EQ(read.area, "");
    EXPECT_FALSE(read.zone.has_value());
    EXPECT_TRUE(read.drive);
    EXPECT_EQ(read.lost_after, milliseconds{1000});
    EXPECT_EQ(read.permitted_time, milliseconds{0});
    EXPECT_EQ(read.cycle, milliseconds{20});
    EXPECT_EQ(read.contract.age_p99_ms, 150.0);
    EXPECT_EQ(read.traces_max, 20'000U);
    EXPECT_EQ(read.vehicles_max, 256U);
    EXPECT_EQ(read.entries_expire_after, milliseconds{0}) << "nothing expires";
    EXPECT_EQ(read.vehicle_messages_per_s_max, 0.0) << "unlimited";
    EXPECT_EQ(read.map_download_link, "");
    EXPECT_FALSE(read.v2x);
    EXPECT_FALSE(read.convoys);
    EXPECT_FALSE(read.anticipation);
    EXPECT_EQ(read.virtual_rules.kind, aiv::SpeedRules::Kind::crisp);
  }
}

TEST(ServerOptionsJson, has_flags_that_can_be_set) {
  const ServerOptions read =
      options_read(R"({"drive":true,"v2x":true,"convoys":true,"anticipation":true,"virtual_rules":"fuzzy"})");
  EXPECT_TRUE(read.drive);
  EXPECT_TRUE(read.v2x);
  EXPECT_TRUE(read.convoys);
  EXPECT_TRUE(read.anticipation);
  EXPECT_EQ(read.virtual_rules.kind, aiv::SpeedRules::Kind::fuzzy);
}

TEST(ServerOptionsJson, has_numbers_above_zero_and_up_to_their_limits) {
  struct Limit {
    std::string_view within;
    std::string_view field;
    const char* max;
    const char* beyond;
  };
  for (const Limit& limit : std::array{
           Limit{"", "lost_after_ms", "3600000", "3600001"}, Limit{"", "permitted_time_ms", "3600000", "3600001"},
           Limit{"", "cycle_ms", "3600000", "3600001"}, Limit{"", "traces_max", "10000000", "10000001"},
           Limit{"", "vehicles_max", "100000", "100001"}, Limit{"contract", "divergence_p99_m", "1000", "1001"},
           Limit{"contract", "age_p99_ms", "10000000", "10000001"},
           Limit{"contract", "command_p99_ms", "10000000", "10000001"},
           Limit{"contract", "event_p99_ms", "10000000", "10000001"},
           Limit{"contract", "effect_p99_ms", "10000000", "10000001"},
           Limit{"contract", "actual_p99_m", "1000", "1001"}}) {
    EXPECT_TRUE(server_options_from_json(json_of(limit.within, limit.field, limit.max)).has_value()) << limit.field;
    for (const char* wrong : {limit.beyond, "0", "-1", "\"1\"", "true"}) {
      const Error error = options_error(json_of(limit.within, limit.field, wrong));
      EXPECT_EQ(error.code, "options.server") << wrong;
      EXPECT_EQ(error.location, limit.field);
    }
  }
}

TEST(ServerOptionsJson, has_zero_for_no_expiry_and_for_no_limit_of_the_rate) {
  ServerOptions options;
  options.entries_expire_after = SimDuration::zero();
  options.vehicle_messages_per_s_max = 0.0;
  const ServerOptions read = options_read(to_json(options));
  EXPECT_EQ(read.entries_expire_after, SimDuration::zero());
  EXPECT_EQ(read.vehicle_messages_per_s_max, 0.0);
  EXPECT_EQ(options_error(R"({"entries_expire_after_ms":-1})").location, "entries_expire_after_ms");
  EXPECT_EQ(options_error(R"({"vehicle_messages_per_s_max":1000001})").location, "vehicle_messages_per_s_max");
  EXPECT_EQ(options_error(R"({"vehicles_max":0.5})").message, "expected at least 1");
}

TEST(ServerOptionsJson, states_the_limits_in_its_errors) {
  EXPECT_EQ(options_error(R"({"contract":{"actual_p99_m":0}})").message,
            "expected a number above 0 and at most 1000.000000");
  EXPECT_EQ(options_error(R"({"cycle_ms":0.5})").message, "expected at least 1");
  EXPECT_EQ(options_error(R"({"contract":[]})"), (Error{"options.server", "expected an object", "contract"}));
  EXPECT_EQ(options_error("[]"), (Error{"options.server", "expected a JSON object with the server's options", ""}));
  EXPECT_EQ(options_error("{").code, "json.syntax");
}

TEST(ServerOptionsJson, has_durations_below_a_millisecond_where_they_are_no_cycle) {
  EXPECT_EQ(options_read(R"({"lost_after_ms":0.5})").lost_after, std::chrono::microseconds{500});
  EXPECT_EQ(options_read(R"({"cycle_ms":1})").cycle, milliseconds{1});
  EXPECT_EQ(options_error(R"({"cycle_ms":0.999})").location, "cycle_ms");
}

TEST(ServerOptionsJson, has_areas_with_names_of_up_to_32_characters) {
  const std::string longest(32, 'a');
  EXPECT_EQ(options_read(json_of("", "area", "\"" + longest + "\"")).area, longest);
  for (const std::string& wrong : {longest + "a", std::string("a/b"), std::string("ä")}) {
    const Error error = options_error(json_of("", "area", "\"" + wrong + "\""));
    EXPECT_EQ(error, (Error{"options.server", "expected a name of A-Z a-z 0-9 _ . : - only, 32 at most", "area"}));
  }
}

TEST(ServerOptionsJson, has_a_zone_and_rules_that_can_be_read) {
  EXPECT_EQ(options_error(R"({"zone":7})").code, "zone.configuration");
  EXPECT_EQ(options_error(R"({"virtual_rules":"none"})").code, "options.rules");
}

}  // namespace
}  // namespace cosiva::virtual_side
