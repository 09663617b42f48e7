#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/pose.h"
#include "cosiva/base/result.h"

/// Trajectories as other tools write them, and the figures that they give for them.
namespace cosiva::experiments {

struct Stamped {
  double t_s{};
  std::array<double, 3> p_m{};                  ///< x, y, z
  std::array<double, 4> q{0.0, 0.0, 0.0, 1.0};  ///< x, y, z, w, of length 1

  /// Seen from above.
  [[nodiscard]] Pose2 pose() const;
};

/// Stamps rise, all numbers are finite.
struct Trajectory {
  std::string name;
  std::vector<Stamped> poses;
};

enum class TrajectoryFormat { tum, kitti, euroc };
/// TUM: "t x y z qx qy qz qw"; KITTI: twelve numbers, the upper rows of a matrix, stamps are line numbers from 0;
/// EuRoC: "ns,x,y,z,qw,qx,qy,qz", more may follow. Lines that begin with # are comments. Fails ("recording.number",
/// "recording.width", "recording.stamp" where stamps do not rise, "recording.rotation", "recording.empty") with file
/// and line.
[[nodiscard]] Result<Trajectory> read_trajectory(TrajectoryFormat format, std::string_view file, std::string_view text);
/// By what its lines look like.
[[nodiscard]] Result<Trajectory> read_trajectory(std::string_view file, std::string_view text);
/// As TUM, with as many digits as read back to the same numbers.
[[nodiscard]] std::string write_tum(const Trajectory& trajectory);
[[nodiscard]] Stamped stamped(double t_s, const Pose2& pose);

enum class Association {
  interpolate,  ///< the reference, to the estimate's stamps
  nearest,      ///< evo's rule: of the shorter one's stamps each the nearest of the other's
};
struct AssociationOptions {
  Association how{Association::interpolate};
  /// Interpolated between two poses of the reference no further apart than this; nearest: from stamp to stamp (evo:
  /// 0.01).
  double gap_s{0.5};
};
struct Pair {
  Stamped reference;
  Stamped estimate;
};
/// Fails ("recording.overlap") where nothing belongs together, with both spans.
[[nodiscard]] Result<std::vector<Pair>> associate(const Trajectory& reference, const Trajectory& estimate,
                                                  const AssociationOptions& options);

/// Absolute position error over pairs, as evo's APE counts it: over all three coordinates, nothing aligned.
struct ApeMetrics {
  std::size_t pairs{};
  double rmse{}, mean{}, median{}, std{}, min{}, max{}, sse{};
};
[[nodiscard]] ApeMetrics ape(const std::vector<Pair>& pairs);

/// By which offset τ of the estimate's stamps its errors along the way are least: estimate(t + τ) against reference(t),
/// in [−limit, limit]. For showing; nothing is ever shifted by it.
[[nodiscard]] double time_offset_s(const std::vector<Pair>& pairs, double limit_s = 0.5);

}  // namespace cosiva::experiments
