// A server that continues from a snapshot is the server that made it: the same effects to the same inputs.
#include "cosiva/experiments/runs/continuation/continued_server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <deque>
#include <string>

#include "cosiva/base/digest.h"
#include "cosiva/base/random.h"
#include "cosiva/experiments/runs/continuation/test_disturbed_run.h"
#include "cosiva/zone/generate/grid.h"

namespace cosiva::experiments {
namespace {

using namespace std::chrono_literals;
using testing::DisturbedRun;

std::string digest_of(const virtual_side::ServerCore& server) {
  Digest digest;
  server.fold(digest);
  return digest.hex();
}

std::string snapshot_of(const virtual_side::ServerCore& server) {
  const auto snapshot = server.snapshot();
  EXPECT_TRUE(snapshot.has_value()) << to_string(snapshot.error());
  return snapshot.value_or("");
}

/// Compares without writing megabytes where they differ.
void expect_same_bytes(const std::string& a, const std::string& b, const std::string& when) {
  if (a == b) return;
  const auto differ = std::mismatch(a.begin(), a.end(), b.begin(), b.end());
  ADD_FAILURE() << when << ": snapshots of " << a.size() << " and " << b.size() << " bytes differ from byte "
                << differ.first - a.begin();
}

/// The continued servers of a run, and what each of them began with.
class Continuations {
 public:
  explicit Continuations(DisturbedRun& run) : run_{run} {
    run.world->observe_server([this](const wire::Input& input, const wire::Effects& effects) {
      for (Continuation& continuation : all_) continuation.server.feed(input, effects);
    });
  }

  void begin() {
    const std::string snapshot = snapshot_of(run_.world->server());
    auto server = ContinuedServer::from(run_.server_options, snapshot, Digest{});
    ASSERT_TRUE(server.has_value()) << "after " << run_.elapsed_s << " s: " << to_string(server.error());
    expect_same_bytes(snapshot, snapshot_of(server->server()), "after " + std::to_string(run_.elapsed_s) + " s");
    EXPECT_EQ(digest_of(run_.world->server()), digest_of(server->server()));
    all_.push_back({run_.elapsed_s, std::move(*server)});
  }

  /// Ends those that have continued for at least `lasted_s`.
  void end(int lasted_s) {
    while (!all_.empty() && run_.elapsed_s - all_.front().since_s >= lasted_s) {
      const ContinuedServer& server = all_.front().server;
      const std::string when = "from " + std::to_string(all_.front().since_s) + " to " + std::to_string(run_.elapsed_s);
      EXPECT_EQ(server.difference().value_or(""), "") << when;
      EXPECT_GT(server.inputs(), 1000U) << when;
      EXPECT_EQ(digest_of(server.server()), digest_of(run_.world->server())) << when;
      expect_same_bytes(snapshot_of(server.server()), snapshot_of(run_.world->server()), when);
      EXPECT_EQ(server.server().snapshot_json(), run_.world->server().snapshot_json()) << when;
      EXPECT_EQ(server.server().summary_json(), run_.world->server().summary_json()) << when;
      all_.pop_front();
      ++ended_;
    }
  }
  [[nodiscard]] int ended() const { return ended_; }

 private:
  struct Continuation {
    int since_s;
    ContinuedServer server;
  };
  DisturbedRun& run_;
  std::deque<Continuation> all_;
  int ended_{0};
};

class ContinuedServerRun : public ::testing::TestWithParam<std::pair<std::uint64_t, bool>> {};

TEST_P(ContinuedServerRun, has_the_effects_and_the_state_of_the_server_that_made_its_snapshot) {
  const auto [seed, as_values] = GetParam();
  DisturbedRun run{seed, as_values};
  Continuations continuations{run};
  Random random{seed, "moments"};
  int next_s = 1;
  while (run.elapsed_s < DisturbedRun::length_s) {
    if (run.elapsed_s >= next_s && run.elapsed_s < DisturbedRun::length_s - 30) {
      run.world->run_for(std::chrono::milliseconds{random.below(1000)});
      ASSERT_NO_FATAL_FAILURE(continuations.begin());
      next_s += 4 + static_cast<int>(random.below(10));
    }
    run.second();
    continuations.end(30);
    if (HasFailure()) return;
  }
  EXPECT_GE(continuations.ended(), 8);
}

INSTANTIATE_TEST_SUITE_P(Seeds, ContinuedServerRun,
                         ::testing::Values(std::pair{std::uint64_t{1}, false}, std::pair{std::uint64_t{2}, true},
                                           std::pair{std::uint64_t{3}, true}));

TEST(ContinuedServer, has_the_plan_of_the_fleet_on_two_way_tracks) {
  zone::GridOptions grid;
  grid.bays = 4;
  grid.two_way = true;
  WorldOptions options;
  options.zone = {"toml", "grid.toml", *zone::generate_grid(grid)};
  options.aivs = 10;
  options.as_values = true;
  virtual_side::ServerOptions server_options = options.server;
  server_options.as_values = true;
  const auto world = World::make(std::move(options));
  ASSERT_TRUE(world.has_value());
  std::deque<ContinuedServer> continued;
  (*world)->observe_server([&](const wire::Input& input, const wire::Effects& effects) {
    for (ContinuedServer& server : continued) server.feed(input, effects);
  });
  for (int i = 0; i < 5; ++i) {
    (*world)->run_for(17300ms);
    if (i == 2) (*world)->kill_aiv(3);  // it is set aside
    const std::string snapshot = snapshot_of((*world)->server());
    auto server = ContinuedServer::from(server_options, snapshot, Digest{});
    ASSERT_TRUE(server.has_value()) << to_string(server.error());
    expect_same_bytes(snapshot, snapshot_of(server->server()), "snapshot " + std::to_string(i));
    continued.push_back(std::move(*server));
  }
  (*world)->run_for(30s);
  for (const ContinuedServer& server : continued) {
    EXPECT_EQ(server.difference().value_or(""), "");
    expect_same_bytes(snapshot_of(server.server()), snapshot_of((*world)->server()), "at the end");
  }
}

TEST(ContinuedServer, reports_the_first_effect_that_differs) {
  DisturbedRun run{1, false};
  for (int s = 0; s < 3; ++s) run.second();
  auto server = ContinuedServer::from(run.server_options, snapshot_of(run.world->server()), Digest{});
  ASSERT_TRUE(server.has_value());
  server->feed({run.world->now(), wire::InputKind::tick, "", ""}, {});
  const std::string first = server->difference().value_or("");
  EXPECT_THAT(first, ::testing::HasSubstr("input 1 "));
  server->feed({run.world->now(), wire::InputKind::tick, "", ""}, {});
  EXPECT_EQ(server->difference().value_or(""), first);
}

TEST(ContinuedServer, continues_the_digest_of_the_inputs_and_effects_before_its_snapshot) {
  DisturbedRun run{1, false};
  for (int s = 0; s < 2; ++s) run.second();
  const std::string snapshot = snapshot_of(run.world->server());
  Digest history;
  history.add(std::uint64_t{42});
  const auto server = ContinuedServer::from(run.server_options, snapshot, history);
  ASSERT_TRUE(server.has_value());
  Digest expected = history;
  run.world->server().fold(expected);
  EXPECT_EQ(server->digest(), expected);
}

TEST(ServerSnapshot, has_the_layout_of_its_format_number) {
  const auto layout_of = [](std::uint64_t seed, bool as_values, int seconds) {
    DisturbedRun run{seed, as_values};
    while (run.elapsed_s < seconds) run.second();
    Digest digest;
    for (const auto& [type, members] : snapshot_layout(run.world->server())) {
      digest.add(std::string_view{type});
      digest.add(std::string_view{members});
    }
    return digest.hex();
  };
  const std::string layout = layout_of(1, false, 12);
  EXPECT_EQ(layout, virtual_side::ServerCore::snapshot_layout_digest)
      << "The members that a snapshot stores have changed: increase ServerCore::snapshot_format, and set "
         "snapshot_layout_digest to \""
      << layout << '"';
  EXPECT_EQ(layout_of(2, true, 20), layout) << "the layout depends on the state";
}

TEST(ServerSnapshot, of_other_options_is_refused) {
  DisturbedRun run{1, false};
  run.second();
  virtual_side::ServerOptions other = run.server_options;
  other.convoys = !other.convoys;
  const auto server = ContinuedServer::from(other, snapshot_of(run.world->server()), Digest{});
  ASSERT_FALSE(server.has_value());
  EXPECT_EQ(server.error().code, "snapshot.options");
}

TEST(ServerSnapshot, is_refused_by_a_server_that_has_taken_inputs) {
  DisturbedRun run{1, false};
  run.second();
  virtual_side::ServerCore server{run.server_options};
  wire::Effects effects;
  server.handle({run.world->now(), wire::InputKind::tick, "", ""}, effects);
  const std::string before = digest_of(server);
  const auto taken = server.continue_from(snapshot_of(run.world->server()));
  ASSERT_FALSE(taken.has_value());
  EXPECT_EQ(taken.error().code, "snapshot.late");
  EXPECT_EQ(digest_of(server), before);
}

TEST(ServerSnapshot, that_was_truncated_or_changed_leaves_the_server_unused) {
  DisturbedRun run{1, false};
  for (int s = 0; s < 6; ++s) run.second();
  const std::string snapshot = snapshot_of(run.world->server());
  Random random{1, "damage"};
  virtual_side::ServerCore server{run.server_options};
  const std::string unused = digest_of(server);
  for (int i = 0; i < 60; ++i) {
    std::string damaged = snapshot;
    if (i % 3 == 0)
      damaged.resize(random.below(damaged.size()));
    else
      damaged[random.below(i % 3 == 1 ? 100 : damaged.size())] ^= static_cast<char>(1U << random.below(8));
    const auto taken = server.continue_from(damaged);
    ASSERT_FALSE(taken.has_value()) << i;
    EXPECT_EQ(taken.error().code, "snapshot.damaged") << i;
    EXPECT_FALSE(taken.error().message.empty());
    ASSERT_EQ(digest_of(server), unused) << i;
  }
  EXPECT_TRUE(server.continue_from(snapshot).has_value());
}

}  // namespace
}  // namespace cosiva::experiments
