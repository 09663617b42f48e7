#include "cosiva/experiments/faults/simulated_store.h"

#include <gtest/gtest.h>

namespace cosiva::experiments {
namespace {

using namespace std::chrono_literals;

const std::string stop = R"({"command":"stop","vehicle":"CoSiVA/AIV1"})";
const std::string slow = R"({"command":"slow","vehicle":"CoSiVA/AIV1"})";

wire::Input input(wire::InputKind kind, const std::string& text, bool flag = false) {
  return {SimTime{}, kind, "http", text, flag};
}

/// An open store, and the decisions of its proposals.
struct Fixture {
  explicit Fixture(Planted planted = Planted::none) : store{1, planted} { EXPECT_TRUE(store.open()); }

  void propose(const std::string& text) {
    store.propose(now, input(wire::InputKind::proposal, text),
                  [this](const Result<void>& decided) { decisions.push_back(decided.has_value()); });
  }
  void run_for(SimDuration time) {
    const SimTime end = now + time;
    for (auto due = store.next_due(); due && *due <= end; due = store.next_due()) {
      now = *due;
      store.work(now);
    }
    now = end;
  }
  CoreStore::Left restart(bool power) {
    store.on_killed();
    if (power) store.cut_power();
    EXPECT_TRUE(store.open());
    return store.left();
  }

  SimTime now{};
  SimulatedStore store;
  std::vector<bool> decisions;
};

TEST(SimulatedStore, decides_a_proposal_when_its_write_has_ended) {
  Fixture fixture;
  fixture.propose(slow);
  EXPECT_TRUE(fixture.decisions.empty());
  fixture.run_for(10ms);
  EXPECT_EQ(fixture.decisions, std::vector{true});
  EXPECT_EQ(fixture.store.durable_proposals().at(slow), 1U);
}

TEST(SimulatedStore, has_an_accepted_command_after_a_power_cut_and_gives_it_once) {
  Fixture fixture;
  fixture.propose(slow);
  fixture.run_for(10ms);
  const auto left = fixture.restart(true);
  ASSERT_EQ(left.accepted.size(), 1U);
  EXPECT_EQ(left.accepted.front().payload, slow);
  fixture.store.append(fixture.now, input(wire::InputKind::command, slow, true));
  fixture.store.append(fixture.now, input(wire::InputKind::persisted, "{}"));
  fixture.run_for(30ms);
  EXPECT_TRUE(fixture.restart(true).accepted.empty());
  EXPECT_FALSE(fixture.store.violation());
}

TEST(SimulatedStore, has_an_accepted_command_after_a_power_cut_at_any_call_of_its_opening) {
  int failed = 0;
  for (std::uint64_t call = 1; call <= 20; ++call) {
    Fixture fixture;
    fixture.propose(slow);
    fixture.run_for(10ms);
    fixture.store.on_killed();
    fixture.store.at_call(call, {});
    if (!fixture.store.open()) {
      ++failed;
      ASSERT_TRUE(fixture.store.open()) << "power is back; call " << call;
    }
    EXPECT_EQ(fixture.store.left().accepted.size(), 1U) << "call " << call;
    EXPECT_FALSE(fixture.store.violation()) << *fixture.store.violation();
  }
  EXPECT_GE(failed, 3) << "an opening lists the files, reads the last one, and replaces it";
  EXPECT_LT(failed, 20);
}

TEST(SimulatedStore, loses_what_waited_for_less_than_a_commit_period) {
  Fixture fixture;
  fixture.store.append(fixture.now, input(wire::InputKind::persisted, "{}"));
  fixture.run_for(5ms);
  EXPECT_FALSE(fixture.restart(false).persisted);
  fixture.store.append(fixture.now, input(wire::InputKind::persisted, "{}"));
  fixture.run_for(20ms);
  EXPECT_EQ(fixture.restart(true).persisted, "{}");
}

TEST(SimulatedStore, refuses_proposals_while_the_disk_refuses_and_writes_the_records_later) {
  Fixture fixture;
  fixture.store.set_refusal("disk.full", 1);
  fixture.store.append(fixture.now, input(wire::InputKind::persisted, "{}"));
  fixture.propose(slow);
  fixture.run_for(1s);
  EXPECT_EQ(fixture.decisions, std::vector{false});
  EXPECT_GT(fixture.store.waiting_bytes(), 0U);
  fixture.store.set_refusal({}, 1);
  fixture.run_for(1s);
  EXPECT_EQ(fixture.store.waiting_bytes(), 0U);
  const auto left = fixture.restart(true);
  EXPECT_EQ(left.persisted, "{}");
  EXPECT_TRUE(left.accepted.empty());
}

TEST(SimulatedStore, reports_a_confirmed_record_that_a_failed_sync_has_lost) {
  bool found = false;
  for (int attempt = 0; attempt < 20 && !found; ++attempt) {
    Fixture fixture{Planted::failed_sync};
    fixture.propose(stop);
    fixture.run_for(10ms);
    fixture.store.set_refusal("disk.io", 1);
    for (int i = 0; i <= attempt; ++i) fixture.propose(slow);
    fixture.run_for(10ms);
    fixture.store.set_refusal({}, 1);
    fixture.restart(true);
    found = fixture.store.violation().has_value();
  }
  EXPECT_TRUE(found);
}

}  // namespace
}  // namespace cosiva::experiments
