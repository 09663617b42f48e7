#include "cosiva/zone/edit/edit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>
#include <string>

#include "cosiva/zone/edit/edit_json.h"
#include "cosiva/zone/testing/test_edit_files.h"
#include "cosiva/zone/testing/test_zones.h"

namespace cosiva::zone {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Pair;
using ::testing::SizeIs;

using testing::file;
using testing::parsed;
using testing::straight;

/// The edit that the page's JSON requests of a zone, or the refusal's code.
Result<ZoneEdit> from_json(const std::string& json, const TrafficZone& zone) {
  const auto value = JsonValue::parse(json);
  EXPECT_TRUE(value) << json;
  return zone_edit_from_json(*value, zone);
}
std::string code_of(const std::string& json, const TrafficZone& zone = testing::lacet4()) {
  const auto edit = from_json(json, zone);
  return edit ? "none" : edit.error().code;
}

/// A straight of 2 m with a grid of its own, which no edit makes larger.
TrafficZone small_grid() {
  TrafficZone zone = parsed(file(straight));
  zone.beacons = BeaconGrid{0.5, {}, 3, 2};
  return zone;
}

// The page's edits
// -------------------------------------------------------------------------------------------------------------

TEST(ZoneEditJson, puts_a_tag_at_the_nearest_position_of_the_circuit) {
  const TrafficZone zone = testing::lacet4();
  // "east" runs from (-0.75, -0.15) eastward; "loop_ne" lies far away.
  const auto edit = from_json(R"({"addTags":[{"number":40,"x":0.35,"y":-0.30}]})", zone);
  ASSERT_TRUE(edit) << to_string(edit.error());
  ASSERT_THAT(edit->set_tags, SizeIs(1));
  EXPECT_EQ(edit->set_tags[0].number, 40U);
  EXPECT_EQ(edit->set_tags[0].position.section, zone.circuit.find("east"));
  EXPECT_NEAR(edit->set_tags[0].position.s_m, 1.10, 1e-9);
}

TEST(ZoneEditJson, reads_everything_that_an_edit_may_hold) {
  const TrafficZone zone = testing::lacet4();
  const auto edit = from_json(R"({"addTags":[{"number":13,"section":"south","s":0.5}],
      "moveTags":[{"number":1,"section":"north","s":0.7}],"removeTags":[2,3],"beaconPitch":0.2,
      "priorities":{"CoSiVA/AIV1":3,"Other/7":0}})",
                              zone);
  ASSERT_TRUE(edit) << to_string(edit.error());
  EXPECT_THAT(edit->set_tags, SizeIs(2));
  EXPECT_THAT(edit->remove_tags, ElementsAre(2, 3));
  EXPECT_EQ(edit->beacon_pitch_m, 0.2);
  EXPECT_THAT(edit->set_priorities, ElementsAre(Pair("CoSiVA/AIV1", 3), Pair("Other/7", 0)));
}

TEST(ZoneEditJson, refuses_each_impossible_edit_with_its_code) {
  EXPECT_EQ(code_of("[]"), "edit.syntax");
  EXPECT_EQ(code_of("{}"), "edit.empty");
  EXPECT_EQ(code_of(R"({"addTag":[]})"), "edit.field");
  EXPECT_EQ(code_of(R"({"addTags":{}})"), "edit.field");
  EXPECT_EQ(code_of(R"({"addTags":[7]})"), "edit.number");
  EXPECT_EQ(code_of(R"({"addTags":[{"number":0,"section":"east","s":1}]})"), "edit.number");
  EXPECT_EQ(code_of(R"({"addTags":[{"number":13.5,"section":"east","s":1}]})"), "edit.number");
  EXPECT_EQ(code_of(R"({"addTags":[{"number":4000000001,"section":"east","s":1}]})"), "edit.number");
  EXPECT_EQ(code_of(R"({"addTags":[{"number":"13","section":"east","s":1}]})"), "edit.number");
  EXPECT_EQ(code_of(R"({"addTags":[{"number":13}]})"), "edit.position");
  EXPECT_EQ(code_of(R"({"addTags":[{"number":13,"x":1}]})"), "edit.position");
  EXPECT_EQ(code_of(R"({"addTags":[{"number":13,"section":"east"}]})"), "edit.position");
  EXPECT_EQ(code_of(R"({"addTags":[{"number":13,"section":"est","s":1}]})"), "edit.section");
  EXPECT_EQ(code_of(R"({"addTags":[{"number":13,"section":"east","s":-0.1}]})"), "edit.position");
  EXPECT_EQ(code_of(R"({"addTags":[{"number":13,"section":"east","s":1.51}]})"), "edit.position");
  EXPECT_EQ(code_of(R"({"addTags":[{"number":1,"section":"east","s":1}]})"), "edit.tag");
  EXPECT_EQ(code_of(R"({"moveTags":[{"number":13,"section":"east","s":1}]})"), "edit.tag");
  EXPECT_EQ(code_of(R"({"removeTags":[13]})"), "edit.tag");
  EXPECT_EQ(code_of(R"({"removeTags":["1"]})"), "edit.number");
  EXPECT_EQ(code_of(R"({"removeTags":[1,1]})"), "edit.twice");
  EXPECT_EQ(code_of(R"({"removeTags":[1],"moveTags":[{"number":1,"section":"east","s":1}]})"), "edit.twice");
  EXPECT_EQ(code_of(R"({"addTags":[{"number":1000000,"section":"east","s":1}]})"), "edit.number");
  EXPECT_EQ(code_of(R"({"beaconPitch":"0.2"})"), "edit.pitch");
  EXPECT_EQ(code_of(R"({"beaconPitch":0.04})"), "edit.pitch");
  EXPECT_EQ(code_of(R"({"beaconPitch":10.1})"), "edit.pitch");
  EXPECT_EQ(code_of(R"({"beaconPitch":0.2})", parsed(file(straight))), "edit.beacons");
  EXPECT_EQ(code_of(R"({"priorities":[]})"), "edit.priority");
  EXPECT_EQ(code_of(R"({"priorities":{"CoSiVA/AIV1":1000}})"), "edit.priority");
  EXPECT_EQ(code_of(R"({"priorities":{"CoSiVA/AIV1":-1}})"), "edit.priority");
  EXPECT_EQ(code_of(R"({"priorities":{"CoSiVA/AIV1":1.5}})"), "edit.priority");
  for (const char* name : {"AIV1", "/AIV1", "CoSiVA/", "CoSiVA/AIV/1", "CoSiVA/#", ""})
    EXPECT_EQ(code_of(R"({"priorities":{")" + std::string(name) + R"(":1}})"), "edit.priority") << name;
  EXPECT_EQ(code_of(R"({"priorities":{"a/b":1,"a/b":2}})"), "edit.twice");
}

TEST(ZoneEditJson, reads_any_part_of_the_beacons_position) {
  const TrafficZone zone = testing::lacet4();
  const auto all = from_json(R"({"beacons":{"pitch":0.3,"origin":[0.1,-0.2],"rotation":0.26}})", zone);
  ASSERT_TRUE(all) << to_string(all.error());
  EXPECT_EQ(all->beacon_pitch_m, 0.3);
  EXPECT_EQ(all->beacon_origin, (Point2{0.1, -0.2}));
  EXPECT_EQ(all->beacon_rotation_rad, 0.26);
  const auto one = from_json(R"({"beacons":{"rotation":-1}})", zone);
  ASSERT_TRUE(one) << to_string(one.error());
  EXPECT_FALSE(one->beacon_pitch_m);
  EXPECT_FALSE(one->beacon_origin);
}

TEST(ZoneEditJson, refuses_impossible_positions_of_beacons) {
  EXPECT_EQ(code_of(R"({"beacons":0.3})"), "edit.field");
  EXPECT_EQ(code_of(R"({"beacons":{}})"), "edit.field");
  EXPECT_EQ(code_of(R"({"beacons":{"pich":0.3}})"), "edit.field");
  EXPECT_EQ(code_of(R"({"beacons":{"pitch":11}})"), "edit.pitch");
  EXPECT_EQ(code_of(R"({"beacons":{"pitch":"x"}})"), "edit.pitch");
  EXPECT_EQ(code_of(R"({"beacons":{"pitch":0.3},"beaconPitch":0.2})"), "edit.twice");
  for (const char* origin : {"3", "[1]", "[1,2,3]", R"(["a",1])", R"([1,"a"])", "[1e7,0]", "[0,-1e300]"})
    EXPECT_EQ(code_of(R"({"beacons":{"origin":)" + std::string(origin) + "}}"), "edit.origin") << origin;
  EXPECT_EQ(code_of(R"({"beacons":{"rotation":6.3}})"), "edit.rotation");
  EXPECT_EQ(code_of(R"({"beacons":{"rotation":true}})"), "edit.rotation");
  EXPECT_EQ(code_of(R"({"beacons":{"rotation":0.1}})", parsed(file(straight))), "edit.beacons");
}

TEST(ZoneEditJson, distinguishes_a_tag_30_cm_off_every_section_from_one_just_near_enough) {
  const TrafficZone zone = parsed(file(straight));
  EXPECT_EQ(code_of(R"({"addTags":[{"number":1,"x":1.0,"y":0.2999}]})", zone), "none");
  EXPECT_EQ(code_of(R"({"addTags":[{"number":1,"x":1.0,"y":0.3}]})", zone), "none");
  EXPECT_EQ(code_of(R"({"addTags":[{"number":1,"x":1.0,"y":-0.3001}]})", zone), "edit.position");
  EXPECT_THAT(from_json(R"({"addTags":[{"number":1,"x":1.0,"y":-0.5}]})", zone).error().message, HasSubstr("0.50 m"));
}

TEST(ZoneEditJson, refuses_more_beacons_than_a_page_can_draw) {
  // 100 m by 0: at 0.05 m that is 2000 columns of 4 or 5; at right angles to it another 100 m make four million.
  const TrafficZone zone = parsed(file(straight + R"(
[[section]]
name = "b"
kind = "arc"
radius_m = 20.0
angle_deg = 90
[beacons]
pitch_m = 1.0
cover = "zone"
)"));
  EXPECT_EQ(code_of(R"({"beaconPitch":0.05})", zone), "edit.pitch");
  EXPECT_EQ(code_of(R"({"beaconPitch":0.5})", zone), "none");
}

TEST(ZoneEditJson, takes_every_number_at_its_limit) {
  const TrafficZone zone = parsed(file(straight));
  EXPECT_EQ(code_of(R"({"addTags":[{"number":1,"section":"a","s":0}]})", zone), "none");
  EXPECT_EQ(code_of(R"({"addTags":[{"number":4000000000,"section":"a","s":2}]})", zone), "none");
  EXPECT_EQ(code_of(R"({"priorities":{"a/b":0,"c/d":999}})", zone), "none");
  const TrafficZone lacet = testing::lacet4();
  EXPECT_EQ(code_of(R"({"removeTags":[0]})", lacet), "edit.number");
  EXPECT_EQ(code_of(R"({"removeTags":[1.5]})", lacet), "edit.number");
  EXPECT_EQ(code_of(R"({"removeTags":3})", lacet), "edit.field");
  EXPECT_EQ(code_of(R"({"priorities":{"a/b":"1"}})", zone), "edit.priority");
  EXPECT_EQ(code_of(R"({"beaconPitch":0.05})", testing::lacet4()), "none");
  EXPECT_EQ(code_of(R"({"beacons":{"pitch":10,"origin":[1000000,-1000000]}})", small_grid()), "none");
}

TEST(ZoneEditJson, prefers_a_section_to_a_point_and_needs_all_of_either) {
  const TrafficZone zone = parsed(file(straight));
  const auto position = [&](const std::string& fields) -> std::optional<TrackPosition> {
    const auto edit = from_json(R"({"addTags":[{"number":1,)" + fields + "}]}", zone);
    if (!edit) return std::nullopt;
    return edit->set_tags.at(0).position;
  };
  EXPECT_EQ(position(R"("section":"a","s":0.5,"x":1,"y":0)"), (TrackPosition{0, 0.5}));
  EXPECT_EQ(position(R"("section":"a","x":1,"y":0)"), (TrackPosition{0, 1.0}));
  EXPECT_EQ(position(R"("s":0.5,"x":1,"y":0)"), (TrackPosition{0, 1.0}));
  EXPECT_EQ(position(R"("s":0.5,"y":0)"), std::nullopt);
  EXPECT_EQ(position(R"("section":"a","x":1)"), std::nullopt);
}

TEST(ZoneEditJson, reports_the_first_fault_and_its_location) {
  const auto error = [](const std::string& json) {
    const auto edit = from_json(json, testing::lacet4());
    EXPECT_FALSE(edit) << json;
    return edit ? Error{} : edit.error();
  };
  EXPECT_EQ(error(R"({"addTag":[],"removeTags":["x"]})").location, "addTag");
  EXPECT_EQ(error(R"({"addTags":{},"removeTags":["x"]})").location, "addTags");
  EXPECT_EQ(error(R"({"addTags":[7],"removeTags":["x"]})").location, "addTags");
  EXPECT_EQ(error(R"({"removeTags":["x"],"beaconPitch":"y"})").location, "removeTags");
  EXPECT_EQ(error(R"({"beaconPitch":"y","priorities":[]})").location, "beaconPitch");
  EXPECT_EQ(error(R"({"priorities":[]})").location, "priorities");
  EXPECT_EQ(error(R"({"addTags":[{"number":13,"section":"est","s":1}]})").location, "tag 13");
  // Names of any length are cut to 64 bytes.
  const std::string cut(64, 'k');
  EXPECT_EQ(error("{\"" + cut + "kk\":1}").location, cut);
  EXPECT_EQ(error("{\"beacons\":{\"" + cut + "kk\":1}}").location, cut);
  EXPECT_EQ(error("{\"priorities\":{\"" + cut + "kk\":-1}}").location, cut);
  EXPECT_EQ(error("{\"priorities\":{\"" + cut + "kk\":1}}").location, cut);
  EXPECT_THAT(error(R"({"addTags":[{"number":13,"section":")" + cut + R"(kk","s":1}]})").message,
              HasSubstr("'" + cut + "'"));
  EXPECT_THAT(error(R"({"addTags":[{"number":1,"section":"east","s":1}]})").message, HasSubstr("already there"));
  EXPECT_THAT(error(R"({"moveTags":[{"number":13,"section":"east","s":1}]})").message, HasSubstr("to move; add it"));
}

TEST(ZoneEditJson, detects_that_a_narrower_pitch_takes_a_tags_number) {
  // Along 2 m of track a pitch of 10 m gives 3 by 3 beacons, numbers 100 to 108; a pitch of 0.5 m gives 7 by 3, up to
  // 120.
  const TrafficZone zone = parsed(file(straight + R"(
[beacons]
pitch_m = 10.0
cover = "zone"
first_number = 100
[[tag]]
number = 120
section = "a"
s_m = 1.0
)"));
  EXPECT_EQ(code_of(R"({"beaconPitch":0.5})", zone), "edit.number");
  EXPECT_EQ(code_of(R"({"beaconPitch":9.0})", zone), "none");
}

}  // namespace
}  // namespace cosiva::zone
