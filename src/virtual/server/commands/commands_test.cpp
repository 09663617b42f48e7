#include "cosiva/virtual/server/commands/commands.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cosiva/virtual/server/testing/server_fixture.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;
using testing::HasSubstr;

class CommandFixture : public testing::Test {
 protected:
  CommandFixture() { fixture.run_for(5s); }
  [[nodiscard]] std::string state_of(const std::string& id) const {
    return fixture.command_entry(id).text("state").value_or("?");
  }
  [[nodiscard]] std::string reason_of(const std::string& id) const {
    return fixture.command_entry(id).text("reason").value_or("?");
  }
  [[nodiscard]] std::string error_of(const std::string& json) const {
    const auto checked = fixture.server->check_command(DecodedCommand{json});
    return checked ? "" : to_string(checked.error());
  }
  void list_actions(const std::vector<std::string>& types) {
    wire::Factsheet sheet;
    sheet.header = aiv.header(fixture.now, 0);
    for (const std::string& type : types) sheet.actions.push_back({type, "", true, false, false, {}});
    fixture.send(aiv, "factsheet", vda::encode(sheet), true);
  }

  ServerFixture fixture;
  FixtureVehicle& aiv{fixture.add("AIV1", {0, 0.5})};
};

TEST_F(CommandFixture, stop_is_issued_accepted_and_materialised_when_the_vehicle_is_stopped) {
  ASSERT_GT(aiv.speed_mps, 0.0);
  fixture.command("stop", "CoSiVA/AIV1", "c1");
  EXPECT_EQ(state_of("c1"), "issued");
  fixture.run_for(1s);
  EXPECT_EQ(state_of("c1"), "materialised");
  EXPECT_EQ(aiv.speed_mps, 0.0);
  EXPECT_EQ(fixture.aiv("CoSiVA/AIV1").text("status"), "stopped");
  const JsonValue entry = fixture.command_entry("c1");
  EXPECT_LE(*entry.number("accepted_ms"), *entry.number("materialised_ms"));
  EXPECT_LE(*entry.number("materialised_ms"), 1000.0);
}

TEST_F(CommandFixture, restart_resumes_driving_and_lifts_a_limit) {
  fixture.command("slow", "CoSiVA/AIV1", "c1");
  fixture.run_for(1s);
  EXPECT_EQ(state_of("c1"), "materialised");
  EXPECT_EQ(fixture.aiv("CoSiVA/AIV1").text("status"), "slow speed");
  fixture.command("stop", "CoSiVA/AIV1", "c2");
  fixture.run_for(1s);
  fixture.command("restart", "CoSiVA/AIV1", "c3");
  fixture.run_for(2s);
  EXPECT_EQ(state_of("c3"), "materialised");
  EXPECT_EQ(aiv.profile, "normal");
  EXPECT_GT(aiv.speed_mps, 0.25);
  EXPECT_EQ(fixture.aiv("CoSiVA/AIV1").text("status"), "Normal");
}

TEST_F(CommandFixture, limit_restricts_the_speed_of_one_vehicle_until_restart_lifts_it) {
  fixture.run_for(2s);
  fixture.send_command(R"({"command":"limit","speed":0.12,"vehicle":"CoSiVA/AIV1","id":"c1"})");
  EXPECT_TRUE(fixture.aiv("CoSiVA/AIV1").find("speedLimit")->is_null()) << "requested, but not yet in effect";
  fixture.run_for(2s);
  EXPECT_EQ(state_of("c1"), "materialised");
  EXPECT_NEAR(aiv.speed_mps, 0.12, 1e-9);
  EXPECT_EQ(fixture.aiv("CoSiVA/AIV1").number("speedLimit"), 0.12);
  const wire::Action& commanded = aiv.actions.back().actions.front();
  EXPECT_EQ(commanded.action_type, "setSpeedLimit");
  EXPECT_EQ(commanded.number("maxSpeed"), 0.12);
  fixture.command("restart", "CoSiVA/AIV1", "c2");
  fixture.run_for(2s);
  EXPECT_EQ(state_of("c2"), "materialised");
  EXPECT_GT(aiv.speed_mps, 0.25);
  EXPECT_TRUE(fixture.aiv("CoSiVA/AIV1").find("speedLimit")->is_null());
}

TEST_F(CommandFixture, limit_needs_a_valid_speed) {
  for (const char* speed : {"", R"("speed":0,)", R"("speed":-0.1,)", R"("speed":5.1,)", R"("speed":"fast",)"})
    EXPECT_THAT(fixture.refusal(R"({"command":"limit",)" + std::string(speed) + R"("vehicle":"CoSiVA/AIV1"})"),
                HasSubstr("maximum speed"))
        << speed;
}

TEST_F(CommandFixture, the_imposed_speed_is_restored_after_a_restart_of_the_server) {
  fixture.command("fast", "CoSiVA/AIV1");
  fixture.run_for(2s);
  fixture.restart_server();
  fixture.run_for(3s);
  EXPECT_EQ(fixture.aiv("CoSiVA/AIV1").text("status"), "fast speed");
}

TEST_F(CommandFixture, cancel_ends_the_order_and_none_follows_until_restart) {
  fixture.command("cancel", "CoSiVA/AIV1", "c1");
  fixture.run_for(10s);
  EXPECT_EQ(state_of("c1"), "materialised");
  EXPECT_FALSE(aiv.book->active());
  EXPECT_EQ(aiv.speed_mps, 0.0);
  fixture.command("restart", "CoSiVA/AIV1", "c2");
  fixture.run_for(3s);
  EXPECT_EQ(state_of("c2"), "materialised");
  EXPECT_GT(aiv.speed_mps, 0.0);
}

TEST_F(CommandFixture, all_addresses_every_vehicle_with_one_entry_each) {
  fixture.add("AIV2", {2, 0.5});
  fixture.run_for(2s);
  fixture.command("stop", "*", "c9");
  fixture.run_for(1s);
  EXPECT_EQ(state_of("c9.AIV1"), "materialised");
  EXPECT_EQ(state_of("c9.AIV2"), "materialised");
  EXPECT_EQ(*fixture.bijection().find("commands")->number("materialised"), 2.0);
}

TEST_F(CommandFixture, an_unacknowledged_action_is_repeated_with_the_same_id_and_fails_after_five_seconds) {
  aiv.deaf_to = {"startPause"};
  const std::size_t before = aiv.actions.size();
  fixture.command("stop", "CoSiVA/AIV1", "c1");
  fixture.run_for(4900ms);
  EXPECT_EQ(state_of("c1"), "issued");
  const std::size_t sent = aiv.actions.size() - before;
  EXPECT_GE(sent, 14U) << "every 300 ms";
  for (std::size_t i = before; i < aiv.actions.size(); ++i)
    EXPECT_EQ(aiv.actions[i].actions[0].action_id, aiv.actions[before].actions[0].action_id);
  fixture.run_for(200ms);
  EXPECT_EQ(state_of("c1"), "failed");
  EXPECT_THAT(reason_of("c1"), HasSubstr("within 5 s"));
  fixture.run_for(2s);
  EXPECT_EQ(aiv.actions.size() - before, sent) << "no repetition after the failure";
}

TEST_F(CommandFixture, every_instant_actions_message_increments_the_header_id_even_when_repeated) {
  aiv.deaf_to = {"startPause"};
  fixture.command("stop", "CoSiVA/AIV1", "c1");
  fixture.run_for(2s);
  fixture.command("slow", "CoSiVA/AIV1", "c2");
  fixture.run_for(1s);
  const auto published = fixture.published_on(aiv.topic("instantActions"));
  std::vector<std::string> pauses;
  for (std::size_t i = 0; i < published.size(); ++i) {
    const wire::InstantActions message = *vda::decode_instant_actions(published[i].payload);
    EXPECT_EQ(message.header.header_id, i);
    if (message.actions[0].action_type == "startPause") pauses.push_back(message.actions[0].action_id);
  }
  EXPECT_GE(pauses.size(), 6U);
  for (const std::string& id : pauses) EXPECT_EQ(id, pauses.front());
}

TEST_F(CommandFixture, a_lost_action_is_repaired_by_repeating_it) {
  fixture.loss = 1.0;
  fixture.command("stop", "CoSiVA/AIV1", "c1");
  fixture.loss = 0.0;
  fixture.run_for(2s);
  EXPECT_EQ(state_of("c1"), "materialised");
}

TEST_F(CommandFixture, a_refused_action_fails_with_the_vehicle_s_reason) {
  aiv.refuses = {"setSpeedLimit"};
  fixture.command("slow", "CoSiVA/AIV1", "c1");
  fixture.run_for(1s);
  EXPECT_EQ(state_of("c1"), "failed");
  EXPECT_THAT(reason_of("c1"), HasSubstr("not supported"));
}

TEST_F(CommandFixture, a_refusal_is_ignored_when_the_effect_is_observed) {
  // Some vehicles report FAILED for a second pause, although they are paused.
  aiv.paused = true;
  aiv.refuses = {"startPause"};
  fixture.run_for(1s);
  fixture.command("stop", "CoSiVA/AIV1", "c1");
  fixture.run_for(1s);
  EXPECT_EQ(state_of("c1"), "materialised");
}

TEST_F(CommandFixture, accepted_without_effect_fails_with_that_reason) {
  aiv.fakes = {"startPause"};
  fixture.command("stop", "CoSiVA/AIV1", "c1");
  fixture.run_for(4s);
  EXPECT_EQ(state_of("c1"), "accepted");
  fixture.run_for(2s);
  EXPECT_EQ(state_of("c1"), "failed");
  EXPECT_THAT(reason_of("c1"), HasSubstr("effect was not observed"));
}

TEST_F(CommandFixture, a_speed_that_the_factsheet_does_not_list_is_refused_at_once) {
  list_actions({"startPause", "stopPause", "cancelOrder"});
  EXPECT_THAT(error_of(R"({"command":"slow","vehicle":"CoSiVA/AIV1"})"), HasSubstr("does not support setSpeedLimit"));
  EXPECT_EQ(error_of(R"({"command":"stop","vehicle":"CoSiVA/AIV1"})"), "");
  fixture.command("slow", "CoSiVA/AIV1", "c1");
  EXPECT_EQ(state_of("c1"), "failed");
  list_actions({"setSpeedLimit"});
  EXPECT_EQ(error_of(R"({"command":"slow","vehicle":"CoSiVA/AIV1"})"), "");
}

TEST_F(CommandFixture, a_command_to_an_absent_vehicle_is_refused_with_advice) {
  fixture.kill(aiv);
  EXPECT_THAT(error_of(R"({"command":"stop","vehicle":"CoSiVA/AIV1"})"), HasSubstr("switch it on"));
  fixture.command("stop", "CoSiVA/AIV1", "c1");
  EXPECT_EQ(state_of("c1"), "failed");
  EXPECT_TRUE(fixture.logged("c1"));
}

TEST_F(CommandFixture, invalid_input_is_refused_with_an_error_message) {
  EXPECT_THAT(error_of("no json"), HasSubstr("JSON object"));
  EXPECT_THAT(error_of("[1]"), HasSubstr("JSON object"));
  EXPECT_THAT(error_of(R"({"vehicle":"*"})"), HasSubstr("which command"));
  EXPECT_THAT(error_of(R"({"command":"stop"})"), HasSubstr("which vehicle"));
  EXPECT_THAT(error_of(R"({"command":"explode","vehicle":"*"})"), HasSubstr("stop, slow, medium, fast"));
  EXPECT_THAT(error_of(R"({"command":"stop","vehicle":"CoSiVA/AIV9"})"), HasSubstr("no vehicle"));
  EXPECT_EQ(error_of(R"({"command":"stop","vehicle":"*"})"), "");
  fixture.feed(wire::InputKind::command, "test", "no json");
  fixture.feed(wire::InputKind::command, "test", std::string(100'000, 'x'));
  EXPECT_EQ(*fixture.bijection().find("commands")->number("failed"), 2.0);
}

TEST_F(CommandFixture, a_newer_command_supersedes_a_contradicting_one) {
  aiv.deaf_to = {"startPause"};
  fixture.command("stop", "CoSiVA/AIV1", "c1");
  fixture.run_for(1s);
  fixture.command("restart", "CoSiVA/AIV1", "c2");
  EXPECT_EQ(state_of("c1"), "failed");
  EXPECT_THAT(reason_of("c1"), HasSubstr("superseded by c2"));
  aiv.deaf_to = {};
  fixture.run_for(2s);
  EXPECT_EQ(state_of("c2"), "materialised");
  EXPECT_GT(aiv.speed_mps, 0.0) << "the lost stop is not sent any more";
}

TEST_F(CommandFixture, a_paused_vehicle_is_granted_no_crossing_and_no_base_extension) {
  fixture.command("stop", "CoSiVA/AIV1");
  fixture.run_for(1s);
  const std::size_t orders = aiv.orders.size();
  fixture.run_for(5s);
  EXPECT_EQ(aiv.orders.size(), orders);
}

}  // namespace
}  // namespace cosiva::virtual_side
