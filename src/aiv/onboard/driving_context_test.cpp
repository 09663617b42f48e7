#include "cosiva/aiv/onboard/driving_context.h"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace cosiva::aiv
