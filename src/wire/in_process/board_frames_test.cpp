#include "cosiva/wire/in_process/board_frames.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "cosiva/wire/module_link/module_link.h"

namespace cosiva::wire {
namespace {

using testing::ElementsAre;

/// One message of each kind, among them those of which a frame cannot hold all.
std::vector<BoardMessage> messages() {
  const Drive with_goal_unsought{150, 500, 800, no_branch, false, Manoeuvre{1, 2, 3}};
  const Drive seeking{150, 500, 800, no_branch, true, Manoeuvre{1, 2, 3}};
  return {Hello{Board::PILS, 1, 7, 9},
          Heartbeat{1000, 1, 2, 0},
          Odometry{1000, -1'234'567, -250, -13, true, Manoeuvre{1, 2, 3}},
          with_goal_unsought,
          seeking,
          TagRead{1000, 12, 20},
          Display{std::string(31, 'a') + "é"},
          Display{"AIV1"},
          Ranges{1000, -84, 14, {500, no_echo}},
          Power{7400, 300, 250, 900, Power::Gauge{900'001, 50}}};
}

TEST(BoardFrames, hold_each_message_as_it_would_be_read_from_its_frame) {
  BoardFrames frames{3};
  std::uint8_t sequence = 0;
  for (const BoardMessage& message : messages()) frames.add(Board::PILS, sequence++, message);
  ASSERT_EQ(frames.frames().size(), messages().size());
  std::vector<BoardMessage> read;
  module_link::Decoder decoder;
  for (std::size_t i = 0; i < messages().size(); ++i)
    decoder.feed(module_link::encode(messages()[i], static_cast<std::uint8_t>(i)), read);
  ASSERT_EQ(read.size(), messages().size());
  for (std::size_t i = 0; i < read.size(); ++i) {
    EXPECT_EQ(frames.frames()[i].message, read[i]) << "message " << i;
    EXPECT_EQ(frames.frames()[i].sequence, i);
  }
  EXPECT_EQ(frames.vehicle(), 3U);
}

TEST(BoardFrames, of_one_board_that_follow_each_other_are_one_run) {
  BoardFrames frames{1};
  std::uint8_t sequence = 0;
  for (const Board board : {Board::PILS, Board::PILS, Board::DOBS, Board::PILS})
    frames.add(board, sequence++, Heartbeat{});
  const auto run_lengths = [&] {
    std::vector<std::size_t> lengths;
    for (std::size_t next = 0; next < frames.frames().size(); next += lengths.back())
      lengths.push_back(frames.run_of_board(next).size());
    return lengths;
  };
  EXPECT_THAT(run_lengths(), ElementsAre(2, 1, 1));
}

TEST(BoardFrames, fold_number_kinds_and_sequence_numbers) {
  const auto digest_of = [](std::vector<std::pair<std::uint8_t, BoardMessage>> sent) {
    BoardFrames frames{1};
    for (auto& [sequence, message] : sent) frames.add(Board::PILS, sequence, message);
    Digest digest;
    frames.fold(digest);
    return digest;
  };
  const Digest one = digest_of({{0, Heartbeat{}}});
  EXPECT_EQ(digest_of({{0, Heartbeat{}}}), one);
  EXPECT_NE(digest_of({{1, Heartbeat{}}}), one);
  EXPECT_NE(digest_of({{0, TagRead{}}}), one);
  EXPECT_NE(digest_of({{0, Heartbeat{}}, {1, Heartbeat{}}}), one);
}

TEST(BoardFramesDeathTest, have_no_run_behind_their_end) {
  BoardFrames frames{1};
  EXPECT_DEATH((void)frames.run_of_board(0), "first < count_");
}

}  // namespace
}  // namespace cosiva::wire
