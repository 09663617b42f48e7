#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "base/pose.h"
#include "base/result.h"

namespace cosiva::zone {

enum class SectionKind { straight, arc, clothoid };
[[nodiscard]] std::string_view to_string(SectionKind kind);

/// A piece of circuit whose curvature is linear in arc length: κ(s) = κ₀ + κ₁·s, s ∈ [0, L] (DESIGN §4.3).
/// κ₁ = 0 is an arc, κ₀ = κ₁ = 0 a straight line; the article's equations (1) to (3) are its special cases (A29).
/// Positions come from Taylor pieces computed once (≤ 0.5 rad each), so that pose_at costs two polynomials and no sine.
class Section {
 public:
  /// @param start            X_MP at s = 0
  /// @param length_m         L > 0, finite
  /// @param curvature_per_m  κ₀; positive bends left
  /// @param curvature_rate_per_m2  κ₁
  /// Fails with code "section.invalid" on non-finite numbers, L ≤ 0, L > 1e5 m or more than 1e4 rad turned in all.
  [[nodiscard]] static Result<Section> make(const Pose2& start, double length_m, double curvature_per_m = 0.0,
                                            double curvature_rate_per_m2 = 0.0);

  [[nodiscard]] double length_m() const { return length_m_; }
  [[nodiscard]] SectionKind kind() const;
  [[nodiscard]] const Pose2& start() const { return start_; }
  [[nodiscard]] const Pose2& end() const { return end_; }

  /// X_MP at arc length s ∈ [0, L] (clamped). Heading is that of increasing s, in (−π, π].
  [[nodiscard]] Pose2 pose_at(double s_m) const;
  [[nodiscard]] double curvature_at(double s_m) const;

  /// The article's request of an AIV to its current section (A30): from `mDTCS_m` travelled on this section, try to
  /// travel `DTT_m` more. Gives the pose reached and DT, the distance that this section could take: DT < DTT when it
  /// ends first (figure 14). Both distances in [0, ∞), in the direction of increasing s.
  struct NextPosition {
    Pose2 pose;
    double DT_m;
  };
  [[nodiscard]] NextPosition nextAIVposition(double mDTCS_m, double DTT_m) const;

  /// The point of this section nearest to p: its arc length, and how far p is to the left of it (negative: right)
  /// there.
  struct Nearest {
    double s_m;
    double left_m;      ///< signed distance along the normal at s
    double distance_m;  ///< ≥ 0, plain distance (differs from |left_m| beyond the ends)
  };
  [[nodiscard]] Nearest nearest(Point2 p) const;

 private:
  /// Position over [from, to] as two polynomials of u = s − (from + to)/2.
  struct Piece {
    double from_m;
    double to_m;
    std::array<double, 12> x;
    std::array<double, 12> y;
  };
  Section() = default;
  Pose2 start_;
  Pose2 end_;
  double length_m_{};
  double curvature_per_m_{};
  double curvature_rate_per_m2_{};
  double pieces_per_m_{};
  std::vector<Piece> pieces_;
};

}  // namespace cosiva::zone
