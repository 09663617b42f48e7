#include "cosiva/virtual/server/commands/commands.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "cosiva/base/digest.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/virtual/server/context/master_control.h"
#include "cosiva/virtual/server/context/server_context.h"
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

TEST_F(CommandFixture, stop_that_was_published_already_has_the_same_action_for_every_vehicle) {
  fixture.add("AIV2", {2, 0.5});
  fixture.run_for(1s);
  const std::size_t before = fixture.published.size();
  fixture.send_command(R"({"id":"S1","command":"stop","vehicle":"*","actionId":"S1"})");
  std::vector<std::string> ids;
  for (std::size_t i = before; i < fixture.published.size(); ++i) {
    const auto actions = vda::decode_instant_actions(fixture.published[i].payload);
    if (actions && actions->actions[0].action_type == "startPause") ids.push_back(actions->actions[0].action_id);
  }
  EXPECT_EQ(ids, (std::vector<std::string>{"S1", "S1"}));
  fixture.run_for(1s);
  EXPECT_EQ(state_of("S1.AIV1"), "materialised");
  EXPECT_EQ(state_of("S1.AIV2"), "materialised");
}

TEST_F(CommandFixture,
       stop_that_was_published_already_is_only_repeated_to_a_third_party_vehicle_that_does_not_list_it) {
  FixtureVehicle& third_party = fixture.add("R1", {2, 0.5}, "Acme");
  fixture.run_for(1s);
  const auto stops = [&](std::size_t begin) {
    std::size_t count = 0;
    for (std::size_t i = begin; i < fixture.published.size(); ++i) {
      const auto actions = vda::decode_instant_actions(fixture.published[i].payload);
      if (actions && actions->header.manufacturer == "Acme" && actions->actions[0].action_id == "S1") ++count;
    }
    return count;
  };
  const std::size_t before = fixture.published.size();
  fixture.send_command(R"({"id":"S1","command":"stop","vehicle":"Acme/R1","actionId":"S1"})");
  EXPECT_EQ(stops(before), 0U);
  fixture.run_for(InstantActionSender::resend_after - 20ms);
  EXPECT_EQ(stops(before), 0U);
  fixture.run_for(40ms);
  EXPECT_EQ(stops(before), 1U);
  fixture.run_for(2s);
  EXPECT_TRUE(third_party.paused);
  EXPECT_EQ(state_of("S1"), "materialised");
}

TEST_F(CommandFixture, stop_after_a_restart_that_is_not_confirmed_is_another_action_than_the_one_published_already) {
  fixture.run_for(1s);
  fixture.command("stop", "CoSiVA/AIV1");
  fixture.run_for(2s);
  ASSERT_TRUE(aiv.paused);
  fixture.send_command(R"({"id":"r","command":"restart","vehicle":"CoSiVA/AIV1"})");
  const std::size_t before = fixture.published.size();
  fixture.send_command(R"({"id":"S1","command":"stop","vehicle":"CoSiVA/AIV1","actionId":"S1"})");
  const auto actions = vda::decode_instant_actions(fixture.published.at(before).payload);
  ASSERT_TRUE(actions);
  EXPECT_EQ(actions->actions[0].action_type, "startPause");
  EXPECT_NE(actions->actions[0].action_id, "S1");
  fixture.run_for(2s);
  EXPECT_TRUE(aiv.paused);
  EXPECT_EQ(state_of("S1"), "materialised");
}

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

TEST_F(CommandFixture, an_unacknowledged_stop_is_repeated_with_the_same_id_until_it_is_confirmed) {
  aiv.deaf_to = {"startPause"};
  const std::size_t before = aiv.actions.size();
  fixture.command("stop", "CoSiVA/AIV1", "c1");
  fixture.run_for(60s);
  EXPECT_EQ(state_of("c1"), "issued");
  EXPECT_GE(aiv.actions.size() - before, 190U) << "every 300 ms";
  for (std::size_t i = before; i < aiv.actions.size(); ++i)
    EXPECT_EQ(aiv.actions[i].actions[0].action_id, aiv.actions[before].actions[0].action_id);
  aiv.deaf_to.clear();
  fixture.run_for(1s);
  EXPECT_EQ(state_of("c1"), "materialised");
}

TEST_F(CommandFixture, an_unacknowledged_action_is_repeated_with_the_same_id_and_fails_after_five_seconds) {
  aiv.deaf_to = {"cancelOrder"};
  const std::size_t before = aiv.actions.size();
  fixture.command("cancel", "CoSiVA/AIV1", "c1");
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
  const std::string& id = aiv.actions[before].actions[0].action_id;
  EXPECT_EQ(std::ranges::count_if(aiv.actions, [&](const auto& message) { return message.actions[0].action_id == id; }),
            static_cast<std::ptrdiff_t>(sent))
      << "no repetition after the failure";
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
  aiv.fakes = {"cancelOrder"};
  fixture.command("cancel", "CoSiVA/AIV1", "c1");
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

TEST_F(CommandFixture, a_command_to_an_absent_vehicle_is_accepted_and_waits_for_it) {
  fixture.kill(aiv);
  EXPECT_EQ(error_of(R"({"command":"stop","vehicle":"CoSiVA/AIV1"})"), "");
  fixture.command("stop", "CoSiVA/AIV1", "c1");
  EXPECT_EQ(state_of("c1"), "issued");
  EXPECT_THAT(reason_of("c1"), HasSubstr("not connected"));
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

using Kind = OperatorCommandKind;
using wire::ActionStatus;

constexpr std::array all_kinds{Kind::stop,  Kind::slow,    Kind::medium, Kind::fast,
                               Kind::limit, Kind::restart, Kind::cancel};
bool imposes_speed(Kind kind) {
  return kind == Kind::slow || kind == Kind::medium || kind == Kind::fast || kind == Kind::limit;
}

/// Commands without the rest of the server: the vehicles CoSiVA/AIV1 and Acme/A2 report what the test states.
class FollowedCommands : public testing::Test {
 protected:
  FollowedCommands() {
    server.publisher.open(now, effects);
    EXPECT_TRUE(server.simulator.receive(now, oval(), step_recorder(server)).has_value());
    aiv1 = add("CoSiVA", "AIV1");
    a2 = add("Acme", "A2");
  }
  VehicleIndex add(const std::string& manufacturer, const std::string& serial) {
    const VehicleIndex vehicle = *server.registry.add({manufacturer, serial}, now);
    AivProxy& added = proxy(vehicle);
    added.twin_link.on_appeared(
        server.simulator.appear(added.name(), added.identity.number(), added.augmented(), 1s, step_recorder(server)));
    added.connection.on_connection(wire::ConnectionState::online, now);
    master.traffic.resize(server.registry.size());
    master.missions.resize(server.registry.size());
    master.orders.resize(server.registry.size());
    return vehicle;
  }
  [[nodiscard]] AivProxy& proxy(VehicleIndex vehicle) { return server.registry[vehicle]; }
  void pass(SimDuration duration) {
    now += duration;
    server.publisher.open(now, effects);
  }

  static VehicleCommand command_to(std::vector<std::string> names, Kind kind, double speed_mps = 0.0) {
    const bool several = names.size() > 1 || names.front() == "*";
    return {"", std::string(to_string(kind)), std::move(names), kind, speed_mps, several};
  }
  static VehicleCommand unknown_command_to(std::vector<std::string> names) {
    const bool several = names.size() > 1 || names.front() == "*";
    return {"", "dance", std::move(names), std::nullopt, 0.0, several};
  }
  const Command& issue(const Result<VehicleCommand>& command) {
    master.commands.issue(command);
    return list().back();
  }
  const Command& issue(Kind kind, double speed_mps = 0.0) {
    return issue(command_to({"CoSiVA/AIV1"}, kind, speed_mps));
  }
  [[nodiscard]] const std::deque<Command>& list() const { return master.commands.list(); }

  void set_state(VehicleIndex vehicle, const std::function<void(wire::State&)>& change) {
    wire::State next = proxy(vehicle).state() != nullptr ? *proxy(vehicle).state() : wire::State{};
    ++next.header.header_id;
    next.header.timestamp = now + next.header.header_id * 1ms;
    change(next);
    proxy(vehicle).reported_state.on_state(std::make_shared<const wire::State>(std::move(next)), true);
  }
  void report(VehicleIndex vehicle, const std::function<void(wire::State&)>& change) {
    set_state(vehicle, change);
    master.actions.on_state(vehicle, *proxy(vehicle).state());
    master.commands.on_state(vehicle);
  }
  void report_again(VehicleIndex vehicle) {
    report(vehicle, [](wire::State&) {});
  }
  [[nodiscard]] std::vector<wire::Action> actions_of(const Command& command) const {
    const auto* pending = master.actions.find(command.handle);
    return pending != nullptr ? pending->message.actions : std::vector<wire::Action>{};
  }
  /// The vehicle reports all actions of the command, in addition to those that it has reported before.
  void report_actions(const Command& command, ActionStatus status, const std::string& result = "") {
    report(command.vehicle, [&](wire::State& next) {
      for (const wire::Action& action : actions_of(command)) {
        std::erase_if(next.action_states, [&](const auto& known) { return known.action_id == action.action_id; });
        next.action_states.push_back({action.action_id, action.action_type, status, result});
      }
    });
  }
  void set_speed(VehicleIndex vehicle, double speed_mps) {
    server.simulator.report(*proxy(vehicle).twin(), now, {now, {0.5, 0.0, 0.0}, speed_mps});
  }
  void impose(VehicleIndex vehicle, const std::string& profile) {
    report(vehicle, [&](wire::State& next) {
      next.action_states.push_back({"earlier", "setSpeedLimit", ActionStatus::finished, profile});
    });
  }
  [[nodiscard]] double slow_mps() const { return server.simulator.zone()->profiles.slow.speed_mps; }
  [[nodiscard]] JsonValue monitored() const {
    JsonWriter json;
    server.simulator.monitor().write(json);
    return *JsonValue::parse(json.text())->find("commands");
  }
  [[nodiscard]] double counted(std::string_view kind) const { return monitored().number(kind).value_or(-1.0); }
  [[nodiscard]] std::string last_log() const {
    std::string text;
    for (const wire::Effect& effect : effects)
      if (const auto* log = std::get_if<wire::Log>(&effect)) text = std::string{log->level} + " " + log->text;
    return text;
  }

  SimTime now{virtual_epoch};
  wire::Effects effects;
  ServerContext server{};
  MasterControl master{server};
  VehicleIndex aiv1{};
  VehicleIndex a2{};
};

TEST_F(FollowedCommands, are_sent_as_instant_actions_that_block_nothing) {
  report_again(aiv1);
  const auto sent = [&](Kind kind, double speed_mps = 0.0) { return actions_of(issue(kind, speed_mps)); };
  const auto types = [](const std::vector<wire::Action>& actions) {
    std::vector<std::string> found;
    for (const wire::Action& action : actions) {
      EXPECT_EQ(action.blocking_type, wire::BlockingType::none);
      found.push_back(action.action_type);
    }
    return found;
  };
  EXPECT_THAT(types(sent(Kind::stop)), testing::ElementsAre("startPause"));
  EXPECT_THAT(types(sent(Kind::cancel)), testing::ElementsAre("cancelOrder"));
  EXPECT_THAT(types(sent(Kind::restart)), testing::ElementsAre("stopPause"));
  const auto limit = sent(Kind::limit, 0.25);
  EXPECT_THAT(types(limit), testing::ElementsAre("setSpeedLimit"));
  EXPECT_EQ(limit[0].number("maxSpeed"), 0.25);
  EXPECT_FALSE(limit[0].text("profile"));
  for (const Kind kind : {Kind::slow, Kind::medium, Kind::fast}) {
    const auto profile = sent(kind);
    EXPECT_THAT(types(profile), testing::ElementsAre("setSpeedLimit"));
    EXPECT_EQ(profile[0].text("profile"), to_string(kind));
  }
}

TEST_F(FollowedCommands, to_restart_lift_an_imposed_profile_or_limit) {
  impose(aiv1, "slow");
  const auto lifts_profile = actions_of(issue(Kind::restart));
  ASSERT_EQ(lifts_profile.size(), 2U);
  EXPECT_EQ(lifts_profile[0].action_type, "stopPause");
  EXPECT_EQ(lifts_profile[1].action_type, "setSpeedLimit");
  EXPECT_EQ(lifts_profile[1].text("profile"), "normal");
  impose(aiv1, "normal");
  EXPECT_EQ(actions_of(issue(Kind::restart)).size(), 1U);
  proxy(aiv1).settings.on_limit(0.2);
  EXPECT_EQ(actions_of(issue(Kind::restart)).size(), 2U);
  EXPECT_FALSE(proxy(aiv1).settings.speed_mps_max()) << "lifted";
}

TEST_F(FollowedCommands, to_restart_lift_the_limit_that_a_vehicle_without_a_report_may_have) {
  ASSERT_EQ(proxy(aiv1).state(), nullptr);
  const auto lifts = actions_of(issue(Kind::restart));
  ASSERT_EQ(lifts.size(), 2U);
  EXPECT_EQ(lifts[1].text("profile"), "normal");
  set_state(aiv1, [](wire::State&) {});
  EXPECT_EQ(actions_of(issue(Kind::restart)).size(), 1U);
}

TEST_F(FollowedCommands, change_the_settings_of_the_vehicle) {
  proxy(aiv1).settings.on_body_in_path();
  issue(Kind::stop);
  EXPECT_FALSE(proxy(aiv1).settings.paused_for_body()) << "the operator pauses the vehicle now";
  issue(Kind::cancel);
  EXPECT_TRUE(proxy(aiv1).settings.no_orders());
  issue(Kind::restart);
  EXPECT_FALSE(proxy(aiv1).settings.no_orders());
  proxy(aiv1).settings.on_limit(0.2);
  issue(Kind::limit, 0.4);
  EXPECT_EQ(proxy(aiv1).settings.speed_mps_max(), 0.2) << "the new limit is not confirmed yet";
  issue(Kind::fast);
  EXPECT_FALSE(proxy(aiv1).settings.speed_mps_max());
}

TEST_F(FollowedCommands, to_stop_materialise_below_a_centimetre_per_second) {
  const Command& stop = issue(Kind::stop);
  report_actions(stop, ActionStatus::finished);
  EXPECT_EQ(stop.state, CommandState::accepted) << "not paused";
  report(aiv1, [](wire::State& next) { next.paused = next.driving = true; });
  EXPECT_EQ(stop.state, CommandState::accepted) << "still driving";
  set_speed(aiv1, 0.01);
  report(aiv1, [](wire::State& next) { next.driving = false; });
  EXPECT_EQ(stop.state, CommandState::accepted);
  set_speed(aiv1, 0.009);
  report_again(aiv1);
  EXPECT_EQ(stop.state, CommandState::materialised);
}

TEST_F(FollowedCommands, to_cancel_materialise_without_nodes_and_at_standstill) {
  const Command& cancel = issue(Kind::cancel);
  report(aiv1, [](wire::State& next) { next.node_states = {{"N1", 2, true, {}}}; });
  report_actions(cancel, ActionStatus::running);
  EXPECT_EQ(cancel.state, CommandState::accepted);
  report(aiv1, [](wire::State& next) {
    next.node_states.clear();
    next.driving = true;
  });
  EXPECT_EQ(cancel.state, CommandState::accepted);
  report(aiv1, [](wire::State& next) { next.driving = false; });
  EXPECT_EQ(cancel.state, CommandState::materialised);
}

TEST_F(FollowedCommands, to_limit_materialise_when_confirmed_up_to_2_centimetres_per_second_above) {
  const Command& limit = issue(Kind::limit, 0.25);
  set_speed(aiv1, 0.1);
  report_actions(limit, ActionStatus::running);
  EXPECT_EQ(limit.state, CommandState::accepted) << "not confirmed";
  set_speed(aiv1, 0.28);
  report_actions(limit, ActionStatus::finished);
  EXPECT_EQ(limit.state, CommandState::accepted) << "too fast";
  EXPECT_FALSE(proxy(aiv1).settings.speed_mps_max());
  set_speed(aiv1, 0.25 + 0.02);
  report_again(aiv1);
  EXPECT_EQ(limit.state, CommandState::materialised);
  EXPECT_EQ(proxy(aiv1).settings.speed_mps_max(), 0.25);
}

TEST_F(FollowedCommands, to_impose_a_profile_materialise_when_the_vehicle_shows_it_and_is_no_faster) {
  const Command& slow = issue(Kind::slow);
  set_speed(aiv1, slow_mps() + 0.03);
  report_actions(slow, ActionStatus::finished, "slow");
  EXPECT_EQ(slow.state, CommandState::accepted);
  set_speed(aiv1, slow_mps() + 0.02);
  impose(aiv1, "fast");
  EXPECT_EQ(slow.state, CommandState::accepted) << "another profile";
  impose(aiv1, "slow");
  EXPECT_EQ(slow.state, CommandState::materialised);
  EXPECT_FALSE(proxy(aiv1).settings.speed_mps_max());
}

TEST_F(FollowedCommands, to_restart_materialise_without_pause_and_profile) {
  report(aiv1, [](wire::State& next) { next.paused = true; });
  const Command& restart = issue(Kind::restart);
  report_actions(restart, ActionStatus::finished);
  EXPECT_EQ(restart.state, CommandState::accepted) << "still paused";
  impose(aiv1, "slow");
  report(aiv1, [](wire::State& next) { next.paused = false; });
  EXPECT_EQ(restart.state, CommandState::accepted) << "still slow";
  impose(aiv1, "normal");
  EXPECT_EQ(restart.state, CommandState::materialised);
}

TEST_F(FollowedCommands, to_restart_materialise_with_a_profile_that_was_requested_since) {
  impose(aiv1, "slow");
  const Command& restart = issue(Kind::restart);
  issue(command_to({"Acme/A2"}, Kind::slow));
  issue(Kind::limit, 0.3);
  issue(unknown_command_to({"CoSiVA/AIV1"}));
  report_actions(restart, ActionStatus::running);
  EXPECT_EQ(restart.state, CommandState::accepted) << "of another vehicle, and no profile";
  issue(Kind::slow);
  report_again(aiv1);
  EXPECT_EQ(restart.state, CommandState::materialised) << "at the same time";
}

TEST_F(FollowedCommands, to_restart_do_not_materialise_with_a_profile_from_before) {
  const Command& slow = issue(Kind::slow);
  report_actions(slow, ActionStatus::finished, "slow");
  ASSERT_EQ(slow.state, CommandState::materialised);
  pass(1ms);
  const Command& restart = issue(Kind::restart);
  report_actions(restart, ActionStatus::running);
  EXPECT_EQ(restart.state, CommandState::accepted);
}

TEST_F(FollowedCommands, are_accepted_only_when_the_vehicle_lists_every_action) {
  impose(aiv1, "slow");
  const Command& restart = issue(Kind::restart);
  const auto actions = actions_of(restart);
  report(aiv1, [&](wire::State& next) {
    next.action_states.push_back({actions[0].action_id, "stopPause", ActionStatus::finished, ""});
  });
  EXPECT_EQ(restart.state, CommandState::issued);
  report(aiv1, [&](wire::State& next) {
    next.action_states.push_back({actions[1].action_id, "setSpeedLimit", ActionStatus::waiting, ""});
  });
  EXPECT_EQ(restart.state, CommandState::accepted);
}

TEST_F(FollowedCommands, have_the_times_of_their_steps_and_are_counted) {
  const Command& stop = issue(Kind::stop);
  EXPECT_EQ(stop.at, virtual_epoch);
  pass(500ms);
  report_actions(stop, ActionStatus::running);
  EXPECT_EQ(stop.accepted_at, virtual_epoch + 500ms);
  EXPECT_FALSE(stop.materialised_at);
  EXPECT_EQ(counted("accepted"), 1.0);
  EXPECT_EQ(counted("materialised"), 0.0);
  pass(1s);
  report(aiv1, [](wire::State& next) { next.paused = true; });
  EXPECT_EQ(stop.accepted_at, virtual_epoch + 500ms);
  EXPECT_EQ(stop.materialised_at, virtual_epoch + 1500ms);
  EXPECT_EQ(counted("issued"), 1.0);
  EXPECT_EQ(counted("accepted"), 1.0);
  EXPECT_EQ(counted("materialised"), 1.0);
  EXPECT_EQ(counted("failed"), 0.0);
  EXPECT_NEAR(monitored().find("latency_ms")->number("max").value(), 1500.0, 1e-6);
}

TEST_F(FollowedCommands, to_a_vehicle_without_a_twin_need_only_what_it_reports) {
  const VehicleIndex vehicle = *server.registry.add({"Acme", "A3"}, now);
  proxy(vehicle).connection.on_connection(wire::ConnectionState::online, now);
  const Command& stop = issue(command_to({"Acme/A3"}, Kind::stop));
  report_actions(stop, ActionStatus::running);
  EXPECT_EQ(stop.state, CommandState::accepted);
  report(vehicle, [](wire::State& next) { next.paused = true; });
  EXPECT_EQ(stop.state, CommandState::materialised);
}

TEST_F(FollowedCommands, to_virtual_vehicles_are_not_counted) {
  add("CoSiVA.virtual", "V1");
  const Command& stop = issue(command_to({"CoSiVA.virtual/V1"}, Kind::stop));
  report_actions(stop, ActionStatus::running);
  report(stop.vehicle, [](wire::State& next) { next.paused = true; });
  EXPECT_EQ(stop.state, CommandState::materialised);
  issue(command_to({"CoSiVA.virtual/V1"}, Kind::slow));
  master.commands.forget(stop.vehicle, "removed");
  for (const auto* kind : {"issued", "accepted", "materialised", "failed"}) EXPECT_EQ(counted(kind), 0.0) << kind;
}

TEST_F(FollowedCommands, are_followed_no_longer_after_their_end) {
  const Command& stop = issue(Kind::stop);
  report_actions(stop, ActionStatus::running);
  ASSERT_FALSE(actions_of(stop).empty());
  report(aiv1, [](wire::State& next) { next.paused = true; });
  EXPECT_TRUE(actions_of(stop).empty()) << "materialised";
  const Command& slow = issue(Kind::slow);
  master.commands.forget(aiv1, "removed");
  EXPECT_TRUE(actions_of(slow).empty()) << "failed";
  EXPECT_EQ(stop.state, CommandState::materialised);
}

TEST_F(FollowedCommands, that_are_a_stop_wait_for_the_vehicle_until_it_has_performed_or_lost_the_action) {
  const Command& stop = issue(Kind::stop);
  EXPECT_TRUE(master.commands.stop_unperformed(aiv1));
  report_actions(stop, ActionStatus::running);
  EXPECT_TRUE(master.commands.stop_unperformed(aiv1));
  report(aiv1, [](wire::State& next) { next.action_states.clear(); });
  EXPECT_FALSE(master.commands.stop_unperformed(aiv1)) << "the vehicle was restarted";
  EXPECT_EQ(stop.state, CommandState::accepted);
}

TEST_F(FollowedCommands, that_the_vehicle_refuses_state_result_and_errors_about_their_actions) {
  const Command& slow = issue(Kind::slow);
  const std::string id = actions_of(slow)[0].action_id;
  report(aiv1, [&](wire::State& next) {
    next.errors = {{"validationError", wire::ErrorLevel::warning, "no such profile", {{"actionId", id}}},
                   {"orderError", wire::ErrorLevel::warning, "of an order", {{"orderId", id}}},
                   {"otherError", wire::ErrorLevel::warning, "of another action", {{"actionId", id + "x"}}}};
  });
  report_actions(slow, ActionStatus::failed, "unknown");
  EXPECT_EQ(slow.state, CommandState::failed);
  EXPECT_EQ(slow.reason, "the vehicle refused the command: unknown (validationError: no such profile)");
  EXPECT_EQ(last_log(), "w command c1 'slow' for 'CoSiVA/AIV1' failed: " + slow.reason);
  EXPECT_EQ(counted("failed"), 1.0);
}

TEST_F(FollowedCommands, that_the_vehicle_refuses_without_a_reason_have_none) {
  const Command& slow = issue(Kind::slow);
  report_actions(slow, ActionStatus::failed);
  EXPECT_EQ(slow.reason, "the vehicle refused the command");
}

TEST_F(FollowedCommands, fail_where_any_of_their_actions_fails) {
  impose(aiv1, "slow");
  const Command& restart = issue(Kind::restart);
  const auto actions = actions_of(restart);
  report(aiv1, [&](wire::State& next) {
    next.action_states.push_back({actions[0].action_id, "stopPause", ActionStatus::finished, ""});
    next.action_states.push_back({actions[1].action_id, "setSpeedLimit", ActionStatus::failed, "no"});
  });
  EXPECT_EQ(restart.reason, "the vehicle refused the command: no");
}

TEST_F(FollowedCommands, fail_five_seconds_after_they_were_issued) {
  const Command& cancel = issue(Kind::cancel);
  const Command& slow = issue(Kind::slow);
  report_actions(slow, ActionStatus::running);
  pass(4999ms);
  master.commands.tick();
  EXPECT_EQ(cancel.state, CommandState::issued);
  EXPECT_EQ(slow.state, CommandState::accepted);
  pass(1ms);
  master.commands.tick();
  EXPECT_EQ(cancel.state, CommandState::failed);
  EXPECT_EQ(cancel.reason, "the vehicle did not respond within 5 s");
  EXPECT_EQ(slow.state, CommandState::failed);
  EXPECT_EQ(slow.reason, "accepted, but its effect was not observed within 5 s");
  master.commands.tick();
  EXPECT_EQ(counted("failed"), 2.0) << "each once";
}

TEST_F(FollowedCommands, to_stop_have_no_time_limit) {
  const Command& stop = issue(Kind::stop);
  pass(1h);
  master.commands.tick();
  EXPECT_EQ(stop.state, CommandState::issued);
}

TEST_F(FollowedCommands, are_numbered_whether_they_have_ids_of_their_own_or_not) {
  EXPECT_EQ(issue(Kind::stop).id, "c1");
  VehicleCommand named = command_to({"CoSiVA/AIV1"}, Kind::slow);
  named.id = "mine";
  EXPECT_EQ(issue(named).id, "mine");
  EXPECT_EQ(issue(unknown_command_to({"CoSiVA/AIV1"})).id, "c3");
}

TEST_F(FollowedCommands, to_several_vehicles_have_one_entry_for_each) {
  issue(command_to({"Acme/A2", "CoSiVA/AIV1", "Acme/A2"}, Kind::stop));
  ASSERT_EQ(list().size(), 2U) << "named twice";
  EXPECT_EQ(list()[0].id, "c1.A2");
  EXPECT_EQ(list()[0].vehicle, a2);
  EXPECT_EQ(list()[0].vehicle_name, "Acme/A2");
  EXPECT_EQ(list()[1].id, "c1.AIV1");
  EXPECT_EQ(list()[1].vehicle_name, "CoSiVA/AIV1");
  EXPECT_EQ(list()[1].command_text, "stop");
}

TEST_F(FollowedCommands, to_all_leave_out_vehicles_that_have_left) {
  proxy(aiv1).on_retired(now);
  issue(command_to({"*"}, Kind::stop));
  ASSERT_EQ(list().size(), 1U);
  EXPECT_EQ(list()[0].vehicle, a2);
}

TEST_F(FollowedCommands, to_all_hold_for_vehicles_that_are_not_known_yet) {
  proxy(aiv1).on_retired(now);
  proxy(a2).on_retired(now);
  EXPECT_TRUE(master.commands.check(command_to({"*"}, Kind::stop)));
  issue(command_to({"*"}, Kind::stop));
  EXPECT_TRUE(list().empty());
}

TEST_F(FollowedCommands, to_unknown_or_retired_vehicles_are_refused) {
  proxy(a2).on_retired(now);
  for (const std::string name : {"Acme/A2", "Acme/A3"}) {
    const auto checked = master.commands.check(command_to({"CoSiVA/AIV1", name}, Kind::stop));
    ASSERT_FALSE(checked) << name;
    EXPECT_EQ(checked.error(),
              (Error{"command.vehicle", "no vehicle '" + name + "' is known; name it as manufacturer/serial number",
                     "vehicle"}));
  }
}

TEST_F(FollowedCommands, to_absent_vehicles_wait_for_them_with_that_reason) {
  proxy(a2).connection.on_offline(now);
  EXPECT_TRUE(master.commands.check(command_to({"Acme/A2"}, Kind::stop)));
  issue(command_to({"*"}, Kind::stop));
  ASSERT_EQ(list().size(), 2U);
  EXPECT_EQ(list()[0].state, CommandState::issued);
  EXPECT_EQ(list()[0].reason, "");
  EXPECT_EQ(list()[1].state, CommandState::issued);
  EXPECT_EQ(list()[1].reason, "Acme/A2 is not connected; the command holds when it is back");
  EXPECT_EQ(counted("issued"), 2.0);
  EXPECT_EQ(counted("failed"), 0.0);
}

TEST_F(FollowedCommands, that_set_a_speed_are_impossible_where_the_factsheet_does_not_list_it) {
  wire::Factsheet factsheet;
  factsheet.actions.push_back({"startPause", "", true, false, false, {}});
  proxy(aiv1).factsheet.on_factsheet(factsheet);
  for (const Kind kind : all_kinds) {
    EXPECT_EQ(master.commands.check(command_to({"CoSiVA/AIV1"}, kind, 0.2)).has_value(), !imposes_speed(kind))
        << to_string(kind);
    EXPECT_TRUE(master.commands.check(command_to({"Acme/A2"}, kind, 0.2))) << "its factsheet is unknown";
  }
}

TEST_F(FollowedCommands, that_are_none_are_listed_as_failed_with_the_vehicles_named) {
  const Command& dance = issue(unknown_command_to({"CoSiVA/AIV1", "Acme/A2"}));
  EXPECT_EQ(dance.state, CommandState::failed);
  EXPECT_EQ(dance.vehicle, no_vehicle);
  EXPECT_EQ(dance.vehicle_name, "CoSiVA/AIV1, Acme/A2");
  EXPECT_EQ(dance.command_text, "dance");
  EXPECT_EQ(dance.reason,
            "command: there is no command 'dance'; use stop, slow, medium, fast, limit, restart, cancel, exclude, "
            "include, retire or self-test");
  const Command& unreadable = issue(fail("command.syntax", "no object"));
  EXPECT_EQ(unreadable.reason, "no object");
  EXPECT_EQ(unreadable.vehicle_name, "");
  EXPECT_EQ(last_log(), "w command c2 '' for '' failed: no object");
  EXPECT_EQ(counted("issued"), 2.0);
  EXPECT_EQ(counted("failed"), 2.0);
}

TEST_F(FollowedCommands, replace_the_older_ones_that_they_contradict) {
  for (const Kind older : all_kinds) {
    for (const Kind newer : all_kinds) {
      const Command& first = issue(older, 0.2);
      const Command& second = issue(newer, 0.3);
      const bool replaced = older == newer || newer == Kind::restart ||
                            (imposes_speed(older) && imposes_speed(newer)) ||
                            (older == Kind::restart && newer == Kind::stop);
      EXPECT_EQ(first.state, replaced ? CommandState::failed : CommandState::issued)
          << to_string(older) << ", " << to_string(newer);
      EXPECT_EQ(second.state, CommandState::issued);
      if (replaced) {
        EXPECT_EQ(first.reason, "superseded by " + second.id + " (" + std::string(to_string(newer)) + ")");
      }
      master.commands.forget(aiv1, "next pair");
    }
  }
}

TEST_F(FollowedCommands, do_not_replace_those_to_another_vehicle) {
  const Command& first = issue(Kind::stop);
  issue(command_to({"Acme/A2"}, Kind::stop));
  EXPECT_EQ(first.state, CommandState::issued);
}

TEST_F(FollowedCommands, of_a_removed_vehicle_fail_and_those_of_others_stay_open) {
  const Command& stop = issue(Kind::stop);
  const Command& other = issue(command_to({"Acme/A2"}, Kind::stop));
  master.commands.forget(aiv1, "the vehicle was removed");
  EXPECT_EQ(stop.state, CommandState::failed);
  EXPECT_EQ(stop.reason, "the vehicle was removed");
  EXPECT_EQ(other.state, CommandState::issued);
  master.commands.forget(aiv1, "again");
  EXPECT_EQ(stop.reason, "the vehicle was removed");
}

TEST_F(FollowedCommands, concern_the_states_of_their_own_vehicle_only) {
  const Command& stop = issue(Kind::stop);
  report_actions(stop, ActionStatus::running);
  set_state(aiv1, [](wire::State& next) { next.paused = true; });
  report_again(a2);
  EXPECT_EQ(stop.state, CommandState::accepted);
  report_again(aiv1);
  EXPECT_EQ(stop.state, CommandState::materialised);
}

TEST_F(FollowedCommands, are_listed_up_to_200_and_the_oldest_fails_where_it_is_open) {
  issue(Kind::cancel);
  for (int i = 1; i < 200; ++i) issue(unknown_command_to({"CoSiVA/AIV1"}));
  ASSERT_EQ(list().size(), 200U);
  EXPECT_EQ(list().front().state, CommandState::issued);
  issue(command_to({"Acme/A2"}, Kind::stop));
  ASSERT_EQ(list().size(), 200U);
  EXPECT_EQ(list().front().id, "c2");
  EXPECT_EQ(last_log(), "w command c1 'cancel' for 'CoSiVA/AIV1' failed: too many commands at once");
  issue(command_to({"Acme/A2"}, Kind::slow));
  EXPECT_EQ(list().front().id, "c3");
  EXPECT_EQ(counted("failed"), 200.0) << "the cancellation and 199 unknown ones, each once";
}

TEST_F(FollowedCommands, fold_their_ids_and_states) {
  issue(Kind::stop);
  issue(unknown_command_to({"CoSiVA/AIV1"}));
  Digest expected;
  expected.add(std::string_view{"c1"});
  expected.add(std::uint64_t{0});  // issued
  expected.add(std::string_view{"c2"});
  expected.add(std::uint64_t{3});  // failed
  Digest folded;
  master.commands.fold(folded);
  EXPECT_EQ(folded.hex(), expected.hex());
}

// The fault simulation found this: a restarted server is given the commands that an earlier process had accepted, and
// it did not know their vehicles yet.
TEST_F(CommandFixture, a_stored_command_holds_for_a_vehicle_that_is_not_known_yet) {
  fixture.feed(wire::InputKind::command, "http", R"({"id":"c1","command":"stop","vehicle":"CoSiVA/AIV2"})", true);
  EXPECT_EQ(state_of("c1"), "failed");
  const FixtureVehicle& late = fixture.add("AIV2", {1, 0.5});
  fixture.run_for(8s);
  EXPECT_EQ(late.speed_mps, 0.0);
  EXPECT_EQ(fixture.aiv("CoSiVA/AIV2").flag("paused"), true);
}

TEST_F(CommandFixture, a_command_that_is_not_stored_does_not_hold_for_an_unknown_vehicle) {
  fixture.feed(wire::InputKind::command, "http", R"({"id":"c1","command":"stop","vehicle":"CoSiVA/AIV2"})", false);
  EXPECT_EQ(state_of("c1"), "failed");
  fixture.add("AIV2", {1, 0.5});
  fixture.run_for(8s);
  EXPECT_EQ(fixture.aiv("CoSiVA/AIV2").flag("paused"), false);
}

TEST_F(CommandFixture, commands_of_an_earlier_process_wait_until_its_vehicles_are_known_again) {
  fixture.restart_server();
  EXPECT_FALSE(fixture.server->takes_earlier_command(R"({"command":"slow","vehicle":"*"})"));
  fixture.run_for(6s);
  EXPECT_TRUE(fixture.server->takes_earlier_command(R"({"command":"slow","vehicle":"*"})"));
}

}  // namespace
}  // namespace cosiva::virtual_side
