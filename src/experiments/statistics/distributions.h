#pragma once

/// Probabilities and quantiles, with the same bits on every machine. Relative errors are below 1e-10 where the result
/// of a test may depend on them.
namespace cosiva::statistics {

/// ln Γ(x) for x > 0: Stirling's series for large x, and the recurrence for small x.
[[nodiscard]] double log_gamma(double x);
/// The regularised incomplete beta function I_x(a, b), a and b > 0; 0 for x ≤ 0, 1 for x ≥ 1.
[[nodiscard]] double incomplete_beta(double a, double b, double x);

[[nodiscard]] double normal_cdf(double z);
/// @param p  in (0, 1)
[[nodiscard]] double normal_quantile(double p);

/// @param degrees  > 0, not necessarily an integer
[[nodiscard]] double chi_squared_cdf(double x, double degrees);
[[nodiscard]] double chi_squared_quantile(double p, double degrees);

[[nodiscard]] double student_cdf(double t, double degrees);
[[nodiscard]] double student_quantile(double p, double degrees);

}  // namespace cosiva::statistics
