#pragma once

// The only include of Eigen but that of base/least_squares.cpp. Its results must be the same on every machine: no
// vector instructions (their width, and fused multiply-adds, change the last bits), no threads. Nothing under another
// licence than MPL-2.0 comes in.
#define EIGEN_MPL2_ONLY
#define EIGEN_DONT_VECTORIZE
#define EIGEN_DONT_PARALLELIZE
#include <Eigen/Cholesky>
#include <Eigen/Core>

namespace cosiva::estimation {

using Vector2 = Eigen::Vector2d;
using Vector3 = Eigen::Vector3d;
using Matrix2 = Eigen::Matrix2d;
using Matrix3 = Eigen::Matrix3d;

/// Rounding makes a covariance slightly asymmetric, and an asymmetric covariance ends up with a negative variance.
template <typename Matrix>
void make_symmetric(Matrix& m) {
  for (Eigen::Index i = 0; i < m.rows(); ++i) {
    for (Eigen::Index j = 0; j < i; ++j) m(i, j) = m(j, i) = 0.5 * (m(i, j) + m(j, i));
  }
}

}  // namespace cosiva::estimation
