// Hostile messages through the whole platform in operation: a million of them by default.
//
//   hostile_messages ZONE.toml CORPUS_DIR [messages=1000000] [seed=1]
//
// An unknown sender on the broker publishes mutated VDA 5050 messages, garbage and oversized payloads on the topics of
// real and of invented vehicles, and broken zones, while four AIVs drive in virtual time. Nothing may stop: no
// collision, every vehicle goes on, every real twin stays matched. Prints what was sent and the run's digest; exit 1
// when a condition was violated.

#include <algorithm>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/base/json_value.h"
#include "cosiva/base/random.h"
#include "cosiva/experiments/runs/world/world.h"
#include "cosiva/wire/messages/topics.h"
#include "e2e/soak.h"
#include "fuzz/corpus.h"
#include "fuzz/mutate.h"

namespace {

using namespace cosiva;
using namespace std::chrono_literals;

constexpr std::uint32_t aivs = 4;
constexpr std::uint64_t burst = 200;  ///< messages between two steps of 100 ms: 2 000 a second

class UnknownSender {
 public:
  UnknownSender(std::uint64_t seed, std::vector<std::string> corpus)
      : random_{seed, "stranger"}, mutator_{seed, std::move(corpus), 1U << 18U} {}

  wire::Publish next() {
    wire::Publish message;
    message.topic = topic();
    if (random_.chance(0.0005))
      message.payload = std::string(300'000, '[');
    else
      message.payload = mutator_.next();
    return message;
  }

 private:
  std::string topic() {
    static constexpr const char* kinds[] = {"state",     "visualization", "connection",
                                            "factsheet", "order",         "instantActions"};
    const auto kind = random_.below(100);
    if (kind == 0) return std::string(wire::zone_topic_prefix) + "toml";
    if (kind == 1) return "uagv/v2/a/b/c/d/state";
    if (kind == 2) return "uagv/v2//x/state";
    const bool real = random_.chance(0.5);
    const wire::VehicleId id{real ? std::string(wire::our_manufacturer) : "Stranger" + std::to_string(random_.below(4)),
                             "AIV" + std::to_string(1 + random_.below(real ? aivs : 16))};
    return wire::vda_topic(id, kinds[random_.below(6)]);
  }

  Random random_;
  fuzz::Mutator mutator_;
};

/// The number of real vehicles that are shown online and near their ground truth.
std::size_t true_twins(const experiments::World& world) {
  const auto snapshot = JsonValue::parse(world.server().snapshot_json());
  std::size_t count = 0;
  for (const auto& aiv : *snapshot->find("aivs")->array()) {
    for (const auto& ground_truth : world.plant().vehicles()) {
      if (aiv.text("id") != "CoSiVA/AIV" + std::to_string(ground_truth.number)) continue;
      const double off_m = norm(aiv.number("x").value_or(1e9) - ground_truth.X_MB.x_m,
                                aiv.number("y").value_or(1e9) - ground_truth.X_MB.y_m);
      if (aiv.text("connection") == "ONLINE" && off_m < 0.10) ++count;
    }
  }
  return count;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "usage: hostile_messages ZONE.toml CORPUS_DIR [messages] [seed]\n");
    return 2;
  }
  std::uint64_t messages = 1'000'000;
  std::uint64_t seed = 1;
  soak::Arguments arguments{argc, argv, 3};
  arguments.take(messages);
  arguments.take(seed);
  auto corpus = fuzz::read_corpus(argv[2]);
  if (corpus.empty()) {
    std::fprintf(stderr, "hostile_messages: no corpus in %s\n", argv[2]);
    return 2;
  }
  soak::Plan plan;
  plan.zone = soak::toml_zone(argv[1]);
  plan.aivs = aivs;
  auto world = soak::make_world(plan, seed);
  if (!world) {
    std::fprintf(stderr, "hostile_messages: %s\n", to_string(world.error()).c_str());
    return 2;
  }
  (*world)->run_for(5s);

  UnknownSender unknown_sender{seed, std::move(corpus)};
  std::uint64_t sent = 0;
  std::size_t steps = 0;
  std::size_t steps_matched = 0;
  while (sent < messages) {
    for (std::uint64_t i = 0; i < burst && sent < messages; ++i, ++sent)
      (*world)->faults().publish_from_outside(unknown_sender.next());
    (*world)->run_for(100ms);
    ++steps;
    if (true_twins(**world) == aivs) ++steps_matched;
  }

  const double slowest_m = std::ranges::min(soak::driven_m(**world));
  const double seconds = to_seconds((*world)->now() - virtual_epoch);
  std::printf(
      "%llu hostile messages in %.0f s: %zu collisions, slowest vehicle drove %.1f m, real twins correct in %zu of %zu "
      "checks, digest %s\n",
      static_cast<unsigned long long>(sent), seconds, (*world)->plant().collisions().size(), slowest_m, steps_matched,
      steps, (*world)->digest().hex().c_str());
  // Undisturbed, a vehicle averages about 0.3 m/s here, waiting included; half of it shows that nothing stopped.
  const bool kept =
      (*world)->plant().collisions().empty() && slowest_m > 0.12 * seconds - 2.0 && steps_matched == steps;
  return kept ? 0 : 1;
}
