#include "cosiva/virtual/server/missions/roaming.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "cosiva/virtual/server/testing/server_fixture.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;
using testing::IsEmpty;

/// Five sections of which the last two lead into dead ends.
class Branches : public testing::Test {
 protected:
  [[nodiscard]] zone::SectionId choose(const std::vector<zone::SectionId>& choice) const {
    return roaming.least_recent(choice, {closed, avoided, goes_on});
  }
  ClosedSections closed;
  std::vector<zone::SectionId> avoided;
  std::vector<bool> goes_on{true, true, true, false, false};
  Roaming roaming;
};

TEST_F(Branches, are_taken_in_turn_the_first_one_first) {
  std::vector<zone::SectionId> taken;
  for (int i = 0; i < 7; ++i) {
    taken.push_back(choose({2, 0, 1}));
    roaming.take(taken.back());
  }
  EXPECT_THAT(taken, testing::ElementsAre(2U, 0U, 1U, 2U, 0U, 1U, 2U));
}

TEST_F(Branches, that_lead_into_a_dead_end_come_last_even_when_never_taken) {
  roaming.take(1);
  EXPECT_EQ(choose({3, 1}), 1U);
  EXPECT_EQ(choose({1, 3}), 1U);
  roaming.take(3);
  EXPECT_EQ(choose({3, 4}), 4U) << "of two dead ends the one taken less recently";
  EXPECT_EQ(choose({3}), 3U);
}

TEST_F(Branches, that_are_closed_or_avoided_are_not_taken) {
  closed.set({0});
  avoided = {1};
  EXPECT_EQ(choose({0, 1, 2}), 2U);
  EXPECT_EQ(choose({0, 1}), zone::no_section);
  EXPECT_EQ(choose({}), zone::no_section);
  EXPECT_EQ(choose({0, 3}), 3U) << "a dead end rather than a closed section";
}

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
