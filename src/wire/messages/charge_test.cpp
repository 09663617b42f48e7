#include "cosiva/wire/messages/charge.h"

#include <gtest/gtest.h>

namespace cosiva::wire {
namespace {

TEST(Charge, is_known_until_a_vehicle_states_otherwise) {
  State state;
  state.information = {{"battery", {}, {{"needsFullCharge", "true"}}}, {"boards", {}, {{"charge", "unknown"}}}};
  EXPECT_FALSE(charge_unknown(state));
  set_charge_unknown(state);
  EXPECT_TRUE(charge_unknown(state));
}

TEST(Charge, that_is_unknown_has_the_level_that_the_standard_gives_a_good_battery_without_gauge) {
  State state;
  set_charge_unknown(state);
  EXPECT_EQ(state.battery.charge_percent, 80.0);
}

}  // namespace
}  // namespace cosiva::wire
