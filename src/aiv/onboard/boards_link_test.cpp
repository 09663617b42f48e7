#include "cosiva/aiv/onboard/boards_link.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <variant>

namespace cosiva::aiv {
namespace {

using std::chrono::milliseconds;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;
using wire::Board;

struct BoardsLinkTest : ::testing::Test {
  BoardsLink boards{7};
  wire::module_link::Encoder encoder;
  wire::Effects effects;

  void receive(Board board, const wire::BoardMessage& message) {
    (void)boards.on_bytes(board, encoder.encode(message));
  }
  /// The messages that are sent to a board.
  [[nodiscard]] std::vector<wire::BoardMessage> sent_to(Board board) const {
    std::vector<wire::BoardMessage> messages;
    wire::module_link::Decoder decoder;
    for (const wire::Effect& effect : effects) {
      const auto& bytes = std::get<wire::SendBytes>(effect);
      if (bytes.port == wire::port_name(7, board)) decoder.feed(bytes.bytes, messages);
    }
    return messages;
  }
  void tick(int ms) {
    effects.clear();
    boards.on_tick(SimTime{milliseconds{ms}}, effects);
  }
};

TEST_F(BoardsLinkTest, has_a_port_for_each_board) {
  EXPECT_THAT(boards.ports(), ElementsAre("7/PILS", "7/PRAV", "7/DOBS", "7/RALI"));
  EXPECT_EQ(boards.board_of("7/DOBS"), Board::DOBS);
  EXPECT_EQ(boards.board_of("8/DOBS"), std::nullopt);
}

TEST_F(BoardsLinkTest, keeps_the_last_power_and_ranges_and_reports_new_ranges_once) {
  EXPECT_FALSE(boards.power());
  EXPECT_FALSE(boards.ranges());
  EXPECT_FALSE(boards.take_new_ranges());
  receive(Board::RALI, wire::Power{7400, 300, 250, 900});
  receive(Board::DOBS, wire::Ranges{1, -50, 10, {500}});
  EXPECT_EQ(boards.power()->charge_permille, 900);
  EXPECT_THAT(boards.ranges()->range_mm, ElementsAre(500));
  EXPECT_TRUE(boards.take_new_ranges());
  EXPECT_FALSE(boards.take_new_ranges());
  EXPECT_TRUE(boards.ranges());
}

TEST_F(BoardsLinkTest, keeps_the_health_that_a_board_reports_until_its_port_opens_anew) {
  receive(Board::PILS, wire::Hello{Board::PILS, 1, 0xF00D, 5});
  receive(Board::PILS, wire::Heartbeat{1234, 2, 3, 4});
  const BoardsLink::Health& health = boards.health(Board::PILS);
  EXPECT_TRUE(health.connected);
  EXPECT_EQ(health.hello->firmware_hash, 0xF00DU);
  EXPECT_EQ(health.uptime_ms, 1234U);
  EXPECT_EQ(health.frames_bad, 2);
  EXPECT_EQ(health.frames_missed, 3);
  EXPECT_EQ(health.self_test, 4);
  EXPECT_FALSE(boards.health(Board::DOBS).connected);
  boards.on_port(Board::PILS, true);
  EXPECT_TRUE(health.connected);
  EXPECT_FALSE(health.hello);
  EXPECT_EQ(health.self_test, 0);
  boards.on_port(Board::PILS, false);
  EXPECT_FALSE(health.connected);
}

TEST_F(BoardsLinkTest, counts_the_frames_of_both_sides) {
  receive(Board::PILS, wire::Heartbeat{0, 20, 30, 0});
  receive(Board::PILS, wire::Heartbeat{0, 20, 30, 0});
  (void)encoder.encode(wire::Heartbeat{});  // this frame is lost
  receive(Board::PILS, wire::Heartbeat{0, 20, 30, 0});
  (void)boards.on_bytes(Board::PILS, std::string("noise\0", 6));
  const BoardsLink::Frames frames = boards.frames(Board::PILS);
  EXPECT_EQ(frames.good, 3U);
  EXPECT_EQ(frames.bad, 21U);
  EXPECT_EQ(frames.missed, 31U);
  EXPECT_EQ(boards.frames(Board::DOBS).good, 0U);
}

TEST_F(BoardsLinkTest, discards_the_rest_of_a_frame_when_a_port_opens_anew) {
  const std::string frame = encoder.encode(wire::Heartbeat{});
  EXPECT_THAT(boards.on_bytes(Board::PILS, frame.substr(0, 4)), IsEmpty());
  boards.on_port(Board::PILS, true);
  EXPECT_THAT(boards.on_bytes(Board::PILS, frame), SizeIs(1));
  EXPECT_EQ(boards.frames(Board::PILS).bad, 0U);
}

TEST_F(BoardsLinkTest, sends_nothing_to_a_board_that_is_not_connected) {
  boards.send(Board::PRAV, wire::Display{"text"}, effects);
  EXPECT_THAT(effects, IsEmpty());
  boards.on_port(Board::PRAV, true);
  boards.send(Board::PRAV, wire::Display{"text"}, effects);
  EXPECT_THAT(sent_to(Board::PRAV), ElementsAre(wire::BoardMessage{wire::Display{"text"}}));
}

TEST_F(BoardsLinkTest, sends_each_connected_board_a_heartbeat_every_100_ms) {
  boards.start(SimTime{milliseconds{1000}});
  boards.on_port(Board::RALI, true);
  receive(Board::RALI, wire::Hello{Board::RALI, 1, 1, 1});
  (void)boards.on_bytes(Board::RALI, std::string("noise\0", 6));
  tick(1250);
  EXPECT_THAT(sent_to(Board::RALI), ElementsAre(wire::BoardMessage{wire::Heartbeat{250, 1, 0, 0}}));
  EXPECT_THAT(effects, SizeIs(1)) << "no other board is connected";
  tick(1349);
  EXPECT_THAT(effects, IsEmpty());
  tick(1350);
  EXPECT_THAT(sent_to(Board::RALI), ElementsAre(wire::BoardMessage{wire::Heartbeat{350, 1, 0, 0}}));
}

TEST_F(BoardsLinkTest, requests_the_identity_of_a_board_with_each_heartbeat_until_it_is_known) {
  boards.on_port(Board::PILS, true);
  const wire::BoardMessage request = wire::Hello{Board::PILS, 1, 0, 0};
  tick(0);
  EXPECT_THAT(sent_to(Board::PILS), ElementsAre(testing::_, request));
  tick(100);
  EXPECT_THAT(sent_to(Board::PILS), ElementsAre(testing::_, request));
  receive(Board::PILS, wire::Hello{Board::PILS, 1, 1, 1});
  tick(200);
  EXPECT_THAT(sent_to(Board::PILS), SizeIs(1));
}

TEST_F(BoardsLinkTest, as_values_stores_and_counts_the_same_and_sends_all_boards_frames_together) {
  BoardsLink values{7, true};
  wire::BoardFrames received{7};
  const auto pass = [&](Board board, std::uint8_t sequence, const wire::BoardMessage& message) {
    (void)boards.on_bytes(board, wire::module_link::encode(message, sequence));
    received.clear();
    received.add(board, sequence, message);
    values.on_frames(received.frames());
  };
  pass(Board::RALI, 0, wire::Power{7400, 300, 250, 900});
  pass(Board::RALI, 3, wire::Heartbeat{100, 4, 5, 6});  // two frames are missing
  pass(Board::DOBS, 0, wire::Ranges{1, -50, 10, {500}});
  pass(Board::PILS, 0, wire::Hello{Board::PILS, 1, 2, 3});
  EXPECT_EQ(values.power(), boards.power());
  EXPECT_EQ(values.ranges(), boards.ranges());
  EXPECT_EQ(values.take_new_ranges(), boards.take_new_ranges());
  for (const Board board : wire::all_boards) {
    EXPECT_EQ(values.frames(board).good, boards.frames(board).good);
    EXPECT_EQ(values.frames(board).bad, boards.frames(board).bad);
    EXPECT_EQ(values.frames(board).missed, boards.frames(board).missed);
    EXPECT_EQ(values.health(board).connected, boards.health(board).connected);
    EXPECT_EQ(values.health(board).hello, boards.health(board).hello);
    EXPECT_EQ(values.health(board).self_test, boards.health(board).self_test);
    EXPECT_EQ(values.health(board).uptime_ms, boards.health(board).uptime_ms);
  }

  tick(0);  // starts the timer
  tick(100);
  wire::Effects together;
  values.on_tick(SimTime{}, together);
  values.on_tick(SimTime{milliseconds{100}}, together);
  EXPECT_THAT(together, IsEmpty()) << "before they are flushed";
  values.flush(together);
  ASSERT_THAT(together, SizeIs(1));
  const auto& frames = dynamic_cast<const wire::BoardFrames&>(*std::get<wire::SendBytes>(together.front()).typed);
  for (const Board board : {Board::PILS, Board::DOBS, Board::RALI}) {
    std::vector<wire::BoardMessage> of_board;
    for (const auto& frame : frames.frames())
      if (frame.board == board) of_board.push_back(frame.message);
    const auto as_bytes = sent_to(board);
    ASSERT_GE(of_board.size(), as_bytes.size());
    EXPECT_THAT(std::vector(of_board.end() - static_cast<std::ptrdiff_t>(as_bytes.size()), of_board.end()),
                testing::ElementsAreArray(as_bytes));
  }
}

}  // namespace
}  // namespace cosiva::aiv
