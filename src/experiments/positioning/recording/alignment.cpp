#include "cosiva/experiments/positioning/recording/alignment.h"

#include <cmath>
#include <tuple>
#include <utility>

#include "cosiva/base/math.h"

namespace cosiva::experiments {
namespace {

using Vector = std::array<double, 3>;
using Quaternion = std::array<double, 4>;
using Matrix4 = std::array<std::array<double, 4>, 4>;

Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Vector turned(const Quaternion& q, const Vector& v) {
  const Vector u{q[0], q[1], q[2]};
  const Vector uv = cross(u, v);
  const Vector uuv = cross(u, uv);
  Vector out{};
  for (std::size_t i = 0; i < 3; ++i) out[i] = v[i] + 2.0 * (q[3] * uv[i] + uuv[i]);
  return out;
}

Quaternion product(const Quaternion& a, const Quaternion& b) {
  return {a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1], a[3] * b[1] - a[0] * b[2] + a[1] * b[3] + a[2] * b[0],
          a[3] * b[2] + a[0] * b[1] - a[1] * b[0] + a[2] * b[3], a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2]};
}

/// Turns by q about the estimates' position `from`, which is moved to `to`.
RigidMotion motion(const Quaternion& q, const Vector& from, const Vector& to) {
  RigidMotion made{q, {}};
  const Vector put = turned(q, from);
  for (std::size_t i = 0; i < 3; ++i) made.shift_m[i] = to[i] - put[i];
  return made;
}

Vector centre_of(const std::vector<Pair>& pairs, Stamped Pair::*which) {
  Vector sum{};
  for (const Pair& pair : pairs) {
    for (std::size_t i = 0; i < 3; ++i) sum[i] += (pair.*which).p_m[i];
  }
  for (double& v : sum) v /= static_cast<double>(pairs.size());
  return sum;
}

struct Eigen4 {
  std::array<double, 4> values;
  Matrix4 vectors;  ///< a column each
};

/// Jacobi's rotations, which end when all off-diagonal elements are zero.
Eigen4 eigen_of(Matrix4 m) {
  Matrix4 v{};
  for (std::size_t i = 0; i < 4; ++i) v[i][i] = 1.0;
  for (int sweep = 0; sweep < 50; ++sweep) {
    double neighbour = 0.0;
    for (std::size_t p = 0; p < 4; ++p) {
      for (std::size_t q = p + 1; q < 4; ++q) {
        if (m[p][q] == 0.0) continue;
        neighbour += m[p][q] * m[p][q];
        const double tau = (m[q][q] - m[p][p]) / (2.0 * m[p][q]);
        const double t = (tau < 0.0 ? -1.0 : 1.0) / (std::fabs(tau) + std::sqrt(tau * tau + 1.0));
        const double c = 1.0 / std::sqrt(t * t + 1.0);
        const double s = t * c;
        for (std::size_t k = 0; k < 4; ++k)
          std::tie(m[k][p], m[k][q]) = std::pair{c * m[k][p] - s * m[k][q], s * m[k][p] + c * m[k][q]};
        for (std::size_t k = 0; k < 4; ++k)
          std::tie(m[p][k], m[q][k]) = std::pair{c * m[p][k] - s * m[q][k], s * m[p][k] + c * m[q][k]};
        for (std::size_t k = 0; k < 4; ++k)
          std::tie(v[k][p], v[k][q]) = std::pair{c * v[k][p] - s * v[k][q], s * v[k][p] + c * v[k][q]};
      }
    }
    if (neighbour == 0.0) break;
  }
  return {{m[0][0], m[1][1], m[2][2], m[3][3]}, v};
}

/// Least squares over all rotations in space. Source: B. K. P. Horn, Closed-form solution of absolute orientation using
/// unit quaternions, JOSA A 4 (1987): the same optimum as Umeyama's without scale, and never a mirror image.
Result<RigidMotion> in_space(const std::vector<Pair>& pairs) {
  const Vector of_ground_truth = centre_of(pairs, &Pair::reference);
  const Vector of_estimate = centre_of(pairs, &Pair::estimate);
  std::array<std::array<double, 3>, 3> s{};
  double ground_truth_spread = 0.0;
  double estimate_spread = 0.0;
  for (const Pair& pair : pairs) {
    Vector e{};
    Vector t{};
    for (std::size_t i = 0; i < 3; ++i) {
      e[i] = pair.estimate.p_m[i] - of_estimate[i];
      t[i] = pair.reference.p_m[i] - of_ground_truth[i];
      ground_truth_spread += t[i] * t[i];
      estimate_spread += e[i] * e[i];
    }
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t k = 0; k < 3; ++k) s[i][k] += e[i] * t[k];
    }
  }
  const double xyz = s[1][2] - s[2][1];
  const double yzx = s[2][0] - s[0][2];
  const double zxy = s[0][1] - s[1][0];
  const double xy = s[0][1] + s[1][0];
  const double zx = s[2][0] + s[0][2];
  const double yz = s[1][2] + s[2][1];
  const Eigen4 eigen = eigen_of({{{s[0][0] + s[1][1] + s[2][2], xyz, yzx, zxy},
                                  {xyz, s[0][0] - s[1][1] - s[2][2], xy, zx},
                                  {yzx, xy, s[1][1] - s[0][0] - s[2][2], yz},
                                  {zxy, zx, yz, s[2][2] - s[0][0] - s[1][1]}}});
  std::size_t best = 0;
  for (std::size_t i = 1; i < 4; ++i) best = eigen.values[i] > eigen.values[best] ? i : best;
  double second = -1e300;
  for (std::size_t i = 0; i < 4; ++i) second = i == best ? second : std::fmax(second, eigen.values[i]);
  // Two rotations are equally good: all positions are on one line, or equal.
  if (!(eigen.values[best] - second > 1e-9 * std::sqrt(ground_truth_spread * estimate_spread)))
    return fail("align.turn",
                "the positions are too near one line to determine a rotation in space; for se2 a line suffices");
  const auto& v = eigen.vectors;
  return motion({v[1][best], v[2][best], v[3][best], v[0][best]}, of_estimate, of_ground_truth);
}

Result<RigidMotion> on_the_floor(const std::vector<Pair>& pairs) {
  std::vector<Point2> ground_truth;
  std::vector<Point2> estimate;
  ground_truth.reserve(pairs.size());
  estimate.reserve(pairs.size());
  for (const Pair& pair : pairs) {
    ground_truth.push_back({pair.reference.p_m[0], pair.reference.p_m[1]});
    estimate.push_back({pair.estimate.p_m[0], pair.estimate.p_m[1]});
  }
  const auto found = rigid_alignment(ground_truth, estimate);
  if (!found) return tl::unexpected(found.error());
  return motion(stamped(0.0, *found).q, centre_of(pairs, &Pair::estimate), centre_of(pairs, &Pair::reference));
}

}  // namespace

Stamped RigidMotion::operator*(const Stamped& pose) const {
  Stamped moved{pose.t_s, turned(q, pose.p_m), product(q, pose.q)};
  for (std::size_t i = 0; i < 3; ++i) moved.p_m[i] += shift_m[i];
  return moved;
}

double RigidMotion::turn_rad() const { return Stamped{0.0, {}, q}.pose().heading_rad; }

Result<RigidMotion> alignment_of(Alignment how, const std::vector<Pair>& pairs) {
  switch (how) {
    case Alignment::none: break;
    case Alignment::se2: return on_the_floor(pairs);
    case Alignment::se3: return in_space(pairs);
    case Alignment::origin: {
      const Stamped& ground_truth = pairs.front().reference;
      const Stamped& estimate = pairs.front().estimate;
      const Quaternion back{-estimate.q[0], -estimate.q[1], -estimate.q[2], estimate.q[3]};
      return motion(product(ground_truth.q, back), estimate.p_m, ground_truth.p_m);
    }
  }
  return RigidMotion{};
}

}  // namespace cosiva::experiments
