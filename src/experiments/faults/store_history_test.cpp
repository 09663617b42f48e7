#include "cosiva/experiments/faults/store_history.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cosiva::experiments {
namespace {

using ::testing::HasSubstr;

wire::Input proposal(const std::string& text) { return {SimTime{}, wire::InputKind::proposal, "http", text, false}; }

/// Two confirmed records, a and b.
StoreHistory confirmed_ab() {
  StoreHistory history;
  history.on_write({proposal("a"), proposal("b")});
  history.on_confirmed();
  return history;
}

TEST(StoreHistory, accepts_exactly_the_confirmed_records) {
  StoreHistory history = confirmed_ab();
  EXPECT_FALSE(history.on_recovered(1, {proposal("a"), proposal("b")}));
  EXPECT_EQ(history.next(), 3U);
}

TEST(StoreHistory, reports_a_lost_and_a_changed_record) {
  StoreHistory lost = confirmed_ab();
  EXPECT_THAT(lost.on_recovered(1, {proposal("a")}).value_or(""), HasSubstr("1 of 2 confirmed records"));
  StoreHistory changed = confirmed_ab();
  EXPECT_THAT(changed.on_recovered(1, {proposal("a"), proposal("x")}).value_or(""), HasSubstr("record 2 is not"));
}

TEST(StoreHistory, accepts_an_unconfirmed_write_only_as_a_whole) {
  const auto recovered = [](const std::vector<wire::Input>& records) {
    StoreHistory history = confirmed_ab();
    history.on_write({proposal("c"), proposal("d")});
    return history.on_recovered(1, records).has_value();
  };
  EXPECT_FALSE(recovered({proposal("a"), proposal("b")}));
  EXPECT_FALSE(recovered({proposal("a"), proposal("b"), proposal("c"), proposal("d")}));
  EXPECT_TRUE(recovered({proposal("a"), proposal("b"), proposal("c")}));
}

TEST(StoreHistory, accepts_a_compacted_store_and_counts_its_proposals_on) {
  StoreHistory history = confirmed_ab();
  EXPECT_FALSE(history.on_recovered(2, {proposal("b")}));
  history.on_write({proposal("b")});
  history.on_confirmed();
  EXPECT_EQ(history.proposals().at("b"), 2U);
  EXPECT_EQ(history.proposals().at("a"), 1U);
  EXPECT_EQ(history.next(), 4U);
}

}  // namespace
}  // namespace cosiva::experiments
