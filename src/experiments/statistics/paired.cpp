#include "cosiva/experiments/statistics/paired.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "cosiva/base/expect.h"
#include "cosiva/base/math.h"
#include "cosiva/base/random.h"
#include "cosiva/experiments/statistics/distributions.h"
#include "cosiva/experiments/statistics/sample.h"

namespace cosiva::statistics {
namespace {

/// Twice the rank of each value, 2 for the smallest: equal values have their mean rank, and twice that is an integer.
std::vector<std::size_t> doubled_ranks(std::span<const double> values) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), 0U);
  std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) { return values[a] < values[b]; });
  std::vector<std::size_t> ranks(values.size());
  for (std::size_t from = 0; from < order.size();) {
    std::size_t to = from;
    while (to < order.size() && values[order[to]] == values[order[from]]) ++to;
    for (std::size_t i = from; i < to; ++i) ranks[order[i]] = from + to + 1;
    from = to;
  }
  return ranks;
}

/// The probability of every sum of (doubled) ranks for random signs, one sign after the other.
std::vector<double> chances(const std::vector<std::size_t>& ranks) {
  std::vector<double> chance(std::accumulate(ranks.begin(), ranks.end(), std::size_t{0}) + 1, 0.0);
  chance[0] = 1.0;
  std::size_t reached = 0;
  for (const std::size_t rank : ranks) {
    reached += rank;
    for (std::size_t s = reached + 1; s-- > 0;) chance[s] = 0.5 * (chance[s] + (s >= rank ? chance[s - rank] : 0.0));
  }
  return chance;
}

/// The largest sum of ranks, doubled, at which n different runs are called different at a level; nothing: none is.
std::optional<std::size_t> critical_sum(std::size_t n, double level) {
  std::vector<std::size_t> ranks(n);
  for (std::size_t i = 0; i < n; ++i) ranks[i] = 2 * (i + 1);
  const std::vector<double> chance = chances(ranks);
  std::optional<std::size_t> largest;
  double tail = 0.0;
  for (std::size_t s = 0; s < chance.size(); ++s) {
    tail += chance[s];
    if (2.0 * tail >= level) break;
    largest = s;
  }
  return largest;
}

/// How often n Gaussian differences with this ratio of mean to deviation are called different, by simulation.
double power_of(std::size_t n, double effect, double level) {
  const auto critical = critical_sum(n, level);
  if (!critical) return 0.0;
  constexpr int tries = 4000;
  Random random{1, "statistics/power"};
  int shown = 0;
  std::vector<double> sizes(n);
  std::vector<bool> positive(n);
  for (int i = 0; i < tries; ++i) {
    for (std::size_t k = 0; k < n; ++k) {
      const double d = random.gaussian(effect, 1.0);
      sizes[k] = std::fabs(d);
      positive[k] = d > 0.0;
    }
    const auto ranks = doubled_ranks(sizes);
    std::size_t sum = 0;
    for (std::size_t k = 0; k < n; ++k) sum += positive[k] ? ranks[k] : 0;
    shown += std::min(sum, n * (n + 1) - sum) <= *critical ? 1 : 0;
  }
  return static_cast<double>(shown) / tries;
}

}  // namespace

double wilcoxon(std::span<const double> differences) {
  std::vector<double> sizes;
  std::vector<bool> positive;
  for (const double d : differences) {
    if (d == 0.0) continue;
    sizes.push_back(std::fabs(d));
    positive.push_back(d > 0.0);
  }
  if (sizes.empty()) return 1.0;
  const std::vector<std::size_t> ranks = doubled_ranks(sizes);
  std::size_t sum = 0;
  std::size_t total = 0;
  double squares = 0.0;
  for (std::size_t i = 0; i < ranks.size(); ++i) {
    if (positive[i]) sum += ranks[i];
    total += ranks[i];
    squares += static_cast<double>(ranks[i]) * static_cast<double>(ranks[i]);
  }
  const std::size_t smaller = std::min(sum, total - sum);
  if (ranks.size() > 200) {
    const double off = 0.5 * static_cast<double>(total) - static_cast<double>(smaller) - 1.0;
    return std::fmin(1.0, 2.0 * normal_cdf(-std::fmax(off, 0.0) / std::sqrt(0.25 * squares)));
  }
  const std::vector<double> chance = chances(ranks);
  double tail = 0.0;
  for (std::size_t s = 0; s <= smaller; ++s) tail += chance[s];
  return std::fmin(1.0, 2.0 * tail);
}

std::vector<double> holm(std::span<const double> p_values) {
  const std::size_t n = p_values.size();
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), 0U);
  std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) { return p_values[a] < p_values[b]; });
  std::vector<double> raised(n);
  double so_far = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    so_far = std::fmax(so_far, std::fmin(1.0, static_cast<double>(n - i) * p_values[order[i]]));
    raised[order[i]] = so_far;
  }
  return raised;
}

std::optional<Friedman> friedman(const std::vector<std::vector<double>>& metrics) {
  if (metrics.size() < 2 || metrics.front().size() < 2) return std::nullopt;
  const std::size_t k = metrics.front().size();
  const auto n = static_cast<double>(metrics.size());
  Friedman result{std::vector<double>(k, 0.0), 0.0, 1.0};
  double squares = 0.0;
  for (const std::vector<double>& run : metrics) {
    COSIVA_EXPECT(run.size() == k);
    const auto ranks = doubled_ranks(run);
    for (std::size_t j = 0; j < k; ++j) {
      const double rank = 0.5 * static_cast<double>(ranks[j]);
      result.mean_ranks[j] += rank / n;
      squares += rank * rank;
    }
  }
  // Conover's form, which remains valid with ties.
  const auto kk = static_cast<double>(k);
  const double centre = n * kk * (kk + 1.0) * (kk + 1.0) / 4.0;
  double between = 0.0;
  for (const double rank : result.mean_ranks) between += (rank - 0.5 * (kk + 1.0)) * (rank - 0.5 * (kk + 1.0));
  if (squares - centre <= 1e-12) return result;  // all equal in every run
  result.chi_squared = (kk - 1.0) * n * n * between / (squares - centre);
  result.p = 1.0 - chi_squared_cdf(result.chi_squared, kk - 1.0);
  return result;
}

std::optional<std::size_t> runs_to_decide(std::span<const double> differences, double level, double power) {
  if (differences.size() < 2) return std::nullopt;
  const double shift = mean(differences);
  const double z = normal_quantile(1.0 - 0.5 * level) + normal_quantile(power);
  // Wilcoxon's test needs π/3 as many runs as Student's where differences are Gaussian.
  const double runs = z * z * sample_variance(differences) / (shift * shift) * (pi / 3.0);
  if (!(runs < 1e9)) return std::nullopt;
  auto n = std::max<std::size_t>(6, static_cast<std::size_t>(std::ceil(runs)));
  // That holds for many runs. With few runs there are few possible sums of ranks.
  constexpr std::size_t few = 30;
  const double effect = std::fabs(shift) / std::sqrt(std::fmax(sample_variance(differences), 1e-300));
  while (n < few && power_of(n, std::fmin(effect, 1e3), level) < power) ++n;
  return n;
}

std::size_t passes_needed(double reliability, double confidence) {
  COSIVA_EXPECT(reliability > 0.0 && reliability < 1.0 && confidence > 0.0 && confidence < 1.0);
  return static_cast<std::size_t>(std::ceil(det_log(1.0 - confidence) / det_log(reliability) - 1e-9));
}

double reliability_shown(std::size_t passes, double confidence) {
  if (passes == 0) return 0.0;
  return det_exp(det_log(1.0 - confidence) / static_cast<double>(passes));
}

}  // namespace cosiva::statistics
