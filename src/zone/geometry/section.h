#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <string_view>
#include <vector>

#include "cosiva/base/expect.h"
#include "cosiva/base/math_inline.h"
#include "cosiva/base/pose.h"
#include "cosiva/base/result.h"
#include "cosiva/zone/geometry/section_shape.h"

namespace cosiva::zone {

/// An upright rectangle of the map.
struct Box {
  Point2 low;
  Point2 high;
  friend bool operator==(const Box&, const Box&) = default;
};
/// Distance of p from the box; 0 inside.
[[nodiscard]] double distance(const Box& box, Point2 p) noexcept;

enum class SectionKind { straight, arc, clothoid, shaped };
[[nodiscard]] std::string_view to_string(SectionKind kind);

/// A piece of circuit (A29), s ∈ [0, L] its arc length. Usually its curvature is linear in it: κ(s) = κ₀ + κ₁·s. κ₁ = 0
/// is an arc, κ₀ = κ₁ = 0 a straight line; the article's equations (1) to (3) are its special cases. Positions come
/// from Taylor pieces computed once (≤ 0.5 rad each), so that pose_at costs two polynomials and no sine. Any other
/// curve is a SectionShape, which the section is placed along.
class Section {
 public:
  /// @param start            X_MP at s = 0
  /// @param length_m         L > 0, finite
  /// @param curvature_per_m  κ₀; positive bends left
  /// @param curvature_rate_per_m2  κ₁
  /// Fails with code "section.invalid" on non-finite numbers, L < 1e-6 m, L > 1e5 m or more than 1e4 rad turned in all.
  [[nodiscard]] static Result<Section> make(const Pose2& start, double length_m, double curvature_per_m = 0.0,
                                            double curvature_rate_per_m2 = 0.0);

  /// Of the given shape, from `start`. Fails with "section.invalid" as above, or as check_shape does.
  [[nodiscard]] static Result<Section> make(const Pose2& start, std::shared_ptr<const SectionShape> shape);

  [[nodiscard]] double length_m() const { return length_m_; }
  [[nodiscard]] SectionKind kind() const;
  /// Null unless the kind is `shaped`.
  [[nodiscard]] const std::shared_ptr<const SectionShape>& shape() const { return shape_; }
  [[nodiscard]] const Pose2& start() const { return start_; }
  [[nodiscard]] const Pose2& end() const { return end_; }

  /// X_MP at arc length s ∈ [0, L] (clamped). Heading is that of increasing s, in (−π, π]. On an arc this is the
  /// article's equation (1), on straights along x and y its equations (2) and (3).
  [[nodiscard]] Pose2 pose_at(double s_m) const;
  /// The position of pose_at(s), to the same bits, without computing the heading.
  [[nodiscard]] Point2 point_at(double s_m) const;
  /// The heading of pose_at(s), to the same bits, without computing the position.
  [[nodiscard]] double heading_at(double s_m) const;
  [[nodiscard]] double curvature_at(double s_m) const;
  [[nodiscard]] double curvature_rate_per_m2() const { return curvature_rate_per_m2_; }  ///< κ₁; 0 of a shape

  /// The article's request of an AIV to its current section (A30): from `mDTCS_m` ≥ 0 travelled on this section, try to
  /// travel `DTT_m` ≥ 0 more. DT < DTT when the section ends first (figure 14). A vehicle in indirect direction (A32)
  /// travels towards the start, and mDTCS counts from the end.
  [[nodiscard]] NextPosition nextAIVposition(double mDTCS_m, double DTT_m, bool indirect = false) const;

  /// The point of this section nearest to p: its arc length, and the distance of p to the left of it (negative: right)
  /// there.
  struct Nearest {
    double s_m;
    double left_m;      ///< signed distance along the normal at s
    double distance_m;  ///< ≥ 0, plain distance (differs from |left_m| beyond the ends)
  };
  [[nodiscard]] Nearest nearest(Point2 p) const;

  /// A box that holds the whole section, at most a few percent too large.
  [[nodiscard]] const Box& box() const { return box_; }
  /// The greatest |curvature|, at one of the ends; of a shape an upper limit.
  [[nodiscard]] double curvature_max_per_m() const;

 private:
  static constexpr std::size_t coefficient_count = 12;

  /// Position over one piece as two polynomials of u = s − middle.
  struct Piece {
    double centre_m;
    std::array<double, coefficient_count> x;
    std::array<double, coefficient_count> y;

    [[nodiscard]] Point2 at(double u_m) const noexcept;
  };

  Section() = default;
  // Out of line, so that the built-in kinds stay short enough to be inlined.
  [[nodiscard, gnu::cold, gnu::pure]] Pose2 shaped_pose_at(double s_m) const;  ///< s in [0, L]
  [[nodiscard, gnu::cold]] NextPosition shaped_next(double mDTCS_m, double DTT_m, bool indirect) const;
  void lay_pieces();
  void finish();  ///< direction, pieces, end and box, from the members that define the section
  [[nodiscard]] Point2 position_at(double s_m) const noexcept;  ///< s in [0, L]
  [[nodiscard]] Nearest nearest_on_straight(Point2 p) const;
  [[nodiscard]] Nearest nearest_on_arc(Point2 p) const;
  [[nodiscard]] Nearest nearest_by_search(Point2 p) const;
  [[nodiscard]] double polish(Point2 p, double s_m, double low_m, double high_m) const;

  // First the members for the search of the nearest position, side by side: on a large circuit they are loaded from far
  // away.
  Pose2 start_;
  SinCos direction_{};  ///< of the heading at the start
  double length_m_{};
  std::shared_ptr<const SectionShape> shape_;
  double curvature_per_m_{};
  double curvature_rate_per_m2_{};
  double pieces_per_m_{};
  std::vector<Piece> pieces_;  ///< none on a straight section, nor of a shape
  Pose2 end_;
  Box box_;
};

/// As in a zone's file: "straight", "arc", "clothoid", or the name that the shape gives its kind.
[[nodiscard]] std::string_view kind_name(const Section& section);
/// The part of a section from `from_m` to `to_m`, which are at least 1e-6 m apart within [0, L].
[[nodiscard]] Section part_of(const Section& section, double from_m, double to_m);
/// The same curve from its end to its start: at s the position of the section at L − s, the heading opposite.
[[nodiscard]] Section reversed(const Section& section);

// The hot path of every moving body, hence defined here for inlining.

inline Point2 Section::Piece::at(double u_m) const noexcept {
  // Even and odd powers apart: two short chains of multiplications instead of one long one.
  const double w = u_m * u_m;
  const double x_even = x[0] + w * (x[2] + w * (x[4] + w * (x[6] + w * (x[8] + w * x[10]))));
  const double x_odd = x[1] + w * (x[3] + w * (x[5] + w * (x[7] + w * (x[9] + w * x[11]))));
  const double y_even = y[0] + w * (y[2] + w * (y[4] + w * (y[6] + w * (y[8] + w * y[10]))));
  const double y_odd = y[1] + w * (y[3] + w * (y[5] + w * (y[7] + w * (y[9] + w * y[11]))));
  return {x_even + u_m * x_odd, y_even + u_m * y_odd};
}

inline Point2 Section::position_at(double s_m) const noexcept {
  if (pieces_.empty()) {
    if (shape_) return position(shaped_pose_at(s_m));
    return {start_.x_m + direction_.cos * s_m, start_.y_m + direction_.sin * s_m};
  }
  const std::size_t index = std::min(static_cast<std::size_t>(s_m * pieces_per_m_), pieces_.size() - 1);
  const Piece& piece = pieces_[index];
  return piece.at(s_m - piece.centre_m);
}

inline double Section::heading_at(double s_m) const {
  const double s = s_m > 0.0 ? std::min(s_m, length_m_) : 0.0;
  if (curvature_per_m_ == 0.0 && curvature_rate_per_m2_ == 0.0)
    return shape_ ? shaped_pose_at(s).heading_rad : start_.heading_rad;
  return wrap_angle(start_.heading_rad + s * (curvature_per_m_ + 0.5 * curvature_rate_per_m2_ * s));
}

inline Point2 Section::point_at(double s_m) const {
  // Written so that a NaN, which no caller should pass, becomes 0 rather than an index.
  return position_at(s_m > 0.0 ? std::min(s_m, length_m_) : 0.0);
}

inline Pose2 Section::pose_at(double s_m) const {
  if (shape_) [[unlikely]]
    return shaped_pose_at(s_m > 0.0 ? std::min(s_m, length_m_) : 0.0);
  const Point2 p = point_at(s_m);
  return {p.x_m, p.y_m, heading_at(s_m)};
}

// Inline so that a caller that needs the distance alone does not compute the pose.
COSIVA_INLINE NextPosition Section::nextAIVposition(double mDTCS_m, double DTT_m, bool indirect) const {
  COSIVA_EXPECT(std::min(DTT_m, mDTCS_m) >= 0.0);
  // The section conservation condition (A31): the rest of this section limits the part of DTT travelled on it.
  const double reached_m = mDTCS_m + DTT_m;
  if (shape_) [[unlikely]]
    return shaped_next(mDTCS_m, DTT_m, indirect);
  if (reached_m > length_m_) return {indirect ? start_ : end_, std::max(length_m_ - mDTCS_m, 0.0)};
  return {pose_at(indirect ? length_m_ - reached_m : reached_m), DTT_m};
}

}  // namespace cosiva::zone
