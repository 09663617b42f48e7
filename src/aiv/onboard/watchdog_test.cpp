// The vehicle brakes half a second after its broker, its server or one of its boards sent the last message, whatever
// the state of the connection, and no single message prevents that.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "cosiva/aiv/onboard/onboard_fixture.h"
#include "cosiva/wire/own/control_areas.h"

namespace cosiva::aiv {
namespace {

using std::chrono::milliseconds;
using test::OnboardFixture;
using ::testing::Contains;
using ::testing::IsEmpty;

constexpr SimDuration timeout = milliseconds{500};
constexpr SimDuration cycle = milliseconds{20};
const std::string owner_topic = "cosiva/v1/owner/CoSiVA/AIV1";

/// Two ends of one long order in the south-east.
test::OrderText along_the_loop(const std::string& id) {
  return test::order(id).through({"loop_se@0", "loop_se@283", "loop_se@2545"});
}

struct WatchdogFixture : OnboardFixture {
  explicit WatchdogFixture(bool with_server) {
    server_heartbeats = with_server;
    run(0.5);
  }

  void drive() {
    order(along_the_loop("O-1"));
    run(1.0);
    ASSERT_NEAR(speed_mps, 0.4, 0.01) << "the medium speed of lacet4";
  }
  [[nodiscard]] bool brakes() const { return last_drive().speed_mmps == 0; }
  /// Runs until the motors are commanded to stop; the time since `since`.
  SimDuration until_it_brakes(const SimTime& since) {
    EXPECT_TRUE(run_until([&] { return brakes(); }, 3.0)) << "the vehicle did not brake";
    return now - since;
  }
  /// Whether the vehicle keeps driving while `step` is called every 10 ms.
  bool drives_for(double seconds, const std::function<void()>& each_step) {
    return !run_until(
        [&] {
          each_step();
          return brakes();
        },
        seconds);
  }
};

struct Driving : WatchdogFixture {
  explicit Driving(bool with_server = true) : WatchdogFixture{with_server} { drive(); }
};

void expect_half_a_second(SimDuration duration, const std::string& what) {
  EXPECT_GT(duration, timeout) << what;
  EXPECT_LE(duration, timeout + cycle) << what;
}

// --- times
// ------------------------------------------------------------------------------------------------------------

TEST(Watchdog, brakes_half_a_second_after_the_last_message_of_a_frozen_broker) {
  for (const bool with_server : {true, false}) {
    Driving fixture{with_server};
    fixture.broker_frozen = true;
    fixture.run(0.01);
    expect_half_a_second(fixture.until_it_brakes(fixture.broker_message_at),
                         with_server ? "with a server" : "with a third-party master control");
  }
}

TEST(Watchdog, brakes_half_a_second_after_the_last_heartbeat_while_all_other_messages_go_on) {
  Driving fixture;
  const SimTime last_heartbeat = fixture.broker_message_at;
  fixture.server_heartbeats = false;
  expect_half_a_second(fixture.until_it_brakes(last_heartbeat), "server");
  EXPECT_GT(fixture.broker_message_at, last_heartbeat) << "the broker is alive";
  EXPECT_THAT(fixture.error_types(), Contains("serverLost"));
}

TEST(Watchdog, brakes_half_a_second_after_the_last_frame_of_any_board_whose_port_stays_open) {
  for (const wire::Board board : wire::all_boards) {
    Driving fixture;
    fixture.silence(board);
    expect_half_a_second(fixture.until_it_brakes(fixture.board_message_at[board]), std::string(to_string(board)));
  }
}

TEST(Watchdog, brakes_by_the_deceleration_of_the_zone) {
  Driving fixture;
  fixture.server_heartbeats = false;
  const SimTime last_heartbeat = fixture.broker_message_at;
  ASSERT_GT(fixture.until_it_brakes(last_heartbeat), timeout);
  EXPECT_GE(fixture.last_drive().braking_mmps2, 600) << "slow profile";
  EXPECT_LE(fixture.last_drive().braking_mmps2, 1000) << "fast profile";
  // 0.4 m/s and at least 0.6 m/s²: 0.67 s.
  EXPECT_TRUE(fixture.run_until([&] { return fixture.speed_mps == 0.0; }, 0.7));
}

TEST(Watchdog, does_not_brake_while_heartbeats_are_up_to_400_ms_apart) {
  Driving fixture{false};
  const std::vector<int> gaps_ms{400, 100, 400, 250, 400, 400};
  std::size_t gap = 0;
  SimTime next = fixture.now;
  EXPECT_TRUE(fixture.drives_for(4.5, [&] {
    if (fixture.now < next) return;
    fixture.receive(wire::server_heartbeat_topic, "{}");
    next = fixture.now + milliseconds{gaps_ms[gap++ % gaps_ms.size()]};
  }));
  EXPECT_EQ(fixture.state().errors.size(), 0U);
}

TEST(Watchdog, does_not_brake_where_a_loaded_machine_delays_each_direction_to_the_broker_by_100_ms) {
  Driving fixture{false};
  fixture.echo_delay = milliseconds{200};
  EXPECT_TRUE(fixture.drives_for(4.5, [] {}));
  EXPECT_GT(fixture.link_checks, 5);
}

TEST(Watchdog, does_not_brake_while_frames_of_a_board_are_up_to_400_ms_apart) {
  for (const wire::Board board : wire::all_boards) {
    if (board == wire::Board::PILS) continue;  // without odometry the vehicle brakes for other reasons
    Driving fixture;
    fixture.silence(board);
    SimTime next = fixture.board_message_at[board] + milliseconds{400};
    EXPECT_TRUE(fixture.drives_for(4.0, [&] {
      if (fixture.now < next) return;
      fixture.send_from_board(board, wire::Heartbeat{0, 0, 0, 0});
      next = fixture.now + milliseconds{400};
    })) << to_string(board);
  }
}

TEST(Watchdog, does_not_brake_while_the_odometry_is_400_ms_late_once) {
  Driving fixture;
  fixture.silence(wire::Board::PILS);
  EXPECT_TRUE(fixture.drives_for(0.4, [] {}));
  fixture.alive.insert(wire::Board::PILS);
  EXPECT_TRUE(fixture.drives_for(2.0, [] {}));
}

// --- link checks
// ------------------------------------------------------------------------------------------------------

TEST(Watchdog, needs_no_messages_of_a_third_party_master_control_on_a_broker_that_is_alive) {
  Driving fixture{false};
  EXPECT_TRUE(fixture.drives_for(4.5, [] {}));
  EXPECT_GT(fixture.link_checks, 10) << "the vehicle's own messages return";
}

TEST(Watchdog, sends_no_link_checks_while_a_server_publishes_its_heartbeat) {
  Driving fixture;
  fixture.run(3.0);
  EXPECT_EQ(fixture.link_checks, 0);
}

// --- resuming
// ---------------------------------------------------------------------------------------------------------

TEST(Watchdog, continues_by_itself_when_a_frozen_broker_goes_on) {
  Driving fixture{false};
  fixture.broker_frozen = true;
  fixture.run(2.0);
  ASSERT_EQ(fixture.speed_mps, 0.0);
  EXPECT_THAT(fixture.error_types(), testing::Not(Contains("serverLost")));
  fixture.broker_frozen = false;
  fixture.run(1.0);
  EXPECT_GT(fixture.speed_mps, 0.25);
}

TEST(Watchdog, does_not_continue_after_a_stop_that_was_commanded_meanwhile) {
  Driving fixture;
  fixture.server_heartbeats = false;
  fixture.run(1.5);
  ASSERT_EQ(fixture.speed_mps, 0.0);
  fixture.act("startPause", "p");
  fixture.server_heartbeats = true;
  fixture.run(2.0);
  EXPECT_EQ(fixture.speed_mps, 0.0);
  EXPECT_THAT(fixture.error_types(), IsEmpty());
  fixture.act("stopPause", "r");
  fixture.run(1.0);
  EXPECT_GT(fixture.speed_mps, 0.25);
}

// --- messages that must not disarm
// ------------------------------------------------------------------------------------

struct SingleMessage {
  std::string name;
  std::string topic;
  std::string payload;
  bool retained;
};

std::string owner(const std::string& area) { return wire::to_json({area, 1, SimTime{}, std::nullopt, std::nullopt}); }

std::vector<SingleMessage> single_messages() {
  const std::string connection{wire::server_connection_topic};
  const std::string heartbeat{wire::server_heartbeat_topic};
  const auto state = [](const std::string& name) { return R"({"connectionState":")" + name + "\"}"; };
  const wire::VehicleId id{"CoSiVA", "AIV1"};
  return {
      {"owner, retained", owner_topic, owner("nowhere"), true},
      {"owner", owner_topic, owner("nowhere"), false},
      {"empty owner, retained", owner_topic, "", true},
      {"owner that cannot be read", owner_topic, R"({"area":"so uth"})", true},
      {"server OFFLINE, retained", connection, state("OFFLINE"), true},
      {"server OFFLINE", connection, state("OFFLINE"), false},
      {"server CONNECTIONBROKEN", connection, state("CONNECTIONBROKEN"), true},
      {"server ONLINE", connection, state("ONLINE"), true},
      {"empty server connection, retained", connection, "", true},
      {"server connection that cannot be read", connection, "{", false},
      {"heartbeat, retained", heartbeat, R"({"headerId":1})", true},
      {"empty heartbeat, retained", heartbeat, "", true},
      {"empty heartbeat", heartbeat, "", false},
      {"another area's server OFFLINE", "cosiva/v1/area/nowhere/server/connection", state("OFFLINE"), true},
      {"another area's heartbeat", "cosiva/v1/area/nowhere/server/heartbeat", "{}", false},
      {"empty zone, retained", "cosiva/v1/zone/toml", "", true},
      {"empty virtual obstacles", wire::own_topic(wire::virtual_obstacles_topic_prefix, id), "", true},
      {"empty order", wire::vda_topic(id, "order"), "", true},
      {"empty instant actions", wire::vda_topic(id, "instantActions"), "", true},
      {"link check", wire::own_topic(wire::link_check_topic_prefix, id), "", true},
  };
}

TEST(Watchdog, of_the_server_is_disarmed_by_no_single_message_while_the_vehicle_drives) {
  for (const SingleMessage& message : single_messages()) {
    Driving fixture;
    const SimTime last_heartbeat = fixture.broker_message_at;
    fixture.server_heartbeats = false;
    fixture.receive(message.topic, message.payload, message.retained);
    expect_half_a_second(fixture.until_it_brakes(last_heartbeat), message.name);
    EXPECT_TRUE(fixture.run_until([&] { return fixture.speed_mps == 0.0; }, 1.0)) << message.name;
    fixture.run(1.0);
    EXPECT_EQ(fixture.speed_mps, 0.0) << message.name << ": the vehicle remains stopped, because it has an order";
  }
}

TEST(Watchdog, of_the_server_is_disarmed_by_no_single_message_while_a_stopped_vehicle_has_an_order) {
  for (const SingleMessage& message : single_messages()) {
    Driving fixture;
    fixture.act("startPause", "p");
    fixture.run(1.0);
    ASSERT_EQ(fixture.speed_mps, 0.0);
    fixture.server_heartbeats = false;
    fixture.receive(message.topic, message.payload, message.retained);
    fixture.run(1.0);
    EXPECT_THAT(fixture.error_types(), Contains("serverLost")) << message.name;
    fixture.act("stopPause", "r");
    fixture.run(1.0);
    EXPECT_EQ(fixture.speed_mps, 0.0) << message.name;
  }
}

TEST(Watchdog, of_the_broker_is_disarmed_by_no_single_message) {
  for (const SingleMessage& message : single_messages()) {
    Driving fixture;
    fixture.broker_frozen = true;
    fixture.receive(message.topic, message.payload, message.retained);
    const SimTime last_message = fixture.now;
    EXPECT_LE(fixture.until_it_brakes(last_message), timeout + cycle) << message.name;
  }
}

TEST(Watchdog, of_the_server_gives_no_time_to_owners_that_change_all_the_time) {
  Driving fixture;
  const SimTime last_heartbeat = fixture.broker_message_at;
  fixture.server_heartbeats = false;
  int owners = 0;
  EXPECT_FALSE(
      fixture.drives_for(3.0, [&] { fixture.receive(owner_topic, owner(++owners % 2 == 0 ? "east" : "west"), true); }));
  expect_half_a_second(fixture.now - last_heartbeat, "owners");
}

TEST(Watchdog, waits_for_the_heartbeat_of_an_owner_that_the_vehicle_has_not_received_anything_of) {
  WatchdogFixture fixture{false};
  fixture.receive(owner_topic, owner("north"), true);
  fixture.run(0.4);
  fixture.order(along_the_loop("O-1"));
  fixture.run(1.5);
  EXPECT_EQ(fixture.speed_mps, 0.0) << "the server of its area is not alive";
  EXPECT_THAT(fixture.error_types(), Contains("serverLost"));
  for (int i = 0; i < 10; ++i) {
    fixture.receive("cosiva/v1/area/north/server/heartbeat", "{}");
    fixture.run(0.1);
  }
  EXPECT_GT(fixture.speed_mps, 0.25);
}

// --- the clean end of a server
// ----------------------------------------------------------------------------------------

constexpr auto offline = R"({"connectionState":"OFFLINE"})";

TEST(Watchdog, of_the_server_ends_at_its_clean_end_for_a_stopped_vehicle_without_order) {
  WatchdogFixture fixture{true};
  fixture.server_heartbeats = false;
  fixture.receive(wire::server_connection_topic, offline, true);
  fixture.run(1.0);
  EXPECT_THAT(fixture.error_types(), IsEmpty());
  fixture.order(along_the_loop("M-1"));
  fixture.run(1.0);
  EXPECT_GT(fixture.speed_mps, 0.25) << "another master control drives the vehicle";
}

TEST(Watchdog, of_the_server_ends_after_its_clean_end_as_soon_as_the_order_is_cancelled) {
  Driving fixture;
  fixture.server_heartbeats = false;
  fixture.receive(wire::server_connection_topic, offline, true);
  fixture.run(2.0);
  ASSERT_EQ(fixture.speed_mps, 0.0);
  EXPECT_THAT(fixture.error_types(), Contains("serverLost"));
  fixture.act("cancelOrder", "c");
  fixture.run(0.5);
  EXPECT_THAT(fixture.error_types(), IsEmpty());
  fixture.order(test::order("M-1").through({"loop_se@283", "loop_se@565", "loop_se@2545"}));
  fixture.run(1.0);
  EXPECT_GT(fixture.speed_mps, 0.25) << "another master control drives the vehicle";
}

TEST(Watchdog, of_the_server_goes_on_with_its_next_heartbeat_after_a_clean_end_that_was_not_its_own) {
  WatchdogFixture fixture{true};
  fixture.receive(wire::server_connection_topic, offline, true);
  fixture.run(0.2);
  fixture.drive();
  const SimTime last_heartbeat = fixture.broker_message_at;
  fixture.server_heartbeats = false;
  expect_half_a_second(fixture.until_it_brakes(last_heartbeat), "server");
}

}  // namespace
}  // namespace cosiva::aiv
