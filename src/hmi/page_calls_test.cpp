#include "cosiva/hmi/page_calls.h"

#include <gmock/gmock.h>
#include <sys/stat.h>

#include <cstdlib>
#include <fstream>
#include <map>

#include "cosiva/adapters/files.h"
#include "cosiva/adapters/test_fixture.h"
#include "cosiva/base/json_parse_count.h"
#include "cosiva/base/test_paths.h"
#include "cosiva/hmi/http_responses.h"
#include "cosiva/hmi/page_fixture.h"

namespace cosiva::app {
namespace {

using adapters::HttpResponse;
using adapters::testing::Scratch;
using fixture::PageFixture;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

std::string allow_of(const HttpResponse& response) {
  for (const auto& [name, value] : response.headers)
    if (name == "Allow") return value;
  return {};
}

TEST(PageCalls, that_do_not_exist_or_have_a_wrong_method_are_refused_with_the_alternatives) {
  PageFixture page;
  EXPECT_EQ(page.send_request("GET", "/api/v1/nothing").status, 404U);
  EXPECT_EQ(page.send_request("GET", "/api%2Fv1/zone").status, 404U);
  EXPECT_EQ(page.send_request("GET", "/api/v1/virtual-objects/a/b").status, 404U);
  const HttpResponse wrong = page.send_request("PATCH", "/api/v1/virtual-objects");
  EXPECT_EQ(wrong.status, 405U);
  EXPECT_EQ(allow_of(wrong), "POST, DELETE");
  EXPECT_THAT(PageFixture::sentence(wrong), HasSubstr("POST, DELETE"));
}

TEST(PageCalls, respond_with_the_present_state) {
  PageFixture page;
  for (const char* what : {"zone", "snapshot", "bijection", "run", "zones", "traces", "traces?after=3&limit=5"}) {
    const HttpResponse response = page.send_request("GET", std::string("/api/v1/") + what);
    EXPECT_EQ(response.status, 200U) << what;
    EXPECT_TRUE(JsonValue::parse(response.body)) << what;
  }
  const auto run = JsonValue::parse(page.send_request("GET", "/api/v1/run").body);
  EXPECT_EQ(run->text("name"), "bench");
  EXPECT_TRUE(run->find("scenario")->is_null());
  EXPECT_EQ(run->find("clock")->text("kind"), "virtual");
  EXPECT_EQ(run->find("clock")->number("time_ms"),
            static_cast<double>(page.server.now.time_since_epoch().count()) / 1e6);
}

TEST(PageCalls, require_whole_numbers_of_traces) {
  PageFixture page;
  EXPECT_EQ(page.send_request("GET", "/api/v1/traces?after=-1").status, 400U);
  EXPECT_EQ(page.send_request("GET", "/api/v1/traces?limit=many").status, 400U);
  EXPECT_EQ(page.send_request("GET", "/api/v1/traces/first").status, 400U);
  EXPECT_EQ(page.send_request("GET", "/api/v1/traces/").status, 200U);  // the slash at the end is ignored
  EXPECT_EQ(page.send_request("GET", "/api/v1/traces/999999999").status, 404U);
  EXPECT_EQ(page.send_request("GET", "/api/v1/traces/99999999999999999999999").status, 400U);
}

TEST(PageCalls, return_one_of_the_traces_whole) {
  PageFixture page;
  const auto list = JsonValue::parse(page.send_request("GET", "/api/v1/traces?after=0&limit=1").body);
  const auto n = static_cast<int>(*list->find("traces")->array()->front().number("n"));
  const HttpResponse response = page.send_request("GET", "/api/v1/traces/" + std::to_string(n));
  EXPECT_EQ(response.status, 200U);
  const auto whole = JsonValue::parse(response.body);
  EXPECT_EQ(whole->number("n"), n);
  EXPECT_NE(whole->find("raw"), nullptr);
}

TEST(PageCalls, pass_commands_on_with_an_id_of_their_own) {
  PageFixture page;
  const HttpResponse one =
      page.send_request("POST", "/api/v1/commands", R"({"command":"fast","vehicle":"CoSiVA/AIV1"})");
  EXPECT_EQ(one.status, 202U);
  const std::string id = PageFixture::field_of(one, "id");
  EXPECT_THAT(page.commands, ElementsAre(R"({"id":")" + id + R"(","command":"fast","vehicle":"CoSiVA/AIV1"})"));
  EXPECT_EQ(page.server.command_entry(id).text("vehicle"), "CoSiVA/AIV1");
}

TEST(PageCalls, pass_the_speed_of_a_limit_on_and_refuse_a_limit_without_one) {
  PageFixture page;
  const std::string limit = R"({"command":"limit","vehicle":"CoSiVA/AIV1","speed":0.25})";
  const std::string id = PageFixture::field_of(page.send_request("POST", "/api/v1/commands", limit), "id");
  EXPECT_THAT(page.commands,
              ElementsAre(R"({"id":")" + id + R"(","command":"limit","vehicle":"CoSiVA/AIV1","speed":0.25})"));
  const auto refused = page.send_request("POST", "/api/v1/commands", R"({"command":"limit","vehicle":"CoSiVA/AIV1"})");
  EXPECT_EQ(refused.status, 400U);
}

TEST(PageCalls, give_a_command_to_several_vehicles_if_all_are_known) {
  PageFixture page;
  const std::string both = R"({"command":"slow","vehicles":["CoSiVA/AIV1","CoSiVA/AIV2"]})";
  const std::string id = PageFixture::field_of(page.send_request("POST", "/api/v1/commands", both), "id");
  EXPECT_THAT(page.commands,
              ElementsAre(R"({"id":")" + id + R"(","command":"slow","vehicles":["CoSiVA/AIV1","CoSiVA/AIV2"]})"));
  EXPECT_EQ(page.server.command_entry(id + ".AIV2").text("vehicle"), "CoSiVA/AIV2");
  page.commands.clear();
  const HttpResponse half =
      page.send_request("POST", "/api/v1/commands", R"({"command":"slow","vehicles":["CoSiVA/AIV1","CoSiVA/AIV9"]})");
  EXPECT_EQ(half.status, 400U);
  EXPECT_THAT(PageFixture::sentence(half), HasSubstr("CoSiVA/AIV9"));
  EXPECT_THAT(page.commands, IsEmpty());
}

TEST(PageCalls, accept_a_stop_of_an_absent_vehicle_which_holds_when_the_vehicle_is_back) {
  PageFixture page;
  page.server.kill(*page.server.vehicles[0]);
  page.server.run_for(std::chrono::seconds{2});
  const HttpResponse response =
      page.send_request("POST", "/api/v1/commands", R"({"command":"stop","vehicle":"CoSiVA/AIV1"})");
  EXPECT_EQ(response.status, 202U);
  EXPECT_THAT(page.server.command_entry(PageFixture::field_of(response, "id")).text("reason").value_or(""),
              HasSubstr("not connected"));
}

TEST(PageCalls, refuse_bodies_that_are_not_an_object) {
  PageFixture page;
  for (const char* bad : {"", "nonsense", "[]", "5", "{", "null", "{}{}"}) {
    for (const auto& [method, path] : std::map<std::string, std::string>{{"POST", "commands"}, {"PUT", "clock"}}) {
      const HttpResponse response = page.send_request(method, "/api/v1/" + path, bad);
      EXPECT_EQ(response.status, 400U) << bad;
      EXPECT_THAT(PageFixture::sentence(response), HasSubstr("JSON object")) << bad;
    }
  }
  EXPECT_THAT(page.commands, IsEmpty());
}

TEST(PageCalls, add_move_and_remove_a_person) {
  PageFixture page;
  const HttpResponse added =
      page.send_request("POST", "/api/v1/virtual-objects", R"({"kind":"person","id":"mine","x":0.4,"y":0.5})");
  EXPECT_EQ(added.status, 201U) << added.body;
  EXPECT_EQ(PageFixture::field_of(added, "id"), "P1");
  EXPECT_EQ(PageFixture::field_of(
                page.send_request("POST", "/api/v1/virtual-objects", R"({"kind":"person","x":0.4,"y":0.6})"), "id"),
            "P2");
  EXPECT_EQ(page.send_request("PATCH", "/api/v1/virtual-objects/P1", R"({"x":0.5,"y":0.5})").status, 200U);
  EXPECT_EQ(page.send_request("PATCH", "/api/v1/virtual-objects/P1", R"({"x":"left"})").status, 400U);
  EXPECT_EQ(page.send_request("PATCH", "/api/v1/virtual-objects/P9", R"({"x":0.5,"y":0.5})").status, 404U);
  EXPECT_EQ(page.send_request("DELETE", "/api/v1/virtual-objects/P1").body, R"({"removed":1})");
  EXPECT_EQ(page.send_request("DELETE", "/api/v1/virtual-objects/P1").status, 404U);
  EXPECT_EQ(page.send_request("DELETE", "/api/v1/virtual-objects").body, R"({"removed":1})");
  EXPECT_EQ(page.send_request("DELETE", "/api/v1/virtual-objects").body, R"({"removed":0})");
}

TEST(PageCalls, accept_both_names_of_a_virtual_aiv) {
  PageFixture page;
  const HttpResponse added = page.send_request("POST", "/api/v1/virtual-objects", R"({"kind":"aiv"})");
  ASSERT_EQ(added.status, 201U) << added.body;
  EXPECT_EQ(PageFixture::field_of(added, "id"), "V1");
  EXPECT_EQ(page.send_request("DELETE", "/api/v1/virtual-objects/CoSiVA.virtual%2FV1").body, R"({"removed":1})");
  EXPECT_EQ(page.send_request("DELETE", "/api/v1/virtual-objects/V1").status, 404U);
}

TEST(PageCalls, add_obstacles_to_an_emulated_world_only) {
  PageFixture page;
  EXPECT_EQ(page.send_request("POST", "/api/v1/plant/obstacles", R"({"x":0.4,"y":0.1})").status, 409U);
  EXPECT_EQ(page.send_request("DELETE", "/api/v1/plant/obstacles/box1").status, 409U);
  page.calls->know_plant({"box1"});
  const HttpResponse added = page.send_request("POST", "/api/v1/plant/obstacles", R"({"x":0.4,"y":0.1})");
  ASSERT_EQ(added.status, 201U) << added.body;
  EXPECT_EQ(PageFixture::field_of(added, "id"), "box2");
  EXPECT_EQ(page.commands.back(), R"({"command":"plant","plant":{"addObstacle":{"id":"box2","x":0.4,"y":0.1}}})");
  page.calls->know_plant({"box1"});  // reported before the world had the obstacle
  EXPECT_EQ(page.send_request("DELETE", "/api/v1/plant/obstacles/box2").body, R"({"removed":1})");
  EXPECT_EQ(page.commands.back(), R"({"command":"plant","plant":{"removeObstacle":"box2"}})");
  EXPECT_EQ(page.send_request("DELETE", "/api/v1/plant/obstacles/box7").status, 404U);
  EXPECT_EQ(page.send_request("POST", "/api/v1/plant/obstacles", R"({"id":"","x":0,"y":0})").status, 400U);
}

TEST(PageCalls, edit_undo_and_redo_the_zone) {
  PageFixture page;
  EXPECT_EQ(page.send_request("POST", "/api/v1/zone/undo").status, 409U);
  const std::string before = page.send_request("GET", "/api/v1/zone/file").body;
  const HttpResponse edited =
      page.send_request("POST", "/api/v1/zone/edit", R"({"addTags":[{"number":900,"section":"east","s":0.5}]})");
  ASSERT_EQ(edited.status, 200U) << edited.body;
  EXPECT_EQ(JsonValue::parse(edited.body)->number("revision"),
            static_cast<double>(page.server.server->zone_revision()));
  EXPECT_NE(page.send_request("GET", "/api/v1/zone/file").body, before);
  EXPECT_EQ(page.send_request("POST", "/api/v1/zone/redo").status, 409U);
  EXPECT_EQ(page.send_request("POST", "/api/v1/zone/undo").status, 200U);
  EXPECT_EQ(page.send_request("GET", "/api/v1/zone/file").body, before);
  EXPECT_EQ(page.send_request("POST", "/api/v1/zone/redo").status, 200U);
  EXPECT_EQ(page.send_request("POST", "/api/v1/zone/edit", "{}").status, 400U);
  for (int i = 0; i < 2; ++i) {  // the second request changes nothing
    const HttpResponse put = page.send_request("PUT", "/api/v1/priorities", R"({"CoSiVA/AIV1":3})");
    EXPECT_EQ(put.status, 200U);
    EXPECT_EQ(put.body, "{}");
  }
  EXPECT_EQ(page.server.aiv("CoSiVA/AIV1").number("priority"), 3.0);
}

TEST(PageCalls, return_the_zones_file_as_a_download) {
  PageFixture page;
  const HttpResponse file = page.send_request("GET", "/api/v1/zone/file");
  EXPECT_EQ(file.content_type, "text/plain; charset=utf-8");
  EXPECT_THAT(file.headers, ElementsAre(std::pair<std::string, std::string>{"Content-Disposition",
                                                                            "attachment; filename=\"lacet4.toml\""}));
  EXPECT_THAT(file.body, HasSubstr("name = \"lacet4\""));
}

TEST(PageCalls, save_the_zone_into_its_own_file_or_name_the_file_that_could_not_be_written) {
  Scratch scratch;
  PageFixture page;
  page.zone_file = scratch.write("mine.toml", "old");
  const HttpResponse saved = page.send_request("POST", "/api/v1/zone/save");
  EXPECT_EQ(saved.status, 200U) << saved.body;
  EXPECT_EQ(PageFixture::field_of(saved, "file"), page.zone_file);
  EXPECT_EQ(*adapters::read_file(page.zone_file), page.send_request("GET", "/api/v1/zone/file").body);
  EXPECT_EQ(page.commands.back(), R"({"command":"saved"})");

  PageFixture other;
  other.zone_file = scratch / "nowhere/mine.toml";
  const HttpResponse failed = other.send_request("POST", "/api/v1/zone/save");
  EXPECT_EQ(failed.status, 500U);
  EXPECT_THAT(PageFixture::sentence(failed), HasSubstr(other.zone_file));
  PageFixture full;
  full.zone_file = "/dev/full/mine.toml";
  EXPECT_EQ(full.send_request("POST", "/api/v1/zone/save").status, 500U);
}

TEST(PageCalls, save_a_ready_zone_into_the_users_folder_and_list_it) {
  Scratch scratch;
  ::setenv("XDG_DATA_HOME", (scratch / "data").c_str(), 1);
  PageFixture page;
  const HttpResponse saved = page.send_request("POST", "/api/v1/zone/save");
  EXPECT_EQ(PageFixture::field_of(saved, "file"), scratch / "data/cosiva/zones/lacet4.toml") << saved.body;
  const std::string mine =
      scratch.write("data/cosiva/zones/mine.toml", "# My control area: with a pit\nname = \"mine\"\n");
  const auto zones = JsonValue::parse(page.send_request("GET", "/api/v1/zones").body);
  std::map<std::string, std::string> titles;
  std::vector<std::string> current;
  for (const JsonValue& zone : *zones->find("zones")->array()) {
    titles[*zone.text("name")] = *zone.text("title");
    if (zone.flag("current") == true) current.push_back(*zone.text("name"));
  }
  EXPECT_EQ(titles["lacet4"], "CircuitLacet4");
  EXPECT_EQ(titles["mine"], "My control area");
  EXPECT_THAT(current, ElementsAre("lacet4"));

  scratch.write("file", "not a folder");
  ::setenv("XDG_DATA_HOME", (scratch / "file").c_str(), 1);
  const HttpResponse failed = page.send_request("POST", "/api/v1/zone/save");
  EXPECT_EQ(failed.status, 500U);
  EXPECT_THAT(PageFixture::sentence(failed), HasSubstr(scratch / "file"));
  ::unsetenv("XDG_DATA_HOME");
}

TEST(PageCalls, change_the_clock_of_virtual_time_and_never_the_walls) {
  PageFixture page;
  EXPECT_EQ(page.send_request("PUT", "/api/v1/clock", R"({"speed":4})").status, 200U);
  EXPECT_EQ(page.clock.speed, 4.0);
  EXPECT_TRUE(page.clock.running);
  EXPECT_EQ(page.send_request("POST", "/api/v1/clock/step", R"({"ms":100})").status, 409U);
  EXPECT_EQ(page.send_request("PUT", "/api/v1/clock", R"({"running":false})").status, 200U);
  EXPECT_EQ(page.clock.speed, 4.0);
  const SimTime before = page.server.now;
  EXPECT_EQ(page.send_request("POST", "/api/v1/clock/step", R"({"ms":100})").status, 200U);
  EXPECT_EQ(page.server.now - before, std::chrono::milliseconds{100});
  for (const char* bad : {"{}", R"({"speed":0})", R"({"speed":101})", R"({"speed":"4"})", R"({"running":1})"})
    EXPECT_EQ(page.send_request("PUT", "/api/v1/clock", bad).status, 400U) << bad;
  for (const char* bad : {"{}", R"({"ms":0})", R"({"ms":10001})", R"({"ms":"1"})"})
    EXPECT_EQ(page.send_request("POST", "/api/v1/clock/step", bad).status, 400U) << bad;

  page.clock = {false, true, 1.0};
  const HttpResponse wall = page.send_request("PUT", "/api/v1/clock", R"({"speed":4})");
  EXPECT_EQ(wall.status, 409U);
  EXPECT_THAT(PageFixture::sentence(wall), HasSubstr("--virtual-time"));
  EXPECT_EQ(page.send_request("POST", "/api/v1/clock/step", R"({"ms":100})").status, 409U);
}

TEST(PageCalls, pass_missions_and_closed_sections_on) {
  PageFixture page;
  EXPECT_EQ(page.send_request("POST", "/api/v1/commands", R"({"command":"close","section":"east"})").status, 202U);
  EXPECT_EQ(page.send_request("POST", "/api/v1/commands", R"({"command":"circulate","vehicle":"*"})").status, 202U);
  EXPECT_THAT(page.commands, ElementsAre(HasSubstr(R"(,"command":"close","section":"east"})"), HasSubstr("circulate")));
  for (const char* bad : {R"({"command":"go","vehicle":"CoSiVA/AIV1","to":"nowhere"})",
                          R"({"command":"go","vehicle":"CoSiVA/AIV1"})", R"({"command":"open","section":"nowhere"})",
                          R"({"command":"circulate","vehicle":"CoSiVA/AIV1","loop":"nowhere"})"}) {
    const HttpResponse response = page.send_request("POST", "/api/v1/commands", bad);
    EXPECT_GE(response.status, 400U) << bad;
    EXPECT_THAT(PageFixture::sentence(response), Not(IsEmpty())) << bad;
  }
}

TEST(PageCalls, switch_to_a_ready_zone_by_its_name) {
  PageFixture page;
  const HttpResponse response = page.send_request("POST", "/api/v1/zone/switch", R"({"name":"indus8"})");
  ASSERT_EQ(response.status, 200U) << response.body;
  EXPECT_EQ(PageFixture::field_of(response, "name"), "indus8");
  EXPECT_EQ(page.server.server->zone()->name, "indus8");
  const auto zones = JsonValue::parse(page.send_request("GET", "/api/v1/zones").body);
  for (const JsonValue& one : *zones->find("zones")->array())
    EXPECT_EQ(one.flag("current"), one.text("name") == "indus8") << *one.text("name");
}

TEST(PageCalls, read_no_file_of_this_machine_for_a_client_that_names_a_zone) {
  PageFixture page;
  for (const char* name : {"zones/lacet4.toml", "/etc/passwd", "../lacet4", "lacet4.toml", ""})
    EXPECT_EQ(page.send_request("POST", "/api/v1/zone/switch", R"({"name":")" + std::string(name) + R"("})").status,
              400U)
        << name;
  EXPECT_EQ(page.send_request("POST", "/api/v1/zone/switch", R"({"name":"lacet5"})").status, 404U);
  EXPECT_THAT(page.commands, IsEmpty());
}

std::string switch_body(const std::string& file, const std::string& text) {
  JsonWriter json;
  json.begin_object().field("file", file).field("text", text).end_object();
  return json.take();
}

TEST(PageCalls, switch_to_a_zone_that_is_sent_as_a_whole) {
  PageFixture page;
  const std::string text = adapters::read_file(source_dir() + "/zones/indus8.toml").value();
  const HttpResponse response = page.send_request("POST", "/api/v1/zone/switch", switch_body("mine.toml", text));
  EXPECT_EQ(response.status, 200U) << response.body;
  EXPECT_EQ(page.send_request("GET", "/api/v1/zone/file").body, text);
  EXPECT_EQ(page.send_request("GET", "/api/v1/zone/sidecar").status, 404U);
  EXPECT_EQ(page.send_request("POST", "/api/v1/zone/switch", switch_body("mine.txt", text)).status, 400U);
}

TEST(PageCalls, preserve_the_zone_when_another_cannot_be_used_and_state_the_reason) {
  PageFixture page;
  const auto revision = page.server.server->zone_revision();
  const HttpResponse response =
      page.send_request("POST", "/api/v1/zone/switch", switch_body("mine.toml", "name = 3\n"));
  EXPECT_EQ(response.status, 422U);
  EXPECT_THAT(PageFixture::sentence(response), HasSubstr("mine.toml:1"));
  EXPECT_EQ(page.server.server->zone()->name, "lacet4");
  EXPECT_EQ(page.server.server->zone_revision(), revision);
  const auto snapshot = JsonValue::parse(page.server.server->snapshot_json());
  const JsonValue* refused = snapshot->find("zone")->find("refused");
  ASSERT_NE(refused, nullptr);
  EXPECT_THAT(refused->text("why").value_or(""), HasSubstr("format_version")) << "the page shows it to every client";
}

TEST(PageCalls, save_into_the_run_s_file_only_while_its_zone_is_in_force) {
  Scratch scratch;
  ::setenv("XDG_DATA_HOME", (scratch / "data").c_str(), 1);
  PageFixture page;
  const std::string lacet4 = adapters::read_file(source_dir() + "/zones/lacet4.toml").value();
  page.zone_file = scratch.write("mine.toml", lacet4);
  ASSERT_EQ(page.send_request("POST", "/api/v1/zone/switch", R"({"name":"indus8"})").status, 200U);
  EXPECT_EQ(PageFixture::field_of(page.send_request("POST", "/api/v1/zone/save"), "file"),
            scratch / "data/cosiva/zones/indus8.toml");
  EXPECT_EQ(adapters::read_file(page.zone_file).value(), lacet4);
  ::unsetenv("XDG_DATA_HOME");
  ASSERT_EQ(page.send_request("POST", "/api/v1/zone/switch", switch_body("mine.toml", lacet4)).status, 200U);
  EXPECT_EQ(PageFixture::field_of(page.send_request("POST", "/api/v1/zone/save"), "file"), page.zone_file);
}

TEST(PageCalls, suggest_an_origin_of_the_beacons) {
  PageFixture page;
  const HttpResponse response = page.send_request("GET", "/api/v1/zone/beacons/suggestion");
  ASSERT_EQ(response.status, 200U) << response.body;
  const auto suggestion = JsonValue::parse(response.body);
  EXPECT_EQ(suggestion->find("origin")->array()->size(), 2U);
  const auto now = suggestion->number("now_m");
  const auto then = suggestion->number("longest_free_m");
  ASSERT_TRUE(then);
  EXPECT_TRUE(!now || *then <= *now);
}

TEST(PageCalls, pass_battery_ready_to_a_battery_test_that_requested_a_battery) {
  PageFixture page;
  const std::string in = R"({"vehicle":"CoSiVA/AIV1","battery":"red","charge":99.5})";
  const HttpResponse unasked = page.send_request("POST", "/api/v1/battery/ready", in);
  EXPECT_EQ(unasked.status, 409U);
  EXPECT_THAT(PageFixture::sentence(unasked), HasSubstr("CoSiVA/AIV1"));
  page.server.feed(wire::InputKind::message, "cosiva/v1/battery/change/CoSiVA/AIV1",
                   R"({"battery":"red","run":1,"reason":""})", true);
  const std::size_t before = page.server.published.size();
  EXPECT_EQ(page.send_request("POST", "/api/v1/battery/ready", in).status, 202U);
  ASSERT_EQ(page.server.published.size(), before + 1);
  EXPECT_EQ(page.server.published.back().topic, "cosiva/v1/battery/fitted/CoSiVA/AIV1");
  EXPECT_THAT(page.server.published.back().payload, HasSubstr(R"("charge":99.5)"));
  EXPECT_EQ(page.send_request("POST", "/api/v1/battery/ready", R"({"vehicle":"CoSiVA/AIV1"})").status, 400U);
}

TEST(PageCalls, return_the_battery_curve_of_a_vehicle_that_reports_its_battery) {
  PageFixture page;
  EXPECT_EQ(page.send_request("GET", "/api/v1/battery/curves/CoSiVA%2FAIV9").status, 404U);
  page.server.feed(wire::InputKind::message, "cosiva/v1/boards/CoSiVA/AIV1",
                   R"({"headerId":1,"timestamp":"2026-01-01T00:00:00.000Z","boards":[],)"
                   R"("power":{"voltage":12.1,"current":0.4,"temperature":24.0,"charge":87.0}})");
  const HttpResponse curve = page.send_request("GET", "/api/v1/battery/curves/CoSiVA%2FAIV1");
  EXPECT_EQ(curve.status, 200U) << curve.body;
  EXPECT_THAT(curve.body, HasSubstr("87,12.1,24]"));
}

TEST(PageCalls, return_the_camera_s_image_unchanged_none_before_the_first_and_the_reason_where_there_is_no_camera) {
  PageFixture page;
  const HttpResponse none = page.send_request("GET", "/api/v1/gvs/preview");
  EXPECT_EQ(none.status, 404U);
  EXPECT_THAT(PageFixture::sentence(none), HasSubstr("cosiva up --gvs"));
  const auto image = std::make_shared<const std::string>("P5\n# {}\n1 1\n255\n\x80");
  int checks = 0;
  PageHost host = page.host();
  host.gvs_preview = [&] { return ++checks > 1 ? image : nullptr; };
  page.calls.emplace(std::move(host));
  const HttpResponse before = page.send_request("GET", "/api/v1/gvs/preview");
  EXPECT_EQ(before.status, 204U) << "the first request starts the preview";
  EXPECT_EQ(before.body, "");
  const HttpResponse shown = page.send_request("GET", "/api/v1/gvs/preview");
  EXPECT_EQ(shown.status, 200U);
  EXPECT_EQ(shown.content_type, "image/x-portable-graymap");
  EXPECT_EQ(shown.body, *image);
}

TEST(PageCommands, are_parsed_once_after_the_request_s_body) {
  PageFixture page;
  const auto parses = [&](const char* method, const char* target, const std::string& body) {
    const std::uint64_t before = json_parse_count();
    const auto response = page.send_request(method, target, body);
    EXPECT_LT(response.status, 300U) << target << ": " << PageFixture::sentence(response);
    return json_parse_count() - before;
  };
  EXPECT_EQ(parses("POST", "/api/v1/commands", R"({"command":"stop","vehicle":"CoSiVA/AIV1"})"), 2U);
  EXPECT_EQ(parses("POST", "/api/v1/virtual-objects", R"({"kind":"person","x":0.9,"y":-0.9})"), 2U);
  EXPECT_EQ(parses("DELETE", "/api/v1/virtual-objects/P1", ""), 1U) << "without a body";
}

}  // namespace
}  // namespace cosiva::app
