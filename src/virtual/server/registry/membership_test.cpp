#include "cosiva/virtual/server/registry/membership.h"

#include <gtest/gtest.h>

namespace cosiva::virtual_side {
namespace {

using namespace std::chrono_literals;

TEST(Membership, begins_with_the_first_message) {
  const Membership membership{virtual_epoch + 3s};
  EXPECT_EQ(membership.first_received(), virtual_epoch + 3s);
  EXPECT_FALSE(membership.retired());
  EXPECT_FALSE(membership.handed_over());
}

TEST(Membership, has_the_time_of_the_last_message) {
  Membership membership{virtual_epoch + 3s};
  EXPECT_EQ(membership.last_received(), virtual_epoch + 3s);
  membership.on_message(virtual_epoch + 5s);
  EXPECT_EQ(membership.last_received(), virtual_epoch + 5s);
  EXPECT_EQ(membership.first_received(), virtual_epoch + 3s);
  EXPECT_DEATH(membership.on_message(virtual_epoch + 4s), "last_received_");
}

TEST(Membership, is_awaited_until_it_ends) {
  Membership membership{virtual_epoch};
  EXPECT_FALSE(membership.awaited());
  membership.on_awaited();
  EXPECT_TRUE(membership.awaited());
  membership.on_awaited_end();
  EXPECT_FALSE(membership.awaited());
  membership.on_awaited();
  membership.on_retired();
  EXPECT_FALSE(membership.awaited());
  EXPECT_DEATH(membership.on_awaited(), "!retired_");
}

TEST(Membership, ends_by_retirement_until_the_vehicle_is_accepted_again) {
  Membership membership{virtual_epoch};
  membership.on_retired();
  EXPECT_TRUE(membership.retired());
  membership.on_accepted();
  EXPECT_FALSE(membership.retired());
}

TEST(Membership, hides_a_vehicle_for_a_second_from_the_first_publication_of_its_new_owner) {
  Membership membership{virtual_epoch};
  membership.on_handed_over(virtual_epoch);
  membership.on_handed_over(virtual_epoch + 500ms);
  EXPECT_EQ(membership.handed_over()->first, virtual_epoch);
  EXPECT_EQ(membership.handed_over()->last, virtual_epoch + 500ms);
  EXPECT_TRUE(membership.hidden_by_handover(virtual_epoch + 999ms));
  EXPECT_FALSE(membership.hidden_by_handover(virtual_epoch + 1s)) << "a repetition does not prolong it";
}

TEST(Membership, shows_a_vehicle_whose_handover_is_void) {
  Membership membership{virtual_epoch};
  membership.on_handed_over(virtual_epoch);
  membership.on_handover_void();
  EXPECT_FALSE(membership.hidden_by_handover(virtual_epoch));
}

TEST(Membership, of_a_retired_vehicle_has_no_handover) {
  Membership membership{virtual_epoch};
  membership.on_handed_over(virtual_epoch);
  membership.on_retired();
  EXPECT_FALSE(membership.handed_over());
  EXPECT_DEATH(membership.on_handed_over(virtual_epoch), "!retired_");
}

TEST(Membership, refuses_a_handover_before_the_last_one) {
  Membership membership{virtual_epoch};
  membership.on_handed_over(virtual_epoch + 1s);
  EXPECT_DEATH(membership.on_handed_over(virtual_epoch), "last <= now");
}

TEST(Membership, may_be_handed_over_twice_at_one_time_and_again_later) {
  Membership membership{virtual_epoch};
  membership.on_handed_over(virtual_epoch + 1s);
  membership.on_handed_over(virtual_epoch + 1s);
  membership.on_handed_over(virtual_epoch + 4s);
  EXPECT_EQ(membership.handed_over()->first, virtual_epoch + 1s);
  EXPECT_EQ(membership.handed_over()->last, virtual_epoch + 4s);
  membership.on_handover_void();
  membership.on_handed_over(virtual_epoch + 2s);
  EXPECT_EQ(membership.handed_over()->first, virtual_epoch + 2s) << "a handover that is void limits nothing";
}

}  // namespace
}  // namespace cosiva::virtual_side
