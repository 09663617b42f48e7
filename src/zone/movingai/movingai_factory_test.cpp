#include "cosiva/zone/movingai/movingai_factory.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "cosiva/zone/edit/edit.h"
#include "cosiva/zone/toml/toml_factory.h"

namespace cosiva::zone {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using ::testing::StartsWith;

const std::string small_map = "type octile\nheight 3\nwidth 3\nmap\nE..\n.@.\n..S\n";

ZoneConfiguration file(const std::string& text, const std::string& sidecar = "") {
  return {"movingai", "maps/small.map", text, sidecar};
}
Result<TrafficZone> read(const std::string& text, const std::string& sidecar = "") {
  return MovingAiCircuitFactory{}.make_zone(file(text, sidecar));
}
Error error_of(const std::string& text, const std::string& sidecar = "") {
  const auto zone = read(text, sidecar);
  return zone ? Error{"none", "", ""} : zone.error();
}

TEST(MovingAiFactory, makes_a_zone_of_two_way_tracks_with_a_node_in_each_square) {
  const auto zone = read(small_map);
  ASSERT_TRUE(zone) << to_string(zone.error());
  EXPECT_EQ(zone->circuit.size(), 16U);
  EXPECT_NEAR(zone->circuit.total_length_m(), 16.0, 1e-9);
  EXPECT_TRUE(zone->edges_are_sections);
  EXPECT_TRUE(zone->nodes_only);
  ASSERT_NE(zone->find_waypoint("x2y1"), nullptr);
  EXPECT_EQ(zone->find_waypoint("x1y1"), nullptr) << "a blocked square";
  ASSERT_THAT(zone->stations, SizeIs(2));
  ASSERT_TRUE(zone->beacons);
  EXPECT_THAT(zone->start_positions(3), SizeIs(3));
}

TEST(MovingAiFactory, takes_the_pitch_the_name_and_the_vehicle_from_the_sidecar_file) {
  const auto zone =
      read(small_map, "name = \"depot\"\n[import]\nscale = 2\n[vehicle]\nlength_m = 1.2\nwidth_m = 0.8\n");
  ASSERT_TRUE(zone) << to_string(zone.error());
  EXPECT_EQ(zone->name, "depot");
  EXPECT_NEAR(zone->circuit.total_length_m(), 32.0, 1e-9);
  EXPECT_EQ(zone->vehicle.length_m, 1.2);
}

TEST(MovingAiFactory, names_a_zone_by_the_content_of_its_map) {
  EXPECT_THAT(read(small_map)->name, StartsWith("map-"));
  EXPECT_EQ(read(small_map)->name, read(small_map, "[import]\nscale = 2\n")->name);
  EXPECT_NE(read(small_map)->name, read("height 1\nwidth 2\nmap\n..\n")->name);
}

TEST(MovingAiFactory, names_file_line_and_column_of_a_fault) {
  const Error error = error_of("type octile\nheight 1\nwidth 3\nmap\n..x\n");
  EXPECT_EQ(error.code, "grid.character");
  EXPECT_EQ(error.location, "maps/small.map: line 5, column 3");
  EXPECT_EQ(error_of("type octile\nheight 1\nwidth 3\nmap\n.@.\n").code, "circuit.empty");
  EXPECT_EQ(error_of("type octile\nheight 1\nwidth 3\nmap\n.@.\n").location, "maps/small.map");
}

TEST(MovingAiFactory, refuses_squares_in_which_vehicles_touch_when_they_turn) {
  // The diagonal of 0.20 m by 0.12 m is 0.2332 m, and bodies stay 0.04 m apart.
  EXPECT_EQ(error_of(small_map, "[import]\nscale = 0.28\n").code, "none");
  const Error error = error_of(small_map, "[import]\nscale = 0.27\n");
  EXPECT_EQ(error.code, "zone.vehicle");
  EXPECT_EQ(error.location, "maps/small.zone.toml");
  EXPECT_THAT(error.message, HasSubstr("at least 0.27"));
}

TEST(MovingAiFactory, refuses_a_sidecar_file_that_is_no_toml) {
  EXPECT_THAT(error_of(small_map, "[import\n").location, HasSubstr("maps/small.zone.toml"));
}

TEST(MovingAiFactory, distributes_as_many_stations_as_the_sidecar_file_states) {
  const std::string open = "height 4\nwidth 4\nmap\n....\n....\n....\n....\n";
  EXPECT_THAT(read(open)->stations, IsEmpty());
  const auto zone = read(open, "[import]\nstations = 3\n");
  ASSERT_TRUE(zone) << to_string(zone.error());
  EXPECT_THAT(zone->stations, SizeIs(3));
  EXPECT_THAT(zone->diagnostics, IsEmpty());
  const auto few = read("height 1\nwidth 4\nmap\nEEEE\n", "[import]\nstations = 3\n");
  ASSERT_TRUE(few) << to_string(few.error());
  EXPECT_THAT(few->stations, SizeIs(2)) << "the ends, instead of the map's own";
  ASSERT_THAT(few->diagnostics, SizeIs(1));
  EXPECT_THAT(few->diagnostics[0].text, HasSubstr("is 3, but only 2 leave all others connected"));
  EXPECT_EQ(error_of(open, "[import]\nstations = 20001\n").location, "maps/small.zone.toml:2: import.stations");
}

TEST(MovingAiFactory, makes_zones_that_the_native_format_holds_without_loss) {
  const auto zone = read(small_map, "[import]\nscale = 0.5\n");
  ASSERT_TRUE(zone);
  std::vector<Diagnostic> lost;
  const auto written = TomlCircuitFactory{}.written(*zone, lost);
  ASSERT_TRUE(written) << to_string(written.error());
  EXPECT_THAT(lost, IsEmpty());
  const auto again = TomlCircuitFactory{}.make_zone(*written);
  ASSERT_TRUE(again) << to_string(again.error());
  EXPECT_TRUE(same_geometry(*zone, *again));
  EXPECT_EQ(again->stations.size(), zone->stations.size());
  EXPECT_EQ(again->name, zone->name);
}

TEST(MovingAiFactory, writes_edits_into_the_sidecar_file_and_no_maps) {
  const MovingAiCircuitFactory factory;
  ZoneEdit edit;
  edit.set_priorities = {{"CoSiVA/AIV1", 5}};
  const auto edited = factory.edited(file(small_map), edit);
  ASSERT_TRUE(edited) << to_string(edited.error());
  EXPECT_EQ(edited->text, small_map);
  EXPECT_THAT(edited->sidecar, HasSubstr("\"CoSiVA/AIV1\" = 5"));
  std::vector<Diagnostic> lost;
  const auto written = factory.written(*read(small_map), lost);
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, "zone.write");
}

TEST(MovingAiFactory, draws_its_circuit) {
  const auto circuit = MovingAiCircuitFactory{}.make_circuit(file(small_map));
  ASSERT_TRUE(circuit);
  EXPECT_FALSE((*circuit)->draw().empty());
}

}  // namespace
}  // namespace cosiva::zone
