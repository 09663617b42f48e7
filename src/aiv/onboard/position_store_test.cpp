#include "cosiva/aiv/onboard/position_store.h"

#include <gtest/gtest.h>

#include <algorithm>

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

TEST_F(PositionStoreTest, adds_what_the_odometer_counted_since_the_position_was_saved) {
  PositionStore positions{options};
  PersistedPosition persisted = saved(7);
  persisted.odometer_um = -250'000;  // the odometer is at 0 now
  positions.restore(persisted, &context);
  (void)positions.on_pils_hello(7);
  positions.find_position(context);
  EXPECT_NEAR(s_m(), 0.65, 1e-9);
}

TEST_F(PositionStoreTest, uses_a_restored_position_up_to_100_m_away) {
  const auto found = [&](std::int64_t odometer_um) {
    DrivingContext fresh{lacet4(), {}};
    fresh.agent().on_odometry({});
    PositionStore positions{options};
    PersistedPosition persisted = saved(7);
    persisted.odometer_um = odometer_um;
    positions.restore(persisted, &fresh);
    (void)positions.on_pils_hello(7);
    positions.find_position(fresh);
    const zone::TrackPosition start = test::at(lacet4(), "loop_se", 0.1);
    return fresh.vehicle().position().track_position() != start;
  };
  EXPECT_TRUE(found(-100'000'000));
  EXPECT_TRUE(found(100'000'000));
  EXPECT_FALSE(found(-100'000'001));
  EXPECT_FALSE(found(100'000'001));
}

TEST_F(PositionStoreTest, waits_for_the_first_reading_of_the_odometer) {
  DrivingContext unread{lacet4(), {}};
  PositionStore positions{options};
  positions.restore(saved(7), &unread);
  (void)positions.on_pils_hello(7);
  positions.find_position(unread);
  EXPECT_FALSE(unread.vehicle().position().known());
  unread.agent().on_odometry({});
  positions.find_position(unread);
  EXPECT_TRUE(unread.vehicle().position().known());
}

TEST_F(PositionStoreTest, restores_pause_and_profile_at_once) {
  PersistedPosition persisted = saved(7);
  persisted.paused = true;
  persisted.imposed = Profile::slow;
  PositionStore positions{options};
  positions.restore(persisted, &context);
  EXPECT_TRUE(context.vehicle().holds().has(Hold::paused));
  EXPECT_EQ(context.agent().instructions().imposed, Profile::slow);

  PositionStore early{options};
  early.restore(persisted, nullptr);
  DrivingContext later{lacet4(), {}};
  early.on_first_zone(later, effects);
  EXPECT_TRUE(later.vehicle().holds().has(Hold::paused));
  EXPECT_EQ(later.agent().instructions().imposed, Profile::slow);
  EXPECT_TRUE(effects.empty());
}

TEST_F(PositionStoreTest, reports_a_start_on_a_section_that_the_zone_does_not_have) {
  options.start = OnboardOptions::Start{"moon", 0.1};
  PositionStore positions{options};
  positions.on_first_zone(context, effects);
  ASSERT_EQ(effects.size(), 1U);
  EXPECT_EQ(std::get<wire::Log>(effects[0]), (wire::Log{'e', "start: no section 'moon' in zone 'lacet4'"}));
  positions.find_position(context);
  EXPECT_FALSE(context.vehicle().position().known());
  options.start.reset();
  PositionStore without{options};
  without.on_first_zone(context, effects);
  EXPECT_EQ(effects.size(), 1U);
}

TEST_F(PositionStoreTest, keeps_a_known_position) {
  context.vehicle().estimator().position_at(test::at(lacet4(), "loop_se", 0.7));
  PositionStore positions{options};
  positions.restore(saved(7), &context);
  (void)positions.on_pils_hello(7);
  positions.find_position(context);
  EXPECT_DOUBLE_EQ(s_m(), 0.7);
}

TEST_F(PositionStoreTest, preserves_a_position_in_another_zone_until_that_zone_is_in_force) {
  PersistedPosition persisted = saved(7);
  persisted.zone = "other";
  PositionStore positions{options};
  positions.restore(persisted, &context);
  (void)positions.on_pils_hello(7);
  positions.find_position(context);
  EXPECT_DOUBLE_EQ(s_m(), 0.1) << "the configured start";
  zone::TrafficZone other = lacet4();
  other.name = "other";
  DrivingContext there{other, {}};
  there.agent().on_odometry({});
  positions.on_zone_switched(there);
  ASSERT_TRUE(there.vehicle().position().known());
  EXPECT_DOUBLE_EQ(there.vehicle().position().track_position().s_m, 0.4);
}

TEST_F(PositionStoreTest, does_not_begin_at_the_configured_start_after_a_zone_switch) {
  PositionStore positions{options};
  positions.on_zone_switched(context);
  positions.find_position(context);
  EXPECT_FALSE(context.vehicle().position().known());
}

TEST_F(PositionStoreTest, of_the_new_zone_replaces_a_pose_only_where_the_vehicle_has_not_moved) {
  const auto replaced = [&](std::int64_t odometer_um) {
    DrivingContext there{lacet4(), {}};
    there.agent().on_odometry({});
    there.vehicle().estimator().position_at(test::at(lacet4(), "loop_se", 0.7));
    PersistedPosition persisted = saved(7);
    persisted.odometer_um = odometer_um;
    PositionStore positions{options};
    positions.restore(persisted, nullptr);
    (void)positions.on_pils_hello(7);
    positions.on_zone_switched(there);
    return there.vehicle().position().track_position().s_m < 0.6;
  };
  EXPECT_TRUE(replaced(0));
  EXPECT_TRUE(replaced(-5'000));
  EXPECT_TRUE(replaced(5'000));
  EXPECT_FALSE(replaced(-5'001));
  EXPECT_FALSE(replaced(5'001));
}

TEST_F(PositionStoreTest, does_not_use_a_restored_position_after_an_operator_gave_another) {
  PositionStore positions{options};
  positions.restore(saved(7), &context);
  positions.discard_restored();
  (void)positions.on_pils_hello(7);
  positions.find_position(context);
  EXPECT_DOUBLE_EQ(s_m(), 0.1);
}

/// Restored with the pose of the section's point, moved by `shift` in the frame of that point.
struct RestoredPose : PositionStoreTest {
  [[nodiscard]] bool used(const Pose2& shift, double saved_s_m = 0.4) {
    DrivingContext fresh{lacet4(), {}};
    fresh.agent().on_odometry({});
    PersistedPosition persisted = saved(7);
    persisted.s_m = saved_s_m;
    persisted.odometer_um = -10'000;  // 1 cm: too far for a pose off the path
    const double end_m = lacet4().circuit.section(test::at(lacet4(), "loop_se", 0.0).section).length_m();
    persisted.pose = lacet4().circuit.pose_at(test::at(lacet4(), "loop_se", std::clamp(saved_s_m, 0.0, end_m))) * shift;
    options.start.reset();
    PositionStore positions{options};
    positions.restore(persisted, &fresh);
    (void)positions.on_pils_hello(7);
    positions.find_position(fresh);
    return fresh.vehicle().position().known();
  }
};

TEST_F(RestoredPose, has_to_lie_on_its_section_to_2_cm_and_a_twentieth_of_a_radian) {
  EXPECT_TRUE(used({}));
  EXPECT_TRUE(used({0.0, 0.0199, 0.0}));
  EXPECT_TRUE(used({-0.0199, 0.0, 0.0}));
  EXPECT_FALSE(used({0.0, 0.0201, 0.0}));
  EXPECT_FALSE(used({0.0, -0.0201, 0.0}));
  EXPECT_TRUE(used({0.0, 0.0, 0.0499}));
  EXPECT_FALSE(used({0.0, 0.0, 0.0501}));
  EXPECT_FALSE(used({0.0, 0.0, -0.0501}));
}

TEST_F(RestoredPose, has_to_be_within_the_section_s_length) {
  const double end_m = lacet4().circuit.section(test::at(lacet4(), "loop_se", 0.0).section).length_m();
  EXPECT_TRUE(used({}, 0.0));
  EXPECT_TRUE(used({}, end_m));
  EXPECT_TRUE(used({}, end_m + 0.0199));
  EXPECT_FALSE(used({}, end_m + 0.0201));
  EXPECT_FALSE(used({}, -0.0001));
}

TEST_F(PositionStoreTest, restores_a_pose_off_the_path_unless_the_vehicle_has_moved) {
  const auto restored = [&](std::int64_t odometer_um) -> std::optional<Pose2> {
    DrivingContext fresh{lacet4(), {}};
    fresh.agent().on_odometry({});
    PersistedPosition persisted = saved(7);
    persisted.off_path = true;
    persisted.pose = Pose2{3.0, 4.0, 0.5};
    persisted.odometer_um = odometer_um;
    options.start.reset();
    PositionStore positions{options};
    positions.restore(persisted, &fresh);
    (void)positions.on_pils_hello(7);
    positions.find_position(fresh);
    if (!fresh.vehicle().position().pose_known()) return std::nullopt;
    return fresh.vehicle().position().pose();
  };
  EXPECT_EQ(restored(0), (Pose2{3.0, 4.0, 0.5}));
  EXPECT_TRUE(restored(5'000));
  EXPECT_FALSE(restored(5'001));
  EXPECT_FALSE(restored(-5'001));
}

TEST_F(PositionStoreTest, does_not_find_a_section_that_the_zone_does_not_have) {
  PersistedPosition persisted = saved(7);
  persisted.section = "moon";
  PositionStore positions{options};
  positions.restore(persisted, &context);
  (void)positions.on_pils_hello(7);
  positions.find_position(context);
  EXPECT_DOUBLE_EQ(s_m(), 0.1) << "the configured start";
}

TEST_F(PositionStoreTest, saves_every_100_ms_while_the_odometer_counts) {
  PositionStore positions{options};
  (void)positions.on_pils_hello(7);
  positions.find_position(context);
  wire::Odometry odometry{};
  const auto saved_at = [&](int ms) {
    odometry.board_ms = static_cast<std::uint32_t>(ms);
    odometry.distance_um += 1'000;
    odometry.speed_mmps = 50;
    context.agent().on_odometry(odometry);
    effects.clear();
    positions.on_tick(SimTime{std::chrono::milliseconds{ms}}, context, effects);
    return effects.size();
  };
  EXPECT_EQ(saved_at(0), 1U);
  EXPECT_EQ(saved_at(20), 0U);
  EXPECT_EQ(saved_at(80), 0U);
  EXPECT_EQ(saved_at(100), 1U);
  EXPECT_EQ(saved_at(180), 0U);
  EXPECT_EQ(saved_at(200), 1U);
}

TEST_F(PositionStoreTest, saves_as_soon_as_the_vehicle_stops) {
  PositionStore positions{options};
  (void)positions.on_pils_hello(7);
  positions.find_position(context);
  wire::Odometry odometry{};
  const auto saved_at = [&](int ms, std::int16_t speed_mmps) {
    odometry.board_ms = static_cast<std::uint32_t>(ms);
    odometry.distance_um += 100;
    odometry.speed_mmps = speed_mmps;
    context.agent().on_odometry(odometry);
    effects.clear();
    positions.on_tick(SimTime{std::chrono::milliseconds{ms}}, context, effects);
    return effects.size();
  };
  EXPECT_EQ(saved_at(0, 50), 1U);
  EXPECT_EQ(saved_at(10, 0), 0U);
  EXPECT_FALSE(context.vehicle().motion().stopped());
  EXPECT_EQ(saved_at(20, 0), 1U);
  EXPECT_TRUE(context.vehicle().motion().stopped());
  EXPECT_EQ(saved_at(30, 0), 0U) << "the vehicle was stopped before";
}

TEST_F(PositionStoreTest, saves_nothing_before_position_session_and_odometer_are_known) {
  PositionStore without_session{options};
  without_session.find_position(context);
  without_session.save_now(context, effects);
  EXPECT_TRUE(effects.empty());

  PositionStore positions{options};
  (void)positions.on_pils_hello(7);
  DrivingContext unread{lacet4(), {}};
  unread.vehicle().estimator().position_at(test::at(lacet4(), "loop_se", 0.1));
  positions.save_now(unread, effects);
  EXPECT_TRUE(effects.empty()) << "no reading of the odometer";
  unread.agent().on_odometry({});
  positions.save_now(unread, effects);
  EXPECT_EQ(effects.size(), 1U);
  DrivingContext lost{lacet4(), {}};
  lost.agent().on_odometry({});
  positions.save_now(lost, effects);
  EXPECT_EQ(effects.size(), 1U) << "no position";
}

TEST_F(PositionStoreTest, saves_all_that_the_next_program_needs) {
  PositionStore positions{options};
  (void)positions.on_pils_hello(7);
  positions.find_position(context);
  wire::Odometry odometry{};
  odometry.distance_um = 25'000;
  context.agent().on_odometry(odometry);
  context.vehicle().hold(Hold::paused, true);
  context.agent().instructions().imposed = Profile::fast;
  positions.save_now(context, effects);
  ASSERT_EQ(effects.size(), 1U);
  const auto written = persisted_position_from_json(std::get<wire::Persist>(effects[0]).bytes);
  ASSERT_TRUE(written);
  EXPECT_EQ(written->zone, "lacet4");
  EXPECT_EQ(written->section, "loop_se");
  EXPECT_NEAR(written->s_m, 0.125, 1e-9);
  EXPECT_EQ(written->odometer_um, 25'000);
  EXPECT_EQ(written->session, 7U);
  EXPECT_TRUE(written->paused);
  EXPECT_EQ(written->imposed, Profile::fast);
  EXPECT_EQ(written->pose, context.vehicle().position().pose());
  EXPECT_FALSE(written->off_path);
  EXPECT_FALSE(written->manoeuvre);
  EXPECT_FALSE(written->next) << "no order leads anywhere";
  EXPECT_EQ(positions.saved_json(), "");
}

TEST_F(PositionStoreTest, saves_a_vehicle_away_from_all_paths_as_off_path) {
  PositionStore positions{options};
  (void)positions.on_pils_hello(7);
  context.vehicle().estimator().set_off_path({3.0, 4.0, 0.5});
  positions.save_now(context, effects);
  ASSERT_EQ(effects.size(), 1U);
  const auto written = persisted_position_from_json(std::get<wire::Persist>(effects[0]).bytes);
  ASSERT_TRUE(written);
  EXPECT_TRUE(written->off_path);
  EXPECT_EQ(written->pose, (Pose2{3.0, 4.0, 0.5}));
  EXPECT_EQ(written->section, "");
}

TEST_F(PositionStoreTest, keeps_the_saved_position_itself_where_messages_pass_as_values) {
  options.as_values = true;
  PositionStore positions{options};
  (void)positions.on_pils_hello(7);
  positions.find_position(context);
  EXPECT_EQ(positions.saved_json(), "");
  positions.save_now(context, effects);
  EXPECT_TRUE(effects.empty());
  EXPECT_EQ(persisted_position_from_json(positions.saved_json())->section, "loop_se");
}

}  // namespace
}  // namespace cosiva::aiv
