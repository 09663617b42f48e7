// VDA 5050 JSON on the hot path: a state of about 1 kB written and read, compared with simdjson's bare parse of the
// same bytes in the same run. Compare the rows of one run; the machine varies more between runs than the code does.
#include <benchmark/benchmark.h>
#include <simdjson.h>

#include <string>
#include <vector>

#include "bench/sample_state.h"
#include "cosiva/wire/vda5050/codec.h"

namespace {

using namespace cosiva;

std::vector<wire::State> states() {
  std::vector<wire::State> all;
  for (std::uint32_t i = 0; i < 256; ++i) {
    const Pose2 X_MB{0.001 * i, -0.15 + 0.0007 * i, 0.01 * i};
    all.push_back(fixture::sample_state({"CoSiVA", "AIV1"}, 4321 + i, virtual_epoch + std::chrono::milliseconds{97 * i},
                                        X_MB, "bench"));
  }
  return all;
}

std::vector<std::string> texts() {
  std::vector<std::string> all;
  for (const wire::State& state : states()) all.push_back(wire::vda5050::encode(state));
  return all;
}

/// Runs `work` over the samples cyclically, and counts messages and bytes.
template <typename Samples, typename Work>
void over(benchmark::State& state, const Samples& samples, Work work) {
  std::size_t i = 0;
  std::int64_t bytes = 0;
  for (auto _ : state) {
    bytes += static_cast<std::int64_t>(work(samples[i]));
    i = (i + 1) % samples.size();
  }
  state.SetItemsProcessed(state.iterations());
  state.SetBytesProcessed(bytes);
}

void BM_encode_state(benchmark::State& state) {
  over(state, states(), [](const wire::State& message) { return wire::vda5050::encode(message).size(); });
}
BENCHMARK(BM_encode_state);

void BM_decode_state(benchmark::State& state) {
  over(state, texts(), [](const std::string& text) {
    auto message = wire::vda5050::decode_state(text);
    benchmark::DoNotOptimize(message);
    return message ? text.size() : 0;
  });
}
BENCHMARK(BM_decode_state);

/// The reference: simdjson's own parse into its tree, without reading any value.
void BM_simdjson_parse(benchmark::State& state) {
  simdjson::dom::parser parser;
  over(state, texts(), [&parser](const std::string& text) {
    simdjson::dom::element element;
    const bool bad = parser.parse(text).get(element) != simdjson::SUCCESS;
    benchmark::DoNotOptimize(element);
    return bad ? 0 : text.size();
  });
}
BENCHMARK(BM_simdjson_parse);

void BM_refuse_truncated_state(benchmark::State& state) {
  std::vector<std::string> cut = texts();
  for (std::string& text : cut) text.resize(text.size() / 2);
  over(state, cut, [](const std::string& text) {
    const auto message = wire::vda5050::decode_state(text);
    return message ? 0 : text.size();
  });
}
BENCHMARK(BM_refuse_truncated_state);

}  // namespace
