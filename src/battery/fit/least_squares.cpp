#include "cosiva/battery/fit/least_squares.h"

#include <algorithm>
#include <vector>

namespace cosiva::battery {
namespace {

/// The minimum over the free unknowns alone, the others at zero.
Eigen::VectorXd solve_free(const Eigen::MatrixXd& normal, const Eigen::VectorXd& right, const std::vector<bool>& free) {
  std::vector<Eigen::Index> at;
  for (std::size_t i = 0; i < free.size(); ++i)
    if (free[i]) at.push_back(static_cast<Eigen::Index>(i));
  const Eigen::MatrixXd small = normal(at, at);
  const Eigen::VectorXd few = right(at);
  const Eigen::VectorXd found = small.ldlt().solve(few);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(right.size());
  for (std::size_t k = 0; k < at.size(); ++k) x(at[k]) = found(static_cast<Eigen::Index>(k));
  return x;
}

}  // namespace

Eigen::VectorXd nonnegative_least_squares(const Eigen::MatrixXd& normal, const Eigen::VectorXd& right) {
  const auto size = static_cast<std::size_t>(right.size());
  std::vector<bool> free(size, false);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(right.size());
  const double tolerance = 1e-10 * right.cwiseAbs().maxCoeff();
  for (std::size_t round = 0; round < 10 * size; ++round) {
    const Eigen::VectorXd pull = right - normal * x;
    Eigen::Index best = -1;
    for (Eigen::Index i = 0; i < right.size(); ++i) {
      if (!free[static_cast<std::size_t>(i)] && pull(i) > tolerance && (best < 0 || pull(i) > pull(best))) best = i;
    }
    if (best < 0) return x;
    free[static_cast<std::size_t>(best)] = true;
    for (std::size_t inner = 0; inner < size; ++inner) {
      const Eigen::VectorXd wanted = solve_free(normal, right, free);
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

}  // namespace cosiva::battery
