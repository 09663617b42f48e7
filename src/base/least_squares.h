#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <vector>

/// Least squares and the little linear algebra around them. The sources of this interface use Eigen, whose headers cost
/// a source up to twenty seconds of compile time; no other module sees them.
namespace cosiva {

/// Coefficients of linear equations: one row per equation, one column per unknown.
class Matrix {
 public:
  /// All coefficients are zero.
  Matrix(std::size_t rows, std::size_t columns) : rows_{rows}, columns_{columns}, values_(rows * columns, 0.0) {}

  [[nodiscard]] std::size_t rows() const { return rows_; }
  [[nodiscard]] std::size_t columns() const { return columns_; }
  [[nodiscard]] double& operator()(std::size_t row, std::size_t column) { return values_[column * rows_ + row]; }
  [[nodiscard]] double operator()(std::size_t row, std::size_t column) const { return values_[column * rows_ + row]; }
  /// Column by column.
  [[nodiscard]] std::span<const double> values() const { return values_; }
  [[nodiscard]] std::span<double> values() { return values_; }

 private:
  std::size_t rows_;
  std::size_t columns_;
  std::vector<double> values_;
};

/// A·x − y.
/// @param x  one value per column of `a` (checked)
/// @param y  one value per row (checked)
[[nodiscard]] std::vector<double> residuals(const Matrix& a, std::span<const double> x, std::span<const double> y);

/// Σ w·e².
/// @param weights  one value per error (checked)
[[nodiscard]] double weighted_squares(std::span<const double> weights, std::span<const double> errors);

/// The x that minimises |A·x − y|², by Householder's QR decomposition with pivoting of columns.
/// @param rank_threshold  ratio of a pivot to the largest pivot; columns below it depend on the other columns
/// @return                nothing where the columns depend on each other: the equations do not determine x
[[nodiscard]] std::optional<std::vector<double>> least_squares(const Matrix& a, std::span<const double> y,
                                                               double rank_threshold);
/// The same of several right sides at once, one per column of `y` and of the result; unknowns that the equations do not
/// determine are zero.
[[nodiscard]] Matrix least_squares(const Matrix& a, const Matrix& y);

/// The x of length 1 that minimises |A·x|²; its sign has no meaning.
/// Source: R. Hartley, A. Zisserman, Multiple View Geometry, 2nd edition 2004, algorithm A5.4.
/// @param a  nine columns (checked)
[[nodiscard]] std::array<double, 9> homogeneous_least_squares(const Matrix& a);

/// AᵀWA and AᵀWy of the equations A·x = y with weights: the x that solves (AᵀWA)·x = AᵀWy minimises Σ w·(A·x − y)².
struct NormalEquations {
  Matrix normal;              ///< symmetric, a row and a column per unknown
  std::vector<double> right;  ///< one value per unknown
};
[[nodiscard]] NormalEquations normal_equations(const Matrix& a, std::span<const double> weights,
                                               std::span<const double> y);

/// The x ≥ 0 that minimises xᵀ N x / 2 − rᵀ x, with N (`normal`) symmetric and positive definite: least squares with
/// bounds. Source: C. Lawson, R. Hanson, Solving Least Squares Problems, 1974, algorithm NNLS.
[[nodiscard]] std::vector<double> nonnegative_least_squares(const NormalEquations& equations);

/// Writes the residuals at x: one value per residual.
using Residuals = std::function<void(std::span<const double> x, std::span<double> out)>;

/// A local minimum of the sum of squares of the residuals, which are smooth functions of unknowns of the order of 1, by
/// the method of Levenberg and Marquardt with differences of 1e-6 for derivatives.
/// Source: D. Marquardt, An algorithm for least-squares estimation of nonlinear parameters, 1963.
/// @param start  an estimate of the unknowns
/// @param count  number of residuals
/// @return       as many unknowns as in `start`; the last call of `write` may have had other ones
[[nodiscard]] std::vector<double> levenberg_marquardt(std::span<const double> start, std::size_t count,
                                                      const Residuals& write);

/// Square matrices of two and three rows, row by row.
template <std::size_t N>
using SquareMatrix = std::array<std::array<double, N>, N>;

/// The x with A·x = b, A symmetric and positive semidefinite; N is 2 or 3.
template <std::size_t N>
[[nodiscard]] std::array<double, N> solve_symmetric(const SquareMatrix<N>& a, const std::array<double, N>& b);
extern template std::array<double, 2> solve_symmetric(const SquareMatrix<2>& a, const std::array<double, 2>& b);
extern template std::array<double, 3> solve_symmetric(const SquareMatrix<3>& a, const std::array<double, 3>& b);

/// The inverse. Nothing where the determinant is zero or not a number.
[[nodiscard]] std::optional<SquareMatrix<3>> inverse(const SquareMatrix<3>& a);

/// The orthogonal matrix with the smallest sum of squared differences from A, by its singular value decomposition.
[[nodiscard]] SquareMatrix<3> nearest_orthogonal(const SquareMatrix<3>& a);

}  // namespace cosiva
