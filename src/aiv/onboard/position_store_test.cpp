#include "cosiva/aiv/onboard/position_store.h"

#include <gtest/gtest.h>

#include "cosiva/aiv/testing/test_zone.h"

namespace cosiva::aiv {
namespace {

using test::lacet4;

struct PositionStoreTest : ::testing::Test {
  OnboardOptions options;
  DrivingContext context{lacet4(), {}};
  wire::Effects effects;

  PositionStoreTest() {
    options.start = OnboardOptions::Start{"loop_se", 0.1};
    context.agent().on_odometry({});
  }
  [[nodiscard]] static PersistedPosition saved(std::uint32_t session) {
    PersistedPosition persisted;
    persisted.zone = "lacet4";
    persisted.section = "loop_se";
    persisted.s_m = 0.4;
    persisted.session = session;
    return persisted;
  }
  [[nodiscard]] double s_m() const { return context.vehicle().position().track_position().s_m; }
};

TEST_F(PositionStoreTest, begins_at_the_configured_start) {
  PositionStore positions{options};
  positions.find_position(context);
  ASSERT_TRUE(context.vehicle().position().known());
  EXPECT_DOUBLE_EQ(s_m(), 0.1);
}

TEST_F(PositionStoreTest, prefers_the_restored_position_of_the_same_odometer) {
  PositionStore positions{options};
  positions.restore(saved(7), &context);
  EXPECT_FALSE(context.vehicle().position().known()) << "PILS has not identified its session yet";
  EXPECT_FALSE(positions.on_pils_hello(7));
  positions.find_position(context);
  EXPECT_DOUBLE_EQ(s_m(), 0.4);
}

TEST_F(PositionStoreTest, does_not_use_a_restored_position_of_another_odometer) {
  PositionStore positions{options};
  positions.restore(saved(7), &context);
  EXPECT_FALSE(positions.on_pils_hello(8));
  positions.find_position(context);
  EXPECT_DOUBLE_EQ(s_m(), 0.1) << "the configured start";
}

TEST_F(PositionStoreTest, detects_a_restart_of_PILS) {
  PositionStore positions{options};
  EXPECT_FALSE(positions.on_pils_hello(7));
  EXPECT_FALSE(positions.on_pils_hello(7));
  EXPECT_TRUE(positions.on_pils_hello(8));
}

TEST_F(PositionStoreTest, saves_on_request_and_not_twice_the_same) {
  PositionStore positions{options};
  (void)positions.on_pils_hello(7);
  positions.find_position(context);
  positions.on_tick(SimTime{}, context, effects);
  ASSERT_EQ(effects.size(), 1U);
  const auto written = persisted_position_from_json(std::get<wire::Persist>(effects[0]).bytes);
  ASSERT_TRUE(written);
  EXPECT_EQ(written->session, 7U);
  EXPECT_EQ(written->section, "loop_se");
  positions.on_tick(SimTime{std::chrono::seconds{1}}, context, effects);
  EXPECT_EQ(effects.size(), 1U) << "nothing has changed";
  positions.request_save();
  positions.on_tick(SimTime{std::chrono::seconds{2}}, context, effects);
  EXPECT_EQ(effects.size(), 2U);
}

}  // namespace
}  // namespace cosiva::aiv
