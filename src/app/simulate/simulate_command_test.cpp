#include "cosiva/app/simulate/simulate_command.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cosiva/app/command_line_fixture.h"
#include "cosiva/base/json_value.h"

namespace cosiva::app {
namespace {

using fixture::CommandOutput;
using fixture::cosiva;
using ::testing::HasSubstr;
using ::testing::StartsWith;

TEST(SimulateCommand, reports_each_seed_in_order_with_the_same_digests_whatever_the_jobs) {
  const CommandOutput one = cosiva({"simulate", "--seeds", "3..4", "--minutes", "0.2", "--jobs", "1", "--json"});
  const CommandOutput two = cosiva({"simulate", "--seeds", "3..4", "--minutes", "0.2", "--jobs", "2", "--json"});
  EXPECT_EQ(one.status, 0);
  EXPECT_THAT(one.data, StartsWith(R"({"seed":"3","digest":")"));
  EXPECT_EQ(one.data, two.data);
}

TEST(SimulateCommand, ends_with_1_and_the_command_that_repeats_a_failed_seed) {
  const CommandOutput output =
      cosiva({"simulate", "--seeds", "3", "--minutes", "0.2", "--plant", "hidden-age", "--shrink"});
  EXPECT_EQ(output.status, 1);
  EXPECT_THAT(output.standard_error,
              HasSubstr("replay: cosiva simulate --seeds 3 --minutes 0.2 --zone lacet4 --aivs 4 --plant hidden-age"));
  EXPECT_THAT(output.standard_error, HasSubstr("shrunk to 0 of"));
}

TEST(SimulateCommand, lists_the_faults_of_a_seed) {
  const CommandOutput output = cosiva({"simulate", "--seeds", "3", "--minutes", "1", "--list"});
  EXPECT_EQ(output.status, 0);
  EXPECT_THAT(output.data, StartsWith("seed 3\n  #1 F"));
}

TEST(SimulateCommand, names_hand_overs_in_the_command_that_repeats_a_failed_seed) {
  const CommandOutput output =
      cosiva({"simulate", "--handovers", "--seeds", "1", "--minutes", "0.2", "--plant", "lost-owner"});
  EXPECT_EQ(output.status, 1);
  EXPECT_THAT(output.standard_error,
              HasSubstr("replay: cosiva simulate --seeds 1 --minutes 0.2 --handovers --aivs 4 --plant lost-owner"));
}

TEST(SimulateCommand, refuses_a_zone_with_hand_overs_and_a_defect_of_hand_overs_without_them) {
  EXPECT_NE(cosiva({"simulate", "--handovers", "--zone", "lacet4"}).status, 0);
  EXPECT_THAT(cosiva({"simulate", "--plant", "lost-owner"}).standard_error, HasSubstr("needs --handovers"));
}

TEST(SimulateCommand, refuses_a_bad_range_and_an_unknown_defect) {
  EXPECT_EQ(cosiva({"simulate", "--seeds", "9..3"}).status, 2);
  EXPECT_EQ(cosiva({"simulate", "--seeds", "x"}).status, 2);
  EXPECT_THAT(cosiva({"simulate", "--plant", "gremlin"}).standard_error, HasSubstr("there is no defect 'gremlin'"));
}

}  // namespace
}  // namespace cosiva::app
