#include "cosiva/base/least_squares.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "cosiva/base/expect.h"

namespace cosiva {
namespace {

using DenseVector = Eigen::VectorXd;
using DenseMatrix = Eigen::MatrixXd;

DenseVector dense(std::span<const double> values) {
  return Eigen::Map<const DenseVector>{values.data(), static_cast<Eigen::Index>(values.size())};
}

DenseMatrix dense(const Matrix& matrix) {
  return Eigen::Map<const DenseMatrix>{matrix.values().data(), static_cast<Eigen::Index>(matrix.rows()),
                                       static_cast<Eigen::Index>(matrix.columns())};
}

template <std::size_t N>
Eigen::Matrix<double, static_cast<int>(N), static_cast<int>(N)> dense(const SquareMatrix<N>& matrix) {
  Eigen::Matrix<double, static_cast<int>(N), static_cast<int>(N)> result;
  for (std::size_t i = 0; i < N; ++i)
    for (std::size_t j = 0; j < N; ++j)
      result(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = matrix[i][j];
  return result;
}

SquareMatrix<3> without_eigen(const Eigen::Matrix3d& matrix) {
  SquareMatrix<3> result{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      result[i][j] = matrix(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
  return result;
}

std::vector<double> without_eigen(const DenseVector& vector) { return {vector.data(), vector.data() + vector.size()}; }

Matrix without_eigen(const DenseMatrix& matrix) {
  Matrix result{static_cast<std::size_t>(matrix.rows()), static_cast<std::size_t>(matrix.cols())};
  std::copy(matrix.data(), matrix.data() + matrix.size(), result.values().begin());
  return result;
}

/// The minimum over the free unknowns alone, the others at zero.
DenseVector solve_free(const DenseMatrix& normal, const DenseVector& right, const std::vector<bool>& free) {
  std::vector<Eigen::Index> at;
  for (std::size_t i = 0; i < free.size(); ++i)
    if (free[i]) at.push_back(static_cast<Eigen::Index>(i));
  const DenseMatrix small = normal(at, at);
  const DenseVector few = right(at);
  const DenseVector found = small.ldlt().solve(few);
  DenseVector x = DenseVector::Zero(right.size());
  for (std::size_t k = 0; k < at.size(); ++k) x(at[k]) = found(static_cast<Eigen::Index>(k));
  return x;
}

DenseVector nonnegative(const DenseMatrix& normal, const DenseVector& right) {
  const auto size = static_cast<std::size_t>(right.size());
  std::vector<bool> free(size, false);
  DenseVector x = DenseVector::Zero(right.size());
  const double tolerance = 1e-10 * right.cwiseAbs().maxCoeff();
  for (std::size_t round = 0; round < 10 * size; ++round) {
    const DenseVector pull = right - normal * x;
    Eigen::Index best = -1;
    for (Eigen::Index i = 0; i < right.size(); ++i) {
      if (!free[static_cast<std::size_t>(i)] && pull(i) > tolerance && (best < 0 || pull(i) > pull(best))) best = i;
    }
    if (best < 0) return x;
    free[static_cast<std::size_t>(best)] = true;
    for (std::size_t inner = 0; inner < size; ++inner) {
      const DenseVector wanted = solve_free(normal, right, free);
      // As far as no unknown becomes negative; an unknown that reaches zero stays there.
      double step = 1.0;
      for (Eigen::Index i = 0; i < right.size(); ++i) {
        if (free[static_cast<std::size_t>(i)] && wanted(i) <= 0.0) step = std::min(step, x(i) / (x(i) - wanted(i)));
      }
      x += step * (wanted - x);
      if (step >= 1.0) break;
      for (Eigen::Index i = 0; i < right.size(); ++i) {
        if (free[static_cast<std::size_t>(i)] && x(i) <= 1e-14 && wanted(i) <= 0.0) {
          x(i) = 0.0;
          free[static_cast<std::size_t>(i)] = false;
        }
      }
    }
  }
  return x;
}

}  // namespace

std::vector<double> residuals(const Matrix& a, std::span<const double> x, std::span<const double> y) {
  COSIVA_EXPECT(x.size() == a.columns() && y.size() == a.rows());
  return without_eigen(DenseVector{dense(a) * dense(x) - dense(y)});
}

double weighted_squares(std::span<const double> weights, std::span<const double> errors) {
  COSIVA_EXPECT(weights.size() == errors.size());
  const DenseVector w = dense(weights);
  const DenseVector e = dense(errors);
  return e.dot(w.asDiagonal() * e);
}

std::optional<std::vector<double>> least_squares(const Matrix& a, std::span<const double> y, double rank_threshold) {
  COSIVA_EXPECT(y.size() == a.rows());
  Eigen::ColPivHouseholderQR<DenseMatrix> solver{dense(a)};
  solver.setThreshold(rank_threshold);
  if (solver.rank() < solver.cols()) return std::nullopt;
  return without_eigen(DenseVector{solver.solve(dense(y))});
}

Matrix least_squares(const Matrix& a, const Matrix& y) {
  COSIVA_EXPECT(y.rows() == a.rows());
  return without_eigen(DenseMatrix{dense(a).colPivHouseholderQr().solve(dense(y))});
}

std::array<double, 9> homogeneous_least_squares(const Matrix& a) {
  COSIVA_EXPECT(a.columns() == 9);
  const DenseMatrix rows = dense(a);
  const Eigen::Matrix<double, 9, 9> squares = rows.transpose() * rows;
  const Eigen::Matrix<double, 9, 1> least =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 9, 9>>(squares).eigenvectors().col(0);
  std::array<double, 9> x{};
  std::copy(least.data(), least.data() + least.size(), x.begin());
  return x;
}

NormalEquations normal_equations(const Matrix& a, std::span<const double> weights, std::span<const double> y) {
  COSIVA_EXPECT(weights.size() == a.rows() && y.size() == a.rows());
  const DenseMatrix rows = dense(a);
  const DenseMatrix weighted = dense(weights).asDiagonal() * rows;
  return {without_eigen(DenseMatrix{rows.transpose() * weighted}),
          without_eigen(DenseVector{weighted.transpose() * dense(y)})};
}

std::vector<double> nonnegative_least_squares(const NormalEquations& equations) {
  COSIVA_EXPECT(equations.normal.rows() == equations.right.size() &&
                equations.normal.columns() == equations.right.size());
  return without_eigen(nonnegative(dense(equations.normal), dense(equations.right)));
}

std::vector<double> levenberg_marquardt(std::span<const double> start, std::size_t count, const Residuals& write) {
  const auto residuals_at = [&](const DenseVector& x, DenseVector& out) {
    write({x.data(), static_cast<std::size_t>(x.size())}, {out.data(), static_cast<std::size_t>(out.size())});
  };
  DenseVector at = dense(start);
  DenseVector here(static_cast<Eigen::Index>(count));
  DenseVector moved(here.size());
  residuals_at(at, here);
  DenseMatrix slopes(here.size(), at.size());
  double damping = 1e-3;
  constexpr int rounds = 60;
  for (int round = 0; round < rounds; ++round) {
    for (Eigen::Index i = 0; i < at.size(); ++i) {
      constexpr double step = 1e-6;
      DenseVector neighbour = at;
      neighbour[i] += step;
      residuals_at(neighbour, moved);
      slopes.col(i) = (moved - here) / step;
    }
    const DenseMatrix squares = slopes.transpose() * slopes;
    const DenseVector pull = slopes.transpose() * here;
    const double before = here.squaredNorm();
    bool better = false;
    while (!better && damping < 1e9) {
      DenseMatrix damped = squares;
      damped.diagonal() *= 1.0 + damping;
      damped.diagonal().array() += 1e-12;
      const DenseVector next = at - DenseVector(damped.ldlt().solve(pull));
      residuals_at(next, moved);
      better = moved.allFinite() && moved.squaredNorm() < before;
      if (better) {
        at = next;
        here = moved;
      }
      damping = better ? std::max(1e-9, 0.2 * damping) : 5.0 * damping;
    }
    if (!better || before - here.squaredNorm() < 1e-13 * before) break;
  }
  return without_eigen(at);
}

template <std::size_t N>
std::array<double, N> solve_symmetric(const SquareMatrix<N>& a, const std::array<double, N>& b) {
  using Vector = Eigen::Matrix<double, static_cast<int>(N), 1>;
  const Vector x = dense(a).ldlt().solve(Vector{b.data()});
  std::array<double, N> result{};
  std::copy(x.data(), x.data() + x.size(), result.begin());
  return result;
}
template std::array<double, 2> solve_symmetric(const SquareMatrix<2>& a, const std::array<double, 2>& b);
template std::array<double, 3> solve_symmetric(const SquareMatrix<3>& a, const std::array<double, 3>& b);

std::optional<SquareMatrix<3>> inverse(const SquareMatrix<3>& a) {
  const Eigen::Matrix3d matrix = dense(a);
  const double determinant = matrix.determinant();
  if (!std::isfinite(determinant) || determinant == 0.0) return std::nullopt;
  return without_eigen(Eigen::Matrix3d{matrix.inverse()});
}

SquareMatrix<3> nearest_orthogonal(const SquareMatrix<3>& a) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> parts{dense(a), Eigen::ComputeFullU | Eigen::ComputeFullV};
  return without_eigen(Eigen::Matrix3d{parts.matrixU() * parts.matrixV().transpose()});
}

}  // namespace cosiva
