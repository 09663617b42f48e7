#include "cosiva/experiments/positioning/campaign/state.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <limits>

#include "cosiva/experiments/positioning/campaign/test_campaign.h"

namespace cosiva::experiments {
namespace {

using ::testing::HasSubstr;
using testing::small_plan;
using testing::work_of;

const CampaignWork& work() {
  static const CampaignWork one = work_of(small_plan);
  return one;
}

UnitRecord record_of(std::size_t unit) {
  auto record = work().done(unit);
  EXPECT_TRUE(record);
  return std::move(*record);
}

TEST(CampaignState, reads_back_to_the_same_bits) {
  UnitRecord record = record_of(4);
  record.votes[0].nees = std::numeric_limits<double>::quiet_NaN();
  record.votes[1].mse_m2 = 5e-324;
  record.votes[2].mean_m = -0.0;
  const auto state = read_state(state_header(work()) + state_line(record), work(), "state");
  ASSERT_TRUE(state) << to_string(state.error());
  ASSERT_EQ(state->records.size(), 1U);
  EXPECT_EQ(state->records[0].unit, 4U);
  EXPECT_TRUE(std::isnan(state->records[0].votes[0].nees));
  EXPECT_EQ(state->records[0].votes[1].mse_m2, 5e-324);
  EXPECT_EQ(state_line(state->records[0]), state_line(record));
}

TEST(CampaignState, tolerates_a_torn_last_line) {
  const std::string whole = state_header(work()) + state_line(record_of(0));
  const std::string line = state_line(record_of(1));
  for (std::size_t bytes = 0; bytes < line.size(); ++bytes) {
    const auto state = read_state(whole + line.substr(0, bytes), work(), "state");
    ASSERT_TRUE(state) << to_string(state.error());
    EXPECT_EQ(state->records.size(), 1U) << bytes;
    EXPECT_EQ(state->torn, bytes > 0);
    EXPECT_EQ(state->whole_bytes, whole.size());
  }
  for (std::size_t bytes = 0; bytes < state_header(work()).size(); ++bytes) {
    const auto state = read_state(whole.substr(0, bytes), work(), "state");
    ASSERT_TRUE(state) << bytes;
    EXPECT_TRUE(state->records.empty());
    EXPECT_EQ(state->whole_bytes, 0U);
  }
}

TEST(CampaignState, refuses_damage_before_its_end_with_advice) {
  std::string text = state_header(work()) + state_line(record_of(0)) + state_line(record_of(1));
  const std::size_t at = state_header(work()).size() + 12;
  text[at] = text[at] == '7' ? '8' : '7';
  const auto state = read_state(text, work(), "out/campaign.state");
  ASSERT_FALSE(state);
  EXPECT_EQ(state.error().code, "campaign.state");
  EXPECT_EQ(state.error().location, "out/campaign.state:2");
  EXPECT_THAT(state.error().message, HasSubstr("--anew"));
}

TEST(CampaignState, refuses_the_state_of_another_plan_and_other_texts) {
  const auto other = read_state(state_header(work_of("seed = 9\n" + small_plan)), work(), "state");
  ASSERT_FALSE(other);
  EXPECT_THAT(other.error().message, HasSubstr("another plan"));
  EXPECT_THAT(other.error().message, HasSubstr("--anew"));
  const auto none = read_state("a shopping list\n", work(), "state");
  ASSERT_FALSE(none);
  EXPECT_THAT(none.error().message, HasSubstr("no campaign's state"));
}

TEST(CampaignState, is_never_read_from_a_changed_text) {
  const std::string good = state_header(work()) + state_line(record_of(0)) + state_line(record_of(1));
  EXPECT_TRUE(rc::check("a byte changed, anywhere", [&] {
    std::string text = good;
    const auto at = *rc::gen::inRange<std::size_t>(0, text.size());
    text[at] = static_cast<char>(*rc::gen::inRange(0, 256));
    const auto state = read_state(text, work(), "state");
    if (!state) return;
    for (const UnitRecord& record : state->records) RC_ASSERT(good.find(state_line(record)) != std::string::npos);
  }));
}

}  // namespace
}  // namespace cosiva::experiments
