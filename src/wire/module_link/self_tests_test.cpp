#include "cosiva/wire/module_link/self_tests.h"

#include <gtest/gtest.h>

namespace cosiva::wire::module_link {
namespace {

using namespace std::chrono_literals;

const SelfTestResult good{1, {{BoardPart::controller}}};
const SelfTestResult bad{1, {{BoardPart::controller}, {BoardPart::RFID, Finding::no_response}}};

TEST(SelfTests, pass_when_every_board_of_the_round_has_passed) {
  SelfTests tests;
  EXPECT_EQ(tests.begin(SimTime{}, {Board::PILS, Board::PRAV}).number, 1);
  tests.on_result(Board::PILS, good);
  EXPECT_TRUE(tests.open());
  EXPECT_FALSE(tests.passed());
  tests.on_result(Board::PRAV, good);
  EXPECT_FALSE(tests.open());
  EXPECT_TRUE(tests.passed());
  EXPECT_EQ(tests.text(), "PILS passed, PRAV passed");
}

TEST(SelfTests, fail_with_one_bad_part_and_name_it) {
  SelfTests tests;
  (void)tests.begin(SimTime{}, {Board::PILS, Board::PRAV});
  tests.on_result(Board::PILS, good);
  tests.on_result(Board::PRAV, bad);
  EXPECT_FALSE(tests.passed());
  EXPECT_EQ(tests.text(), "PILS passed, PRAV RFID: no response");
}

TEST(SelfTests, end_after_a_second_with_the_boards_that_have_not_responded) {
  SelfTests tests;
  (void)tests.begin(SimTime{}, {Board::PILS, Board::DOBS});
  tests.on_result(Board::PILS, good);
  tests.on_tick(SimTime{1s});
  EXPECT_TRUE(tests.open());
  tests.on_tick(SimTime{1001ms});
  EXPECT_FALSE(tests.open());
  EXPECT_FALSE(tests.passed());
  EXPECT_EQ(tests.text(), "PILS passed, DOBS no response");
}

TEST(SelfTests, ignore_results_of_an_earlier_round_and_late_ones) {
  SelfTests tests;
  (void)tests.begin(SimTime{}, {Board::PILS});
  EXPECT_EQ(tests.begin(SimTime{}, {Board::PILS}).number, 2);
  tests.on_result(Board::PILS, good);
  EXPECT_FALSE(tests.parts(Board::PILS));
  tests.on_tick(SimTime{2s});
  tests.on_result(Board::PILS, {2, {{BoardPart::controller}}});
  EXPECT_FALSE(tests.parts(Board::PILS)) << "too late";
}

TEST(FaultText, names_part_and_finding_and_shows_an_unknown_code_as_it_is) {
  EXPECT_EQ(fault_code({BoardPart::DEMS, Finding::implausible}), 50);
  EXPECT_EQ(fault_text(50), "DEMS: implausible readings");
  EXPECT_EQ(fault_text(0x84), "regulator: supply too low");
  for (const int code : {1, 3, 0x10, 0x15, 0x91, 255})
    EXPECT_EQ(fault_text(static_cast<std::uint8_t>(code)), "fault " + std::to_string(code));
  EXPECT_EQ(fault_code({BoardPart::PMOT, Finding::passed}), 0);
}

}  // namespace
}  // namespace cosiva::wire::module_link
