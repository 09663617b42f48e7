#pragma once

/// Distributions for tests of variance, for power, and for tolerance bounds. The same bits on every machine.
namespace cosiva::statistics {

/// Fisher's F: the probability that a ratio of two mean squares, with these degrees of freedom, is below f.
[[nodiscard]] double fisher_cdf(double f, double numerator_degrees, double denominator_degrees);

/// Student's t about a mean that is not zero: P((Z + shift)/√(χ²/degrees) ≤ t), by quadrature, to about 1e-9.
[[nodiscard]] double shifted_student_cdf(double t, double degrees, double shift);
/// @param p  in (0, 1)
[[nodiscard]] double shifted_student_quantile(double p, double degrees, double shift);

}  // namespace cosiva::statistics
