// The formats that the program knows, and what a zone does with each.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <string_view>

#include "cosiva/zone/edit/edit.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::zone {
namespace {

using ::testing::ElementsAre;

TEST(Formats, are_toml_lif_opendrive_and_movingai) {
  EXPECT_THAT(known_formats(), ElementsAre("toml", "lif", "opendrive", "movingai"));
  for (const std::string_view format : known_formats()) {
    const auto factory = circuit_factory_for(format);
    ASSERT_TRUE(factory) << format;
    EXPECT_EQ((*factory)->format(), format);
  }
  const auto none = circuit_factory_for("c" + std::string(60, 'a'));
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, "zone.format");
  EXPECT_EQ(none.error().message, "no circuit factory for the format 'c" + std::string(39, 'a') +
                                      "'; known formats: toml, lif, opendrive, movingai");
}

TEST(Formats, are_recognised_by_the_ending_of_a_file_s_name) {
  EXPECT_EQ(format_of_file("zones/a.toml"), "toml");
  EXPECT_EQ(format_of_file("a.lif.json"), "lif");
  EXPECT_EQ(format_of_file("a.b.xodr"), "opendrive");
  EXPECT_EQ(format_of_file("maps/a.map"), "movingai");
  const auto none = format_of_file("a.dxf");
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, "zone.format");
  EXPECT_EQ(none.error().location, "a.dxf");
  EXPECT_TRUE(none.error().message.starts_with("a zone's file ends with one of .toml, .lif")) << none.error().message;
  EXPECT_TRUE(none.error().message.ends_with(".xodr, .map")) << none.error().message;
}

TEST(Formats, other_than_the_native_one_have_a_sidecar_file) {
  EXPECT_EQ(sidecar_of_file("zones/a.xodr"), "zones/a.zone.toml");
  EXPECT_EQ(sidecar_of_file("a.lif.json"), "a.zone.toml");
  EXPECT_EQ(sidecar_of_file("a.toml"), std::nullopt);
  EXPECT_EQ(sidecar_of_file("a.dxf"), std::nullopt);
}

TEST(Formats, of_squares_have_a_pitch_which_the_sidecar_file_keeps) {
  const ZoneConfiguration map{"movingai", "a.map", "height 1\nwidth 2\nmap\n..\n", ""};
  const auto wider = with_pitch(map, 2.5);
  ASSERT_TRUE(wider);
  const auto rtm = Rtm::initialise(*wider);
  ASSERT_TRUE(rtm) << to_string(rtm.error());
  EXPECT_EQ(rtm->zone().circuit.section(0).length_m(), 2.5);
  const auto other = with_pitch({"lif", "a.lif.json", "{}", ""}, 2.5);
  ASSERT_FALSE(other);
  EXPECT_EQ(other.error().code, "zone.format");
  EXPECT_EQ(other.error().location, "a.lif.json");
}

TEST(Formats, that_are_unknown_are_a_fault_at_the_file_s_origin) {
  const ZoneConfiguration unknown{"dxf", "plant.dxf", ""};
  const auto all = faults(unknown);
  ASSERT_EQ(all.size(), 1U);
  EXPECT_EQ(all[0].code, "zone.format");
  EXPECT_EQ(all[0].location, "plant.dxf");
  const auto rtm = Rtm::initialise(unknown);
  ASSERT_FALSE(rtm);
  EXPECT_EQ(rtm.error(), all[0]);
  const auto changed = edited(unknown, ZoneEdit{});
  ASSERT_FALSE(changed);
  EXPECT_EQ(changed.error().code, "zone.format");
}

TEST(Rtm, counts_each_initialisation_even_one_that_fails) {
  const std::uint64_t before = Rtm::initialised_count();
  EXPECT_FALSE(Rtm::initialise({"dxf", "plant.dxf", ""}));
  EXPECT_EQ(Rtm::initialised_count() - before, 1U);
  const ZoneConfiguration good{
      "toml", "a.toml",
      "name = \"a\"\nformat_version = 1\n[[section]]\nname = \"s\"\nkind = \"straight\"\nlength_m = 2\n"};
  const auto rtm = Rtm::initialise(good);
  ASSERT_TRUE(rtm);
  EXPECT_EQ(Rtm::initialised_count() - before, 2U);
  EXPECT_EQ(rtm->configuration(), good);
  EXPECT_EQ(rtm->zone().circuit.size(), 1U);
}

}  // namespace
}  // namespace cosiva::zone
