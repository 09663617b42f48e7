#include "cosiva/aiv/onboard/driving_context.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "cosiva/aiv/testing/test_zone.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::aiv {
namespace {

using test::lacet4;

/// The lacet4 zone with some of its text replaced.
zone::Rtm edited_lacet4(const std::string& from, const std::string& to) {
  zone::ZoneConfiguration configuration = test::lacet4_configuration();
  configuration.text.replace(configuration.text.find(from), from.size(), to);
  auto rtm = zone::Rtm::initialise(configuration);
  EXPECT_TRUE(rtm);
  return std::move(*rtm);
}

TEST(DrivingContext, builds_every_part_from_a_copy_of_the_zone) {
  DrivingContext context{lacet4(), {}};
  EXPECT_NE(&context.zone(), &lacet4());
  EXPECT_EQ(context.zone().name, "lacet4");
  EXPECT_EQ(context.shared_zone().get(), &context.zone());
  EXPECT_FALSE(context.vehicle().position().known());
  EXPECT_TRUE(context.neighbours().empty());
  EXPECT_FALSE(context.virtual_bodies().informed());
}

TEST(DrivingContext, adopts_a_tag_that_was_moved_without_another_zone_object) {
  DrivingContext context{lacet4(), {}};
  const zone::TrafficZone* const before = &context.zone();
  context.adopt_fiducials(edited_lacet4("s_m = 1.4137", "s_m = 1.3637").zone());
  EXPECT_EQ(&context.zone(), before) << "the parts refer to this object";
  EXPECT_DOUBLE_EQ(context.zone().find_tag(2)->position.s_m, 1.3637);
}

TEST(DrivingContextDeathTest, does_not_adopt_another_circuit) {
  DrivingContext context{lacet4(), {}};
  zone::TrafficZone other = lacet4();
  other.vehicle.width_m += 0.01;
  EXPECT_DEATH(context.adopt_fiducials(other), "same_");
}

TEST(DrivingContext, keeps_the_restrictions_of_the_agent_that_it_takes_over) {
  DrivingContext before{lacet4(), {}};
  before.vehicle().hold(Hold::paused, true);
  before.agent().instructions().imposed = Profile::slow;
  const DrivingContext after{lacet4(), {}, before.agent()};
  EXPECT_TRUE(after.vehicle().holds().has(Hold::paused));
  EXPECT_EQ(after.agent().instructions().imposed, Profile::slow);
}

TEST(DrivingContext, forgets_a_contradicting_beacon_where_beacons_may_have_been_moved) {
  // Two beacons next to the loop in the south-east, while the estimate is in the north-west.
  const Point2 first{1.0, -0.25};
  const Point2 second{1.25, -0.5};
  const auto& loop = lacet4().circuit.section(1);
  for (const bool moved : {false, true}) {
    DrivingContext context{lacet4(), {}};
    wire::Odometry odometry;
    context.agent().on_odometry(odometry);
    context.vehicle().estimator().position_at(test::at(lacet4(), "loop_nw", 1.0));
    EXPECT_EQ(context.vehicle().on_tag({0, lacet4().beacons->nearest(first)->number, 0}).kind, FixKind::outlier);
    if (moved) context.adopt_fiducials(lacet4());
    for (int i = 0; i < 100; ++i) {
      odometry.distance_um += std::llround(1e4 * (loop.nearest(second).s_m - loop.nearest(first).s_m));
      context.agent().on_odometry(odometry);
    }
    EXPECT_EQ(context.vehicle().on_tag({0, lacet4().beacons->nearest(second)->number, 0}).kind,
              moved ? FixKind::outlier : FixKind::relocated);
  }
}

TEST(DrivingContextDeathTest, is_taken_over_only_from_a_vehicle_that_has_stopped) {
  DrivingContext before{lacet4(), {}};
  wire::Odometry moving;
  moving.speed_mmps = 400;
  before.agent().on_odometry(moving);
  EXPECT_DEATH(static_cast<void>(DrivingContext{lacet4(), {}, before.agent()}), "stopped");
}

}  // namespace
}  // namespace cosiva::aiv
