#include "cosiva/aiv/order/action_catalogue.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>

namespace cosiva::aiv {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

wire::Action of(std::string type, std::vector<wire::Parameter> parameters = {}) {
  return {std::move(type), "1", "", wire::BlockingType::hard, std::move(parameters)};
}
Result<ActionCatalogue> read(std::string_view json) { return action_catalogue_from_json(*JsonValue::parse(json)); }
std::string refusal(std::string_view json) {
  const auto catalogue = read(json);
  return catalogue ? "read" : catalogue.error().code + ": " + catalogue.error().message;
}

TEST(UsualActions, have_the_scopes_of_par_6_8_1) {
  struct Scope {
    const char* name;
    bool instant;
    bool node;
    bool edge;
  };
  for (const Scope& scope :
       {Scope{"startCharging", true, true, false}, Scope{"stopCharging", true, true, false},
        Scope{"pick", false, true, true}, Scope{"drop", false, true, true}, Scope{"detectObject", false, true, true},
        Scope{"finePositioning", false, true, true}, Scope{"waitForTrigger", false, true, false}}) {
    const ActionCatalogue usual = usual_actions();
    const ActionType* type = find_action(usual, scope.name);
    ASSERT_NE(type, nullptr) << scope.name;
    EXPECT_EQ(type->instant, scope.instant) << scope.name;
    EXPECT_EQ(type->at_nodes, scope.node) << scope.name;
    EXPECT_EQ(type->on_edges, scope.edge) << scope.name;
    EXPECT_EQ(check_action(usual, of(scope.name), ActionScope::edge).has_value(), scope.edge) << scope.name;
  }
}

TEST(UsualActions, pause_where_par_6_8_2_has_an_entry_under_paused) {
  for (const ActionType& type : usual_actions().types) {
    const bool pauses =
        type.name == "pick" || type.name == "drop" || type.name == "finePositioning" || type.name == "noop";
    EXPECT_EQ(type.pausable, pauses) << type.name;
  }
}

TEST(CheckAction, par_6_6_4_2_names_what_the_vehicle_cannot_perform) {
  const ActionCatalogue usual = usual_actions();
  EXPECT_TRUE(check_action(usual, of("pick", {{"lhd", std::string("deck")}}), ActionScope::node));
  EXPECT_EQ(check_action(usual, of("honk"), ActionScope::node).error().message, "action 'honk' (1) is not supported");
  EXPECT_EQ(check_action(usual, of("waitForTrigger"), ActionScope::edge).error().message,
            "action 'waitForTrigger' (1) is not supported on edges");
  EXPECT_EQ(check_action(usual, of("drop", {{"lhd", std::string("fork")}}), ActionScope::node).error(),
            (Error{"orderError", "action 'drop' (1): there is no load handling device 'fork'", ""}));
}

TEST(ActionCatalogue, of_a_vehicle_without_load_handling_devices_has_no_pick_and_no_drop) {
  ActionCatalogue catalogue = usual_actions();
  catalogue.load_positions.clear();
  remove_impossible(catalogue);
  EXPECT_EQ(find_action(catalogue, "pick"), nullptr);
  EXPECT_EQ(find_action(catalogue, "drop"), nullptr);
  EXPECT_NE(find_action(catalogue, "noop"), nullptr);
}

TEST(ActionCatalogue, is_read_as_it_was_written) {
  ActionCatalogue catalogue = usual_actions();
  catalogue.load_positions = {"front", "back"};
  catalogue.types[0].duration = std::chrono::milliseconds{1234};
  ActionType own = action_named("polish");
  own.on_edges = true;
  own.at_nodes = false;
  own.description = "polishes \"the\" floor";
  own.preparation = std::chrono::seconds{2};
  own.duration = std::chrono::hours{24};
  catalogue.types.push_back(own);
  JsonWriter json;
  write_json(json, catalogue);
  const auto again = read(json.text());
  ASSERT_TRUE(again) << to_string(again.error());
  EXPECT_EQ(*again, catalogue);
}

TEST(ActionCatalogue, that_cannot_be_used_is_refused_with_the_reason) {
  EXPECT_EQ(refusal(R"({"types":[],"load_positions":[]})"), "read");
  for (const char* json :
       {R"({})", R"({"types":{},"load_positions":[]})", R"({"types":[],"load_positions":7})", R"([])"})
    EXPECT_THAT(refusal(json), HasSubstr("an object with the arrays")) << json;
  for (const char* type :
       {R"({"name":"a b","preparation_ms":0,"duration_ms":1})", R"({"preparation_ms":0,"duration_ms":1})",
        R"({"name":"cancelOrder","preparation_ms":0,"duration_ms":1})", R"({"name":"a","duration_ms":1})",
        R"({"name":"a","preparation_ms":-1,"duration_ms":1})"})
    EXPECT_THAT(refusal("{\"types\":[" + std::string(type) + "],\"load_positions\":[]}"),
                HasSubstr("with a name of their own"))
        << type;
  for (const char* type : {R"({"name":"a","preparation_ms":0})", R"({"name":"a","preparation_ms":0,"duration_ms":"1"})",
                           R"({"name":"waitForTrigger","preparation_ms":0,"duration_ms":86400001})"})
    EXPECT_THAT(refusal("{\"types\":[" + std::string(type) + "],\"load_positions\":[]}"), HasSubstr("a duration_ms"))
        << type;
  EXPECT_THAT(refusal(R"({"types":[{"name":"a","preparation_ms":0,"duration_ms":1},
                                   {"name":"a","preparation_ms":0,"duration_ms":1}],"load_positions":[]})"),
              HasSubstr("each type once"));
  EXPECT_THAT(refusal(R"({"types":[],"load_positions":["a","a"]})"), HasSubstr("each load position once"));
  EXPECT_THAT(refusal(R"({"types":[],"load_positions":[""]})"), HasSubstr("names of load positions"));
  std::string many = "[0";
  for (int i = 0; i < 64; ++i) many += ",0";
  EXPECT_THAT(refusal("{\"types\":" + many + "],\"load_positions\":[]}"), HasSubstr("at most 64"));
}

TEST(ActionNames, are_short_and_plain) {
  EXPECT_TRUE(valid_action_name("my.action-2"));
  for (const char* name : {"", "with space", "quote\"", "umlaut\xC3\xBC"})
    EXPECT_FALSE(valid_action_name(name)) << name;
}

}  // namespace
}  // namespace cosiva::aiv
