// The boards as modules that are verified one by one (A14 to A18): self-tests, a vehicle without RALI, a board that
// starts anew, and what the parts of PILS measure.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cosiva/aiv/onboard/onboard_fixture.h"
#include "cosiva/wire/messages/charge.h"

namespace cosiva::aiv::test {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::Not;
using wire::ActionStatus;
using wire::Board;
using wire::BoardPart;
using wire::Finding;

const wire::BoardsReport::Line& line_of(const OnboardFixture& fixture, Board board) {
  return *std::ranges::find(fixture.boards_reports.back().boards, board, &wire::BoardsReport::Line::board);
}

TEST(SelfTest, is_performed_by_each_board_and_ends_the_action_with_all_results) {
  OnboardFixture fixture;
  fixture.run(1.0);
  fixture.findings[Board::PILS] = {{BoardPart::controller}, {BoardPart::DEMS}};
  fixture.act("selfTest", "t1");
  fixture.run(0.5);
  ASSERT_TRUE(fixture.action("t1"));
  EXPECT_EQ(fixture.action("t1")->status, ActionStatus::finished);
  EXPECT_EQ(fixture.action("t1")->result_description, "PILS passed, PRAV passed, DOBS passed, RALI passed");
  fixture.run(0.6);
  EXPECT_THAT(line_of(fixture, Board::PILS).parts,
              ElementsAre(wire::PartFinding{BoardPart::controller}, wire::PartFinding{BoardPart::DEMS}));
}

TEST(SelfTest, with_a_bad_part_fails_and_names_it) {
  OnboardFixture fixture;
  fixture.run(1.0);
  fixture.findings[Board::PRAV] = {{BoardPart::controller}, {BoardPart::RFID, Finding::no_response}};
  fixture.self_test[Board::PRAV] = wire::fault_code({BoardPart::RFID, Finding::no_response});
  fixture.act("selfTest", "t1");
  fixture.run(0.5);
  EXPECT_EQ(fixture.action("t1")->status, ActionStatus::failed);
  EXPECT_EQ(fixture.action("t1")->result_description, "PILS passed, PRAV RFID: no response, DOBS passed, RALI passed");
  fixture.run(1.0);
  const auto& errors = fixture.state().errors;
  ASSERT_FALSE(errors.empty());
  EXPECT_EQ(errors.back().type, "boardFaulty");
  EXPECT_EQ(errors.back().description, "PRAV reports RFID: no response");
}

TEST(SelfTest, fails_after_a_second_without_response_of_a_board) {
  OnboardFixture fixture;
  fixture.run(1.0);
  fixture.silence(Board::DOBS);
  fixture.act("selfTest", "t1");
  fixture.run(0.9);
  EXPECT_EQ(fixture.action("t1")->status, ActionStatus::running);
  fixture.run(0.3);
  EXPECT_EQ(fixture.action("t1")->status, ActionStatus::failed);
  EXPECT_EQ(fixture.action("t1")->result_description, "PILS passed, PRAV passed, DOBS no response, RALI passed");
}

TEST(SelfTest, is_refused_to_a_vehicle_that_drives) {
  OnboardFixture fixture;
  fixture.run(1.0);
  fixture.order(order("O-1").through({"loop_se@0", "loop_se@283", "loop_se@565", "loop_se@848"}));
  ASSERT_TRUE(fixture.run_until([&] { return fixture.speed_mps > 0.1; }, 5.0));
  fixture.act("selfTest", "t1");
  fixture.run(0.2);
  EXPECT_EQ(fixture.action("t1")->status, ActionStatus::failed);
  EXPECT_EQ(fixture.action("t1")->result_description, "the vehicle drives; stop it before a self-test");
  EXPECT_TRUE(fixture.requested_tests.empty());
}

TEST(WithoutRali, the_vehicle_drives_and_reports_its_charge_as_unknown) {
  OnboardFixture fixture{{.rali = false}};
  fixture.run(1.0);
  EXPECT_THAT(fixture.error_types(), Not(Contains("boardLost")));
  EXPECT_TRUE(wire::charge_unknown(fixture.state()));
  EXPECT_EQ(fixture.state().battery.charge_percent, 80.0) << "the standard's good level of a vehicle without gauge";
  EXPECT_FALSE(fixture.state().battery.voltage_v);
  fixture.order(order("O-1").through({"loop_se@0", "loop_se@283", "loop_se@565", "loop_se@848"}));
  EXPECT_TRUE(fixture.run_until([&] { return fixture.speed_mps > 0.1; }, 5.0));
  EXPECT_EQ(line_of(fixture, Board::RALI).health, "absent");
  EXPECT_FALSE(fixture.boards_reports.back().power);
  for (const std::string& port : fixture.core->ports()) EXPECT_EQ(port.find("RALI"), std::string::npos);
}

TEST(WithoutRali, that_the_vehicle_should_have_it_stops_and_reports_the_board_lost) {
  OnboardFixture fixture;
  fixture.run(1.0);
  fixture.silence(Board::RALI);
  fixture.run(1.0);
  EXPECT_THAT(fixture.error_types(), Contains("boardLost"));
  EXPECT_FALSE(wire::charge_unknown(fixture.state()));
}

TEST(WithoutRali, a_self_test_concerns_the_other_boards) {
  OnboardFixture fixture{{.rali = false}};
  fixture.run(1.0);
  fixture.act("selfTest", "t1");
  fixture.run(0.5);
  EXPECT_EQ(fixture.action("t1")->status, ActionStatus::finished);
  EXPECT_EQ(fixture.action("t1")->result_description, "PILS passed, PRAV passed, DOBS passed");
}

TEST(Restart, of_a_board_with_its_port_open_is_reported_with_its_name) {
  OnboardFixture fixture;
  fixture.run(1.0);
  fixture.send_from_board(Board::DOBS, wire::Hello{Board::DOBS, 1, 0xF00D, 77});
  fixture.run(0.2);
  EXPECT_THAT(fixture.error_types(), Not(Contains("boardRestarted"))) << "the same session";
  fixture.send_from_board(Board::DOBS, wire::Hello{Board::DOBS, 1, 0xF00D, 78});
  fixture.run(0.2);
  EXPECT_THAT(fixture.error_types(), Contains("boardRestarted"));
}

TEST(Restart, of_prav_gives_the_display_its_text_again) {
  OnboardFixture fixture;
  fixture.run(2.0);
  ASSERT_FALSE(fixture.displayed.empty());
  const std::string text = fixture.displayed.back();
  const std::size_t before = fixture.displayed.size();
  fixture.send_from_board(Board::PRAV, wire::Hello{Board::PRAV, 1, 0xF00D, 78});
  fixture.run(1.0);
  ASSERT_GT(fixture.displayed.size(), before);
  EXPECT_EQ(fixture.displayed.back(), text);
}

TEST(BoardsReport, has_the_display_s_text_and_what_the_parts_of_pils_measure) {
  OnboardFixture fixture;
  const wire::PilsParts parts{9, 5012, 7, {0, 0, 96, 255, 255, 32, 0, 0}, {310, 140}, {325, 135}};
  fixture.run(2.0);
  fixture.send_from_board(Board::PILS, parts);
  fixture.run(0.6);
  const wire::BoardsReport& report = fixture.boards_reports.back();
  EXPECT_EQ(report.affi, fixture.displayed.back());
  ASSERT_TRUE(report.pils);
  EXPECT_EQ(report.pils->reading, parts.reading);
  EXPECT_EQ(report.pils->left, parts.left);
  EXPECT_EQ(report.pils->supply_mv, 5012);
}

}  // namespace
}  // namespace cosiva::aiv::test
