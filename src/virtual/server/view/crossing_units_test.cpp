#include "cosiva/virtual/server/view/crossing_units.h"

#include <gtest/gtest.h>

#include <string>

#include "cosiva/base/json_value.h"

namespace cosiva::virtual_side {
namespace {

using namespace std::chrono_literals;

wire::CrossingStatus status_of(const std::string& crossing) {
  wire::CrossingStatus status;
  status.map_id = "lacet4";
  status.crossing = crossing;
  status.unit = {"CoSiVA.unit", crossing};
  status.centre = {0.15, -0.15};
  return status;
}

struct CrossingUnitsTest : ::testing::Test {
  CrossingUnits units;
  SimTime now{virtual_epoch};

  Result<void> receive(const wire::CrossingStatus& status, const std::string& as = {}, bool retained = false) {
    const std::string topic = "cosiva/v1/unit/" + (as.empty() ? wire::to_string(status.unit) : as);
    return units.on_message(now, {now, wire::InputKind::message, topic, to_json(status), retained});
  }
  [[nodiscard]] JsonValue::Array shown(const std::string& map = "lacet4") const {
    JsonWriter json;
    units.write(json, now, map);
    return *JsonValue::parse(json.text())->array();
  }
  [[nodiscard]] std::string trouble() const { return shown().at(0).text("trouble").value_or(""); }
  [[nodiscard]] std::uint64_t revision() const {
    Digest digest;
    units.fold(digest, now);
    return digest.value();
  }
};

TEST_F(CrossingUnitsTest, shows_position_holders_and_waiting_vehicles_with_the_age_of_what_is_known) {
  wire::CrossingStatus status = status_of("X1");
  status.holders = {{{"CoSiVA", "AIV1"}, 100}};
  status.waiting = {{{"CoSiVA", "AIV2"}, 50}};
  EXPECT_TRUE(receive(status));
  now += 150ms;
  const JsonValue unit = shown().at(0);
  EXPECT_EQ(unit.text("crossing"), "X1");
  EXPECT_EQ(unit.number("x"), 0.15);
  EXPECT_EQ(unit.text("state"), "online");
  EXPECT_EQ(unit.number("age_ms"), 150.0);
  EXPECT_EQ(unit.find("holders")->array()->at(0).text("id"), "CoSiVA/AIV1");
  EXPECT_EQ(unit.find("holders")->array()->at(0).number("age_ms"), 250.0);
  EXPECT_EQ(unit.find("waiting")->array()->at(0).number("age_ms"), 200.0);
  EXPECT_EQ(trouble(), "");
}

TEST_F(CrossingUnitsTest, reports_a_unit_that_has_sent_nothing_for_two_seconds) {
  EXPECT_TRUE(receive(status_of("X1")));
  const auto before = revision();
  now += 1999ms;
  EXPECT_EQ(trouble(), "");
  EXPECT_EQ(revision(), before);
  now += 1ms;
  EXPECT_EQ(shown().at(0).text("state"), "unresponsive");
  EXPECT_EQ(trouble(), "no status for 2 s");
  EXPECT_NE(revision(), before);
  EXPECT_TRUE(receive(status_of("X1")));
  EXPECT_EQ(shown().at(0).text("state"), "online");
}

TEST_F(CrossingUnitsTest, reports_a_unit_that_keeps_its_crossing_occupied_for_an_unresponsive_vehicle) {
  wire::CrossingStatus status = status_of("X1");
  status.holders = {{{"CoSiVA", "AIV1"}, 9'999}};
  status.waiting = {{{"CoSiVA", "AIV2"}, 50}};
  EXPECT_TRUE(receive(status));
  EXPECT_EQ(trouble(), "");
  status.holders[0].age_ms = 10'000;
  EXPECT_TRUE(receive(status));
  EXPECT_EQ(trouble(), "it keeps the crossing occupied for AIV1, whose last message is 10 s old; waiting: AIV2");
}

TEST_F(CrossingUnitsTest, reports_a_unit_that_reports_the_same_vehicle_for_a_minute) {
  wire::CrossingStatus status = status_of("X1");
  status.holders = {{{"CoSiVA", "AIV9"}, 0}};
  const SimTime end = now + 60s;
  for (; now < end; now += 500ms) {
    EXPECT_TRUE(receive(status));
    EXPECT_EQ(trouble(), "");
  }
  EXPECT_TRUE(receive(status));
  EXPECT_EQ(trouble(), "it has reported AIV9 in the crossing for 60 s");
  status.holders = {{{"CoSiVA", "AIV8"}, 0}};
  EXPECT_TRUE(receive(status));
  EXPECT_EQ(trouble(), "");
  status.holders.clear();
  EXPECT_TRUE(receive(status));
  EXPECT_EQ(trouble(), "");
}

TEST_F(CrossingUnitsTest, forgets_a_unit_that_signs_off) {
  EXPECT_TRUE(receive(status_of("X1")));
  wire::CrossingStatus last = status_of("X1");
  last.online = false;
  EXPECT_TRUE(receive(last));
  EXPECT_TRUE(shown().empty());
}

TEST_F(CrossingUnitsTest, shows_units_of_the_zone_in_force_only) {
  EXPECT_TRUE(receive(status_of("X1")));
  EXPECT_TRUE(shown("indus8").empty());
  EXPECT_EQ(shown().size(), 1U);
}

TEST_F(CrossingUnitsTest, refuses_what_another_sender_sends_or_is_retained_or_cannot_be_read) {
  EXPECT_EQ(receive(status_of("X1"), "CoSiVA.unit/X2").error().code, "unit.sender");
  wire::CrossingStatus vehicle = status_of("X1");
  vehicle.unit = {"CoSiVA", "X1"};
  EXPECT_EQ(receive(vehicle).error().code, "unit.sender");
  EXPECT_EQ(receive(status_of("X1"), {}, true).error().code, "unit.sender") << "of unknown age";
  EXPECT_FALSE(units.on_message(now, {now, wire::InputKind::message, "cosiva/v1/unit/CoSiVA.unit/X1", "{", false}));
  EXPECT_TRUE(shown().empty());
}

TEST_F(CrossingUnitsTest, stores_a_limited_number_of_units) {
  for (std::size_t i = 0; i < CrossingUnits::units_max; ++i) EXPECT_TRUE(receive(status_of("Y" + std::to_string(i))));
  EXPECT_EQ(receive(status_of("X1")).error().code, "unit.count");
}

}  // namespace
}  // namespace cosiva::virtual_side
