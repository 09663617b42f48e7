#pragma once

// Common to the soaks: runs of the whole platform in virtual time, over many seeds.

#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <thread>
#include <vector>

#include "cosiva/zone/layout/circuit_factory.h"

namespace cosiva::soak {

inline zone::ZoneConfiguration toml_zone(const char* path) {
  std::ifstream file{path};
  std::ostringstream text;
  text << file.rdbuf();
  return {"toml", path, text.str()};
}

/// COSIVA_LONG=1: the full size, however long it takes.
inline bool wanted_whole() {
  const char* whole = std::getenv("COSIVA_LONG");
  return whole != nullptr && *whole != '\0';
}

/// Calls run(i) for each i below `count`, on several threads, in no particular order.
template <typename Run>
void each(std::uint64_t count, unsigned workers, const Run& run) {
  std::atomic<std::uint64_t> next{0};
  std::vector<std::jthread> threads;
  for (unsigned w = 0; w < workers; ++w) {
    threads.emplace_back([&] {
      for (std::uint64_t i = next++; i < count; i = next++) run(i);
    });
  }
}

}  // namespace cosiva::soak
