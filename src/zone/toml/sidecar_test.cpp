#include "cosiva/zone/toml/sidecar.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cosiva/zone/edit/edit.h"
#include "cosiva/zone/layout/waypoints.h"
#include "cosiva/zone/testing/test_zones.h"
#include "cosiva/zone/toml/toml_edit.h"

namespace cosiva::zone {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Pair;
using ::testing::SizeIs;
using ::testing::StartsWith;

/// A format whose every file is a running track with a dock, and which leaves everything else to its sidecar file.
class TrackFactory final : public CircuitFactory {
 public:
  std::string_view format() const override { return "track"; }
  std::vector<std::string_view> file_endings() const override { return {".track"}; }
  Result<TrafficZone> make_zone(const ZoneConfiguration& configuration) const override {
    const auto sidecar = read_sidecar(configuration);
    if (!sidecar) return tl::unexpected(sidecar.error());
    TrafficZone zone{
        sidecar->name.value_or("track"), testing::track(2.0 * sidecar->scale), {}, {}, {}, {}, {}, {}, {}, {}};
    zone.stations = {{"dock", {0, 1.0}, StationKind::stop}};
    zone.closed = {3};
    WaypointRules rules;
    rules.start_ids = {"N1", "N2", "N3", "N4"};
    if (const auto done = furnish(zone, configuration, *sidecar, rules); !done) return tl::unexpected(done.error());
    return zone;
  }
  Result<ZoneConfiguration> edited(const ZoneConfiguration& configuration, const ZoneEdit& edit) const override {
    return edited_sidecar(*this, configuration, edit);
  }
};

ZoneConfiguration file(const std::string& sidecar) { return {"track", "plants/area.track", "?", sidecar}; }
Result<TrafficZone> read(const std::string& sidecar) { return TrackFactory{}.make_zone(file(sidecar)); }
std::string error_of(const std::string& sidecar) {
  const auto zone = read(sidecar);
  return zone ? "no error" : zone.error().code + " " + to_string(zone.error());
}

TEST(Sidecar, that_is_empty_leaves_the_defaults) {
  const auto zone = read("");
  ASSERT_TRUE(zone) << to_string(zone.error());
  EXPECT_EQ(zone->name, "track");
  EXPECT_EQ(zone->vehicle.length_m, 0.20);
  EXPECT_EQ(zone->profiles.medium.speed_mps, 0.30);
  EXPECT_THAT(zone->stations, SizeIs(1));
  EXPECT_THAT(zone->closed, ElementsAre(3));
  EXPECT_EQ(zone->waypoints.front().id, "N1");
  EXPECT_FALSE(zone->beacons);
}

TEST(Sidecar, adds_all_that_the_format_cannot_express) {
  const auto zone = read(R"(name = "area"
[import]
scale = 2.0
[vehicle]
length_m = 0.3
width_m = 0.2
[profiles.slow]
speed_mps = 0.1
acceleration_mps2 = 0.2
braking_mps2 = 0.4
[crossings]
clearance_m = 0.1
[waypoints]
nodes_only = true
[[limit]]
section = "east"
speed_mps_max = 0.25
[beacons]
pitch_m = 0.5
cover = "zone"
[[tag]]
number = 5
section = "south"
s_m = 3.5
[[station]]
name = "plug"
kind = "charger"
section = "north"
s_m = 1
[[start]]
section = "south"
s_m = 0.5
[[loop]]
name = "round"
sections = ["south", "east", "north", "west"]
[priorities]
"A/1" = 7
[closed]
sections = ["north"]
)");
  ASSERT_TRUE(zone) << to_string(zone.error());
  EXPECT_EQ(zone->name, "area");
  EXPECT_EQ(zone->circuit.section(0).length_m(), 4.0);
  EXPECT_EQ(zone->vehicle.width_m, 0.2);
  EXPECT_EQ(zone->profiles.slow.speed_mps, 0.1);
  EXPECT_EQ(zone->circuit.part(1).speed_mps_max, 0.25);
  EXPECT_FALSE(zone->circuit.part(0).speed_mps_max);
  EXPECT_TRUE(zone->nodes_only);
  EXPECT_EQ(zone->find_tag(5)->position, (TrackPosition{0, 3.5}));
  ASSERT_THAT(zone->stations, SizeIs(2));  // the format's own first
  EXPECT_EQ(zone->stations[0].name, "dock");
  EXPECT_EQ(zone->stations[1].kind, StationKind::charger);
  EXPECT_THAT(zone->starts, SizeIs(1));
  EXPECT_THAT(zone->loops, SizeIs(1));
  EXPECT_THAT(zone->priorities, ElementsAre(Pair("A/1", 7)));
  EXPECT_THAT(zone->closed, ElementsAre(2, 3));
  EXPECT_TRUE(zone->beacons);
}

TEST(Sidecar, reads_the_import_before_the_geometry) {
  const auto sidecar =
      read_sidecar(file("[import]\nscale = 0.001\ntolerance_m = 0.002\ntolerance_rad = 0.01\n"
                        "layout = \"control area 2\"\nvehicle_type = \"AMR\"\n"));
  ASSERT_TRUE(sidecar) << to_string(sidecar.error());
  EXPECT_EQ(sidecar->scale, 0.001);
  EXPECT_EQ(sidecar->tolerance_m, 0.002);
  EXPECT_EQ(sidecar->tolerance_rad, 0.01);
  EXPECT_EQ(sidecar->layout, "control area 2");
  EXPECT_EQ(sidecar->vehicle_type, "AMR");
}

TEST(Sidecar, that_is_wrong_is_refused_with_its_own_file_and_line) {
  EXPECT_THAT(error_of("[vehicle\n"), StartsWith("zone.syntax plants/area.zone.toml:1: "));
  EXPECT_THAT(
      error_of("[import]\nscle = 2\n"),
      StartsWith("zone.unknown_key plants/area.zone.toml:2: import.scle: unknown key; did you mean \"scale\"?"));
  EXPECT_THAT(error_of("\n[import]\nscale = 0\n"), StartsWith("zone.field plants/area.zone.toml:3: import.scale"));
  EXPECT_THAT(error_of("[[section]]\n"), StartsWith("zone.unknown_key"));
  EXPECT_THAT(error_of("format_version = 2\n"), StartsWith("zone.version"));
  EXPECT_THAT(error_of("[[tag]]\nnumber = 1\nsection = \"up\"\ns_m = 0\n"),
              StartsWith("zone.reference plants/area.zone.toml:3: tag[1].section"));
  EXPECT_THAT(error_of("[[limit]]\nsection = \"up\"\nspeed_mps_max = 1\n"),
              StartsWith("zone.reference plants/area.zone.toml:1: limit[1].section"));
  EXPECT_THAT(error_of("[[station]]\nname = \"dock\"\nsection = \"east\"\ns_m = 0\n"),
              HasSubstr("two stations have the name 'dock'"));
  EXPECT_THAT(error_of("[profiles.slow]\nspeed_mps = 0.5\nacceleration_mps2 = 1\nbraking_mps2 = 1\n"),
              StartsWith("zone.field plants/area.zone.toml"));
}

TEST(Sidecar, accepts_a_bend_too_tight_for_the_vehicle_with_a_diagnostic) {
  const auto zone = read("[vehicle]\nlength_m = 0.5\nwidth_m = 1.2\n");
  ASSERT_TRUE(zone) << to_string(zone.error());
  ASSERT_THAT(zone->diagnostics, SizeIs(2));
  EXPECT_EQ(zone->diagnostics[0].kind, Diagnostic::Kind::notice);
  EXPECT_EQ(zone->diagnostics[0].location, "section 'east'");
}

TEST(Sidecar, takes_edits_and_is_created_where_there_is_none) {
  const TrackFactory factory;
  ZoneEdit edit;
  edit.set_tags = {{3, {1, 0.5}}};
  edit.set_priorities = {{"A/1", 2}};
  const auto made = factory.edited(file(""), edit);
  ASSERT_TRUE(made) << to_string(made.error());
  EXPECT_EQ(made->text, "?");
  EXPECT_EQ(made->sidecar, "[[tag]]\nnumber = 3\nsection = \"east\"\ns_m = 0.50\n\n[priorities]\n\"A/1\" = 2\n");
  ZoneEdit beacons;
  beacons.beacon_origin = Point2{0.25, 0.0};
  EXPECT_EQ(factory.edited(*made, beacons).error().code, "edit.beacons");
  const auto moved = factory.edited(file("# ours\n[beacons]\npitch_m = 0.5\ncover = \"zone\"\n"), beacons);
  ASSERT_TRUE(moved) << to_string(moved.error());
  EXPECT_EQ(moved->sidecar, "# ours\n[beacons]\npitch_m = 0.5\norigin = [0.25, 0.00]\ncover = \"zone\"\n");
}

TEST(SidecarFile, has_a_name_derived_from_the_file_it_belongs_to) {
  EXPECT_EQ(sidecar_file("plants/area.lif.json"), "plants/area.zone.toml");
  EXPECT_EQ(sidecar_file("plants.d/area.xodr"), "plants.d/area.zone.toml");
  EXPECT_EQ(sidecar_file("plants.d/area"), "plants.d/area.zone.toml");
  EXPECT_EQ(sidecar_file("area.v2.json"), "area.v2.zone.toml");
  EXPECT_EQ(sidecar_of_file("area.xodr"), "area.zone.toml");
  EXPECT_EQ(sidecar_of_file("area.toml"), std::nullopt);
}

}  // namespace
}  // namespace cosiva::zone
