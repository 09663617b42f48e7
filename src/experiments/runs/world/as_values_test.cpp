// Messages passed on as values: the same run as with texts, to the last bit.
#include <gtest/gtest.h>

#include "cosiva/experiments/runs/world/test_world.h"
#include "cosiva/wire/in_process/typed_message.h"

namespace cosiva::experiments {
namespace {

using namespace std::chrono_literals;

std::unique_ptr<World> world(bool as_values, double loss = 0.0) {
  WorldOptions options;
  options.zone = testing::zone_named("lacet4");
  options.aivs = 5;
  options.seed = 4;
  options.network.loss = loss;
  options.network.duplication = loss;
  options.as_values = as_values;
  auto made = World::make(std::move(options));
  EXPECT_TRUE(made.has_value()) << (made ? "" : to_string(made.error()));
  return std::move(*made);
}

/// A run with all kinds of events: a person, a virtual AIV, a stop, a vehicle that dies and is restarted.
void live(World& world) {
  world.run_for(15s);
  world.command_server(R"({"command":"add","virtualObject":{"id":"V1","kind":"aiv","x":0.0,"y":0.0}})");
  world.command_server(R"({"id":"c1","command":"stop","vehicle":"CoSiVA/AIV2"})");
  world.command_plant(R"({"addObstacle":{"id":"box","x":0.5,"y":0.9,"radius":0.05}})");
  world.run_for(10s);
  world.command_server(R"({"id":"c2","command":"restart","vehicle":"CoSiVA/AIV2"})");
  world.command_plant(R"({"removeObstacle":"box"})");
  world.kill_aiv(3);
  world.run_for(5s);
  world.start_aiv(3);
  world.run_for(20s);
}

TEST(AsValues, all_estimates_are_equal_to_the_last_bit) {
  for (const double loss : {0.0, 0.03}) {
    const auto texts = world(false, loss);
    const auto values = world(true, loss);
    live(*texts);
    live(*values);
    EXPECT_EQ(values->estimates().hex(), texts->estimates().hex()) << "with a loss of " << loss;
    EXPECT_EQ(values->network().counters().delivered, texts->network().counters().delivered);
    EXPECT_EQ(values->log(), texts->log());
  }
}

TEST(AsValues, frequent_messages_have_no_text_and_state_their_kind) {
  const auto values = world(true);
  std::size_t passed = 0;
  values->tap([&](SimTime, const std::string&, const wire::Publish& message) {
    const bool often = message.topic.ends_with("/state") || message.topic.ends_with("/visualization");
    EXPECT_TRUE(message.typed || !often) << message.topic;
    if (!message.typed) return;
    EXPECT_TRUE(message.payload.empty()) << message.topic;
    ++passed;
  });
  values->run_for(5s);
  EXPECT_GT(passed, 200U);
}

TEST(AsValues, another_seed_gives_another_run) {
  const auto run = [](std::uint64_t seed) {
    WorldOptions options;
    options.zone = testing::zone_named("lacet4");
    options.aivs = 3;
    options.seed = seed;
    options.as_values = true;
    auto made = World::make(std::move(options));
    EXPECT_TRUE(made.has_value());
    (*made)->run_for(10s);
    return std::pair{(*made)->digest().hex(), (*made)->estimates().hex()};
  };
  EXPECT_EQ(run(7), run(7));
  EXPECT_NE(run(7).first, run(8).first);
  EXPECT_NE(run(7).second, run(8).second);
}

TEST(PassesValues, is_false_for_one_seed_in_ten) {
  std::size_t with_texts = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) with_texts += passes_values(seed) ? 0U : 1U;
  EXPECT_EQ(with_texts, 10U);
  EXPECT_TRUE(passes_values(1)) << "the default";
}

}  // namespace
}  // namespace cosiva::experiments
