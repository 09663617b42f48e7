// Frames between the on-board program and its boards: written, and read from a stream in pieces as from a socket.
#include <benchmark/benchmark.h>

#include <string>
#include <vector>

#include "cosiva/wire/messages/board.h"
#include "cosiva/wire/module_link/module_link.h"

namespace {

using namespace cosiva::wire;

std::vector<BoardMessage> messages() {
  Ranges ranges{1234, -35, 10, {}};
  for (std::uint16_t i = 0; i < 8; ++i) ranges.range_mm.push_back(static_cast<std::uint16_t>(300 + 40 * i));
  return {Odometry{1234, 987'654'321, 300, -12, false},
          Odometry{1254, 987'654'321, 0, 0, false, Manoeuvre{120, -35, 1571}},
          Drive{300, 500, 800, 0, false},
          TagRead{1234, 7, 12},
          ranges,
          Heartbeat{123'456, 0, 0, 0},
          Power{12'100, 850, 241, 873}};
}

void BM_encode(benchmark::State& state) {
  const std::vector<BoardMessage> all = messages();
  module_link::Encoder encoder;
  std::size_t i = 0;
  for (auto _ : state) {
    std::string frame = encoder.encode(all[i]);
    benchmark::DoNotOptimize(frame.data());
    i = (i + 1) % all.size();
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(BM_encode);

void BM_decode(benchmark::State& state) {
  constexpr std::size_t frames = 252;  // whole cycles of the seven messages, within one count of the sequence byte
  const std::vector<BoardMessage> all = messages();
  module_link::Encoder encoder;
  std::string stream;
  for (std::size_t i = 0; i < frames; ++i) stream += encoder.encode(all[i % all.size()]);
  const auto piece = static_cast<std::size_t>(state.range(0));
  std::vector<BoardMessage> received;
  for (auto _ : state) {
    module_link::Decoder decoder;
    received.clear();
    for (std::size_t at = 0; at < stream.size(); at += piece) {
      decoder.feed(std::string_view{stream}.substr(at, piece), received);
    }
    if (received.size() != frames) state.SkipWithError("frames were lost");
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(frames));
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(stream.size()));
}
BENCHMARK(BM_decode)->Arg(7)->Arg(64)->Arg(4096);

}  // namespace
