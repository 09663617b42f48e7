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

}  // namespace
}  // namespace cosiva::virtual_side
