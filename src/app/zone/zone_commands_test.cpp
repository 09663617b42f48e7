#include <gmock/gmock.h>

#include <filesystem>

#include "cosiva/adapters/files.h"
#include "cosiva/adapters/test_fixture.h"
#include "cosiva/app/command_line_fixture.h"
#include "cosiva/app/remote/zone_switch.h"
#include "cosiva/base/json_value.h"
#include "cosiva/drawing/png/svg_to_png.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::app {
namespace {

using adapters::testing::Scratch;
using fixture::CommandOutput;
using fixture::cosiva;
using fixture::zones;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::StartsWith;

const std::string cycle = R"(name = "ring"
format_version = 1
[circuit]
closed = true
[[section]]
name = "south"
kind = "straight"
length_m = 2.0
[[section]]
name = "east"
kind = "arc"
radius_m = 0.5
angle_deg = 180
[[section]]
name = "north"
kind = "straight"
length_m = 2.0
[[section]]
name = "west"
kind = "arc"
radius_m = 0.5
angle_deg = 180
)";

// --- help and invalid terms
// -----------------------------------------------------------------------------------------------

TEST(ZoneCommands, show_examples) {
  for (const char* command : {"check", "show", "convert", "generate", "switch"}) {
    const CommandOutput output = cosiva({"zone", command, "--help"});
    EXPECT_EQ(output.status, 0) << command;
    EXPECT_THAT(output.data, HasSubstr("Examples:\n  cosiva zone " + std::string(command) + " ")) << command;
    EXPECT_EQ(output.standard_error, "") << command;
  }
  EXPECT_THAT(cosiva({"zone", "--help"}).data, HasSubstr(".zone.toml"));
  EXPECT_THAT(cosiva({"zone"}).standard_error, HasSubstr("generate or switch"));
}

TEST(ZoneCommands, with_missing_or_surplus_arguments_end_with_2) {
  const std::vector<std::vector<std::string>> all{
      {"zone", "check"},
      {"zone", "show"},
      {"zone", "convert", zones + "lacet4.toml"},
      {"zone", "generate"},
      {"zone", "switch"},
      {"zone", "show", zones + "lacet4.toml", "--png", "x.png", "--width", "3"},
      {"zone", "generate", "--sections", "0", "-o", "x.toml"},
      {"zone", "generate", "--sections", "100", "--rows", "2", "-o", "x.toml"},
      {"zone", "generate", "--bay-ratio", "2", "-o", "x.toml"},
      {"zone", "generate", "--grid", "6x5", "--loop", "12", "-o", "x.toml"},
      {"zone", "generate", "--grid", "6x5", "--rows", "2", "-o", "x.toml"},
      {"zone", "generate", "--loop", "12", "--two-way", "-o", "x.toml"},
      {"zone", "switch", zones + "lacet4.toml", "--url", "localhost"},
      {"zone", "switch", zones + "lacet4.toml", "--broker", "nowhere:"}};
  for (const auto& arguments : all) {
    const CommandOutput output = cosiva(arguments);
    EXPECT_EQ(output.status, 2) << arguments[1] << " " << arguments.back();
    EXPECT_NE(output.standard_error, "") << arguments[1];
    EXPECT_EQ(output.data, "") << arguments[1];
  }
}

TEST(ZoneCommands, of_a_file_of_unknown_format_name_the_known_endings) {
  Scratch scratch;
  const std::string file = scratch.write("zone.txt", cycle);
  for (const char* command : {"check", "show", "switch"}) {
    const CommandOutput output = cosiva({"zone", command, file});
    EXPECT_EQ(output.status, 2) << command;
    EXPECT_THAT(output.standard_error, HasSubstr(".toml")) << command;
    EXPECT_THAT(output.standard_error, HasSubstr("zone.txt")) << command;
  }
}

// --- check
// ---------------------------------------------------------------------------------------------------------------

TEST(ZoneCheck, reports_the_longest_distance_without_a_tag) {
  Scratch scratch;
  // 2 tags on a loop of 4 + π m: the longer distance is behind the second tag.
  const std::string file = scratch.write("ring.toml", cycle +
                                                          "[[tag]]\nnumber = 1\nsection = \"south\"\ns_m = 0.5\n"
                                                          "[[tag]]\nnumber = 2\nsection = \"north\"\ns_m = 0.5\n"
                                                          "[[tag]]\nnumber = 3\nsection = \"south\"\ns_m = 1.5\n");
  const CommandOutput output = cosiva({"zone", "check", file});
  EXPECT_EQ(output.status, 0) << output.standard_error;
  EXPECT_THAT(output.data, HasSubstr("3 tags, the longest distance without a tag is 3.571 m, from north at 0.500 m"));
  const auto json = JsonValue::parse(cosiva({"zone", "check", file, "--json"}).data);
  ASSERT_TRUE(json);
  EXPECT_NEAR(json->number("longest_tag_free_m").value_or(0.0), 2.0 + 3.14159265358979 / 2.0, 1e-6);
  EXPECT_EQ(json->find("tag_free")->find("from")->text("section"), "north");
  EXPECT_TRUE(json->find("beacon_free")->is_null());
}

TEST(ZoneCheck, lists_every_fault_of_an_unusable_file) {
  Scratch scratch;
  std::string text = cycle;
  text.replace(text.find("closed = true"), 13, "closed = false");
  for (const char* section : {"\"east\"", "\"north\""}) {
    const std::size_t at = text.find(section);
    text.insert(text.find('\n', at) + 1, "start = { x = 9.0, y = 9.0, heading_deg = 0 }\nnext = [\"south\"]\n");
  }
  const std::string file = scratch.write("broken.toml", text);
  const CommandOutput output = cosiva({"zone", "check", file, "--json"});
  EXPECT_EQ(output.status, 2);
  const auto json = JsonValue::parse(output.data);
  ASSERT_TRUE(json) << output.data;
  EXPECT_EQ(json->flag("good"), false);
  EXPECT_GE(json->find("faults")->array()->size(), 2U) << output.standard_error;
  EXPECT_THAT(output.standard_error, HasSubstr("'east'"));
  EXPECT_THAT(output.standard_error, HasSubstr("'north'"));
}

TEST(ZoneCheck, names_stations_that_obstruct_others_and_layouts_that_are_well_formed) {
  Scratch scratch;
  const std::string corridor = scratch.write("corridor.map", "height 1\nwidth 5\nmap\nE.E.E\n");
  const CommandOutput cut = cosiva({"zone", "check", corridor});
  EXPECT_EQ(cut.status, 0);
  EXPECT_THAT(cut.data,
              HasSubstr("a vehicle at station 'S2' cuts off station 'S3' from the others; give the station a bay"));
  EXPECT_THAT(cut.data, Not(HasSubstr("well-formed for")));
  const auto json = JsonValue::parse(cosiva({"zone", "check", corridor, "--json"}).data);
  ASSERT_TRUE(json);
  EXPECT_EQ(json->find("layout")->array()->size(), 2U);
  EXPECT_EQ(*json->find("well_formed")->flag(), false);

  const std::string bays = scratch.write("bays.map", "height 2\nwidth 5\nmap\n.....\nE@E@E\n");
  EXPECT_THAT(cosiva({"zone", "check", bays}).data,
              HasSubstr("well-formed for 3 vehicles: each station can be reached and left while vehicles are stopped"));
  EXPECT_EQ(*JsonValue::parse(cosiva({"zone", "check", bays, "--json"}).data)->find("well_formed")->flag(), true);
}

TEST(ZoneCheck, names_a_station_that_can_be_entered_but_not_left) {
  Scratch scratch;
  const std::string file =
      scratch.write("line.toml",
                    "name = \"line\"\nformat_version = 1\n[[section]]\nname = \"a\"\nkind = "
                    "\"straight\"\nlength_m = 2.0\n[[station]]\nname = \"S7\"\nsection = \"a\"\ns_m = 2\n");
  EXPECT_THAT(cosiva({"zone", "check", file}).data, HasSubstr("station 'S7' can be entered but not left"));
}

TEST(ZoneCheck, warns_of_a_usable_zone_and_ends_with_0) {
  Scratch scratch;
  std::string text = cycle;
  text.replace(text.find("closed = true"), 13, "closed = false");
  const CommandOutput output = cosiva({"zone", "check", scratch.write("open.toml", text)});
  EXPECT_EQ(output.status, 0) << output.standard_error;
  EXPECT_THAT(output.data, HasSubstr("warning"));
  EXPECT_THAT(output.data, HasSubstr("'west'"));
}

// --- show
// ----------------------------------------------------------------------------------------------------------------

TEST(ZoneShow, draws_a_png_of_the_requested_width) {
  Scratch scratch;
  const CommandOutput output = cosiva({"zone", "show", zones + "lacet4.toml", "--png", scratch / "z.png", "--svg",
                                       scratch / "z.svg", "--width", "300"});
  EXPECT_EQ(output.status, 0) << output.standard_error;
  const std::string png = adapters::read_file(scratch / "z.png").value();
  ASSERT_THAT(png, StartsWith("\x89PNG"));
  // The header's width, four bytes with the highest first (RFC 2083, 4.1.1).
  EXPECT_EQ(static_cast<unsigned char>(png[18]) * 256 + static_cast<unsigned char>(png[19]), 300);
  EXPECT_THAT(adapters::read_file(scratch / "z.svg").value(), HasSubstr("</svg>"));
  EXPECT_EQ(output.data, "") << "drawn into files, not to standard output";
}

TEST(ZoneShow, reports_a_file_that_cannot_be_written) {
  Scratch scratch;
  for (const std::string& target : {scratch.path(), std::string("/nonexistent/z.png")}) {
    const CommandOutput output = cosiva({"zone", "show", zones + "lacet4.toml", "--png", target});
    EXPECT_EQ(output.status, 2) << target;
    EXPECT_THAT(output.standard_error, HasSubstr(target));
  }
}

TEST(Image, that_is_invalid_or_too_high_is_refused) {
  EXPECT_EQ(png_of("no picture", 100).error().code, "picture.svg");
  EXPECT_EQ(png_of("<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 1 1000'/>", 100).error().code, "image.size");
}

// --- convert and generate
// ------------------------------------------------------------------------------------------------

TEST(ZoneConvert, writes_the_same_geometry_in_another_format_with_a_sidecar) {
  Scratch scratch;
  const std::string file = scratch / "copy.lif.json";
  const CommandOutput output = cosiva({"zone", "convert", zones + "indus8.toml", file, "--json"});
  ASSERT_EQ(output.status, 0) << output.standard_error;
  const auto reported = JsonValue::parse(output.data);
  ASSERT_TRUE(reported);
  EXPECT_EQ(reported->text("sidecar"), scratch / "copy.zone.toml");
  const auto before = JsonValue::parse(cosiva({"zone", "check", zones + "indus8.toml", "--json"}).data);
  const auto after = JsonValue::parse(cosiva({"zone", "check", file, "--json"}).data);
  ASSERT_TRUE(before && after);
  EXPECT_NEAR(*after->number("length_m"), *before->number("length_m"), 1e-4 * *before->number("length_m"));
  EXPECT_EQ(after->number("stations"), before->number("stations"));
  EXPECT_EQ(after->number("tags"), before->number("tags")) << "the sidecar file is read automatically";
}

TEST(ZoneConvert, makes_a_zone_of_a_map_of_squares_with_the_requested_pitch) {
  Scratch scratch;
  const std::string map = scratch.write("small.map", "type octile\nheight 2\nwidth 3\nmap\n...\n.@.\n");
  const CommandOutput output = cosiva({"zone", "convert", map, scratch / "small.toml", "--pitch", "2.5", "--json"});
  ASSERT_EQ(output.status, 0) << output.standard_error;
  const auto made = JsonValue::parse(output.data);
  EXPECT_EQ(made->number("sections"), 8.0);
  EXPECT_EQ(made->number("length_m"), 20.0);
  const auto stations = cosiva({"zone", "convert", map, scratch / "two.toml", "--stations", "2", "--json"});
  EXPECT_EQ(JsonValue::parse(stations.data)->number("stations"), 2.0);
  const auto checked = JsonValue::parse(cosiva({"zone", "check", scratch / "small.toml", "--json"}).data);
  EXPECT_EQ(checked->number("length_m"), 20.0);
  EXPECT_EQ(JsonValue::parse(cosiva({"zone", "check", map, "--json"}).data)->number("length_m"), 8.0);
}

TEST(ZoneConvert, names_line_and_column_of_a_map_s_fault_and_formats_without_a_pitch) {
  Scratch scratch;
  const std::string map = scratch.write("bad.map", "type octile\nheight 2\nwidth 3\nmap\n...\n.x.\n");
  const CommandOutput bad = cosiva({"zone", "convert", map, scratch / "bad.toml"});
  EXPECT_EQ(bad.status, 2);
  EXPECT_THAT(bad.standard_error, HasSubstr("bad.map: line 6, column 2: "));
  const CommandOutput other = cosiva({"zone", "check", zones + "lacet4.toml", "--pitch", "2"});
  EXPECT_EQ(other.status, 2);
  EXPECT_THAT(other.standard_error, HasSubstr("(.map) has a pitch"));
  EXPECT_EQ(cosiva({"zone", "check", map, "--pitch", "0"}).status, 2);
}

TEST(ZoneConvert, refuses_read_only_formats_and_unknown_endings) {
  Scratch scratch;
  EXPECT_EQ(cosiva({"zone", "convert", zones + "lacet4.toml", scratch / "a.xodr"}).status, 2);
  EXPECT_EQ(cosiva({"zone", "convert", zones + "lacet4.toml", scratch / "a.txt"}).status, 2);
  EXPECT_EQ(cosiva({"zone", "convert", zones + "lacet4.toml", scratch / "a.txt", "--to", "nothing"}).status, 2);
  EXPECT_THAT(std::filesystem::is_empty(scratch.path()), true) << "nothing was written";
  const std::string file = scratch.write("ring.toml", cycle);
  EXPECT_EQ(cosiva({"zone", "convert", file, file}).status, 2);
  EXPECT_EQ(adapters::read_file(file).value(), cycle);
}

TEST(ZoneGenerate, generates_a_plant_of_the_requested_size_reproducibly) {
  Scratch scratch;
  const CommandOutput output = cosiva({"zone", "generate", "--sections", "200", "-o", scratch / "a.toml", "--json"});
  ASSERT_EQ(output.status, 0) << output.standard_error;
  EXPECT_GE(JsonValue::parse(output.data)->number("sections").value_or(0.0), 200.0);
  EXPECT_LT(JsonValue::parse(output.data)->number("sections").value_or(0.0), 400.0);
  EXPECT_EQ(cosiva({"zone", "generate", "--sections", "200", "-o", scratch / "b.toml"}).status, 0);
  EXPECT_EQ(adapters::read_file(scratch / "a.toml").value(), adapters::read_file(scratch / "b.toml").value());
  EXPECT_EQ(cosiva({"zone", "check", scratch / "a.toml"}).status, 0);
  EXPECT_EQ(cosiva({"zone", "generate", "--sections", "200", "--seed", "2", "-o", scratch / "c.toml"}).status, 0);
  EXPECT_NE(adapters::read_file(scratch / "a.toml").value(), adapters::read_file(scratch / "c.toml").value());
}

TEST(ZoneGenerate, names_invalid_numbers) {
  Scratch scratch;
  const CommandOutput output = cosiva({"zone", "generate", "--rows", "0", "-o", scratch / "a.toml"});
  EXPECT_EQ(output.status, 2);
  EXPECT_THAT(output.standard_error, HasSubstr("rows"));
  EXPECT_EQ(cosiva({"zone", "generate", "-o", scratch / "a.txt"}).status, 2);
  EXPECT_TRUE(std::filesystem::is_empty(scratch.path()));
}

TEST(ZoneGenerate, generates_two_way_grids_and_loops_that_can_be_checked_drawn_and_written_as_lif) {
  Scratch scratch;
  const std::string grid = scratch / "grid.toml";
  const CommandOutput output =
      cosiva({"zone", "generate", "--grid", "6x5", "--pitch", "3", "--bays", "8", "--two-way", "-o", grid, "--json"});
  ASSERT_EQ(output.status, 0) << output.standard_error;
  // Each of 49 tracks and 8 bays in both directions.
  EXPECT_EQ(JsonValue::parse(output.data)->number("sections"), 2.0 * (49 + 8));
  EXPECT_EQ(JsonValue::parse(output.data)->number("stations"), 8.0);
  EXPECT_EQ(JsonValue::parse(output.data)->text("zone"), "grid");
  const std::string loop = scratch / "loop.lif.json";
  EXPECT_EQ(cosiva({"zone", "generate", "--loop", "12", "--bays", "6", "--name", "round", "-o", loop}).status, 0);
  for (const std::string& file : {grid, loop}) {
    const auto checked = JsonValue::parse(cosiva({"zone", "check", file, "--json"}).data);
    ASSERT_TRUE(checked);
    EXPECT_EQ(checked->flag("good"), true) << file;
    EXPECT_THAT(cosiva({"zone", "show", file}).data, HasSubstr("</svg>"));
  }
  EXPECT_EQ(JsonValue::parse(cosiva({"zone", "check", loop, "--json"}).data)->number("sections"), 2.0 * (12 + 6));
  EXPECT_EQ(cosiva({"zone", "generate", "--grid", "4x4", "--starts", "3", "-o", grid}).status, 0) << "one-way";
}

TEST(ZoneGenerate, names_impossible_grids_and_loops_and_writes_nothing) {
  Scratch scratch;
  const auto refusal = [&](std::vector<std::string> options) {
    options.insert(options.begin(), {"zone", "generate", "-o", scratch / "a.toml"});
    const CommandOutput output = cosiva(options);
    EXPECT_EQ(output.status, 2) << options.back();
    return output.standard_error;
  };
  for (const char* size : {"6", "6x", "x5", "6x5x4", "6 x 5", "-6x5", "6X5", "a", "99999999999x2"})
    EXPECT_THAT(refusal({"--grid", size}), HasSubstr("--grid: expected columns and rows, such as 6x5")) << size;
  EXPECT_THAT(refusal({"--grid", "0x5", "--two-way"}), HasSubstr("1 to 1000 columns"));
  EXPECT_THAT(refusal({"--grid", "6x5", "--pitch", "1"}), HasSubstr("expected a pitch of 1.55 m"));
  EXPECT_THAT(refusal({"--grid", "6x5", "--bays", "23"}), HasSubstr("at most 22 bays"));
  EXPECT_THAT(refusal({"--loop", "2"}), HasSubstr("3 to 10000 nodes"));
  EXPECT_TRUE(std::filesystem::is_empty(scratch.path()));
}

// --- switch
// --------------------------------------------------------------------------------------------------------------

TEST(ZoneSwitch, without_a_running_platform_explains_how_to_start_one) {
  const CommandOutput output = cosiva({"zone", "switch", zones + "indus8.toml", "--url", "http://127.0.0.1:1"});
  EXPECT_EQ(output.status, 2);
  EXPECT_THAT(output.standard_error, HasSubstr("cosiva up"));
}

TEST(ZoneSwitch, without_a_broker_or_with_a_bad_file_ends_with_2) {
  Scratch scratch;
  const CommandOutput bad =
      cosiva({"zone", "switch", scratch.write("bad.toml", "name = 3\n"), "--broker", "127.0.0.1:1"});
  EXPECT_EQ(bad.status, 2);
  EXPECT_THAT(bad.standard_error, HasSubstr("bad.toml:1"));
}

TEST(SwitchedZone, is_read_from_the_snapshot_with_off_route_vehicles) {
  const auto switched = switched_in(
      R"({"aivs":[{},{}],"zone":{"name":"b","switched":{"at":1,"from":"a","first_moving_ms":431.4,"snapped":12,)"
      R"("offRoute":["CoSiVA/AIV7"]}}})");
  ASSERT_TRUE(switched);
  EXPECT_EQ(switched->name, "b");
  EXPECT_THAT(switched->off_route, ElementsAre("CoSiVA/AIV7"));
  EXPECT_EQ(to_text(*switched), "12 snapped, 1 off-route: AIV7; the first moved after 431 ms");
}

TEST(SwitchedZone, distinguishes_no_moving_vehicle_from_no_vehicle) {
  const std::string table =
      R"("zone":{"name":"b","switched":{"at":1,"first_moving_ms":null,"snapped":0,"offRoute":[]}}})";
  EXPECT_THAT(to_text(*switched_in(R"({"aivs":[{}],)" + table)), HasSubstr("no vehicle has moved yet"));
  EXPECT_THAT(to_text(*switched_in(R"({"aivs":[],)" + table)), HasSubstr("there are no vehicles"));
  EXPECT_THAT(to_text(*switched_in(R"({"aivs":[{}],"zone":{"switched":{"snapped":0,"offRoute":["CoSiVA/AIV1"]}}})")),
              HasSubstr("no vehicle can continue"));
  EXPECT_FALSE(switched_in(R"({"aivs":[],"zone":{"name":"b","switched":null}})"));
  for (const char* none : {"", "null", "[]", "{}", R"({"zone":3})"}) EXPECT_FALSE(switched_in(none)) << none;
}

TEST(SwitchedZone, is_refused_with_the_platform_s_own_message) {
  EXPECT_EQ(refusal_in(R"({"error":{"code":"circuit.gap","message":"a.toml:3: …"}})", 422).message, "a.toml:3: …");
  EXPECT_THAT(refusal_in("<html>", 502).message, HasSubstr("502"));
}

}  // namespace
}  // namespace cosiva::app
