#include "cosiva/journal/store/restart.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cosiva::journal {
namespace {

using wire::InputKind;

/// A restart from the records of these inputs.
Restart restart_from(const std::vector<wire::Input>& inputs) {
  Restart restart;
  RecordNumber number = 0;
  for (const wire::Input& input : inputs) {
    std::string bytes;
    append_record(bytes, input);
    restart.take(++number, front_record(bytes).value().value());
  }
  return restart;
}

wire::Input proposal(std::string command) { return {{}, InputKind::proposal, "http", std::move(command), false}; }
wire::Input given(std::string command) { return {{}, InputKind::command, "http", std::move(command), true}; }
wire::Input persisted(std::string state) { return {{}, InputKind::persisted, {}, std::move(state), false}; }
wire::Input checkpoint(std::string state) { return {{}, InputKind::persisted, {}, std::move(state), true}; }

std::vector<std::string> accepted(const Restart& restart) {
  std::vector<std::string> commands;
  for (const wire::Input& input : restart.accepted()) commands.push_back(input.payload);
  return commands;
}

TEST(Restart, continues_with_the_state_persisted_last) {
  EXPECT_EQ(restart_from({}).persisted(), std::nullopt);
  EXPECT_EQ(restart_from({persisted("first"), persisted("second"), given("later")}).persisted(), "second");
}

TEST(Restart, gives_the_accepted_commands_that_the_core_was_not_given_in_their_order) {
  const Restart restart = restart_from({proposal("a"), proposal("b"), given("a"), proposal("c"), persisted("s")});
  EXPECT_THAT(accepted(restart), testing::ElementsAre("b", "c"));
}

TEST(Restart, takes_a_stop_that_preceded_its_record_for_no_accepted_command) {
  const wire::Input stop{{}, InputKind::command, "http", "stop", false};
  EXPECT_THAT(accepted(restart_from({proposal("a"), stop})), testing::ElementsAre("a"));
}

TEST(Restart, from_a_checkpoint_on_ignores_commands_that_were_accepted_before_it) {
  EXPECT_THAT(accepted(restart_from({checkpoint("s"), given("accepted before"), proposal("a")})),
              testing::ElementsAre("a"));
}

wire::Input tick(int second) { return {SimTime{std::chrono::seconds{second}}, InputKind::tick, {}, {}, false}; }
wire::Input configure() { return {{}, InputKind::configure, "server", "{}", false}; }

TEST(Restart, gives_all_inputs_of_a_core_from_its_beginning_on) {
  const Restart restart = restart_from({configure(), tick(1), persisted("s"), proposal("a"), given("a")});
  EXPECT_EQ(restart.state(), std::nullopt);
  EXPECT_THAT(restart.inputs(), testing::ElementsAre(configure(), tick(1), given("a")));
}

TEST(Restart, gives_the_last_snapshot_and_the_inputs_after_it) {
  const CoreState state{"bytes", 5, {"#"}};
  const Restart restart = restart_from(
      {configure(), tick(1), to_input({"old", 4, {}}, {}), tick(2), to_input(state, {}), checkpoint("s"), tick(3)});
  EXPECT_EQ(restart.state(), state);
  EXPECT_THAT(restart.inputs(), testing::ElementsAre(tick(3)));
}

TEST(Restart, forgets_the_state_of_a_core_that_another_one_has_not_continued) {
  const Restart restart = restart_from({to_input({"old", 4, {}}, {}), tick(1), configure(), tick(2)});
  EXPECT_EQ(restart.state(), std::nullopt);
  EXPECT_THAT(restart.inputs(), testing::ElementsAre(configure(), tick(2)));
}

TEST(Restart, gives_no_inputs_where_the_first_ones_are_missing) {
  EXPECT_THAT(restart_from({checkpoint("s"), tick(1)}).inputs(), testing::IsEmpty());
}

TEST(Restart, names_the_last_checkpoint) {
  EXPECT_EQ(restart_from({persisted("s")}).checkpoint(), std::nullopt);
  EXPECT_EQ(restart_from({checkpoint("s"), persisted("t"), checkpoint("t"), given("a")}).checkpoint(), 3U);
}

TEST(Restart, takes_an_empty_checkpoint_for_a_core_that_has_persisted_nothing) {
  const Restart restart = restart_from({checkpoint("")});
  EXPECT_EQ(restart.persisted(), std::nullopt);
  EXPECT_EQ(restart.checkpoint(), 1U);
}

}  // namespace
}  // namespace cosiva::journal
