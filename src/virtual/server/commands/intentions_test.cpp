#include "cosiva/virtual/server/commands/intentions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cosiva::virtual_side {
namespace {

using enum OperatorCommandKind;
using testing::ElementsAre;

std::string text_of(const Intentions& intentions) {
  JsonWriter json;
  intentions.write(json);
  return json.take();
}

TEST(Intentions, are_none_at_first) {
  const Intentions intentions;
  EXPECT_TRUE(intentions.empty());
  EXPECT_TRUE(intentions.of("CoSiVA/AIV1").empty());
}

TEST(Intentions, hold_a_stop_until_the_vehicle_is_restarted) {
  Intentions intentions;
  intentions.take("CoSiVA/AIV1", stop, 0.0);
  EXPECT_TRUE(intentions.of("CoSiVA/AIV1").stopped);
  EXPECT_FALSE(intentions.of("CoSiVA/AIV2").stopped);
  intentions.take("CoSiVA/AIV1", restart, 0.0);
  EXPECT_TRUE(intentions.empty());
}

TEST(Intentions, for_all_hold_for_vehicles_that_come_later) {
  Intentions intentions;
  intentions.take_for_all(stop, 0.0);
  EXPECT_TRUE(intentions.of("Other/Newcomer").stopped);
}

TEST(Intentions, of_one_vehicle_can_be_lifted_while_all_others_stay_stopped) {
  Intentions intentions;
  intentions.take_for_all(stop, 0.0);
  intentions.take("CoSiVA/AIV1", restart, 0.0);
  EXPECT_FALSE(intentions.of("CoSiVA/AIV1").stopped);
  EXPECT_TRUE(intentions.of("CoSiVA/AIV2").stopped);
  EXPECT_THAT(intentions.names(), ElementsAre("CoSiVA/AIV1"));
}

TEST(Intentions, of_all_reach_those_with_one_of_their_own) {
  Intentions intentions;
  intentions.take("CoSiVA/AIV1", slow, 0.0);
  intentions.take_for_all(stop, 0.0);
  EXPECT_TRUE(intentions.of("CoSiVA/AIV1").stopped);
  EXPECT_EQ(intentions.of("CoSiVA/AIV1").profile, aiv::Profile::slow);
  intentions.take_for_all(restart, 0.0);
  EXPECT_TRUE(intentions.empty());
}

TEST(Intentions, of_speed_replace_each_other_as_the_commands_do) {
  Intentions intentions;
  intentions.take("CoSiVA/AIV1", limit, 0.25);
  EXPECT_EQ(intentions.of("CoSiVA/AIV1").speed_mps_max, 0.25);
  intentions.take("CoSiVA/AIV1", medium, 0.0);
  EXPECT_EQ(intentions.of("CoSiVA/AIV1"), (Intention{false, false, aiv::Profile::medium, std::nullopt}));
  intentions.take("CoSiVA/AIV1", limit, 0.5);
  EXPECT_EQ(intentions.of("CoSiVA/AIV1"), (Intention{false, false, aiv::Profile::medium, 0.5}));
}

TEST(Intentions, of_exclusion_outlast_restarts_and_missions_until_the_vehicle_is_included) {
  Intentions intentions;
  intentions.take("CoSiVA/AIV1", stop, 0.0);
  intentions.take("CoSiVA/AIV1", exclude, 0.0);
  intentions.take_for_all(restart, 0.0);
  intentions.on_mission("CoSiVA/AIV1");
  EXPECT_EQ(intentions.of("CoSiVA/AIV1"), (Intention{false, false, std::nullopt, std::nullopt, true}));
  EXPECT_FALSE(intentions.of("CoSiVA/AIV2").excluded);
  Intentions restored;
  ASSERT_TRUE(restored.restore(*JsonValue::parse(text_of(intentions))));
  EXPECT_TRUE(restored.of("CoSiVA/AIV1").excluded);
  restored.take_for_all(include, 0.0);
  EXPECT_TRUE(restored.empty());
}

TEST(Intentions, of_cancelling_end_with_a_mission) {
  Intentions intentions;
  intentions.take("CoSiVA/AIV1", cancel, 0.0);
  EXPECT_TRUE(intentions.of("CoSiVA/AIV1").cancelled);
  intentions.on_mission("CoSiVA/AIV1");
  EXPECT_TRUE(intentions.empty());
}

TEST(Intentions, are_written_and_restored) {
  Intentions intentions;
  intentions.take_for_all(stop, 0.0);
  intentions.take("CoSiVA/AIV1", cancel, 0.0);
  intentions.take("CoSiVA/AIV2", restart, 0.0);
  intentions.take("CoSiVA/AIV2", fast, 0.0);
  intentions.take("CoSiVA/AIV2", limit, 0.25);
  const std::string text = text_of(intentions);
  EXPECT_EQ(text, R"({"all":{"stopped":true},"vehicles":{"CoSiVA/AIV1":{"stopped":true,"cancelled":true},)"
                  R"("CoSiVA/AIV2":{"profile":"fast","speed":0.25}}})");
  Intentions restored;
  restored.take("CoSiVA/AIV3", slow, 0.0);
  EXPECT_TRUE(restored.restore(*JsonValue::parse(text)));
  EXPECT_EQ(text_of(restored), text);
}

TEST(Intentions, skip_what_cannot_be_restored_and_report_that) {
  for (const char* vehicle : {R"({"speed":0})", R"({"speed":-1})", R"({"profile":"quick"})", "7"}) {
    Intentions intentions;
    const std::string text = std::string(R"({"all":{"stopped":true},"vehicles":{"a/b":)") + vehicle + "}}";
    EXPECT_FALSE(intentions.restore(*JsonValue::parse(text))) << vehicle;
    EXPECT_TRUE(intentions.of("a/b").stopped) << vehicle;
    EXPECT_THAT(intentions.names(), ElementsAre()) << vehicle;
  }
}

}  // namespace
}  // namespace cosiva::virtual_side
