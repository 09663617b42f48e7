#include "cosiva/virtual/server/registry/on_board_reports.h"

#include <gtest/gtest.h>

namespace cosiva::virtual_side {
namespace {

using namespace std::chrono_literals;

wire::BoardsReport boards_at(SimDuration time) {
  wire::BoardsReport report;
  report.timestamp = virtual_epoch + time;
  return report;
}

TEST(OnBoardReports, hold_the_last_report_of_the_boards) {
  OnBoardReports reports;
  EXPECT_FALSE(reports.boards());
  EXPECT_FALSE(reports.boards_outdated(virtual_epoch));
  reports.on_boards(boards_at(10s));
  EXPECT_FALSE(reports.boards_outdated(virtual_epoch + 10s));
  EXPECT_TRUE(reports.boards_outdated(virtual_epoch + 9s));
  EXPECT_FALSE(reports.boards_outdated(virtual_epoch + 5s)) << "the clock was set";
  EXPECT_DEATH(reports.on_boards(boards_at(9s)), "boards_outdated");
}

TEST(OnBoardReports, ignore_a_detected_obstacle_that_was_overtaken) {
  OnBoardReports reports;
  EXPECT_TRUE(reports.on_detected(virtual_epoch + 10s));
  EXPECT_FALSE(reports.on_detected(virtual_epoch + 9s));
  EXPECT_TRUE(reports.on_detected(virtual_epoch + 10s)) << "the last one counts, not the late one";
}

TEST(OnBoardReports, are_forgotten_in_a_new_session) {
  OnBoardReports reports;
  reports.on_boards(boards_at(10s));
  EXPECT_TRUE(reports.on_detected(virtual_epoch + 10s));
  reports.on_session();
  EXPECT_FALSE(reports.boards());
  EXPECT_FALSE(reports.boards_outdated(virtual_epoch + 9s));
  EXPECT_TRUE(reports.on_detected(virtual_epoch + 9s));
}

TEST(OnBoardReports, trace_one_v2x_message_a_second) {
  OnBoardReports reports;
  EXPECT_TRUE(reports.on_v2x(virtual_epoch));
  EXPECT_FALSE(reports.on_v2x(virtual_epoch + 999ms));
  EXPECT_TRUE(reports.on_v2x(virtual_epoch + 1s));
}

TEST(OnBoardReports, hold_the_report_that_was_received_last) {
  OnBoardReports reports;
  reports.on_boards(boards_at(10s));
  reports.on_boards(boards_at(10s));
  reports.on_boards(boards_at(4s));
  EXPECT_EQ(reports.boards()->timestamp, virtual_epoch + 4s) << "the clock was set";
  EXPECT_TRUE(reports.boards_outdated(virtual_epoch + 3s));
}

TEST(OnBoardReports, compare_a_detected_obstacle_with_the_last_one) {
  OnBoardReports reports;
  EXPECT_TRUE(reports.on_detected(virtual_epoch + 10s));
  EXPECT_TRUE(reports.on_detected(virtual_epoch + 12s));
  EXPECT_FALSE(reports.on_detected(virtual_epoch + 11s));
  EXPECT_TRUE(reports.on_detected(virtual_epoch + 7s)) << "five seconds back: the clock was set";
  EXPECT_FALSE(reports.on_detected(virtual_epoch + 6s));
}

TEST(OnBoardReports, trace_the_first_of_two_v2x_messages_at_one_time) {
  OnBoardReports reports;
  EXPECT_TRUE(reports.on_v2x(virtual_epoch + 10s));
  EXPECT_FALSE(reports.on_v2x(virtual_epoch + 10s));
  EXPECT_TRUE(reports.on_v2x(virtual_epoch + 11s));
  EXPECT_FALSE(reports.on_v2x(virtual_epoch + 11999ms)) << "a second from the last traced one";
}

TEST(OnBoardReports, trace_a_v2x_message_after_the_clock_of_the_server_was_set_back) {
  OnBoardReports reports;
  EXPECT_TRUE(reports.on_v2x(virtual_epoch + 10s));
  EXPECT_TRUE(reports.on_v2x(virtual_epoch + 9s));
}

}  // namespace
}  // namespace cosiva::virtual_side
