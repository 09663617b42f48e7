#include "cosiva/experiments/faults/command_ledger.h"

#include <gtest/gtest.h>

namespace cosiva::experiments {
namespace {

const std::string stop = R"({"command":"stop","vehicle":"CoSiVA/AIV1"})";
const std::string slow = R"({"command":"slow","vehicle":"CoSiVA/AIV1"})";

TEST(CommandLedger, finds_an_accepted_stop_that_a_restart_has_lost) {
  const SimulatedStore store{1, Planted::none};
  CommandLedger ledger{store};
  ledger.on_submitted(stop);
  EXPECT_FALSE(ledger.on_given(stop, false));
  EXPECT_FALSE(ledger.on_decided(stop, true));
  EXPECT_TRUE(ledger.state().stopped("CoSiVA/AIV1"));
  ledger.on_killed();
  const Finding found = ledger.on_start({});
  ASSERT_TRUE(found);
  EXPECT_EQ(found->invariant, "I2");
}

TEST(CommandLedger, permits_a_stop_without_a_response_to_be_lost) {
  const SimulatedStore store{1, Planted::none};
  CommandLedger ledger{store};
  ledger.on_submitted(stop);
  EXPECT_FALSE(ledger.on_given(stop, false));
  ledger.on_killed();
  EXPECT_FALSE(ledger.on_start({}));
  EXPECT_FALSE(ledger.state().stopped("CoSiVA/AIV1"));
}

TEST(CommandLedger, finds_a_command_given_twice_and_one_given_before_it_is_durable) {
  const SimulatedStore store{1, Planted::none};
  CommandLedger ledger{store};
  ledger.on_submitted(slow);
  const Finding early = ledger.on_given(slow, true);
  ASSERT_TRUE(early);
  EXPECT_EQ(early->invariant, "I5");
  const Finding again = ledger.on_given(slow, true);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->invariant, "I2");
}

TEST(CommandLedger, finds_a_persisted_state_that_does_not_follow_from_the_commands) {
  const SimulatedStore store{1, Planted::none};
  CommandLedger ledger{store};
  ledger.on_submitted(stop);
  EXPECT_FALSE(ledger.on_given(stop, false));
  EXPECT_FALSE(ledger.on_persisted(R"({"intentions":{"all":{},"vehicles":{"CoSiVA/AIV1":{"stopped":true}}}})"));
  const Finding found = ledger.on_persisted(R"({"intentions":{"all":{},"vehicles":{}}})");
  ASSERT_TRUE(found);
  EXPECT_EQ(found->invariant, "I1");
}

TEST(CommandLedger, finds_a_virtual_aiv_that_was_lost_and_one_that_comes_back) {
  const std::string add = R"({"command":"add","virtualObject":{"id":"V1","kind":"aiv","section":"a","s":0.3}})";
  const std::string remove = R"({"command":"remove","id":"V1"})";
  const std::string with = R"({"aivs":[{"id":"V1","section":"a","s":0.3}]})";
  const std::string without = R"({"aivs":[]})";
  const SimulatedStore store{1, Planted::none};
  CommandLedger ledger{store};
  ledger.on_submitted(add);
  EXPECT_FALSE(ledger.on_given(add, false));
  EXPECT_FALSE(ledger.on_persisted(without)) << "there is no room for it yet";
  EXPECT_FALSE(ledger.on_persisted(with));
  Finding lost = ledger.on_persisted(without);
  ASSERT_TRUE(lost);
  EXPECT_EQ(lost->invariant, "I2");
  ledger.on_submitted(remove);
  EXPECT_FALSE(ledger.on_given(remove, false));
  EXPECT_FALSE(ledger.on_persisted(without));
  const Finding back = ledger.on_persisted(with);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->invariant, "I2");
}

TEST(CommandLedger, permits_a_virtual_aiv_to_be_removed_by_a_durable_command_that_the_restarted_server_is_given) {
  const std::string add = R"({"command":"add","virtualObject":{"id":"V1","kind":"aiv","section":"a","s":0.3}})";
  const std::string remove = R"({"command":"remove","id":"V1"})";
  const std::string with = R"({"aivs":[{"id":"V1","section":"a","s":0.3}]})";
  SimulatedStore store{1, Planted::none};
  ASSERT_TRUE(store.open());
  store.propose({}, {{}, wire::InputKind::proposal, "http", remove, false}, [](const Result<void>&) {});
  for (auto due = store.next_due(); due; due = store.next_due()) store.work(*due);
  CommandLedger ledger{store};
  ledger.on_submitted(add);
  EXPECT_FALSE(ledger.on_given(add, false));
  EXPECT_FALSE(ledger.on_persisted(with));
  ledger.on_submitted(remove);
  ledger.on_killed();
  EXPECT_FALSE(ledger.on_start({with, {{{}, wire::InputKind::command, "http", remove, true}}}));
}

TEST(CommandLedger, finds_a_virtual_aiv_that_a_restart_has_lost) {
  const std::string add = R"({"command":"add","virtualObject":{"id":"V1","kind":"aiv","section":"a","s":0.3}})";
  const SimulatedStore store{1, Planted::none};
  CommandLedger ledger{store};
  ledger.on_submitted(add);
  EXPECT_FALSE(ledger.on_given(add, false));
  EXPECT_FALSE(ledger.on_persisted(R"({"aivs":[{"id":"V1","section":"a","s":0.3}]})"));
  ledger.on_killed();
  const Finding found = ledger.on_start({});
  ASSERT_TRUE(found);
  EXPECT_EQ(found->text, "virtual AIV V1 is not in the zone any more, although it was not removed");
}

}  // namespace
}  // namespace cosiva::experiments
