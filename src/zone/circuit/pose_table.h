#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "cosiva/zone/circuit/circuit.h"

namespace cosiva::zone {

/// A circuit's geometry side by side, for the poses of many vehicles in one pass. Straights and arcs have the same
/// form, so that no branch is needed: from a centre C, or a straight's start, with R = 1/κ, or 0 on a straight,
///     θ(s) = θ₀ + κs,   p(s) = C + R·(sin θ, −cos θ) + l·(cos θ, sin θ),   l = s on a straight, else 0.
/// Clothoids, and arcs that are nearly straight, are evaluated one by one.
class PoseTable {
 public:
  /// @param circuit  must outlive the table
  explicit PoseTable(const Circuit& circuit);

  /// X_MP of track positions, one entry each: within 1e-11 m and rad of Circuit::pose_at, and the same bits on every
  /// machine.
  /// @param s_m  in [0, length]
  void poses(std::span<const SectionId> sections, std::span<const double> s_m, std::span<double> x_m,
             std::span<double> y_m, std::span<double> heading_rad) const;
  [[nodiscard]] std::size_t bytes() const;

 private:
  const Circuit* circuit_;
  /// Eight numbers a section, in one cache line: C.x, C.y, R, θ₀, κ.
  static constexpr std::size_t stride = 8;
  std::vector<double> rows_;
  bool none_special_{true};
  std::vector<bool> is_special_;
};

}  // namespace cosiva::zone
