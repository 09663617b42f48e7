#pragma once

#include "cosiva/experiments/positioning/metrology/alignment.h"
#include "cosiva/experiments/positioning/recording/trajectory.h"

namespace cosiva::experiments {

/// x ↦ R(q)·x + shift.
struct RigidMotion {
  std::array<double, 4> q{0.0, 0.0, 0.0, 1.0};  ///< x, y, z, w, of length 1
  std::array<double, 3> shift_m{};

  [[nodiscard]] Stamped operator*(const Stamped& pose) const;
  /// About the vertical.
  [[nodiscard]] double turn_rad() const;
};

/// What brings the pairs' estimates onto their references. Fails ("align.turn") where places are too alike, or, with
/// any turn in space, too near one line, to tell it.
[[nodiscard]] Result<RigidMotion> alignment_of(Alignment how, const std::vector<Pair>& pairs);

}  // namespace cosiva::experiments
