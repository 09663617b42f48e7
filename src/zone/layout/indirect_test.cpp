#include "cosiva/zone/layout/indirect.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "cosiva/zone/testing/test_zones.h"

namespace cosiva::zone {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// A ready zone for travel in the other direction.
TrafficZone indirect(const std::string& file) {
  const auto configuration = in_travel_direction(testing::configuration_file(file), TravelDirection::indirect);
  EXPECT_TRUE(configuration) << to_string(configuration.error());
  const auto rtm = Rtm::initialise(*configuration);
  EXPECT_TRUE(rtm) << (rtm ? "" : to_string(rtm.error()));
  return rtm->zone();
}

TrafficZone direct(const std::string& file) { return Rtm::initialise(testing::configuration_file(file))->zone(); }

TEST(IndirectZone, has_its_tags_stations_and_beacons_at_the_same_points) {
  for (const char* file : {"lacet4.toml", "indus8.toml"}) {
    const TrafficZone there = direct(file);
    const TrafficZone back = indirect(file);
    EXPECT_TRUE(back.circuit.indirect());
    EXPECT_FALSE(there.circuit.indirect());
    EXPECT_EQ(back.name, there.name + "-indirect");
    EXPECT_EQ(back.circuit.name(), back.name) << "the page shows the drawn circuit's name";
    EXPECT_TRUE(is_reversed(back.circuit, there.circuit));
    ASSERT_EQ(back.tags.size(), there.tags.size());
    for (std::size_t i = 0; i < there.tags.size(); ++i) {
      EXPECT_EQ(back.tags[i].number, there.tags[i].number);
      EXPECT_NEAR(distance(back.circuit.pose_at(back.tags[i].position), there.circuit.pose_at(there.tags[i].position)),
                  0.0, 1e-9);
    }
    ASSERT_EQ(back.stations.size(), there.stations.size());
    for (std::size_t i = 0; i < there.stations.size(); ++i)
      EXPECT_NEAR(
          distance(back.circuit.pose_at(back.stations[i].position), there.circuit.pose_at(there.stations[i].position)),
          0.0, 1e-9);
    ASSERT_EQ(back.beacons.has_value(), there.beacons.has_value());
    if (there.beacons) {
      EXPECT_EQ(back.beacons->columns, there.beacons->columns);
    }
    EXPECT_EQ(back.starts.size(), there.starts.size());
  }
}

TEST(IndirectZone, has_the_same_crossings_and_lets_vehicles_stop_before_each) {
  const TrafficZone there = direct("lacet4.toml");
  const TrafficZone back = indirect("lacet4.toml");
  ASSERT_EQ(back.crossings.size(), there.crossings.size());
  for (const Crossing& crossing : back.crossings) {
    for (const CrossingSpan& span : crossing.spans) {
      if (span.from_m < 0.01) continue;
      const std::size_t before = back.waypoint_behind({span.section, span.from_m - 1e-6});
      ASSERT_LT(before, back.waypoints.size());
      EXPECT_EQ(back.crossing_at(back.waypoints[before].position), nullptr) << crossing.name;
    }
  }
}

TEST(IndirectZone, has_its_loops_in_the_other_order) {
  const std::string text = testing::straight +
                           "next = [\"b\"]\n[[section]]\nname = \"b\"\nkind = \"arc\"\nradius_m = 1.0\nangle_deg = 90\n"
                           "next = []\n";
  const auto zone = testing::read_zone("travel_direction = \"indirect\"\n" + text);
  ASSERT_TRUE(zone) << to_string(zone.error());
  EXPECT_THAT(zone->circuit.next(1), ElementsAre(0));
  EXPECT_THAT(zone->circuit.next(0), ElementsAre());
  EXPECT_NEAR(zone->circuit.section(1).start().y_m, 1.0, 1e-9);
}

TEST(IndirectZone, is_read_from_one_of_two_terms_and_no_other) {
  EXPECT_FALSE(testing::read_zone("travel_direction = \"direct\"\n" + testing::straight)->circuit.indirect());
  EXPECT_TRUE(testing::read_zone("travel_direction = \"indirect\"\n" + testing::straight)->circuit.indirect());
  const auto refused = testing::read_zone("travel_direction = \"backwards\"\n" + testing::straight);
  ASSERT_FALSE(refused);
  EXPECT_THAT(to_string(refused.error()), HasSubstr("indirect"));
}

TEST(IndirectZone, of_a_format_without_the_key_has_it_in_the_sidecar_file) {
  const TrafficZone back = indirect("workshop.lif.json");
  EXPECT_TRUE(back.circuit.indirect());
  EXPECT_TRUE(is_reversed(back.circuit, direct("workshop.lif.json").circuit));
}

TEST(TravelDirectionText, is_one_line_behind_the_version_and_changes_in_place) {
  const ZoneConfiguration plain{"toml", "z.toml", testing::straight};
  const auto back = in_travel_direction(plain, TravelDirection::indirect);
  ASSERT_TRUE(back);
  EXPECT_THAT(back->text, HasSubstr("format_version = 1\ntravel_direction = \"indirect\"\n"));
  const auto again = in_travel_direction(*back, TravelDirection::direct);
  ASSERT_TRUE(again);
  EXPECT_FALSE(testing::read_zone(again->text)->circuit.indirect());
  EXPECT_EQ(in_travel_direction(*again, TravelDirection::indirect)->text, back->text);
  EXPECT_EQ(in_travel_direction(plain, TravelDirection::direct)->text, plain.text);
  EXPECT_FALSE(in_travel_direction({"toml", "z.toml", "no = = toml"}, TravelDirection::indirect));
}

TEST(TravelDirectionText, survives_an_edit_whose_tag_lies_where_it_was_put) {
  const auto configuration =
      in_travel_direction(testing::configuration_file("lacet4.toml"), TravelDirection::indirect).value();
  const TrafficZone before = Rtm::initialise(configuration)->zone();
  ZoneEdit edit;
  edit.set_tags = {{before.tags[0].number, {before.tags[0].position.section, 0.3}}};
  const auto after = edited(configuration, edit);
  ASSERT_TRUE(after) << to_string(after.error());
  const TrafficZone zone = Rtm::initialise(*after)->zone();
  EXPECT_TRUE(zone.circuit.indirect());
  EXPECT_NEAR(zone.find_tag(before.tags[0].number)->position.s_m, 0.3, 1e-4);
}

}  // namespace
}  // namespace cosiva::zone
