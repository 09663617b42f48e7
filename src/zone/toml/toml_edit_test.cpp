// Edits of a file's text that src/zone/edit does not try: at the end of the file, in tables of one line, and between
// others.
#include "cosiva/zone/toml/toml_edit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/zone/edit/edit.h"
#include "cosiva/zone/layout/rounding.h"
#include "cosiva/zone/testing/test_zones.h"
#include "cosiva/zone/toml/toml_factory.h"

namespace cosiva::zone {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;
using testing::straight;

Result<ZoneConfiguration> edited_plant(const std::string& text, const ZoneEdit& edit) {
  return TomlCircuitFactory{}.edited({"toml", "plant.toml", text, {}}, edit);
}
std::string text_after(const std::string& text, const ZoneEdit& edit) {
  const auto result = edited_plant(text, edit);
  return result ? result->text : "refused: " + to_string(result.error());
}
ZoneEdit tag_put(TagNumber number, double s_m) {
  ZoneEdit edit;
  edit.set_tags = {{number, {0, s_m}}};
  return edit;
}
ZoneEdit tag_removed(TagNumber number) {
  ZoneEdit edit;
  edit.remove_tags = {number};
  return edit;
}
ZoneEdit priorities_set(std::vector<std::pair<std::string, std::int32_t>> priorities) {
  ZoneEdit edit;
  edit.set_priorities = std::move(priorities);
  return edit;
}
std::string tag_text(const std::string& number, const std::string& s_m) {
  return "[[tag]]\nnumber = " + number + "\nsection = \"a\"\ns_m = " + s_m + "\n";
}
std::string with_line_ends(const std::string& text, const std::string& end) {
  std::string changed;
  for (const char c : text) changed += c == '\n' ? end : std::string(1, c);
  return changed;
}

TEST(TomlEdit, adds_a_tag_behind_one_that_ends_the_file_without_a_newline) {
  const std::string before = straight + "\n" + tag_text("1", "0.5");
  EXPECT_EQ(text_after(before.substr(0, before.size() - 1), tag_put(2, 1.0)), before + "\n" + tag_text("2", "1.00"));
}

TEST(TomlEdit, removes_a_blank_line_behind_a_tag_only_where_one_is_before_it) {
  const std::string station = "[[station]]\nname = \"s\"\nsection = \"a\"\ns_m = 1.0\n";
  const std::string tag = tag_text("1", "0.5");
  EXPECT_EQ(text_after(straight + "\n" + tag + "\n" + station, tag_removed(1)), straight + "\n" + station);
  EXPECT_EQ(text_after(straight + "\n" + tag + " \t\n" + station, tag_removed(1)), straight + "\n" + station);
  EXPECT_EQ(text_after(straight + " \n" + tag + "\n" + station, tag_removed(1)), straight + " \n" + station);
  EXPECT_EQ(text_after(straight + "# gate\n" + tag + "\n" + station, tag_removed(1)),
            straight + "# gate\n\n" + station);
  EXPECT_EQ(text_after(straight + "\n" + tag + station, tag_removed(1)), straight + "\n" + station);
  EXPECT_EQ(text_after(straight + "\n" + tag, tag_removed(1)), straight + "\n");
  EXPECT_EQ(text_after(straight + tag, tag_removed(1)), straight);
}

TEST(TomlEdit, removes_lines_with_the_ends_of_another_system) {
  const std::string before = straight + "\n" + tag_text("1", "0.5") + "\n" + tag_text("2", "1.0");
  const std::string after = straight + "\n" + tag_text("2", "1.0");
  EXPECT_EQ(text_after(with_line_ends(before, "\r\n"), tag_removed(1)), with_line_ends(after, "\r\n"));
}

TEST(TomlEdit, refuses_to_rewrite_lists_of_one_line_with_the_file_s_name) {
  const auto listed =
      edited_plant("tag = [ { number = 1, section = \"a\", s_m = 0.5 } ]\n" + straight, tag_put(2, 1.0));
  ASSERT_FALSE(listed);
  EXPECT_EQ(listed.error().code, "edit.format");
  EXPECT_EQ(listed.error().location, "plant.toml");
  EXPECT_THAT(listed.error().message, StartsWith("the tags of this file are in a list; write each under"));
  const std::string in_one_line = "priorities = { \"A/1\" = 1 }\n" + straight;
  for (const ZoneEdit& edit : {priorities_set({{"A/1", 0}}), priorities_set({{"B/2", 1}})}) {
    const auto refused = edited_plant(in_one_line, edit);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, "edit.format");
    EXPECT_EQ(refused.error().location, "plant.toml");
    EXPECT_THAT(refused.error().message, StartsWith("the priorities of this file are in one line;"));
  }
  EXPECT_EQ(text_after(in_one_line, priorities_set({{"B/2", 0}})), in_one_line) << "which has none";
  EXPECT_EQ(text_after(straight, priorities_set({{"B/2", 0}})), straight);
}

TEST(TomlEdit, changes_adds_and_removes_priorities_between_other_tables) {
  const auto file_with = [](const std::string& priorities) {
    return "[vehicle]\nlength_m = 0.2\nwidth_m = 0.12\n[priorities]\n" + priorities + "[beacons]\npitch_m = 1\n" +
           "columns = 1\nrows = 1\n";
  };
  EXPECT_EQ(text_after(straight + file_with("\"A/1\" = 1\n\"B/2\" = 2\n"),
                       priorities_set({{"A/1", 0}, {"B/2", 5}, {"C/3", 999}})),
            straight + file_with("\"B/2\" = 5\n\"C/3\" = 999\n"));
  // At the very end, without a newline.
  EXPECT_EQ(text_after(straight + "[priorities]\n\"A/1\" = 1", priorities_set({{"B/2", 2}})),
            straight + "[priorities]\n\"A/1\" = 1\n\"B/2\" = 2\n");
}

TEST(TomlEdit, writes_pitch_origin_and_rotation_of_beacons_in_one_line) {
  ZoneEdit edit;
  edit.beacon_pitch_m = 0.5;
  edit.beacon_origin = Point2{0.5, -0.25};
  edit.beacon_rotation_rad = 0.5 * pi;
  EXPECT_EQ(
      text_after("beacons = { pitch_m = 1, columns = 3, rows = 2 } # few\n" + straight, edit),
      "beacons = { pitch_m = 0.50, origin = [0.50, -0.25], rotation_deg = 90.00, columns = 3, rows = 2 } # few\n" +
          straight);
}

TEST(TomlEdit, keeps_the_unit_of_the_beacons_rotation) {
  const std::string before = straight + "[beacons]\npitch_m = 1\ncolumns = 3\nrows = 2\nrotation_rad = 0.25\n";
  ZoneEdit edit;
  edit.beacon_rotation_rad = 0.1;  // 5.72958°, written with four decimals
  const auto after = edited_plant(before, edit);
  ASSERT_TRUE(after) << to_string(after.error());
  EXPECT_THAT(after->text, HasSubstr("\nrotation_rad = 0.10000038"));
  EXPECT_THAT(after->text, Not(HasSubstr("rotation_deg")));
  EXPECT_EQ(TomlCircuitFactory{}.make_zone(*after)->beacons->rotation_rad, 5.7296 * rad_per_deg);
}

TEST(TomlEdit, changes_nothing_without_a_change) {
  const std::string before = "# plant\n" + straight + tag_text("1", "0.5") + "[priorities]\n\"A/1\" = 1\n";
  EXPECT_EQ(text_after(before, {}), before);
}

std::string sidecar_with_scale(const std::string& sidecar, const std::string& scale = "0.5") {
  const auto result = with_import({"movingai", "a.map", "", sidecar}, "scale", scale);
  return result ? result->sidecar : "refused: " + to_string(result.error());
}

TEST(Import, has_a_key_that_is_written_into_the_sidecar_file_wherever_that_has_room_for_it) {
  EXPECT_EQ(sidecar_with_scale(""), "[import]\nscale = 0.5\n");
  EXPECT_EQ(sidecar_with_scale("name = \"a\""), "name = \"a\"\n[import]\nscale = 0.5\n");
  EXPECT_EQ(sidecar_with_scale("[import]\nlayout = \"b\"\n"), "[import]\nscale = 0.5\nlayout = \"b\"\n");
  EXPECT_EQ(sidecar_with_scale("[import] # squares\nscale = 3 # m\n[vehicle]\n", "1.25"),
            "[import] # squares\nscale = 1.25 # m\n[vehicle]\n");
  EXPECT_EQ(sidecar_with_scale("import = { scale = 3 }\n"), "import = { scale = 0.5 }\n");
}

TEST(Import, has_no_line_for_a_key_in_a_table_without_a_header) {
  EXPECT_THAT(sidecar_with_scale("import = { layout = \"b\" }\n"), StartsWith("refused: a.zone.toml: "));
  EXPECT_THAT(sidecar_with_scale("[import\n"), StartsWith("refused: a.zone.toml: cannot be read"));
}

}  // namespace
}  // namespace cosiva::zone
