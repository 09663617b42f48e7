#pragma once

// Common to the soaks: runs of the whole platform in virtual time, over many seeds.

#include <algorithm>
#include <atomic>
#include <chrono>
#include <concepts>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <sstream>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "cosiva/experiments/runs/world/test_disturbance.h"
#include "cosiva/experiments/runs/world/world.h"
#include "cosiva/zone/layout/circuit_factory.h"

namespace cosiva::soak {

/// The content of a file; nothing where the file cannot be read.
inline std::optional<std::string> text_of(const std::string& path) {
  std::ifstream file{path, std::ios::binary};
  if (!file) return std::nullopt;
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

inline zone::ZoneConfiguration toml_zone(const std::string& path) {
  return {"toml", path, text_of(path).value_or(""), {}};
}

/// COSIVA_LONG=1: the full size, however long it takes.
inline bool wanted_whole() {
  const char* whole = std::getenv("COSIVA_LONG");
  return whole != nullptr && *whole != '\0';
}

/// The optional arguments of a soak. Each call takes the next one; the value stays as it is where none is left.
class Arguments {
 public:
  Arguments(int argc, char** argv, int first) : left_{argv + std::min(first, argc), argv + argc} {}

  template <std::unsigned_integral T>
  void take(T& value) {
    if (const char* text = next()) value = static_cast<T>(std::strtoull(text, nullptr, 10));
  }
  void take(double& value) {
    if (const char* text = next()) value = std::strtod(text, nullptr);
  }
  /// "off", or anything else for on.
  void take(bool& value) {
    if (const char* text = next()) value = std::string_view{text} != "off";
  }

 private:
  const char* next() {
    if (left_.empty()) return nullptr;
    const char* text = left_.front();
    left_ = left_.subspan(1);
    return text;
  }

  std::span<char*> left_;
};

/// The settings of a soak over many seeds.
struct Plan {
  zone::ZoneConfiguration zone;
  std::uint64_t seeds{};
  std::uint32_t aivs{12};
  double loss{};  ///< ratio of messages that the network loses
  std::uint64_t first_seed{1};
  unsigned workers{2};
  bool convoys{true};
};

/// The world of one seed before its start.
inline Result<std::unique_ptr<experiments::World>> make_world(const Plan& plan, std::uint64_t seed) {
  experiments::WorldOptions options;
  options.zone = plan.zone;
  options.aivs = plan.aivs;
  options.seed = seed;
  options.network.loss = plan.loss;
  options.server.convoys = plan.convoys;
  return experiments::World::make(std::move(options));
}

/// The distance that each vehicle has driven.
inline std::vector<double> driven_m(const experiments::World& world) {
  std::vector<double> driven;
  for (const auto& vehicle : world.plant().vehicles()) driven.push_back(vehicle.distance_m);
  return driven;
}

/// The result of one seed of a soak that counts collisions and deadlocks.
struct Outcome {
  std::uint64_t seed{};
  std::size_t collisions{};
  double distance_m{};
  double slowest_m{};
  experiments::testing::DeadlockMetrics deadlocks;
  std::string digest;
  std::string failure;

  void fail(const std::string& why) { failure += (failure.empty() ? "" : ", ") + why; }

  /// Reads the metrics of a world that has run, and the failures that hold in every soak.
  void evaluate(const experiments::World& world) {
    digest = world.digest().hex();
    collisions = world.plant().collisions().size();
    if (collisions > 0) fail(std::to_string(collisions) + " collisions");
    deadlocks = experiments::testing::deadlock_metrics(world);
    if (deadlocks.open > 0.0) fail("a deadlock is not resolved");
    const auto all_m = driven_m(world);
    slowest_m = *std::ranges::min_element(all_m);
    for (const double m : all_m) distance_m += m;
  }
};

/// Calls run(seed) for each seed of the plan on several threads, in no particular order, and print(result, number of
/// results so far) for one at a time. Returns the results in the order of the seeds.
template <typename Run, typename Print>
auto run_all(const Plan& plan, const Run& run, const Print& print) {
  std::vector<decltype(run(plan.first_seed))> results(plan.seeds);
  std::atomic<std::uint64_t> next{0};
  std::size_t done = 0;
  std::mutex printing;
  std::vector<std::jthread> threads;
  for (unsigned w = 0; w < plan.workers; ++w) {
    threads.emplace_back([&] {
      for (std::uint64_t i = next++; i < plan.seeds; i = next++) {
        results[i] = run(plan.first_seed + i);
        const std::scoped_lock lock{printing};
        print(results[i], ++done);
      }
    });
  }
  threads.clear();
  return results;
}

/// Time since its construction, of the wall clock.
class Stopwatch {
 public:
  [[nodiscard]] double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - began_).count();
  }

 private:
  std::chrono::steady_clock::time_point began_{std::chrono::steady_clock::now()};
};

}  // namespace cosiva::soak
