#include "cosiva/physical/roadside/crossing_unit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>

#include "cosiva/wire/own/v2x_port.h"
#include "cosiva/zone/testing/test_zones.h"

namespace cosiva::physical {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

std::shared_ptr<const zone::Rtm> lacet4() {
  auto rtm = zone::Rtm::initialise(zone::testing::configuration_file("lacet4.toml"));
  EXPECT_TRUE(rtm);
  return std::make_shared<const zone::Rtm>(std::move(*rtm));
}

CrossingUnitOptions at(const std::string& crossing) {
  CrossingUnitOptions options;
  options.rtm = lacet4();
  options.crossing = crossing;
  options.direct = true;
  return options;
}

std::vector<std::string> serials(const std::vector<wire::CrossingStatus::Vehicle>& vehicles) {
  std::vector<std::string> names;
  for (const auto& one : vehicles) names.push_back(one.vehicle.serial_number);
  return names;
}

struct CrossingUnitTest : ::testing::Test {
  std::unique_ptr<CrossingUnit> unit{*CrossingUnit::make(at("X1"))};
  SimTime now{virtual_epoch};
  std::uint32_t header{0};
  wire::Effects effects;

  void give(wire::InputKind kind, std::string source, std::string payload) {
    effects.clear();
    unit->handle({now, kind, std::move(source), std::move(payload), false}, effects);
  }
  void intent(const std::string& serial, double entry_m, double arrival_s, bool direct = true,
              const std::string& name = "X1") {
    wire::Intent sent;
    sent.header_id = ++header;
    sent.timestamp = now;
    sent.map_id = "lacet4";
    sent.vehicle = {"CoSiVA", serial};
    sent.crossings.push_back({name, entry_m, entry_m + 0.4, arrival_s, arrival_s + 1.0, entry_m == 0.0});
    if (direct)
      give(wire::InputKind::bytes, wire::v2x_port_of(sent.vehicle), to_json(sent));
    else
      give(wire::InputKind::message, wire::v2x_topic("lacet4", {}, sent.vehicle), to_json(sent));
  }
  wire::CrossingClaims claims_of(const std::string& serial, std::uint32_t stamp, bool granted) {
    wire::CrossingClaims sent;
    sent.header_id = ++header;
    sent.timestamp = now;
    sent.map_id = "lacet4";
    sent.vehicle = {"CoSiVA", serial};
    sent.claim = wire::CrossingClaims::Claim{1, stamp, 0, granted, {"X1"}};
    return sent;
  }
  void send(const wire::CrossingClaims& claims) {
    give(wire::InputKind::bytes, wire::v2x_port_of(claims.vehicle, wire::claims_port), to_json(claims));
  }
  const wire::CrossingStatus& after_tick() {
    now += 100ms;
    give(wire::InputKind::tick, {}, {});
    return unit->status();
  }
};

TEST_F(CrossingUnitTest, knows_who_is_in_its_crossing_and_who_approaches) {
  intent("AIV3", 0.0, 0.0);
  intent("AIV1", 0.6, 1.5);
  intent("AIV2", 0.3, 0.8, false);
  intent("AIV4", 0.3, 0.8, true, "X2");
  EXPECT_THAT(serials(after_tick().holders), ElementsAre("AIV3"));
  EXPECT_THAT(serials(unit->status().waiting), ElementsAre("AIV2", "AIV1")) << "by arrival";
  EXPECT_EQ(unit->status().holders.front().age_ms, 100U);
}

TEST_F(CrossingUnitTest, shows_claims_in_the_order_in_which_they_go) {
  send(claims_of("AIV1", 9, false));
  send(claims_of("AIV2", 4, true));
  send(claims_of("AIV3", 5, false));
  send(claims_of("AIV4", 0, false));
  intent("AIV5", 0.1, 0.2);
  EXPECT_THAT(serials(after_tick().holders), ElementsAre("AIV2", "AIV4")) << "AIV4 was started in the crossing";
  EXPECT_THAT(serials(unit->status().waiting), ElementsAre("AIV3", "AIV1", "AIV5"));
}

TEST_F(CrossingUnitTest, drops_a_waiting_vehicle_a_second_after_its_last_message) {
  intent("AIV1", 0.6, 1.5);
  now += 800ms;
  EXPECT_THAT(serials(after_tick().waiting), ElementsAre("AIV1"));
  EXPECT_THAT(after_tick().waiting, IsEmpty()) << "exactly a second";
}

TEST_F(CrossingUnitTest, keeps_a_crossing_occupied_by_a_vehicle_that_became_unresponsive_in_it) {
  send(claims_of("AIV1", 4, true));
  now += 60s;
  ASSERT_THAT(serials(after_tick().holders), ElementsAre("AIV1"));
  EXPECT_EQ(unit->status().holders.front().age_ms, 60'100U);
  wire::CrossingClaims left = claims_of("AIV1", 4, true);
  left.claim.reset();
  send(left);
  EXPECT_THAT(after_tick().holders, IsEmpty()) << "it has sent that it is out";
}

TEST_F(CrossingUnitTest, uses_the_newest_of_an_intent_and_claims_that_are_both_old) {
  intent("AIV1", 0.0, 0.0);
  now += 50ms;
  wire::CrossingClaims left = claims_of("AIV1", 4, true);
  left.claim.reset();
  send(left);
  now += 2s;
  EXPECT_THAT(after_tick().holders, IsEmpty());
}

TEST_F(CrossingUnitTest, sends_five_times_a_second_and_at_once_after_a_change) {
  give(wire::InputKind::link, "broker", "up");
  std::size_t sent_count = 0;
  for (int i = 0; i < 20; ++i) {
    after_tick();
    sent_count += effects.size();
  }
  EXPECT_EQ(sent_count, 2U * 10U) << "by the direct link and the broker";
  after_tick();
  intent("AIV1", 0.0, 0.0);
  after_tick();
  ASSERT_EQ(effects.size(), 2U);
  const auto& sent = std::get<wire::SendBytes>(effects[0]);
  EXPECT_EQ(sent.port, "v2x.unit");
  EXPECT_EQ(*wire::crossing_status_from_json(sent.bytes), unit->status());
  EXPECT_EQ(std::get<wire::Publish>(effects[1]).topic, "cosiva/v1/unit/CoSiVA.unit/X1");
  give(wire::InputKind::link, "broker", "down");
  now += 500ms;
  after_tick();
  EXPECT_EQ(effects.size(), 1U) << "without a broker by the direct link";
}

TEST_F(CrossingUnitTest, repeats_claims_unchanged_under_their_senders_name_and_once) {
  const wire::CrossingClaims claims = claims_of("AIV1", 4, false);
  send(claims);
  ASSERT_EQ(effects.size(), 1U);
  const auto& repeated = std::get<wire::SendBytes>(effects[0]);
  EXPECT_EQ(repeated.port, "v2x.claims/CoSiVA/AIV1");
  EXPECT_EQ(repeated.bytes, to_json(claims));
  send(claims);
  EXPECT_THAT(effects, IsEmpty()) << "another unit repeated it";
  wire::CrossingClaims far = claims_of("AIV2", 5, false);
  far.position = {5.0, 0.0};
  send(far);
  EXPECT_THAT(effects, IsEmpty()) << "too far away for the vehicles at this crossing";
  intent("AIV1", 0.5, 1.0);
  EXPECT_THAT(effects, IsEmpty()) << "intents are not repeated";
}

TEST_F(CrossingUnitTest, ignores_messages_under_a_false_name_of_another_map_or_that_cannot_be_read) {
  wire::Intent lie;
  lie.map_id = "lacet4";
  lie.vehicle = {"CoSiVA", "AIV1"};
  lie.crossings.push_back({"X1", 0.0, 0.4, 0.0, 1.0, true});
  give(wire::InputKind::bytes, "v2x/CoSiVA/AIV2", to_json(lie));
  lie.map_id = "other";
  give(wire::InputKind::bytes, "v2x/CoSiVA/AIV1", to_json(lie));
  give(wire::InputKind::bytes, "v2x/CoSiVA/AIV1", "no JSON");
  give(wire::InputKind::bytes, "v2x.claims/CoSiVA/AIV1", "no JSON");
  EXPECT_THAT(effects, IsEmpty()) << "and repeats no such claims";
  EXPECT_THAT(after_tick().holders, IsEmpty());
  EXPECT_THAT(unit->status().waiting, IsEmpty());
  EXPECT_EQ(unit->counters().refused, 4U);
}

TEST_F(CrossingUnitTest, stores_a_limited_number_of_vehicles) {
  for (std::size_t i = 0; i < CrossingUnit::vehicles_max + 10; ++i) intent("AIV" + std::to_string(i), 0.5, 1.0);
  EXPECT_EQ(unit->counters().refused, 10U);
  EXPECT_EQ(after_tick().waiting.size(), wire::CrossingStatus::vehicles_max);
}

TEST_F(CrossingUnitTest, signs_off_when_its_program_ends) {
  give(wire::InputKind::link, "broker", "up");
  after_tick();
  effects.clear();
  unit->farewell(now, effects);
  ASSERT_EQ(effects.size(), 2U);
  EXPECT_FALSE(wire::crossing_status_from_json(std::get<wire::Publish>(effects[1]).payload)->online);
}

TEST(CrossingUnit, that_is_switched_off_neither_sends_nor_receives_and_forgets) {
  CrossingUnitOptions options = at("X1");
  options.emulated = true;
  const auto unit = *CrossingUnit::make(std::move(options));
  EXPECT_THAT(unit->subscriptions(), ElementsAre("cosiva/v1/v2x/lacet4/#", "cosiva/v1/plant/unit"));
  SimTime now = virtual_epoch;
  wire::CrossingClaims claims;
  claims.map_id = "lacet4";
  claims.vehicle = {"CoSiVA", "AIV1"};
  claims.claim = wire::CrossingClaims::Claim{1, 4, 0, true, {"X1"}};
  const auto given = [&](wire::InputKind kind, const std::string& source, const std::string& payload) {
    wire::Effects effects;
    now += 200ms;
    unit->handle({now, kind, source, payload, false}, effects);
    return effects.size();
  };
  const auto switch_to = [&](const std::string& crossing, bool on) {
    given(wire::InputKind::message, "cosiva/v1/plant/unit", to_json(wire::UnitSwitch{crossing, on}));
  };
  EXPECT_EQ(given(wire::InputKind::bytes, "v2x.claims/CoSiVA/AIV1", to_json(claims)), 1U);
  EXPECT_EQ(given(wire::InputKind::tick, {}, {}), 1U);
  EXPECT_EQ(unit->status().holders.size(), 1U);
  switch_to("X2", false);
  EXPECT_TRUE(unit->on()) << "another unit is meant";
  switch_to("X1", false);
  EXPECT_FALSE(unit->on());
  ++claims.header_id;
  EXPECT_EQ(given(wire::InputKind::bytes, "v2x.claims/CoSiVA/AIV1", to_json(claims)), 0U);
  EXPECT_EQ(given(wire::InputKind::tick, {}, {}), 0U);
  switch_to("X1", true);
  EXPECT_EQ(given(wire::InputKind::tick, {}, {}), 1U);
  EXPECT_THAT(unit->status().holders, IsEmpty());
}

TEST(CrossingUnit, belongs_to_a_crossing_of_its_zone) {
  const auto unknown = CrossingUnit::make(at("X9"));
  ASSERT_FALSE(unknown);
  EXPECT_EQ(unknown.error().code, "unit.crossing");
  EXPECT_EQ(unknown.error().location, "X9");
  EXPECT_NE(unknown.error().message.find("X1, X2"), std::string::npos);
}

TEST(CrossingUnit, is_made_again_from_the_options_in_its_journal) {
  CrossingUnitOptions options = at("X2");
  options.emulated = options.off = true;
  const auto read = crossing_unit_options_from_json(to_json(options));
  ASSERT_TRUE(read);
  EXPECT_EQ(to_json(*read), to_json(options));
  EXPECT_FALSE(crossing_unit_options_from_json(R"({"crossing":"X1"})"));
  EXPECT_FALSE(crossing_unit_options_from_json("["));
}

}  // namespace
}  // namespace cosiva::physical
