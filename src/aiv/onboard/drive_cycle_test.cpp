#include "cosiva/aiv/onboard/drive_cycle.h"

#include <gtest/gtest.h>

#include "cosiva/aiv/testing/test_zone.h"

namespace cosiva::aiv {
namespace {

using test::lacet4;

struct DriveCycleTest : ::testing::Test {
  Supervision supervision{std::chrono::milliseconds{500}};
  VirtualPerception perception;
  wire::VehicleId id{"CoSiVA", "AIV1"};
  V2xParticipant v2x{id, true};
  BoardsLink boards{1};
  ServerProxy server_proxy{id, wire::default_interface};
  DriveCycle cycle{supervision, perception, v2x, boards, server_proxy};
  DrivingContext context{lacet4(), {}};
  wire::Effects effects;

  DriveCycleTest() { boards.on_port(wire::Board::PILS, true); }
};

TEST_F(DriveCycleTest, sends_one_command_to_the_motors) {
  cycle.run(SimTime{}, context, effects);
  ASSERT_EQ(effects.size(), 1U);
  EXPECT_EQ(std::get<wire::SendBytes>(effects[0]).port, wire::port_name(1, wire::Board::PILS));
}

TEST_F(DriveCycleTest, holds_for_each_link_that_is_lost_and_no_longer) {
  cycle.run(SimTime{}, context, effects);
  EXPECT_TRUE(context.vehicle().holds().has(Hold::broker_lost));
  EXPECT_TRUE(context.vehicle().holds().has(Hold::board_lost));
  EXPECT_FALSE(context.vehicle().holds().has(Hold::server_lost)) << "no heartbeat was received yet";
  supervision.on_broker_message(SimTime{});
  for (const wire::Board board : wire::all_boards) supervision.on_board_message(SimTime{}, board);
  supervision.on_server_heartbeat(SimTime{});
  cycle.run(SimTime{std::chrono::milliseconds{500}}, context, effects);
  EXPECT_EQ(context.vehicle().holds().bits(), 0);
  cycle.run(SimTime{std::chrono::milliseconds{501}}, context, effects);
  EXPECT_TRUE(context.vehicle().holds().has(Hold::server_lost));
  EXPECT_TRUE(context.vehicle().holds().has(Hold::board_lost));
  EXPECT_TRUE(context.vehicle().holds().has(Hold::broker_lost));
}

TEST_F(DriveCycleTest, holds_for_a_fault_of_wheels_or_obstacle_sensor_only) {
  const auto holds_for = [&](wire::Board board) {
    const auto report = [&](std::uint8_t code) {
      wire::module_link::Encoder encoder;
      (void)boards.on_bytes(board, encoder.encode(wire::Heartbeat{0, 0, 0, code}));
    };
    report(1);
    cycle.run(SimTime{}, context, effects);
    const bool held = context.vehicle().holds().has(Hold::board_faulty);
    report(0);
    cycle.run(SimTime{}, context, effects);
    EXPECT_FALSE(context.vehicle().holds().has(Hold::board_faulty));
    return held;
  };
  EXPECT_TRUE(holds_for(wire::Board::PILS));
  EXPECT_FALSE(holds_for(wire::Board::PRAV));
  EXPECT_TRUE(holds_for(wire::Board::DOBS));
  EXPECT_FALSE(holds_for(wire::Board::RALI));
}

TEST_F(DriveCycleTest, takes_a_vehicle_whose_wheels_are_lost_for_stopped) {
  for (const wire::Board board : wire::all_boards) supervision.on_board_message(SimTime{}, board);
  wire::Odometry moving{};
  moving.speed_mmps = 400;
  context.agent().on_odometry(moving);
  cycle.run(SimTime{}, context, effects);
  EXPECT_FALSE(context.vehicle().motion().stopped());
  supervision.forget_board(wire::Board::DOBS);
  cycle.run(SimTime{}, context, effects);
  EXPECT_FALSE(context.vehicle().motion().stopped()) << "another board";
  supervision.forget_board(wire::Board::PILS);
  cycle.run(SimTime{}, context, effects);
  EXPECT_TRUE(context.vehicle().motion().stopped());
}

}  // namespace
}  // namespace cosiva::aiv
