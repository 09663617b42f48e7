// How long one step of a battery's ground truth takes, for each cell: tables, current from power, two RC pairs, heat.
// Goal: 50 ns.
#include <benchmark/benchmark.h>

#include <cstdint>
#include <memory>

#include "cosiva/battery/cell_table.h"
#include "cosiva/battery/pack.h"

namespace {

using namespace cosiva;

/// items/s are cell steps: 12 packs under a load that goes up and down, replaced when they are empty.
void BM_step(benchmark::State& state) {
  const auto table = std::make_shared<battery::CellTable>(*battery::shipped_type("lipo850"));
  const battery::PackDesign design{static_cast<std::uint32_t>(state.range(0)),
                                   static_cast<std::uint32_t>(state.range(1)), 1.0};
  std::vector<battery::Pack> packs;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) packs.emplace_back(table, design, battery::PackHistory{"B", seed});
  const double cells = design.series * design.parallel;
  double power_w = 1.0;
  for (auto _ : state) {
    power_w = power_w > 2.0 ? 1.0 : power_w + 0.01;
    for (battery::Pack& pack : packs) {
      if (pack.draw_power(power_w * cells, 22.0, 0.1).event != battery::PackEvent::none) pack.renew(22.0);
    }
  }
  state.SetItemsProcessed(state.iterations() * 12 * static_cast<std::int64_t>(cells));
}
BENCHMARK(BM_step)->Args({1, 1})->Args({2, 1})->Args({4, 2})->Args({12, 10});

}  // namespace
