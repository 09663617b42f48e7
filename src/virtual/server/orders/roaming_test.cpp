#include "cosiva/virtual/server/orders/roaming.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "cosiva/virtual/server/testing/server_fixture.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;
using testing::IsEmpty;

TEST(Roaming, takes_the_branches_alternately) {
  ServerFixture fixture{fork()};
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.1});
  std::vector<zone::SectionId> taken;
  fixture.each_step = [&] {
    const zone::SectionId here = aiv.track_position().section;
    if ((here == 1 || here == 5) && (taken.empty() || taken.back() != here)) taken.push_back(here);
    if (here == 2 && !taken.empty() && taken.back() != 2) taken.push_back(2);
  };
  fixture.run_for(130s);
  std::erase(taken, 2U);
  ASSERT_GE(taken.size(), 4U);
  for (std::size_t i = 1; i < taken.size(); ++i) EXPECT_NE(taken[i], taken[i - 1]) << i;
  EXPECT_THAT(aiv.refusals, IsEmpty());
  EXPECT_THAT(fixture.bijection().number("matched"), testing::Optional(1.0));
}

TEST(Roaming, of_six_vehicles_over_fork_and_merge_is_without_contact_and_continues_after_restarts) {
  ServerFixture fixture{fork()};
  int number = 0;
  for (const zone::TrackPosition track_position : fixture.zone->start_positions(6))
    fixture.add("AIV" + std::to_string(++number), track_position);
  ASSERT_EQ(number, 6);
  fixture.loss = 0.02;
  int touches = 0;
  fixture.each_step = [&] { touches += fixture.touches(); };
  for (int i = 0; i < 4; ++i) {
    fixture.run_for(20s);
    fixture.restart_server();
  }
  std::vector<double> driven;
  for (const auto& aiv : fixture.vehicles) driven.push_back(aiv->driven_m);
  fixture.run_for(40s);
  EXPECT_EQ(touches, 0);
  for (std::size_t i = 0; i < fixture.vehicles.size(); ++i) {
    EXPECT_THAT(fixture.vehicles[i]->refusals, IsEmpty());
    EXPECT_GT(fixture.vehicles[i]->driven_m, driven[i] + 3.0) << i;
  }
}

}  // namespace
}  // namespace cosiva::virtual_side
