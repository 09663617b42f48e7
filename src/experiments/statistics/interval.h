#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

namespace cosiva::statistics {

struct Interval {
  double low{};
  double high{};
  friend bool operator==(const Interval&, const Interval&) = default;
};

struct BootstrapOptions {
  double level{0.95};
  std::size_t resamples{2000};
  std::uint64_t seed{1};
};

/// Interval of the metric `of(mean of values)`, where every value represents one run: bias-corrected and accelerated
/// bootstrap (BCa) over runs, widened for few runs by Student's t as Hesterberg proposes. `of` must be monotone: the
/// identity, a root. Nothing for fewer than two runs. Sources: B. Efron, Better Bootstrap Confidence Intervals, JASA 82
/// (1987); T. Hesterberg, What Teachers Should Know About the Bootstrap, The American Statistician 69 (2015), section
/// 4.3.
using Of = double (*)(double mean);
[[nodiscard]] std::optional<Interval> bca(std::span<const double> runs, const BootstrapOptions& options = {},
                                          Of of = nullptr);

/// Interval of the mean of one run's series with correlated neighbours: circular blocks, each long enough that its ends
/// are uncorrelated (3·n/effective size, at least). Nothing for a series equivalent to fewer than four independent
/// values: such a run does not indicate its own variation. Source: D. N. Politis, J. P. Romano, A Circular
/// Block-Resampling Procedure for Stationary Data (1992).
struct BlockInterval {
  Interval interval;
  double effective_size;
  std::size_t block;
};
[[nodiscard]] std::optional<BlockInterval> block_bootstrap(std::span<const double> series,
                                                           const BootstrapOptions& options = {}, Of of = nullptr);

}  // namespace cosiva::statistics
