#include "cosiva/zone/edit/edit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/zone/drawing/zone_circuit.h"
#include "cosiva/zone/testing/test_edit_files.h"
#include "cosiva/zone/testing/test_zones.h"

namespace cosiva::zone {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Pair;

using testing::file;
using testing::lacet4_file;
using testing::parsed;
using testing::straight;

std::string edited_text(const std::string& text, const ZoneEdit& edit) {
  const auto result = edited(file(text), edit);
  return result ? result->text : "refused: " + result.error().code + ": " + result.error().message;
}

// The file's text
// ---------------------------------------------------------------------------------------------------------

constexpr TrackPosition at_a(double s_m) { return {0, s_m}; }

TEST(ZoneEdit, moves_a_tag_by_changing_its_two_values_alone) {
  const std::string before = straight + R"(
# by the gate
[[tag]]   # one
number = 1   # blue
section = "a"   # on a
s_m     =   0.5   # metres
)";
  const std::string after = edited_text(before, {{{1, at_a(1.25)}}, {}, {}, {}});
  std::string wanted = before;
  wanted.replace(wanted.find("0.5 "), 3, "1.25");
  EXPECT_EQ(after, wanted);
}

TEST(ZoneEdit, writes_another_section_only_where_it_changes) {
  const std::string before = straight + R"([[section]]
name = "b \"2\""
kind = "straight"
length_m = 1.0
[[tag]]
s_m = 0.5
section = 'a'
number = 1
)";
  EXPECT_THAT(edited_text(before, {{{1, {0, 0.25}}}, {}, {}, {}}), HasSubstr("s_m = 0.25\nsection = 'a'\n"));
  EXPECT_THAT(edited_text(before, {{{1, {1, 0.25}}}, {}, {}, {}}),
              HasSubstr("s_m = 0.25\nsection = \"b \\\"2\\\"\"\n"));
}

TEST(ZoneEdit, adds_a_tag_behind_the_last_one) {
  const std::string tag = "\n[[tag]]\nnumber = 1\nsection = \"a\"\ns_m = 0.5\n";
  const std::string rest = "\n# what follows\n[[station]]\nname = \"s\"\nsection = \"a\"\ns_m = 1.0";
  EXPECT_EQ(edited_text(straight + tag + rest, {{{2, at_a(1.23456)}}, {}, {}, {}}),
            straight + tag + "\n[[tag]]\nnumber = 2\nsection = \"a\"\ns_m = 1.2346\n" + rest);
}

TEST(ZoneEdit, adds_the_first_tag_at_the_end_even_of_a_file_without_a_last_newline) {
  const std::string bare = straight.substr(0, straight.size() - 1);
  EXPECT_EQ(
      edited_text(bare, {{{2, at_a(1.0)}, {3, at_a(1.5)}}, {}, {}, {}}),
      straight +
          "\n[[tag]]\nnumber = 2\nsection = \"a\"\ns_m = 1.00\n\n[[tag]]\nnumber = 3\nsection = \"a\"\ns_m = 1.50\n");
}

TEST(ZoneEdit, removes_a_tags_lines_and_one_blank_line_but_no_comment) {
  const std::string before = straight + R"(
[[tag]]
number = 1
section = "a"
s_m = 0.5

# the second
[[tag]]
number = 2
# half way
section = "a"
s_m = 1.0

[[tag]]
number = 3
section = "a"
s_m = 1.5
)";
  EXPECT_EQ(edited_text(before, {{}, {1}, {}, {}}), straight + R"(
# the second
[[tag]]
number = 2
# half way
section = "a"
s_m = 1.0

[[tag]]
number = 3
section = "a"
s_m = 1.5
)");
  EXPECT_EQ(edited_text(before, {{}, {1, 2, 3}, {}, {}}), straight + "\n# the second\n# half way\n\n");
}

TEST(ZoneEdit, changes_only_the_number_of_the_beacons_pitch) {
  const ZoneConfiguration before = lacet4_file();
  const auto after = edited(before, {{}, {}, 0.2, {}});
  ASSERT_TRUE(after) << to_string(after.error());
  std::string wanted = before.text;
  wanted.replace(wanted.find("pitch_m = 0.30"), 14, "pitch_m = 0.20");
  EXPECT_EQ(after->text, wanted);
  EXPECT_EQ(after->origin, before.origin);
  EXPECT_EQ(parsed(*after).beacons->pitch_m, 0.2);
}

TEST(ZoneEdit, keeps_the_number_of_beacons_that_a_file_counts_itself) {
  const std::string before = straight + "beacons = { pitch_m = 1, columns = 3, rows = 2 } # few\n";
  // An inline table belongs to the section here, so it must be at the top.
  const std::string top = "beacons = { pitch_m = 1, columns = 3, rows = 2 } # few\n" + straight;
  EXPECT_EQ(edited_text(top, {{}, {}, 0.5, {}}),
            "beacons = { pitch_m = 0.50, columns = 3, rows = 2 } # few\n" + straight);
  EXPECT_THAT(edited_text(before, {{}, {}, 0.5, {}}), HasSubstr("refused: zone.unknown_key"));
}

ZoneEdit beacons(std::optional<double> pitch_m, std::optional<Point2> origin, std::optional<double> rotation_rad) {
  ZoneEdit edit;
  edit.beacon_pitch_m = pitch_m;
  edit.beacon_origin = origin;
  edit.beacon_rotation_rad = rotation_rad;
  return edit;
}

TEST(ZoneEdit, writes_origin_and_rotation_in_place_or_behind_the_pitch) {
  const std::string before = straight + "[beacons]   # ours\npitch_m = 0.5 # wide\ncover = \"zone\"\n";
  const std::string once = edited_text(before, beacons({}, Point2{0.15, -0.20004}, pi / 6.0));
  EXPECT_EQ(once, straight +
                      "[beacons]   # ours\npitch_m = 0.5 # wide\norigin = [0.15, -0.20]\nrotation_deg = 30.00\n"
                      "cover = \"zone\"\n");
  EXPECT_EQ(edited_text(once, beacons(0.25, Point2{1.0, 2.0}, -0.1)),
            straight +
                "[beacons]   # ours\npitch_m = 0.25 # wide\norigin = [1.00, 2.00]\nrotation_deg = -5.7296\n"
                "cover = \"zone\"\n");
  const TrafficZone zone = parsed(file(once));
  EXPECT_EQ(zone.beacons->rotation_rad, 30.0 * pi / 180.0);
  EXPECT_EQ(zone.beacons->covers_through, (Point2{0.15, -0.2}));
}

TEST(ZoneEdit, moves_beacons_that_are_written_in_one_line_or_end_the_file) {
  const std::string one_line = "beacons = { pitch_m = 1, columns = 3, rows = 2 } # few\n" + straight;
  EXPECT_EQ(edited_text(one_line, beacons({}, Point2{0.5, 0.0}, {})),
            "beacons = { pitch_m = 1, origin = [0.50, 0.00], columns = 3, rows = 2 } # few\n" + straight);
  EXPECT_EQ(edited_text(straight + "[beacons]\ncover = \"zone\"\npitch_m = 0.5", beacons({}, {}, 0.5 * pi)),
            straight + "[beacons]\ncover = \"zone\"\npitch_m = 0.5\nrotation_deg = 90.00\n");
  EXPECT_THAT(
      edited_text(straight + "[beacons]\ncover = \"zone\"\npitch_m = 0.5\nrotation_rad = 0.1\n", beacons({}, {}, 0.0)),
      HasSubstr("rotation_rad = 0\n"));
}

TEST(ZoneEdit, makes_the_priorities_when_they_are_missing_and_keeps_them_in_order) {
  const std::string one = edited_text(straight, {{}, {}, {}, {{"CoSiVA/AIV2", 3}}});
  EXPECT_EQ(one, straight + "\n[priorities]\n\"CoSiVA/AIV2\" = 3\n");
  const std::string two = edited_text(one + "# end\n", {{}, {}, {}, {{"CoSiVA/AIV1", 999}, {"CoSiVA/AIV2", 12}}});
  EXPECT_EQ(two, straight + "\n[priorities]\n\"CoSiVA/AIV2\" = 12\n\"CoSiVA/AIV1\" = 999\n# end\n");
  EXPECT_THAT(parsed(file(two)).priorities, ElementsAre(Pair("CoSiVA/AIV1", 999), Pair("CoSiVA/AIV2", 12)));
  const std::string three = edited_text(two, {{}, {}, {}, {{"CoSiVA/AIV1", 0}, {"CoSiVA/AIV2", 0}, {"x/y", 0}}});
  EXPECT_EQ(three, straight + "\n[priorities]\n# end\n");
}

TEST(ZoneEdit, keeps_the_line_ends_of_another_system) {
  std::string crlf;
  for (const char c : straight + "[[tag]]\nnumber = 1\nsection = \"a\"\ns_m = 0.5\n")
    crlf += c == '\n' ? "\r\n" : std::string(1, c);
  const std::string after = edited_text(crlf, {{{1, at_a(0.75)}, {2, at_a(1.0)}}, {}, {}, {{"a/b", 1}}});
  EXPECT_THAT(after, HasSubstr("s_m = 0.75\r\n\r\n[[tag]]\r\nnumber = 2\r\n"));
  for (std::size_t i = 0; i < after.size(); ++i) EXPECT_TRUE(after[i] != '\n' || after[i - 1] == '\r') << i;
}

TEST(ZoneEdit, counts_bytes_where_the_file_has_other_letters_than_ascii) {
  const std::string before = "\xEF\xBB\xBF" + straight +
                             "[[section]]\nname = \"ö\"\nkind = \"straight\"\nlength_m = 1.0\n" +
                             "[[tag]]\nnumber = 1\nsection = \"ö\" # über\ns_m = 0.5\n";
  const std::string after = edited_text(before, {{{1, {0, 0.25}}}, {}, {}, {}});
  EXPECT_THAT(after, HasSubstr("section = \"a\" # über\ns_m = 0.25\n"));
}

TEST(ZoneEdit, refuses_to_rewrite_tags_written_in_a_list_but_moves_them) {
  const std::string before = "tag = [ { number = 1, section = \"a\", s_m = 0.5 } ]\n" + straight;
  EXPECT_THAT(edited_text(before, {{{1, at_a(1.0)}}, {}, {}, {}}), HasSubstr("s_m = 1.00 }"));
  EXPECT_THAT(edited_text(before, {{{2, at_a(1.0)}}, {}, {}, {}}), HasSubstr("refused: edit.format"));
  EXPECT_THAT(edited_text(before, {{}, {1}, {}, {}}), HasSubstr("[[tag]]"));
  EXPECT_THAT(edited_text("priorities = { \"a/b\" = 1 }\n" + straight, {{}, {}, {}, {{"c/d", 1}}}),
              HasSubstr("refused: edit.format"));
  EXPECT_THAT(edited_text("priorities = { \"a/b\" = 1 }\n" + straight, {{}, {}, {}, {{"a/b", 2}}}),
              HasSubstr("\"a/b\" = 2 }"));
}

TEST(ZoneEdit, of_a_bad_file_or_a_bad_edit_fails_with_a_reason) {
  EXPECT_THAT(edited_text("name = ", {{}, {}, 0.2, {}}), HasSubstr("refused: zone.syntax"));
  EXPECT_THAT(edited_text(straight, {{}, {7}, {}, {}}), HasSubstr("refused: edit.tag"));
  EXPECT_THAT(edited_text(straight, {{{1, {5, 0.0}}}, {}, {}, {}}), HasSubstr("refused: edit.section"));
  EXPECT_THAT(edited_text(straight, {{{1, at_a(2.001)}}, {}, {}, {}}), HasSubstr("refused: edit.position"));
  EXPECT_THAT(edited_text(straight, {{}, {}, {}, {{"a/b", 1000}}}), HasSubstr("refused: edit.priority"));
  const auto other = edited({"cad", "x", ""}, {});
  ASSERT_FALSE(other);
  EXPECT_EQ(other.error().code, "zone.format");
}

TEST(ZoneEdit, is_refused_by_a_format_that_cannot_express_it) {
  class Rigid final : public CircuitFactory {
   public:
    std::string_view format() const override { return "rigid"; }
    std::vector<std::string_view> file_endings() const override { return {".rigid"}; }
    Result<TrafficZone> make_zone(const ZoneConfiguration&) const override { return testing::lacet4(); }
    Result<std::shared_ptr<const DrawableCircuit>> make_circuit(const ZoneConfiguration& configuration) const override {
      return circuit_of(make_zone(configuration));
    }
  };
  const auto result = Rigid{}.edited({"rigid", "x", ""}, {});
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, "edit.format");
  EXPECT_THAT(result.error().message, HasSubstr("'rigid'"));
}

TEST(ZoneEdit, rounds_no_tag_off_its_section) {
  const TrafficZone zone = testing::lacet4();
  const SectionId loop = *zone.circuit.find("loop_se");
  const double length_m = zone.circuit.section(loop).length_m();  // 0.6 m · 3π/2 = 2.82743… m
  const auto after = edited(lacet4_file(), {{{50, {loop, length_m}}}, {}, {}, {}});
  ASSERT_TRUE(after) << to_string(after.error());
  EXPECT_EQ(parsed(*after).find_tag(50)->position, (TrackPosition{loop, 2.8274}));
}

// Same sections -----------------------------------------------------------------------------------------------------

TEST(SameGeometry, are_those_that_a_running_vehicle_need_not_notice) {
  const TrafficZone zone = testing::lacet4();
  EXPECT_TRUE(same_geometry(zone, zone));
  const auto after = edited(lacet4_file(), {{{1, {0, 0.3}}, {77, {2, 0.3}}}, {4}, 0.07, {{"CoSiVA/AIV1", 3}}});
  ASSERT_TRUE(after) << to_string(after.error());
  EXPECT_TRUE(same_geometry(zone, parsed(*after)));
}

TEST(SameGeometry, differ_in_a_length_a_name_a_speed_a_body_or_a_clearance) {
  const ZoneConfiguration given = lacet4_file();
  const TrafficZone zone = parsed(given);
  for (const auto& [from, to] : {std::pair{"name = \"lacet4\"", "name = \"lacet5\""},
                                 {"name = \"loop_se\"", "name = \"loop_es\""},
                                 {"length_m = 0.20", "length_m = 0.21"},
                                 {"speed_mps = 0.40", "speed_mps = 0.41"},
                                 {"x = -0.75", "x = -0.76"},
                                 {"[vehicle]", "[crossings]\nclearance_m = 0.05\n[vehicle]"},
                                 {"[vehicle]", "[waypoints]\nspacing_m = 0.25\n[vehicle]"},
                                 {"kind = \"straight\"", "kind = \"straight\"\nspeed_mps_max = 0.2"}}) {
    ZoneConfiguration other = given;
    // The dock is on loop_se, as are tags; a section's new name must reach them too.
    for (auto at = other.text.find(from); at != std::string::npos;
         at = other.text.find(from, at + std::string(to).size())) {
      other.text.replace(at, std::string(from).size(), to);
      if (std::string(from) != "name = \"loop_se\"") break;
      for (auto use = other.text.find("section = \"loop_se\""); use != std::string::npos;
           use = other.text.find("section = \"loop_se\""))
        other.text.replace(use, 19, "section = \"loop_es\"");
    }
    EXPECT_FALSE(same_geometry(zone, parsed(other))) << to;
  }
}

// The edited zone
// ---------------------------------------------------------------------------------------------------------

/// 2 m eastward with tag 5 at 0.5 m, and a grid of 3 by 2 beacons from number 100.
TrafficZone small_zone() {
  TrafficZone zone = parsed(file(straight));
  zone.tags = {{5, {0, 0.5}}};
  zone.beacons = BeaconGrid{0.5, {0.0, -0.25}, 3, 2, 100};
  return zone;
}

ZoneEdit tag_edit(TagNumber number, TrackPosition position) {
  ZoneEdit edit;
  edit.set_tags.push_back({number, position});
  return edit;
}
ZoneEdit priority_edit(std::string vehicle, std::int32_t priority) {
  ZoneEdit edit;
  edit.set_priorities.emplace_back(std::move(vehicle), priority);
  return edit;
}
/// "" where the edit is possible.
std::string refusal(const ZoneEdit& edit, const TrafficZone& zone = small_zone()) {
  const auto after = with_edit(zone, edit);
  return after ? std::string() : after.error().code;
}

TEST(WithEdit, takes_tags_with_any_number_from_1_to_4000000000_anywhere_on_a_section) {
  EXPECT_EQ(refusal(tag_edit(1, {0, 1.0})), "");
  EXPECT_EQ(refusal(tag_edit(4'000'000'000, {0, 1.0})), "");
  EXPECT_EQ(refusal(tag_edit(0, {0, 1.0})), "edit.number");
  EXPECT_EQ(refusal(tag_edit(4'000'000'001, {0, 1.0})), "edit.number");
  EXPECT_EQ(refusal(tag_edit(1, {1, 0.0})), "edit.section");
  EXPECT_EQ(refusal(tag_edit(1, {0, 0.0})), "");
  EXPECT_EQ(refusal(tag_edit(1, {0, 2.0})), "");
  EXPECT_EQ(refusal(tag_edit(1, {0, -1e-6})), "edit.position");
  EXPECT_EQ(refusal(tag_edit(1, {0, 2.000001})), "edit.position");
  EXPECT_EQ(refusal(tag_edit(1, {0, std::nan("")})), "edit.position");
  EXPECT_THAT(with_edit(small_zone(), tag_edit(1, {0, 3.0})).error().message, HasSubstr("from 0 to its length, 2.00"));
}

TEST(WithEdit, keeps_the_order_of_tags_and_appends_new_ones) {
  TrafficZone zone = small_zone();
  zone.tags = {{5, {0, 0.5}}, {3, {0, 1.0}}, {9, {0, 1.5}}};
  ZoneEdit edit = tag_edit(3, {0, 1.25004});
  edit.set_tags.push_back({1, {0, 0.1}});
  edit.remove_tags = {5};
  const auto after = with_edit(zone, edit);
  ASSERT_TRUE(after) << to_string(after.error());
  ASSERT_EQ(after->tags.size(), 3U);
  EXPECT_EQ(after->tags[0].number, 3U);
  EXPECT_EQ(after->tags[0].position, (TrackPosition{0, 1.25}));
  EXPECT_EQ(after->tags[1].number, 9U);
  EXPECT_EQ(after->tags[1].position, (TrackPosition{0, 1.5}));
  EXPECT_EQ(after->tags[2].number, 1U);
  edit.remove_tags = {7};
  EXPECT_EQ(refusal(edit, zone), "edit.tag");
}

TEST(WithEdit, takes_a_pitch_from_5_cm_to_10_m_as_it_is_written) {
  const auto pitch = [](double pitch_m) { return refusal(beacons(pitch_m, {}, {})); };
  EXPECT_EQ(pitch(0.05), "");
  EXPECT_EQ(pitch(0.04996), "") << "written as 0.05";
  EXPECT_EQ(pitch(0.0499), "edit.pitch");
  EXPECT_EQ(pitch(10.0), "");
  EXPECT_EQ(pitch(10.0001), "edit.pitch");
  EXPECT_EQ(pitch(std::nan("")), "edit.pitch");
  const auto after = with_edit(small_zone(), beacons(0.25004, {}, {}));
  ASSERT_TRUE(after);
  EXPECT_EQ(after->beacons->pitch_m, 0.25);
  EXPECT_EQ(after->beacons->origin, (Point2{0.0, -0.25}));
  EXPECT_EQ(after->beacons->rotation_rad, 0.0);
  EXPECT_EQ(after->beacons->columns, 3U);
  TrafficZone coarse = small_zone();
  coarse.beacons->pitch_m = 0.01;  // as a file may have it
  EXPECT_EQ(refusal(beacons({}, Point2{1.0, 1.0}, {}), coarse), "") << "a pitch that is not edited is not checked";
}

TEST(WithEdit, moves_the_origin_within_a_thousand_kilometres_and_turns_by_at_most_a_turn) {
  const auto origin = [](double x_m, double y_m) { return refusal(beacons({}, Point2{x_m, y_m}, {})); };
  for (const double good_m : {-1e6, 0.0, 1e6}) {
    EXPECT_EQ(origin(good_m, 1.0), "");
    EXPECT_EQ(origin(1.0, good_m), "");
  }
  for (const double bad_m : {-1.000001e6, 1.000001e6, std::nan("")}) {
    EXPECT_EQ(origin(bad_m, 1.0), "edit.origin") << bad_m;
    EXPECT_EQ(origin(1.0, bad_m), "edit.origin") << bad_m;
  }
  const auto rotation = [](double rad) { return refusal(beacons({}, {}, rad)); };
  EXPECT_EQ(rotation(2.0 * pi), "");
  EXPECT_EQ(rotation(-2.0 * pi), "");
  EXPECT_EQ(rotation(6.2832), "edit.rotation");
  EXPECT_EQ(rotation(-6.2832), "edit.rotation");
  EXPECT_EQ(rotation(std::nan("")), "edit.rotation");

  const auto after = with_edit(small_zone(), beacons({}, Point2{0.12344, -3.00006}, pi / 6.0 + 1e-8));
  ASSERT_TRUE(after);
  EXPECT_EQ(after->beacons->origin, (Point2{0.1234, -3.0001}));
  EXPECT_EQ(after->beacons->rotation_rad, 30.0 * pi / 180.0);
  EXPECT_EQ(after->beacons->pitch_m, 0.5);
  EXPECT_EQ(after->beacons->rows, 2U);
  EXPECT_FALSE(after->beacons->covers_through);
}

TEST(WithEdit, lets_a_covering_grid_cover_the_zone_again_from_the_same_number) {
  TrafficZone zone = small_zone();
  zone.beacons->covers_through = Point2{0.0, 0.0};
  const auto after = with_edit(zone, beacons(0.25, Point2{0.1, 0.2}, {}));
  ASSERT_TRUE(after);
  EXPECT_EQ(after->beacons->covers_through, (Point2{0.1, 0.2}));
  EXPECT_EQ(after->beacons->first_number, 100U);
  // 2 m of path and half a vehicle, 0.06 m, on either side: x from −0.15 to 2.10 m, y from −0.30 to 0.20 m.
  EXPECT_EQ(after->beacons->columns, 10U);
  EXPECT_EQ(after->beacons->rows, 3U);
  EXPECT_NEAR(after->beacons->origin.x_m, -0.15, 1e-12);
  EXPECT_NEAR(after->beacons->origin.y_m, -0.30, 1e-12);
}

TEST(WithEdit, covers_a_zone_with_at_most_twenty_thousand_beacons) {
  // 197.5 m and half a vehicle, 0.06 m, on either side: 200 columns from −1 m to 198 m.
  const auto covered = [](double depth_m) {
    TrafficZone zone = small_zone();
    zone.circuit = testing::circuit({testing::part("near", testing::section({}, 197.5)),
                                     testing::part("far", testing::section({0.0, depth_m, 0.0}, 197.5))});
    zone.beacons->covers_through = Point2{0.0, 0.0};
    return refusal(beacons(1.0, {}, {}), zone);
  };
  EXPECT_EQ(covered(97.5), "") << "100 rows";
  EXPECT_EQ(covered(98.5), "edit.pitch") << "101 rows";
}

TEST(WithEdit, without_a_change_of_beacons_needs_none) {
  TrafficZone zone = small_zone();
  zone.beacons.reset();
  EXPECT_EQ(refusal(tag_edit(7, {0, 1.0}), zone), "");
  EXPECT_EQ(refusal(beacons(0.5, {}, {}), zone), "edit.beacons");
  EXPECT_EQ(refusal(beacons({}, Point2{}, {}), zone), "edit.beacons");
  EXPECT_EQ(refusal(beacons({}, {}, 0.0), zone), "edit.beacons");
}

TEST(WithEdit, refuses_a_tag_with_the_number_of_a_beacon) {
  EXPECT_EQ(refusal(tag_edit(99, {0, 1.0})), "");
  EXPECT_EQ(refusal(tag_edit(100, {0, 1.0})), "edit.number");
  EXPECT_EQ(refusal(tag_edit(105, {0, 1.0})), "edit.number");
  EXPECT_EQ(refusal(tag_edit(106, {0, 1.0})), "");
  const auto refused = with_edit(small_zone(), tag_edit(101, {0, 1.0}));
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("give the tag one below 100"));
  EXPECT_EQ(refused.error().location, "tag 101");
}

TEST(WithEdit, keeps_priorities_sorted_and_none_of_zero) {
  TrafficZone zone = small_zone();
  zone.priorities = {{"B/1", 5}, {"D/1", 7}};
  const auto after = [&](const ZoneEdit& edit) {
    auto edited_zone = with_edit(zone, edit);
    EXPECT_TRUE(edited_zone);
    return edited_zone->priorities;
  };
  EXPECT_THAT(after(priority_edit("C/1", 999)), ElementsAre(Pair("B/1", 5), Pair("C/1", 999), Pair("D/1", 7)));
  EXPECT_THAT(after(priority_edit("E/1", 1)), ElementsAre(Pair("B/1", 5), Pair("D/1", 7), Pair("E/1", 1)));
  EXPECT_THAT(after(priority_edit("B/1", 6)), ElementsAre(Pair("B/1", 6), Pair("D/1", 7)));
  EXPECT_THAT(after(priority_edit("B/1", 0)), ElementsAre(Pair("D/1", 7)));
  EXPECT_THAT(after(priority_edit("A/1", 0)), ElementsAre(Pair("B/1", 5), Pair("D/1", 7)));
  EXPECT_EQ(refusal(priority_edit("A/1", -1)), "edit.priority");
  EXPECT_EQ(refusal(priority_edit("A/1", 1000)), "edit.priority");
}

TEST(WithEdit, refuses_what_occurs_twice_and_reports_the_first_fault) {
  ZoneEdit edit = tag_edit(7, {0, 1.0});
  edit.set_tags.push_back({7, {0, 1.5}});
  EXPECT_EQ(refusal(edit), "edit.twice");
  EXPECT_EQ(with_edit(small_zone(), edit).error().location, "tag 7");
  ZoneEdit two = priority_edit("a/b", 1);
  two.set_priorities.emplace_back("a/b", 1);
  EXPECT_EQ(refusal(two), "edit.twice");
  ZoneEdit faults = tag_edit(0, {0, 1.0});
  faults.beacon_pitch_m = 99.0;
  faults.set_priorities.emplace_back("none", 1);
  EXPECT_EQ(refusal(faults), "edit.number");
  faults.set_tags.clear();
  EXPECT_EQ(refusal(faults), "edit.pitch");
  faults.remove_tags = {77, 78};
  EXPECT_EQ(with_edit(small_zone(), faults).error().location, "tag 77");
  faults = priority_edit("none", 1);
  faults.set_priorities.emplace_back("a/b", 1000);
  EXPECT_EQ(with_edit(small_zone(), faults).error().location, "none");
}

TEST(VehicleName, is_a_manufacturer_a_slash_and_a_serial_number) {
  for (const std::string& good : {std::string("a/b"), "m/" + std::string(126, 's'), std::string("Ä b/c-1")})
    EXPECT_FALSE(wrong_vehicle_name(good)) << good;
  for (const std::string& bad :
       {std::string(), std::string("/"), std::string("a"), std::string("a/"), std::string("/b"), std::string("a/b/c"),
        std::string("a/b/"), "m/" + std::string(127, 's'), std::string("a/+"), std::string("#/b"),
        std::string("a\x1F/b"), std::string("a/\x7F")})
    EXPECT_TRUE(wrong_vehicle_name(bad)) << bad;
}

// Differences
// ---------------------------------------------------------------------------------------------------------

/// A zone with something of everything.
TrafficZone full_zone() {
  TrafficZone zone = testing::lacet4();
  zone.loops = {{"round", {0, 1}}};
  zone.closed = {2};
  zone.priorities = {{"a/b", 3}};
  return zone;
}

Circuit changed(const Circuit& circuit, const std::function<void(std::vector<Circuit::Part>&)>& change) {
  std::vector<Circuit::Part> parts;
  for (SectionId id = 0; id < circuit.size(); ++id) parts.push_back(circuit.part(id));
  change(parts);
  auto made = Circuit::make(circuit.name(), std::move(parts), 10.0, 10.0);
  EXPECT_TRUE(made) << to_string(made.error());
  return std::move(*made);
}

TEST(SameGeometry, differ_in_every_property_of_a_section_a_crossing_or_a_waypoint) {
  const TrafficZone zone = full_zone();
  using Parts = std::vector<Circuit::Part>;
  const Section& east = zone.circuit.section(0);
  const auto reshaped = [&](Pose2 start, double length_m, double curvature_per_m, double rate_per_m2) {
    return [=](Parts& parts) { parts[0].section = *Section::make(start, length_m, curvature_per_m, rate_per_m2); };
  };
  const Pose2 start = east.start();
  const double length_m = east.length_m();
  const std::vector<std::pair<const char*, std::function<void(Parts&)>>> changes{
      {"name", [](Parts& parts) { parts[0].name = "other"; }},
      {"start", reshaped({start.x_m, start.y_m + 1e-6, start.heading_rad}, length_m, 0.0, 0.0)},
      {"length", reshaped(start, length_m + 1e-6, 0.0, 0.0)},
      {"curvature", reshaped(start, length_m, 1e-6, 0.0)},
      {"end's curvature", reshaped(start, length_m, 0.0, 1e-6)},
      {"limit", [](Parts& parts) { parts[0].speed_mps_max = 0.1; }},
      {"successors", [](Parts& parts) { parts[0].next.clear(); }},
      {"turn on the spot", [](Parts& parts) { parts[0].pivots = !parts[0].pivots; }},
      {"number", [](Parts& parts) {
         parts.push_back({"extra", *Section::make({}, 1.0), std::nullopt, {}, false});
       }}};
  for (const auto& [what, change] : changes) {
    TrafficZone other = zone;
    other.circuit = changed(zone.circuit, change);
    EXPECT_FALSE(same_geometry(zone, other)) << what;
    EXPECT_FALSE(same_geometry(other, zone)) << what;
    EXPECT_EQ(difference(zone, other), "its sections differ") << what;
  }
  const auto expect_other = [&](const char* what, const auto& change) {
    TrafficZone other = zone;
    change(other);
    EXPECT_FALSE(same_geometry(zone, other)) << what;
  };
  expect_other("zone's name", [](TrafficZone& other) { other.name += "x"; });
  expect_other("length", [](TrafficZone& other) { other.vehicle.length_m += 0.01; });
  expect_other("width", [](TrafficZone& other) { other.vehicle.width_m += 0.01; });
  for (auto profile : {&SpeedProfiles::slow, &SpeedProfiles::medium, &SpeedProfiles::fast}) {
    for (auto value : {&SpeedProfile::speed_mps, &SpeedProfile::acceleration_mps2, &SpeedProfile::braking_mps2})
      expect_other("profile", [=](TrafficZone& other) { other.profiles.*profile.*value += 0.01; });
  }
  const auto with_crossing = [&](const auto& change) {
    return [change](TrafficZone& other) {
      Crossing crossing = other.crossings[0];
      change(crossing);
      other.crossings.replace(0, crossing);
    };
  };
  expect_other("crossing", with_crossing([](Crossing& crossing) { crossing.name += "x"; }));
  expect_other("span", with_crossing([](Crossing& crossing) { crossing.spans[0].section += 1; }));
  expect_other("span", with_crossing([](Crossing& crossing) { crossing.spans[0].from_m += 0.01; }));
  expect_other("span", with_crossing([](Crossing& crossing) { crossing.spans[0].to_m += 0.01; }));
  expect_other("spans", with_crossing([](Crossing& crossing) { crossing.spans.pop_back(); }));
  expect_other("crossings", [](TrafficZone& other) {
    other.crossings.erase_if([&](const Crossing& crossing) { return crossing.name == "X1"; });
  });
  const auto with_waypoint = [&](const auto& change) {
    return [change](TrafficZone& other) {
      Waypoint waypoint = other.waypoints[1];
      change(waypoint);
      other.waypoints.replace(1, waypoint);
    };
  };
  expect_other("waypoint", with_waypoint([](Waypoint& waypoint) { waypoint.id += "x"; }));
  expect_other("waypoint", with_waypoint([](Waypoint& waypoint) { waypoint.position.s_m += 0.01; }));
  expect_other("waypoint", with_waypoint([](Waypoint& waypoint) { waypoint.position.section += 1; }));
}

TEST(Difference, names_the_part_of_the_zone_that_differs) {
  const TrafficZone zone = full_zone();
  EXPECT_FALSE(difference(zone, zone));
  const auto expect_difference = [&](const char* text, const auto& change) {
    TrafficZone other = zone;
    change(other);
    EXPECT_EQ(difference(zone, other), text);
    EXPECT_EQ(difference(other, zone), text);
  };
  const auto with_tag = [](const Tag& tag) { return [tag](TrafficZone& other) { other.tags.replace(0, tag); }; };
  Tag tag = zone.tags[0];
  tag.number = 99;
  expect_difference("its tags differ", with_tag(tag));
  tag = zone.tags[0];
  tag.position.s_m += 0.01;
  expect_difference("its tags differ", with_tag(tag));
  tag = zone.tags[0];
  tag.position.section += 1;
  expect_difference("its tags differ", with_tag(tag));
  expect_difference("its tags differ", [](TrafficZone& other) { other.tags.push_back({99, {0, 0.1}}); });

  expect_difference("its beacons differ", [](TrafficZone& other) { other.beacons.reset(); });
  expect_difference("its beacons differ", [](TrafficZone& other) { other.beacons->pitch_m += 0.01; });
  expect_difference("its beacons differ", [](TrafficZone& other) { other.beacons->origin.x_m += 0.01; });
  expect_difference("its beacons differ", [](TrafficZone& other) { ++other.beacons->columns; });
  expect_difference("its beacons differ", [](TrafficZone& other) { ++other.beacons->rows; });
  expect_difference("its beacons differ", [](TrafficZone& other) { ++other.beacons->first_number; });
  expect_difference("its beacons differ", [](TrafficZone& other) { other.beacons->rotation_rad += 0.01; });
  expect_difference("its beacons differ", [](TrafficZone& other) { other.beacons->covers_through = Point2{7.0, 7.0}; });

  expect_difference("its stations or starts differ", [](TrafficZone& other) { other.stations[0].name += "x"; });
  expect_difference("its stations or starts differ",
                    [](TrafficZone& other) { other.stations[0].position.s_m += 0.01; });
  expect_difference("its stations or starts differ", [](TrafficZone& other) {
    StationKind& kind = other.stations[0].kind;
    kind = kind == StationKind::stop ? StationKind::charger : StationKind::stop;
  });
  expect_difference("its stations or starts differ", [](TrafficZone& other) { other.stations.pop_back(); });
  expect_difference("its stations or starts differ", [](TrafficZone& other) { other.starts[0].s_m += 0.01; });

  expect_difference("its loops or closed sections differ", [](TrafficZone& other) { other.loops[0].name += "x"; });
  expect_difference("its loops or closed sections differ",
                    [](TrafficZone& other) { other.loops[0].sections.pop_back(); });
  expect_difference("its loops or closed sections differ", [](TrafficZone& other) { other.loops.clear(); });
  expect_difference("its loops or closed sections differ", [](TrafficZone& other) { other.closed = {3}; });
  expect_difference("its edges' names differ",
                    [](TrafficZone& other) { other.edges_are_sections = !other.edges_are_sections; });
  expect_difference("its priorities differ", [](TrafficZone& other) { other.priorities[0].second = 4; });
}

TEST(Priorities, are_read_sorted_and_without_zeros) {
  const TrafficZone zone = parsed(file(straight + "[priorities]\n\"B/2\" = 7\n\"A/1\" = 999\n\"C/3\" = 0\n"));
  EXPECT_THAT(zone.priorities, ElementsAre(Pair("A/1", 999), Pair("B/2", 7)));
  EXPECT_EQ(zone.priority_of("B/2"), 7);
  EXPECT_EQ(zone.priority_of("C/3"), 0);
  EXPECT_EQ(zone.priority_of(""), 0);
}

TEST(Priorities, that_are_invalid_are_refused_with_their_line) {
  for (const char* bad :
       {"\"A/1\" = 1000", "\"A/1\" = -1", "\"A/1\" = 1.5", "\"A/1\" = \"3\"", "A1 = 3", "\"A/\" = 3"}) {
    const auto zone = testing::read_zone(straight + "[priorities]\n" + bad + "\n");
    ASSERT_FALSE(zone) << bad;
    EXPECT_EQ(zone.error().code, "zone.field") << bad;
    EXPECT_THAT(zone.error().location, HasSubstr("test.toml:8: priorities.")) << bad;
  }
}

// Any edits
// ---------------------------------------------------------------------------------------------------------

std::vector<std::string> comments(const std::string& text) {
  std::vector<std::string> found;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);)
    if (const auto at = line.find('#'); at != std::string::npos) found.push_back(line.substr(at));
  return found;
}

/// One edit that fits a zone with these tags, as an operator might click it together.
ZoneEdit arbitrary_edit(const TrafficZone& zone, const std::map<TagNumber, TrackPosition>& tags) {
  const auto position = [&] {
    const auto section = *rc::gen::inRange<SectionId>(0, static_cast<SectionId>(zone.circuit.size()));
    const double ratio = *rc::gen::inRange(0, 1001) * 1e-3;
    return TrackPosition{section, ratio * zone.circuit.section(section).length_m()};
  };
  ZoneEdit edit;
  std::set<TagNumber> used;
  const int changes = *rc::gen::inRange(1, 4);
  for (int i = 0; i < changes; ++i) {
    const auto kind = *rc::gen::inRange(0, 5);
    const TagNumber number = *rc::gen::inRange<TagNumber>(1, 30);
    const bool fresh = used.insert(number).second;
    if (kind <= 1 && fresh) edit.set_tags.push_back({number, position()});
    if (kind == 2 && fresh && tags.count(number) > 0) edit.remove_tags.push_back(number);
    if (kind == 3) edit.beacon_pitch_m = *rc::gen::inRange(50, 1000) * 1e-3;
    if (kind == 4 && edit.set_priorities.empty())
      edit.set_priorities.emplace_back("CoSiVA/AIV" + std::to_string(*rc::gen::inRange(1, 5)),
                                       *rc::gen::inRange(0, 1000));
  }
  return edit;
}

TEST(ZoneEdit, of_any_kind_in_any_order_leaves_exactly_the_wanted_zone_and_every_comment) {
  const ZoneConfiguration start = lacet4_file();
  const TrafficZone first = parsed(start);
  const auto logged = comments(start.text);
  EXPECT_TRUE(rc::check([&] {
    ZoneConfiguration now = start;
    std::map<TagNumber, TrackPosition> tags;
    std::map<std::string, std::int32_t> priorities;
    for (const Tag& tag : first.tags) tags[tag.number] = tag.position;
    double pitch_m = first.beacons->pitch_m;
    const int edits = *rc::gen::inRange(1, 4);
    for (int i = 0; i < edits; ++i) {
      const ZoneEdit edit = arbitrary_edit(first, tags);
      const auto after = edited(now, edit);
      if (!after) RC_FAIL(to_string(after.error()));
      now = *after;
      for (const TagNumber number : edit.remove_tags) tags.erase(number);
      for (const auto& [number, position] : edit.set_tags) tags[number] = position;
      for (const auto& [vehicle, priority] : edit.set_priorities) {
        priorities.erase(vehicle);
        if (priority > 0) priorities[vehicle] = priority;
      }
      if (edit.beacon_pitch_m) pitch_m = *edit.beacon_pitch_m;
    }
    const TrafficZone last = parsed(now);
    RC_ASSERT(last.tags.size() == tags.size());
    for (const Tag& tag : last.tags) {
      RC_ASSERT(tags.count(tag.number) == 1U);
      RC_ASSERT(tag.position.section == tags[tag.number].section);
      RC_ASSERT(std::fabs(tag.position.s_m - tags[tag.number].s_m) <= 1e-4);  // 4 decimals, down at a section's end
    }
    RC_ASSERT(
        (last.priorities == std::vector<std::pair<std::string, std::int32_t>>(priorities.begin(), priorities.end())));
    RC_ASSERT(std::fabs(last.beacons->pitch_m - pitch_m) <= 0.5e-4);
    RC_ASSERT(same_geometry(first, last));
    RC_ASSERT(last.stations.size() == first.stations.size());
    RC_ASSERT(last.starts == first.starts);
    RC_ASSERT(comments(now.text) == logged);
  }));
}

}  // namespace
}  // namespace cosiva::zone
