#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>

#include "cosiva/base/random.h"
#include "cosiva/zone/edit/edit.h"
#include "cosiva/zone/layout/beacons.h"
#include "cosiva/zone/layout/crossings.h"
#include "cosiva/zone/layout/waypoints.h"
#include "cosiva/zone/testing/test_zones.h"
#include "cosiva/zone/toml/sidecar.h"
#include "cosiva/zone/toml/toml_factory.h"
#include "cosiva/zone/toml/toml_write.h"

namespace cosiva::zone {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

/// The zone as it reads back from the written text; nothing may be lost.
TrafficZone written_and_read(const TrafficZone& zone) {
  std::vector<Diagnostic> lost;
  const auto written = TomlCircuitFactory{}.written(zone, lost);
  EXPECT_TRUE(written) << to_string(written.error());
  EXPECT_THAT(lost, IsEmpty()) << (lost.empty() ? "" : lost[0].text) << "\n" << written->text;
  auto back = TomlCircuitFactory{}.make_zone(*written);
  EXPECT_TRUE(back) << to_string(back.error());
  return std::move(*back);
}

TEST(TomlWriter, writes_the_ready_zones_so_that_they_read_back_the_same) {
  for (const char* name : {"lacet4.toml", "indus8.toml"}) {
    const TrafficZone zone = testing::zone_file(name);
    EXPECT_EQ(difference(zone, written_and_read(zone)), std::nullopt) << name;
  }
}

TEST(TomlWriter, uses_the_usual_form_where_it_gives_the_same_value) {
  std::vector<Diagnostic> lost;
  const std::string text = TomlCircuitFactory{}.written(testing::lacet4(), lost)->text;
  EXPECT_THAT(text, HasSubstr("kind = \"arc\"\nradius_m = 0.6\nangle_deg = -270\n"));
  EXPECT_THAT(text, HasSubstr("start = { x = -0.75, y = -0.15, heading_deg = 0 }\n"));
  EXPECT_THAT(text, HasSubstr("cover = \"zone\"\n"));
  EXPECT_THAT(text, Not(HasSubstr("_rad")));
}

/// Sections of any shape and any numbers, end to end or elsewhere, with all elements that can be on them.
TrafficZone arbitrary_zone(std::uint64_t seed) {
  Random random{seed, "toml_write_test"};
  const auto between = [&](double low, double high) { return low + (high - low) * random.uniform(); };
  std::vector<Circuit::Part> parts;
  const std::size_t count = 1 + random.below(6);
  Pose2 at{between(-100.0, 100.0), between(-100.0, 100.0), wrap_angle(between(-4.0, 4.0))};
  for (std::size_t i = 0; i < count; ++i) {
    if (i > 0 && random.below(4) == 0) {
      at = {at.x_m + between(5.0, 9.0), at.y_m, wrap_angle(between(-4.0, 4.0))};
    } else if (i > 0) {
      parts.back().next = {static_cast<SectionId>(i)};
    }
    const auto kind = random.below(3);
    const double k0 = kind == 0 ? 0.0 : between(-2.0, 2.0);
    auto section = Section::make(at, between(0.1, 3.0), k0, kind == 2 ? between(-1.0, 1.0) : 0.0);
    EXPECT_TRUE(section);
    at = section->end();
    Circuit::Part part{"s " + std::to_string(i) + (random.below(2) == 0 ? "" : " \"é\\"), *section, {}, {}};
    if (random.below(3) == 0) part.speed_mps_max = between(0.1, 1.0);
    part.pivots = random.below(4) == 0;
    parts.push_back(std::move(part));
  }
  TrafficZone zone{"any", testing::circuit(std::move(parts)), {}, default_profiles, {}, {}, {}, {}, {}, {}};
  zone.vehicle = {between(0.1, 0.3), between(0.05, 0.2)};
  zone.clearance_m = between(0.0, 0.1);
  zone.spacing_m = between(0.1, 1.0);
  zone.nodes_only = random.below(2) == 0;
  zone.edges_are_sections = random.below(2) == 0;
  const auto position = [&] {
    const auto id = static_cast<SectionId>(random.below(zone.circuit.size()));
    return TrackPosition{id, between(0.0, zone.circuit.section(id).length_m())};
  };
  for (std::uint64_t i = 0; i < random.below(4); ++i)
    zone.tags.push_back({static_cast<TagNumber>(7 * i + 1), position()});
  for (std::uint64_t i = 0; i < random.below(4); ++i)
    zone.stations.push_back(
        {"st" + std::to_string(i), position(), i % 2 == 0 ? StationKind::stop : StationKind::charger});
  if (random.below(2) == 0) zone.closed = {static_cast<SectionId>(random.below(zone.circuit.size()))};
  if (random.below(2) == 0) zone.priorities = {{"A/1", 3}, {"B/2", 999}};
  const double rotation_rad = random.below(2) == 0 ? 0.0 : between(-3.0, 3.0);
  if (random.below(2) == 0) {
    zone.beacons =
        BeaconGrid{between(0.1, 2.0), {between(-5.0, 5.0), between(-5.0, 5.0)}, 4, 9, 5000, {}, rotation_rad};
  } else {
    zone.beacons = covering_grid(zone.circuit, zone.vehicle, between(1.0, 2.0), {between(-5.0, 5.0), 0.1}, 1'000'000,
                                 rotation_rad);
  }
  WaypointRules rules{zone.spacing_m, stopping_room_m(zone.vehicle), zone.nodes_only, {}, {}, {}};
  for (const Station& station : zone.stations) rules.at.push_back(station.position);
  if (random.below(2) == 0) {
    rules.start_ids.resize(zone.circuit.size());
    rules.end_ids.resize(zone.circuit.size());
    rules.start_ids[0] = "first node";
    const auto last = static_cast<SectionId>(zone.circuit.size() - 1);
    if (zone.circuit.next(last).empty()) rules.end_ids[last] = "last node";
  }
  zone.crossings = find_crossings(zone.circuit, zone.vehicle, zone.clearance_m);
  zone.waypoints = lay_waypoints(zone.circuit, zone.crossings, rules);
  return zone;
}

TEST(TomlWriter, writes_any_zone_so_that_it_reads_back_the_same_to_the_last_bit) {
  EXPECT_TRUE(rc::check([] {
    const TrafficZone zone = arbitrary_zone(*rc::gen::arbitrary<std::uint64_t>());
    std::vector<Diagnostic> lost;
    const auto written = TomlCircuitFactory{}.written(zone, lost);
    if (!written) RC_FAIL(to_string(written.error()));
    if (!lost.empty()) RC_FAIL(lost[0].text + "\n" + written->text);
    RC_ASSERT(difference(zone, *TomlCircuitFactory{}.make_zone(*written)) == std::nullopt);
  }));
}

TEST(TomlWriter, refuses_a_name_that_no_file_can_hold) {
  const TrafficZone zone{"z", testing::circuit({testing::part("a\nb", testing::section({}, 1.0))}),
                         {},  default_profiles,
                         {},  {},
                         {},  {},
                         {},  {}};
  std::vector<Diagnostic> lost;
  const auto written = TomlCircuitFactory{}.written(zone, lost);
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, "zone.write");
}

TEST(SidecarWriter, writes_what_other_formats_cannot_express) {
  TrafficZone zone = testing::zone_file("indus8.toml");
  const std::string all = sidecar_text(zone);
  for (const char* table :
       {"[vehicle]", "[profiles.fast]", "[[limit]]", "[beacons]", "[[tag]]", "[[station]]", "[[start]]", "[[loop]]"})
    EXPECT_THAT(all, HasSubstr(table));
  EXPECT_THAT(all, Not(HasSubstr("[[section]]")));
  const std::string less = sidecar_text(zone, {.limits = false, .stations = false, .closed = false});
  EXPECT_THAT(less, Not(HasSubstr("[[limit]]")));
  EXPECT_THAT(less, Not(HasSubstr("[[station]]")));
}

}  // namespace
}  // namespace cosiva::zone
