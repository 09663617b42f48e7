#include "cosiva/wire/in_process/frame_batch.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cosiva::wire {
namespace {

using testing::IsEmpty;
using testing::SizeIs;

const BoardFrames& frames_of(const Effect& effect) {
  return dynamic_cast<const BoardFrames&>(*std::get<SendBytes>(effect).typed);
}

TEST(FrameBatch, leaves_as_one_effect_with_all_boards_frames) {
  FrameBatch batch{4};
  batch.add(Board::PILS, 0, Heartbeat{});
  batch.add(Board::DOBS, 9, Heartbeat{});
  Effects effects;
  batch.flush("4/PILS", effects);
  ASSERT_THAT(effects, SizeIs(1));
  const auto& send = std::get<SendBytes>(effects.front());
  EXPECT_EQ(send.port, "4/PILS");
  EXPECT_THAT(send.bytes, IsEmpty());
  EXPECT_EQ(frames_of(effects.front()).vehicle(), 4U);
  ASSERT_THAT(frames_of(effects.front()).frames(), SizeIs(2));
  EXPECT_EQ(frames_of(effects.front()).frames()[1].board, Board::DOBS);
  EXPECT_EQ(frames_of(effects.front()).frames()[1].sequence, 9);
}

TEST(FrameBatch, without_frames_sends_nothing) {
  FrameBatch batch{1};
  Effects effects;
  batch.flush("1/PILS", effects);
  batch.add(Board::PILS, 0, Heartbeat{});
  batch.flush("1/PILS", effects);
  batch.flush("1/PILS", effects);
  EXPECT_THAT(effects, SizeIs(1));
}

TEST(FrameBatch, uses_a_list_again_once_its_receiver_has_released_it) {
  FrameBatch batch{1};
  Effects effects;
  const auto send = [&](std::uint8_t sequence) {
    batch.add(Board::PILS, sequence, Heartbeat{});
    batch.flush("1/PILS", effects);
    return &frames_of(effects.back());
  };
  const BoardFrames* first = send(0);
  const BoardFrames* second = send(1);
  EXPECT_NE(second, first) << "the first is still held";
  EXPECT_EQ(first->frames()[0].sequence, 0);
  effects.clear();
  const BoardFrames* third = send(2);
  EXPECT_TRUE(third == first || third == second);
  EXPECT_THAT(third->frames(), SizeIs(1));
  EXPECT_EQ(third->frames()[0].sequence, 2);
}

TEST(FrameBatch, whose_lists_are_all_held_makes_new_ones) {
  FrameBatch batch{1};
  Effects held;
  for (std::uint8_t sequence = 0; sequence < 20; ++sequence) {
    batch.add(Board::PILS, sequence, Heartbeat{});
    batch.flush("1/PILS", held);
  }
  for (std::uint8_t sequence = 0; sequence < 20; ++sequence)
    EXPECT_EQ(frames_of(held[sequence]).frames()[0].sequence, sequence);
}

}  // namespace
}  // namespace cosiva::wire
