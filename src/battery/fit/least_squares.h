#pragma once

#include <Eigen/Dense>

namespace cosiva::battery {

/// The x ≥ 0 that minimises xᵀ N x / 2 − rᵀ x, N (`normal`) symmetric and positive definite: least squares with bounds,
/// from the normal equations. Source: C. Lawson, R. Hanson, Solving Least Squares Problems, 1974, algorithm NNLS.
[[nodiscard]] Eigen::VectorXd nonnegative_least_squares(const Eigen::MatrixXd& normal, const Eigen::VectorXd& right);

}  // namespace cosiva::battery
