#include "cosiva/experiments/statistics/effects.h"

#include <algorithm>
#include <cmath>

#include "cosiva/base/expect.h"
#include "cosiva/experiments/statistics/distributions.h"
#include "cosiva/experiments/statistics/sample.h"
#include "cosiva/experiments/statistics/special.h"

namespace cosiva::statistics {
namespace {

double two_sided_p(double t, double degrees) { return 2.0 * student_cdf(-std::fabs(t), degrees); }

}  // namespace

std::optional<OneFactor> one_factor(const std::vector<std::vector<double>>& groups) {
  double n = 0.0;
  double sum = 0.0;
  double within = 0.0;
  double n_squares = 0.0;
  std::size_t there = 0;
  for (const auto& group : groups) {
    if (group.empty()) continue;
    ++there;
    const auto size = static_cast<double>(group.size());
    n += size;
    n_squares += size * size;
    sum += size * mean(group);
    within += size * variance(group);
  }
  if (there < 2) return std::nullopt;
  const double numerator = static_cast<double>(there) - 1.0;
  const double denominator = n - static_cast<double>(there);
  if (denominator < 1.0 || !(within > 0.0)) return std::nullopt;
  double between = 0.0;
  for (const auto& group : groups) {
    if (group.empty()) continue;
    const double off = mean(group) - sum / n;
    between += static_cast<double>(group.size()) * off * off;
  }
  const double noise = within / denominator;
  const double f = between / numerator / noise;
  const double usual_size = (n - n_squares / n) / numerator;
  return OneFactor{f, 1.0 - fisher_cdf(f, numerator, denominator), std::sqrt(noise),
                   std::sqrt(std::max(0.0, (between / numerator - noise) / usual_size))};
}

std::optional<Trend> trend(std::span<const double> x, std::span<const double> y, double level) {
  COSIVA_EXPECT(x.size() == y.size());
  const auto n = static_cast<double>(x.size());
  if (x.size() < 3) return std::nullopt;
  const double centre_x = mean(x);
  const double centre_y = mean(y);
  double xx = 0.0;
  double xy = 0.0;
  double yy = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    xx += (x[i] - centre_x) * (x[i] - centre_x);
    xy += (x[i] - centre_x) * (y[i] - centre_y);
    yy += (y[i] - centre_y) * (y[i] - centre_y);
  }
  if (!(xx > 0.0)) return std::nullopt;
  const double slope = xy / xx;
  const double left = std::max(0.0, yy - slope * xy);
  const double noise = left / (n - 2.0);
  const double slope_sd = std::sqrt(noise / xx);
  const double p = slope_sd > 0.0 ? two_sided_p(slope / slope_sd, n - 2.0) : slope == 0.0 ? 1.0 : 0.0;
  const double at_first = centre_y + slope * (1.0 - centre_x);
  const double half = student_quantile(0.5 + 0.5 * level, n - 2.0) *
                      std::sqrt(noise * (1.0 / n + (1.0 - centre_x) * (1.0 - centre_x) / xx));
  return Trend{slope, slope_sd, p, yy > 0.0 ? 1.0 - left / yy : 1.0, at_first, {at_first - half, at_first + half}};
}

std::vector<std::vector<std::size_t>> latin_square(std::size_t size) {
  COSIVA_EXPECT(size > 0);
  // 0, 1, n−1, 2, n−2 …: all steps between neighbours differ, so that for even sizes each carrier follows each other
  // one once.
  std::vector<std::size_t> zigzag;
  for (std::size_t k = 0; k < size; ++k) zigzag.push_back(k == 0 ? 0 : k % 2 == 1 ? (k + 1) / 2 : size - k / 2);
  std::vector<std::vector<std::size_t>> square(size, std::vector<std::size_t>(size));
  for (std::size_t run = 0; run < size; ++run)
    for (std::size_t unit = 0; unit < size; ++unit) square[run][unit] = (zigzag[run] + unit) % size;
  return square;
}

double power_of(double effect, std::size_t n1, std::size_t n2, double alpha) {
  if (n1 < 2 || n2 < 2) return 0.0;
  const auto a = static_cast<double>(n1);
  const auto b = static_cast<double>(n2);
  const double degrees = a + b - 2.0;
  const double shift = std::fabs(effect) * std::sqrt(a * b / (a + b));
  const double critical = student_quantile(1.0 - 0.5 * alpha, degrees);
  return 1.0 - shifted_student_cdf(critical, degrees, shift) + shifted_student_cdf(-critical, degrees, shift);
}

std::optional<Comparison> compare(std::span<const double> first, std::span<const double> second, double level) {
  if (first.size() < 2 || second.size() < 2) return std::nullopt;
  const auto n1 = static_cast<double>(first.size());
  const auto n2 = static_cast<double>(second.size());
  const double v1 = sample_variance(first) / n1;
  const double v2 = sample_variance(second) / n2;
  if (!(v1 + v2 > 0.0)) return std::nullopt;
  Comparison found{};
  found.difference = mean(second) - mean(first);
  found.degrees = (v1 + v2) * (v1 + v2) / (v1 * v1 / (n1 - 1.0) + v2 * v2 / (n2 - 1.0));
  found.t = found.difference / std::sqrt(v1 + v2);
  found.p = two_sided_p(found.t, found.degrees);
  const double half = student_quantile(0.5 + 0.5 * level, found.degrees) * std::sqrt(v1 + v2);
  found.interval = {found.difference - half, found.difference + half};
  const double degrees = n1 + n2 - 2.0;
  const double pooled = std::sqrt(((n1 - 1.0) * v1 * n1 + (n2 - 1.0) * v2 * n2) / degrees);
  found.effect = found.difference / pooled * (1.0 - 3.0 / (4.0 * degrees - 1.0));
  found.power = power_of(found.effect, first.size(), second.size());
  constexpr std::size_t most = 100'000;
  std::size_t high = 2;
  while (high < most && power_of(found.effect, high, high) < 0.8) high *= 2;
  std::size_t low = high / 2;
  while (high < most && high - low > 1) {
    const std::size_t centre = low + (high - low) / 2;
    (power_of(found.effect, centre, centre) < 0.8 ? low : high) = centre;
  }
  found.needed = high;
  return found;
}

}  // namespace cosiva::statistics
