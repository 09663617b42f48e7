#include "cosiva/virtual/fleet/spacing.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "cosiva/aiv/motion/formulas.h"
#include "cosiva/base/random.h"
#include "cosiva/virtual/fleet/test_fleet.h"
#include "cosiva/zone/geometry/section.h"

namespace cosiva::virtual_side {
namespace {

using namespace test;

/// Whether two bodies on one arc overlap, with `apart_m` of arc length between their body origins.
bool touch_on_arc(const zone::VehicleShape& shape, double curvature_per_m, double apart_m) {
  const auto arc = zone::Section::make({}, apart_m + 1.0, curvature_per_m);
  return overlap(arc->pose_at(0.0), arc->pose_at(apart_m), shape);
}

TEST(Spacing, is_the_vehicle_s_length_on_a_straight) {
  zone::VehicleShape shape;
  shape.length_m = 1.2;
  EXPECT_EQ(bodies_apart_m(shape, 0.0), 1.2);
}

RC_GTEST_PROP(Spacing, on_an_arc_is_where_bodies_cease_to_touch, ()) {
  Random random{*rc::gen::arbitrary<std::uint64_t>(), "spacing_test"};
  zone::VehicleShape shape;
  shape.length_m = random.uniform(0.1, 3.0);
  shape.width_m = random.uniform(0.1, 1.5);
  const double radius_m = random.uniform(0.8, 20.0) * shape.width_m + 0.5 * shape.length_m;
  const double apart_m = bodies_apart_m(shape, 1.0 / radius_m);
  for (const double curvature_per_m : {1.0 / radius_m, -1.0 / radius_m}) {
    RC_ASSERT(!touch_on_arc(shape, curvature_per_m, apart_m + 1e-6));
    RC_ASSERT(touch_on_arc(shape, curvature_per_m, apart_m - 1e-6));
  }
}

TEST(Spacing, is_the_vehicle_s_length_where_bends_are_wide) {
  for (const char* name : {"zones/lacet4.toml", "zones/indus8.toml", "zones/crossing8.xodr"}) {
    const Zone zone = zone_file(name);
    EXPECT_EQ(occupied_m(*zone), zone->vehicle.length_m) << name;
  }
}

TEST(Spacing, keeps_bodies_apart_in_the_tightest_bend_of_a_factory_layout) {
  const Zone zone = plant({.rows = 1, .aisles = 2, .bays = 1, .seed = 1});
  const double apart_m = occupied_m(*zone) + aiv::clearance_m;
  EXPECT_GT(occupied_m(*zone), zone->vehicle.length_m);
  for (zone::SectionId id = 0; id < zone->circuit.size(); ++id) {
    const double curvature_per_m = zone->circuit.section(id).curvature_max_per_m();
    if (curvature_per_m > 0.0) {
      EXPECT_FALSE(touch_on_arc(zone->vehicle, curvature_per_m, apart_m)) << zone->circuit.part(id).name;
    }
  }
}

}  // namespace
}  // namespace cosiva::virtual_side
