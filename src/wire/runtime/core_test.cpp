#include "cosiva/wire/runtime/core.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>

namespace cosiva::wire {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;

TEST(TopicFilter, matches_level_by_level) {
  EXPECT_TRUE(topic_matches("a/b/c", "a/b/c"));
  EXPECT_FALSE(topic_matches("a/b/c", "a/b"));
  EXPECT_FALSE(topic_matches("a/b", "a/b/c"));
  EXPECT_FALSE(topic_matches("a/b", "a/bb"));
  EXPECT_FALSE(topic_matches("", "a"));
}

TEST(TopicFilter, plus_matches_exactly_one_level_even_an_empty_one) {
  EXPECT_TRUE(topic_matches("uagv/+/+/+/state", "uagv/v2/CoSiVA/1/state"));
  EXPECT_FALSE(topic_matches("uagv/+/+/state", "uagv/v2/CoSiVA/1/state"));
  EXPECT_TRUE(topic_matches("a/+", "a/"));
  EXPECT_FALSE(topic_matches("a/+", "a"));
  EXPECT_TRUE(topic_matches("+/+", "/finance"));
  EXPECT_FALSE(topic_matches("+", "/finance"));
}

TEST(TopicFilter, hash_matches_the_rest_and_its_parent) {
  EXPECT_TRUE(topic_matches("#", "a/b/c"));
  EXPECT_TRUE(topic_matches("sport/tennis/#", "sport/tennis/player1/ranking"));
  EXPECT_TRUE(topic_matches("sport/#", "sport"));
  EXPECT_FALSE(topic_matches("sport/tennis/#", "sport"));
  EXPECT_FALSE(topic_matches("sport/#", "sports"));
}

/// Responds to each message with its payload, and counts its inputs.
class EchoCore final : public Core {
 public:
  void handle(const Input& input, Effects& effects) override {
    ++reported;
    if (input.kind == InputKind::message) effects.push_back(Publish{"echo", input.payload, 0, false});
    if (input.kind == InputKind::tick) effects.push_back(Log{'i', "tick"});
    recorded_then = recorded;
  }
  [[nodiscard]] SimDuration tick_period() const override { return 100ms; }
  [[nodiscard]] std::vector<std::string> subscriptions() const override { return {}; }
  void fold(Digest& digest) const override { digest.add(reported); }

  std::uint64_t reported{0};
  int recorded{0};
  int recorded_then{0};
};

Input message(SimDuration at, std::string payload) {
  return {SimTime{at}, InputKind::message, "topic", std::move(payload), false};
}

TEST(CoreRunner, records_an_input_before_the_core_acts_on_it) {
  EchoCore core;
  CoreRunner runner{core, [&](const Input&) { ++core.recorded; }};
  runner.feed(message(1ms, "x"));
  EXPECT_EQ(core.recorded_then, 1);
}

TEST(CoreRunner, hands_out_the_effects_of_the_last_input_only) {
  EchoCore core;
  CoreRunner runner{core};
  EXPECT_THAT(runner.feed(message(1ms, "x")), ElementsAre(Effect{Publish{"echo", "x", 0, false}}));
  EXPECT_THAT(runner.feed(message(2ms, "y")), ElementsAre(Effect{Publish{"echo", "y", 0, false}}));
}

std::string digest_of(const std::vector<Input>& inputs) {
  EchoCore core;
  CoreRunner runner{core};
  for (const Input& input : inputs) runner.feed(input);
  return runner.digest().hex();
}

TEST(RunDigest, is_equal_for_equal_runs) {
  EXPECT_EQ(digest_of({message(1ms, "x"), message(2ms, "y")}), digest_of({message(1ms, "x"), message(2ms, "y")}));
}

TEST(RunDigest, depends_on_order_time_effects_and_the_state_at_the_end) {
  const std::string reference = digest_of({message(1ms, "x"), message(2ms, "y")});
  EXPECT_NE(digest_of({message(1ms, "y"), message(2ms, "x")}), reference);
  EXPECT_NE(digest_of({message(1ms, "x"), message(3ms, "y")}), reference);
  EXPECT_NE(digest_of({message(1ms, "x")}), reference);
  EXPECT_NE(digest_of({}), digest_of({{SimTime{}, InputKind::command, "", "", false}}));
}

TEST(RunDigest, can_be_queried_in_between_without_changing_the_end) {
  EchoCore core;
  CoreRunner runner{core};
  runner.feed(message(1ms, "x"));
  (void)runner.digest();
  runner.feed(message(2ms, "y"));
  EXPECT_EQ(runner.digest().hex(), digest_of({message(1ms, "x"), message(2ms, "y")}));
}

/// Responds once with the given effect.
class OneEffectCore final : public Core {
 public:
  explicit OneEffectCore(Effect effect) : effect_{std::move(effect)} {}
  void handle(const Input&, Effects& effects) override { effects.push_back(effect_); }
  [[nodiscard]] SimDuration tick_period() const override { return 1s; }
  [[nodiscard]] std::vector<std::string> subscriptions() const override { return {}; }
  void fold(Digest&) const override {}

 private:
  Effect effect_;
};

TEST(RunDigest, distinguishes_every_kind_of_effect_and_does_not_read_the_log) {
  const auto digest_with = [](Effect effect) {
    OneEffectCore core{std::move(effect)};
    CoreRunner runner{core};
    runner.feed({SimTime{}, InputKind::tick, "", "", false});
    return runner.digest().hex();
  };
  const std::vector<std::string> digests{
      digest_with(Publish{"a", "b", 0, false}), digest_with(Publish{"a", "b", 1, false}),
      digest_with(Publish{"a", "b", 0, true}),  digest_with(Publish{"ab", "", 0, false}),
      digest_with(SendBytes{"a", "b"}),         digest_with(Persist{"ab"}),
  };
  for (std::size_t i = 0; i < digests.size(); ++i) {
    for (std::size_t k = i + 1; k < digests.size(); ++k) EXPECT_NE(digests[i], digests[k]) << i << " and " << k;
  }
  EXPECT_EQ(digest_with(Log{'i', "one"}), digest_with(Log{'e', "two"}));
}

/// A message as values that folds one number.
struct NumberMessage final : InProcessMessage {
  void fold(Digest& digest) const override { digest.add(std::uint64_t{77}); }
};

TEST(RunDigest, folds_the_time_of_the_input_and_then_the_number_and_the_fields_of_each_effect) {
  const auto digest_with = [](Effect effect) {
    OneEffectCore core{std::move(effect)};
    CoreRunner runner{core};
    runner.feed({SimTime{5ms}, InputKind::tick, "", "", false});
    return runner.digest().hex();
  };
  const auto expected = [](const auto&... parts) {
    Digest digest;
    digest.add(SimTime{5ms});
    (digest.add(parts), ...);
    return digest.hex();
  };
  using Number = std::uint64_t;
  using Text = std::string_view;
  EXPECT_EQ(digest_with(Publish{"topic", "payload", 0, false}),
            expected(Number{1}, Text{"topic"}, Text{"payload"}, Number{0}));
  EXPECT_EQ(digest_with(Publish{"topic", "payload", 1, true}),
            expected(Number{1}, Text{"topic"}, Text{"payload"}, Number{3}));
  EXPECT_EQ(digest_with(Publish{"topic", "", 0, false, std::make_shared<const NumberMessage>()}),
            expected(Number{1}, Text{"topic"}, Text{""}, Number{0}, Number{77}));
  EXPECT_EQ(digest_with(SendBytes{"port", "bytes"}), expected(Number{2}, Text{"port"}, Text{"bytes"}));
  EXPECT_EQ(digest_with(Persist{"bytes"}), expected(Number{3}, Text{"bytes"}));
  EXPECT_EQ(digest_with(Listen{{"a/+", "b"}}), expected(Number{4}, Number{2}, Text{"a/+"}, Text{"b"}));
  EXPECT_EQ(digest_with(Log{'i', "text"}), expected());
}

TEST(CoreRunner, records_an_input_as_values_only_together_with_its_text) {
  EchoCore core;
  CoreRunner recorded{core, [](const Input&) {}};
  CoreRunner unrecorded{core};
  const auto typed = std::make_shared<const NumberMessage>();
  const Input without_text{SimTime{}, InputKind::message, "topic", "", false, typed};
  const Input with_text{SimTime{}, InputKind::message, "topic", "x", false, typed};
  const Input empty{SimTime{}, InputKind::message, "topic", "", false};
  EXPECT_THAT(recorded.feed(with_text), ::testing::SizeIs(1));
  EXPECT_THAT(recorded.feed(empty), ::testing::SizeIs(1));
  EXPECT_THAT(unrecorded.feed(without_text), ::testing::SizeIs(1));
  EXPECT_DEATH(recorded.feed(without_text), "payload");
}

TEST(TopicFilter, distinguishes_an_empty_last_level_from_none) {
  EXPECT_TRUE(topic_matches("a/", "a/"));
  EXPECT_FALSE(topic_matches("a/", "a"));
  EXPECT_FALSE(topic_matches("a", "a/"));
  EXPECT_FALSE(topic_matches("a/b", "a/"));
  EXPECT_TRUE(topic_matches("a//b", "a//b"));
  EXPECT_FALSE(topic_matches("a//b", "a/b"));
  EXPECT_TRUE(topic_matches("a/#", "a/"));
}

TEST(TopicFilter, may_combine_plus_and_hash) {
  EXPECT_TRUE(topic_matches("+/#", "a"));
  EXPECT_TRUE(topic_matches("a/+/#", "a/b"));
  EXPECT_TRUE(topic_matches("a/+/#", "a/b/c/d"));
  EXPECT_FALSE(topic_matches("a/+/#", "a"));
  EXPECT_FALSE(topic_matches("a/+/#", "b/c"));
  EXPECT_FALSE(topic_matches("a/+", "a/b/c"));
  EXPECT_FALSE(topic_matches("+/b", "a/c"));
}

TEST(RunDigest, folds_each_effect_of_an_input_in_order) {
  /// Responds to each input with two effects.
  class TwoEffectsCore final : public Core {
   public:
    void handle(const Input& input, Effects& effects) override {
      effects.push_back(Persist{input.payload});
      effects.push_back(SendBytes{"port", input.payload});
    }
    [[nodiscard]] SimDuration tick_period() const override { return 1s; }
    [[nodiscard]] std::vector<std::string> subscriptions() const override { return {}; }
    void fold(Digest& digest) const override { digest.add(std::uint64_t{5}); }
  };
  TwoEffectsCore core;
  CoreRunner runner{core};
  runner.feed(message(1ms, "x"));
  runner.feed(message(2ms, "y"));
  Digest expected;
  for (const auto& [at, text] : {std::pair{SimTime{1ms}, "x"}, std::pair{SimTime{2ms}, "y"}}) {
    expected.add(at);
    expected.add(std::uint64_t{3});
    expected.add(std::string_view{text});
    expected.add(std::uint64_t{2});
    expected.add(std::string_view{"port"});
    expected.add(std::string_view{text});
  }
  expected.add(std::uint64_t{5});
  EXPECT_EQ(runner.digest().hex(), expected.hex());
}

}  // namespace
}  // namespace cosiva::wire
