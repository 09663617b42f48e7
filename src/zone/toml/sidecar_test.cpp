#include "cosiva/zone/toml/sidecar.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "cosiva/zone/drawing/zone_circuit.h"
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
  Result<std::shared_ptr<const DrawableCircuit>> make_circuit(const ZoneConfiguration& configuration) const override {
    return circuit_of(make_zone(configuration));
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

TEST(Sidecar, has_an_import_within_its_limits_and_defaults_without_one) {
  const auto none = read_sidecar(file(""));
  ASSERT_TRUE(none);
  EXPECT_EQ(none->scale, 1.0);
  EXPECT_EQ(none->tolerance_m, 1e-3);
  EXPECT_EQ(none->tolerance_rad, 1e-3);
  const auto empty = read_sidecar(file("[import]\n"));
  ASSERT_TRUE(empty);
  EXPECT_EQ(empty->scale, 1.0);
  EXPECT_EQ(empty->tolerance_m, 1e-3);
  EXPECT_EQ(empty->tolerance_rad, 1e-3);
  EXPECT_FALSE(empty->layout || empty->vehicle_type || empty->lane_types);
  const struct {
    const char* key;
    const char* low;
    const char* below;
    const char* high;
    const char* above;
    const char* expected;
  } all[] = {{"scale", "1e-6", "0.9e-6", "1e6", "1.1e6", "metres per unit of the file, 0.000001 to 1000000"},
             {"tolerance_m", "1e-6", "0.9e-6", "1", "1.1", "metres from 0.000001 to 1"},
             {"tolerance_rad", "1e-6", "0.9e-6", "0.2", "0.21", "radians from 0.000001 to 0.2"}};
  for (const auto& [key, low, below, high, above, expected] : all) {
    const auto with = [key = key](const char* value) {
      return read_sidecar(file("[import]\n" + std::string(key) + " = " + value + "\n"));
    };
    for (const char* good : {low, high}) EXPECT_TRUE(with(good)) << key << good;
    for (const char* bad : {below, above}) {
      const auto refused = with(bad);
      ASSERT_FALSE(refused) << key << bad;
      EXPECT_EQ(refused.error().code, "zone.field");
      EXPECT_EQ(refused.error().location, "plants/area.zone.toml:2: import." + std::string(key));
      EXPECT_THAT(refused.error().message, StartsWith("expected " + std::string(expected) + ", found "));
    }
  }
  const auto types = read_sidecar(file("[import]\nlane_types = [\"driving\", \"rail\"]\n"));
  ASSERT_TRUE(types);
  ASSERT_TRUE(types->lane_types);
  EXPECT_THAT(*types->lane_types, ElementsAre("driving", "rail"));
}

TEST(Sidecar, names_a_bend_as_tight_as_half_the_vehicle_s_width) {
  // The bends of the track have a radius of 0.5 m.
  const auto with_width = [](const char* width_m) {
    const auto zone = read("[vehicle]\nlength_m = 0.2\nwidth_m = " + std::string(width_m) + "\n");
    EXPECT_TRUE(zone) << to_string(zone.error());
    return zone->diagnostics;
  };
  EXPECT_THAT(with_width("0.99"), SizeIs(0));
  const auto found = with_width("1.0");
  ASSERT_THAT(found, SizeIs(2));
  EXPECT_EQ(found[0].text,
            "bends with a radius of 0.50 m, less than half the vehicle's 1.00 m of width: its inner side drives "
            "backwards here");
  EXPECT_EQ(found[1].location, "section 'west'");
}

TEST(Sidecar, names_twenty_tight_bends_and_counts_the_others) {
  const auto diagnostics = [](int bends) {
    std::vector<Circuit::Part> parts;
    for (int i = 0; i < bends; ++i)
      parts.push_back(testing::part("s" + std::to_string(i), testing::section({10.0 * i, 0.0, 0.0}, 0.5, 2.0)));
    TrafficZone zone{"z", testing::circuit(std::move(parts)), {}, {}, {}, {}, {}, {}, {}, {}};
    const ZoneConfiguration configuration = file("[vehicle]\nlength_m = 0.2\nwidth_m = 1.2\n");
    EXPECT_TRUE(furnish(zone, configuration, *read_sidecar(configuration)));
    return zone.diagnostics;
  };
  const auto twenty = diagnostics(20);
  ASSERT_THAT(twenty, SizeIs(20));
  EXPECT_EQ(twenty.back().location, "section 's19'");
  const auto more = diagnostics(22);
  ASSERT_THAT(more, SizeIs(21));
  EXPECT_EQ(more.back().kind, Diagnostic::Kind::notice);
  EXPECT_EQ(more.back().location, "sections");
  EXPECT_EQ(more.back().text, "2 more bend as tightly as those above");
}

TEST(Sidecar, takes_precedence_over_the_format_s_own_rules_for_waypoints) {
  const auto nodes_only = [](const std::string& sidecar) {
    TrafficZone zone{"z", testing::track(), {}, {}, {}, {}, {}, {}, {}, {}};
    WaypointRules rules;
    rules.nodes_only = true;
    EXPECT_TRUE(furnish(zone, file(sidecar), *read_sidecar(file(sidecar)), rules));
    EXPECT_EQ(zone.waypoints.size() == 4U, zone.nodes_only);
    return zone.nodes_only;
  };
  EXPECT_TRUE(nodes_only(""));
  EXPECT_FALSE(nodes_only("[waypoints]\nnodes_only = false\n"));
  EXPECT_TRUE(nodes_only("[waypoints]\nnodes_only = true\n"));
  const auto edges = [](const std::string& sidecar, bool before) {
    TrafficZone zone{"z", testing::track(), {}, {}, {}, {}, {}, {}, {}, {}};
    zone.edges_are_sections = before;
    EXPECT_TRUE(furnish(zone, file(sidecar), *read_sidecar(file(sidecar))));
    return zone.edges_are_sections;
  };
  EXPECT_TRUE(edges("[waypoints]\nedges_are_sections = true\n", false));
  EXPECT_FALSE(edges("", false));
  EXPECT_TRUE(edges("", true)) << "the format's own";
}

TEST(Sidecar, loses_the_blank_line_behind_a_tag_on_its_first_line) {
  const std::string second = "[[tag]]\nnumber = 2\nsection = \"south\"\ns_m = 1.5\n";
  ZoneEdit edit;
  edit.remove_tags = {1};
  const auto edited =
      TrackFactory{}.edited(file("[[tag]]\nnumber = 1\nsection = \"south\"\ns_m = 0.5\n\n" + second), edit);
  ASSERT_TRUE(edited) << to_string(edited.error());
  EXPECT_EQ(edited->sidecar, second);
  const auto listed = TrackFactory{}.edited(file("tag = [ { number = 1, section = \"south\", s_m = 0.5 } ]\n"), edit);
  ASSERT_FALSE(listed);
  EXPECT_EQ(listed.error().code, "edit.format");
  EXPECT_EQ(listed.error().location, "plants/area.zone.toml");
}

TEST(SidecarFile, has_a_name_derived_from_the_file_it_belongs_to) {
  EXPECT_EQ(sidecar_file("plants/area.lif.json"), "plants/area.zone.toml");
  EXPECT_EQ(sidecar_file("plants.d/area.xodr"), "plants.d/area.zone.toml");
  EXPECT_EQ(sidecar_file("plants.d/area"), "plants.d/area.zone.toml");
  EXPECT_EQ(sidecar_file("area.v2.json"), "area.v2.zone.toml");
  EXPECT_EQ(sidecar_file("plants/a.b"), "plants/a.zone.toml");
  EXPECT_EQ(sidecar_file("plants/.b"), "plants/.b.zone.toml");
  EXPECT_EQ(sidecar_of_file("area.xodr"), "area.zone.toml");
  EXPECT_EQ(sidecar_of_file("area.toml"), std::nullopt);
}

}  // namespace
}  // namespace cosiva::zone
