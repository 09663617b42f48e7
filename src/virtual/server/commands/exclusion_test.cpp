// Vehicles that an operator excludes from traffic.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "cosiva/virtual/server/testing/server_fixture.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;
using testing::HasSubstr;

/// A vehicle that circulates on the oval, and a second one.
class Exclusion : public testing::Test {
 protected:
  Exclusion() { fixture.run_for(5s); }
  [[nodiscard]] std::string state_of(const std::string& id) const {
    return fixture.command_entry(id).text("state").value_or("?");
  }
  [[nodiscard]] std::string error_of(const std::string& json) const {
    const auto checked = fixture.server->check_command(DecodedCommand{json});
    return checked ? "" : to_string(checked.error());
  }
  void exclude() { fixture.command("exclude", "CoSiVA/AIV1", "x"); }

  ServerFixture fixture;
  FixtureVehicle& aiv{fixture.add("AIV1", {0, 0.5})};
  FixtureVehicle& other{fixture.add("AIV2", {2, 0.5})};
};

TEST_F(Exclusion, ends_the_order_and_keeps_the_twin) {
  exclude();
  fixture.run_for(3s);
  EXPECT_EQ(state_of("x"), "materialised");
  EXPECT_EQ(aiv.speed_mps, 0.0);
  const JsonValue shown = fixture.aiv("CoSiVA/AIV1");
  EXPECT_EQ(shown.flag("excluded"), true);
  EXPECT_EQ(fixture.bijection().number("matched"), 2.0) << "it is still there";
  EXPECT_EQ(fixture.aiv("CoSiVA/AIV2").flag("excluded"), false);
  EXPECT_GT(other.speed_mps, 0.0);
}

TEST_F(Exclusion, is_lifted_by_inclusion_only) {
  exclude();
  fixture.run_for(3s);
  fixture.command("restart", "*");
  fixture.command("circulate", "*");
  fixture.run_for(5s);
  EXPECT_EQ(aiv.speed_mps, 0.0);
  fixture.command("include", "CoSiVA/AIV1", "i");
  EXPECT_EQ(state_of("i"), "materialised");
  fixture.run_for(3s);
  EXPECT_GT(aiv.speed_mps, 0.0);
  EXPECT_EQ(fixture.aiv("CoSiVA/AIV1").flag("excluded"), false);
}

TEST_F(Exclusion, refuses_missions_by_name_and_leaves_the_others_theirs) {
  exclude();
  EXPECT_THAT(error_of(R"({"command":"circulate","vehicle":"CoSiVA/AIV1"})"),
              HasSubstr("'CoSiVA/AIV1' is excluded; include it first"));
  EXPECT_EQ(error_of(R"({"command":"circulate","vehicle":"*"})"), "");
  EXPECT_THAT(error_of(R"({"command":"exclude","vehicle":"*"})"), HasSubstr("name the vehicles to exclude"));
  EXPECT_EQ(error_of(R"({"command":"include","vehicle":"*"})"), "");
}

TEST_F(Exclusion, holds_over_a_restart_of_the_server_and_for_a_vehicle_that_returns) {
  exclude();
  fixture.run_for(3s);
  fixture.restart_server(true);
  const double driven_m = other.driven_m;
  fixture.run_for(8s);
  EXPECT_EQ(aiv.speed_mps, 0.0);
  EXPECT_EQ(fixture.aiv("CoSiVA/AIV1").flag("excluded"), true);
  EXPECT_GT(other.driven_m, driven_m + 0.5);
}

TEST_F(Exclusion, of_a_vehicle_that_is_away_can_be_lifted) {
  exclude();
  fixture.run_for(3s);
  fixture.restart_server(true);
  EXPECT_EQ(error_of(R"({"command":"include","vehicle":"CoSiVA/AIV1"})"), "") << "before its first report";
  EXPECT_THAT(error_of(R"({"command":"include","vehicle":"CoSiVA/AIV7"})"), HasSubstr("no vehicle"));
}

TEST_F(Exclusion, that_is_not_performed_is_repeated) {
  aiv.deaf_to = {"cancelOrder"};
  exclude();
  fixture.run_for(6s);
  EXPECT_EQ(state_of("x"), "failed");
  aiv.deaf_to.clear();
  fixture.run_for(8s);
  EXPECT_EQ(aiv.speed_mps, 0.0);
}

}  // namespace
}  // namespace cosiva::virtual_side
