#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/pose.h"
#include "cosiva/base/result.h"

/// Trajectories in the formats of other tools, and the metrics of these tools.
namespace cosiva::experiments {

struct Stamped {
  double t_s{};
  std::array<double, 3> p_m{};                  ///< x, y, z
  std::array<double, 4> q{0.0, 0.0, 0.0, 1.0};  ///< x, y, z, w, of length 1

  /// The pose on the plane, from above.
  [[nodiscard]] Pose2 pose() const;
};

/// Stamps must rise, all numbers are finite.
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
/// Detects the format from the lines.
[[nodiscard]] Result<Trajectory> read_trajectory(std::string_view file, std::string_view text);
/// Writes as TUM, with as many digits as read back to the same numbers.
[[nodiscard]] std::string write_tum(const Trajectory& trajectory);
[[nodiscard]] Stamped stamped(double t_s, const Pose2& pose);

enum class Association {
  interpolate,  ///< the reference, to the estimate's stamps
  nearest,      ///< evo's rule: for each stamp of the shorter trajectory the nearest of the other
};
struct AssociationOptions {
  Association how{Association::interpolate};
  /// Greatest distance of the reference poses between which a pose is interpolated; for nearest: of the two stamps
  /// (evo: 0.01).
  double gap_s{0.5};
};
struct Pair {
  Stamped reference;
  Stamped estimate;
};
/// Fails ("recording.overlap") where no stamps match, with both spans.
[[nodiscard]] Result<std::vector<Pair>> associate(const Trajectory& reference, const Trajectory& estimate,
                                                  const AssociationOptions& options);

/// Absolute position error over pairs, as evo's APE computes it: over all three coordinates, without alignment.
struct ApeMetrics {
  std::size_t pairs{};
  double rmse{}, mean{}, median{}, std{}, min{}, max{}, sse{};
};
[[nodiscard]] ApeMetrics ape(const std::vector<Pair>& pairs);

/// The offset τ of the estimate's stamps with the least errors along the path: estimate(t + τ) against reference(t), in
/// [−limit, limit]. For display; no estimate is shifted by it.
[[nodiscard]] double time_offset_s(const std::vector<Pair>& pairs, double limit_s = 0.5);

}  // namespace cosiva::experiments
