#include "cosiva/wire/in_process/typed_message.h"

#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <utility>

namespace cosiva::wire {
namespace {

using std::chrono::microseconds;
using std::chrono::nanoseconds;

constexpr SimTime between_two_milliseconds = virtual_epoch + microseconds{1999};
constexpr SimTime as_written = virtual_epoch + microseconds{1000};

template <typename Message>
SimTime header_time_received(Message message) {
  message.header.timestamp = between_two_milliseconds;
  return as_received(std::move(message)).header.timestamp;
}
template <typename Message>
SimTime time_received(Message message, SimTime sent = between_two_milliseconds) {
  message.timestamp = sent;
  return as_received(std::move(message)).timestamp;
}

TEST(ReceivedValues, have_the_time_of_their_text_which_is_cut_to_the_millisecond) {
  EXPECT_EQ(header_time_received(State{}), as_written);
  EXPECT_EQ(header_time_received(Visualization{}), as_written);
  EXPECT_EQ(header_time_received(Order{}), as_written);
  EXPECT_EQ(time_received(Intent{}), as_written);
  EXPECT_EQ(time_received(DetectedObstacleReport{}), as_written);
  EXPECT_EQ(time_received(BoardsReport{}), as_written);
}

TEST(ReceivedValues, before_1970_are_cut_towards_the_past_too) {
  EXPECT_EQ(time_received(Intent{}, SimTime{nanoseconds{-1}}), SimTime{std::chrono::milliseconds{-1}});
}

TEST(ReceivedValues, lack_the_boards_own_clock) {
  BoardsReport report;
  report.ranges.emplace();
  report.ranges->board_ms = 4711;
  const BoardsReport received = as_received(std::move(report));
  ASSERT_TRUE(received.ranges);
  EXPECT_EQ(received.ranges->board_ms, 0U);
  EXPECT_FALSE(as_received(BoardsReport{}).ranges) << "there was none";
}

TEST(ReceivedValues, are_taken_before_the_text) {
  DetectedObstacleReport detected;
  detected.header_id = 7;
  Input input{virtual_epoch, InputKind::message, "topic", "no json", false, typed(std::move(detected))};
  EXPECT_EQ(detected_obstacle_from(input).value().header_id, 7U);
  EXPECT_FALSE(boards_report_from(input)) << "another message, and the text is none";
  input.typed.reset();
  EXPECT_FALSE(detected_obstacle_from(input));
}

TEST(ReceivedValues, are_those_of_the_text_where_there_is_only_text) {
  BoardsReport report;
  report.header_id = 9;
  report.timestamp = virtual_epoch;
  const Input input{virtual_epoch, InputKind::message, "topic", to_json(report), false};
  EXPECT_EQ(boards_report_from(input).value(), report);
}

}  // namespace
}  // namespace cosiva::wire
