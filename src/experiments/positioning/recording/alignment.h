#pragma once

#include "cosiva/experiments/positioning/metrology/alignment.h"
#include "cosiva/experiments/positioning/recording/trajectory.h"

namespace cosiva::experiments {

/// x ↦ R(q)·x + shift.
struct RigidMotion {
  std::array<double, 4> q{0.0, 0.0, 0.0, 1.0};  ///< x, y, z, w, of length 1
  std::array<double, 3> shift_m{};

  [[nodiscard]] Stamped operator*(const Stamped& pose) const;
  /// A rotation about the vertical.
  [[nodiscard]] double turn_rad() const;
};

/// The motion that aligns the pairs' estimates with their references. Fails ("align.turn") where positions are too
/// close together, or, for rotations in space, too near one line, to determine it.
[[nodiscard]] Result<RigidMotion> alignment_of(Alignment how, const std::vector<Pair>& pairs);

}  // namespace cosiva::experiments
