#include "cosiva/virtual/server/reports/vehicle_lifecycle.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "cosiva/virtual/server/testing/server_fixture.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;
using testing::HasSubstr;
using testing::Not;

ServerOptions with_vehicles_max(std::size_t max) {
  ServerOptions options;
  options.vehicles_max = max;
  return options;
}

/// A connection message that names a vehicle of which nothing else is known.
void forge_connection(ServerFixture& fixture, const std::string& serial) {
  const wire::Connection online{{0, fixture.now, "2.1.0", "Acme", serial}, wire::ConnectionState::online};
  fixture.feed(wire::InputKind::message, "uagv/v2/Acme/" + serial + "/connection", vda::encode(online));
}

std::size_t lines_with(const ServerFixture& fixture, std::string_view phrase) {
  return static_cast<std::size_t>(std::ranges::count_if(
      fixture.logs, [&](const std::string& line) { return line.find(phrase) != std::string::npos; }));
}

double registry_number(const ServerFixture& fixture, std::string_view field) {
  return *fixture.snapshot().find("registry")->number(field);
}

TEST(VehicleLifecycle, removes_an_entry_ten_minutes_after_its_last_message_where_it_was_never_a_vehicle) {
  ServerFixture fixture;
  forge_connection(fixture, "X1");
  EXPECT_EQ(registry_number(fixture, "vehicles"), 1.0);
  fixture.now += 9min;
  fixture.run_for(1s);
  EXPECT_EQ(registry_number(fixture, "vehicles"), 1.0);
  fixture.now += 1min;
  fixture.run_for(2s);
  EXPECT_EQ(registry_number(fixture, "vehicles"), 0.0);
  EXPECT_TRUE(fixture.logged("Acme/X1: removed, as it never proved to be a vehicle"));
  EXPECT_THAT(fixture.server->summary_json(), Not(HasSubstr("Acme/X1")));
  forge_connection(fixture, "X1");
  EXPECT_EQ(registry_number(fixture, "vehicles"), 1.0) << "a vehicle of this name may come";
}

TEST(VehicleLifecycle, preserves_the_twin_of_a_vehicle_that_was_present_however_long_ago) {
  ServerFixture fixture;
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.5});
  fixture.run_for(3s);
  fixture.connection(aiv, wire::ConnectionState::offline);
  aiv.alive = false;
  fixture.now += 24h;
  fixture.run_for(2s);
  EXPECT_EQ(registry_number(fixture, "vehicles"), 1.0);
  EXPECT_EQ(fixture.aiv("CoSiVA/AIV1").text("connection"), "OFFLINE");
  EXPECT_EQ(*fixture.bijection().number("virtual"), 1.0);
}

TEST(VehicleLifecycle, preserves_a_vehicle_that_reports_without_a_position) {
  ServerFixture fixture;
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.5});
  aiv.position_known = false;
  fixture.run_for(3s);
  aiv.alive = false;
  fixture.now += 1h;
  fixture.run_for(2s);
  EXPECT_EQ(registry_number(fixture, "vehicles"), 1.0) << "the monitor lists it as an orphan";
}

TEST(VehicleLifecycle, removes_nothing_where_the_options_exclude_it) {
  ServerOptions options;
  options.entries_expire_after = SimDuration::zero();
  ServerFixture fixture{oval(), options};
  forge_connection(fixture, "X1");
  fixture.now += 24h;
  fixture.run_for(2s);
  EXPECT_EQ(registry_number(fixture, "vehicles"), 1.0);
}

TEST(VehicleLifecycle, lets_no_forged_connection_messages_displace_a_vehicle_or_refuse_a_new_one) {
  ServerFixture fixture{oval(), with_vehicles_max(20)};
  fixture.add("AIV1", {0, 0.5});
  fixture.run_for(2s);
  for (int i = 0; i < 500; ++i) forge_connection(fixture, "forged" + std::to_string(i));
  EXPECT_EQ(registry_number(fixture, "vehicles"), 20.0);
  fixture.add("AIV2", {2, 0.5});
  for (int i = 500; i < 1000; ++i) forge_connection(fixture, "forged" + std::to_string(i));
  fixture.run_for(5s);
  EXPECT_EQ(fixture.aiv("CoSiVA/AIV1").text("connection"), "ONLINE");
  EXPECT_EQ(fixture.aiv("CoSiVA/AIV2").flag("lost"), false);
  EXPECT_EQ(registry_number(fixture, "refused"), 0.0);
  EXPECT_EQ(*fixture.bijection().number("matched"), 2.0);
  EXPECT_TRUE(fixture.bijection().find("orphans")->array()->empty());
}

TEST(VehicleLifecycle, refuses_vehicles_beyond_the_limit_with_one_line_a_minute_and_an_alarm) {
  ServerFixture fixture{oval(), with_vehicles_max(1)};
  fixture.add("AIV1", {0, 0.5});
  fixture.run_for(2s);
  for (int i = 0; i < 100; ++i) {
    forge_connection(fixture, "forged" + std::to_string(i));
    fixture.run_for(100ms);
  }
  EXPECT_EQ(registry_number(fixture, "refused"), 100.0);
  EXPECT_EQ(fixture.snapshot().find("registry")->flag("full"), true);
  EXPECT_EQ(lines_with(fixture, "not accepted, as the server already has its limit of 1 vehicles"), 1U);
  EXPECT_EQ(fixture.aiv("CoSiVA/AIV1").flag("lost"), false) << "a known vehicle notices nothing";
  fixture.run_for(61s);
  EXPECT_EQ(fixture.snapshot().find("registry")->flag("full"), false);
  forge_connection(fixture, "later");
  EXPECT_EQ(lines_with(fixture, "not accepted"), 2U);
}

TEST(VehicleLifecycle, accepts_two_thousand_vehicles) {
  ServerFixture fixture;
  for (int i = 0; i < 2'001; ++i) {
    wire::State state;
    state.header = {0, fixture.now, "2.1.0", "Acme", "n" + std::to_string(i)};
    fixture.feed(wire::InputKind::message, "uagv/v2/Acme/" + state.header.serial_number + "/state", vda::encode(state));
  }
  EXPECT_EQ(registry_number(fixture, "vehicles"), 2'000.0);
  EXPECT_EQ(registry_number(fixture, "refused"), 1.0);
}

TEST(VehicleLifecycle, gives_the_mission_of_a_removed_entry_to_the_vehicle_that_comes_back) {
  ServerFixture fixture{{"toml", "fork", fork_text()}};
  fixture.persisted =
      R"({"version":1,"traffic":{"zone":"fork","missions":[{"vehicle":"Acme/X1","kind":"go","name":"dock"}]}})";
  fixture.restart_server(true);
  forge_connection(fixture, "X1");
  fixture.now += 11min;
  fixture.run_for(2s);
  ASSERT_EQ(registry_number(fixture, "vehicles"), 0.0);
  EXPECT_THAT(fixture.persisted, HasSubstr(R"("vehicle":"Acme/X1")"));
}

}  // namespace
}  // namespace cosiva::virtual_side
