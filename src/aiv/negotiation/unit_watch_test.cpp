#include "cosiva/aiv/negotiation/unit_watch.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>

namespace cosiva::aiv {
namespace {

using namespace std::chrono_literals;

const wire::VehicleId x1{"CoSiVA.unit", "X1"};

wire::CrossingStatus status_of(std::uint32_t header, bool occupied) {
  wire::CrossingStatus status;
  status.header_id = header;
  status.map_id = "lacet4";
  status.unit = x1;
  status.crossing = "X1";
  if (occupied) status.holders.push_back({{"CoSiVA", "AIV2"}, 100});
  return status;
}

struct UnitWatchTest : ::testing::Test {
  UnitWatch watch{"lacet4"};
  SimTime now{virtual_epoch};

  bool receive(const wire::CrossingStatus& status, const wire::VehicleId& sender = x1) {
    return watch.on_status(now, sender, std::make_shared<const wire::CrossingStatus>(status));
  }
  [[nodiscard]] bool occupied(const std::string& crossing = "X1") const {
    return !watch.holders(now, crossing).empty();
  }
};

TEST_F(UnitWatchTest, knows_which_crossing_a_unit_reports_as_occupied) {
  EXPECT_FALSE(occupied()) << "no unit";
  EXPECT_TRUE(receive(status_of(1, true)));
  EXPECT_TRUE(occupied());
  EXPECT_FALSE(occupied("X2"));
  EXPECT_TRUE(receive(status_of(2, false)));
  EXPECT_FALSE(occupied());
}

TEST_F(UnitWatchTest, ignores_a_unit_that_has_sent_nothing_for_a_second) {
  receive(status_of(1, true));
  now += 999ms;
  EXPECT_TRUE(occupied());
  now += 1ms;
  EXPECT_FALSE(occupied());
}

TEST_F(UnitWatchTest, ignores_a_unit_that_has_signed_off) {
  receive(status_of(1, true));
  wire::CrossingStatus last = status_of(2, true);
  last.online = false;
  EXPECT_TRUE(receive(last));
  EXPECT_FALSE(occupied());
}

TEST_F(UnitWatchTest, does_not_use_an_overtaken_message_but_one_of_a_restarted_unit) {
  receive(status_of(100, false));
  receive(status_of(99, true));
  EXPECT_FALSE(occupied());
  now += 1s;
  receive(status_of(1, true));
  EXPECT_TRUE(occupied());
  EXPECT_EQ(watch.units(), 1U);
}

TEST_F(UnitWatchTest, does_not_use_a_message_of_another_sender_of_a_vehicle_or_of_another_map) {
  EXPECT_FALSE(receive(status_of(1, true), {"CoSiVA.unit", "X2"}));
  EXPECT_FALSE(receive(status_of(1, true), {"CoSiVA", "X1"}));
  wire::CrossingStatus other = status_of(1, true);
  other.crossing = "X2";
  EXPECT_FALSE(receive(other)) << "a unit reports its own crossing";
  other = status_of(1, true);
  other.map_id = "indus8";
  EXPECT_FALSE(receive(other));
  EXPECT_EQ(watch.units(), 0U);
}

TEST_F(UnitWatchTest, stores_a_limited_number_of_units) {
  for (std::size_t i = 0; i <= UnitWatch::units_max; ++i) {
    wire::CrossingStatus status = status_of(1, true);
    status.crossing = status.unit.serial_number = "Y" + std::to_string(i);
    EXPECT_TRUE(receive(status, status.unit));
  }
  EXPECT_EQ(watch.units(), UnitWatch::units_max);
}

}  // namespace
}  // namespace cosiva::aiv
