#include "cosiva/zone/geometry/section_shape.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::zone {
namespace {

constexpr double length_min_m = 1e-6;
constexpr double length_max_m = 1e5;
constexpr double turned_max_rad = 1e4;

/// Samples of the check: enough for each quarter of a radian, and at least this many.
constexpr double samples_min = 64.0;
constexpr double samples_max = 1e5;
constexpr double turn_per_sample_rad = 0.25;

/// Where a vehicle on a path is: far above rounding, far below what a vehicle can measure.
constexpr double start_m = 1e-9;
/// Of a difference quotient over a step in which the curve turns by at most 1e-3 rad.
constexpr double slope_error = 1e-5;
constexpr double curvature_error = 1e-3;

class PartOfShape final : public SectionShape {
 public:
  PartOfShape(std::shared_ptr<const SectionShape> whole, double from_m, double to_m)
      : whole_{std::move(whole)}, from_m_{from_m}, length_m_{to_m - from_m}, X_SM_{inverse(whole_->pose_at(from_m))} {}

  std::string_view kind() const override { return whole_->kind(); }
  double length_m() const override { return length_m_; }
  Pose2 pose_at(double s_m) const override { return X_SM_ * whole_->pose_at(from_m_ + s_m); }
  double curvature_at(double s_m) const override { return whole_->curvature_at(from_m_ + s_m); }
  double curvature_max_per_m() const override { return whole_->curvature_max_per_m(); }
  std::vector<Field> fields() const override { return whole_->fields(); }

 private:
  std::shared_ptr<const SectionShape> whole_;
  double from_m_;
  double length_m_;
  Pose2 X_SM_;  ///< of the whole's frame, in the frame of this start
};

class ReversedShape final : public SectionShape {
 public:
  explicit ReversedShape(std::shared_ptr<const SectionShape> shape)
      : shape_{std::move(shape)},
        length_m_{shape_->length_m()},
        X_SM_{inverse(turned_round(shape_->pose_at(length_m_)))} {}

  std::string_view kind() const override { return shape_->kind(); }
  double length_m() const override { return length_m_; }
  Pose2 pose_at(double s_m) const override { return X_SM_ * turned_round(shape_->pose_at(length_m_ - s_m)); }
  double curvature_at(double s_m) const override { return -shape_->curvature_at(length_m_ - s_m); }
  double curvature_max_per_m() const override { return shape_->curvature_max_per_m(); }
  std::vector<Field> fields() const override { return shape_->fields(); }

  [[nodiscard]] const std::shared_ptr<const SectionShape>& shape() const { return shape_; }

 private:
  std::shared_ptr<const SectionShape> shape_;
  double length_m_;
  Pose2 X_SM_;  ///< of the shape's frame, in the frame of this start
};

tl::unexpected<Error> invalid(const SectionShape& shape, const std::string& why) {
  return fail("section.invalid", "a section of kind '" + std::string(shape.kind()) + "' " + why);
}
std::string at(double s_m) { return " at s = " + std::to_string(s_m) + " m"; }

bool finite(const Pose2& pose) {
  return std::isfinite(pose.x_m) && std::isfinite(pose.y_m) && std::isfinite(pose.heading_rad);
}

/// The shape about one s, by the difference quotients of a short step to either side of it, inside the curve.
Result<void> check_at(const SectionShape& shape, double s_m, double curvature_max) {
  const double length_m = shape.length_m();
  const double step_m = std::min(0.25 * length_m, 1e-3 / std::max(curvature_max, 1e-3));
  const double low_m = std::clamp(s_m - 0.5 * step_m, 0.0, length_m - step_m);
  const double centre_m = low_m + 0.5 * step_m;
  const Pose2 low = shape.pose_at(low_m);
  const Pose2 centre = shape.pose_at(centre_m);
  const Pose2 high = shape.pose_at(low_m + step_m);
  const double curvature = shape.curvature_at(centre_m);
  if (!finite(low) || !finite(centre) || !finite(high) || !std::isfinite(curvature))
    return invalid(shape, "is not finite" + at(s_m));
  // Positions carry the rounding of a curve that may be far from its start.
  const double rounding = 1e-12 * (1.0 + std::fabs(centre.x_m) + std::fabs(centre.y_m)) / step_m;
  const SinCos direction = sincos(centre.heading_rad);
  const double dx = (high.x_m - low.x_m) / step_m;
  const double dy = (high.y_m - low.y_m) / step_m;
  if (std::fabs(norm(dx, dy) - 1.0) > slope_error + rounding)
    return invalid(shape, "is not parametrised by its arc length" + at(s_m) + ": its speed is " +
                              std::to_string(norm(dx, dy)) + ", expected 1");
  if (norm(dx - direction.cos, dy - direction.sin) > 10.0 * slope_error + rounding)
    return invalid(shape, "has a heading that is not its direction" + at(s_m));
  const double bend = wrap_angle(high.heading_rad - low.heading_rad) / step_m;
  if (std::fabs(bend - curvature) > curvature_error * (1.0 + curvature_max) + 1e-9 / step_m)
    return invalid(shape, "has a curvature of " + std::to_string(curvature) + " per m" + at(s_m) +
                              ", but its heading changes by " + std::to_string(bend) + " rad per m");
  if (std::fabs(curvature) > curvature_max * (1.0 + 1e-9) + 1e-12)
    return invalid(shape, "has a curvature of " + std::to_string(curvature) + " per m" + at(s_m) +
                              ", above its own limit of " + std::to_string(curvature_max) + " per m");
  return {};
}

}  // namespace

NextPosition SectionShape::nextAIVposition(double mDTCS_m, double DTT_m, bool indirect) const {
  COSIVA_EXPECT(mDTCS_m >= 0.0 && DTT_m >= 0.0);
  const double length = length_m();
  const double reached_m = mDTCS_m + DTT_m;
  if (reached_m > length) return {pose_at(indirect ? 0.0 : length), std::max(length - mDTCS_m, 0.0)};
  return {pose_at(indirect ? length - reached_m : reached_m), DTT_m};
}

Result<void> check_shape(const SectionShape& shape) {
  const double length_m = shape.length_m();
  const double curvature_max = shape.curvature_max_per_m();
  if (!(length_m >= length_min_m && length_m <= length_max_m))
    return invalid(shape, "must have a length from 0.000001 to 100000 m, not " + std::to_string(length_m) + " m");
  if (!(curvature_max >= 0.0 && curvature_max * length_m <= turned_max_rad))
    return invalid(shape, "may turn at most 10000 rad, not " + std::to_string(curvature_max * length_m) + " rad");
  const Pose2 start = shape.pose_at(0.0);
  if (!(std::fabs(start.x_m) <= start_m && std::fabs(start.y_m) <= start_m && std::fabs(start.heading_rad) <= start_m))
    return invalid(shape, "does not begin at the origin with heading 0");
  const double samples =
      std::clamp(std::ceil(curvature_max * length_m / turn_per_sample_rad), samples_min, samples_max);
  for (double i = 0.0; i <= samples; i += 1.0)
    if (auto checked = check_at(shape, length_m * (i / samples), curvature_max); !checked) return checked;
  return {};
}

std::shared_ptr<const SectionShape> part_of_shape(std::shared_ptr<const SectionShape> whole, double from_m,
                                                  double to_m) {
  COSIVA_EXPECT(0.0 <= from_m && from_m < to_m && to_m <= whole->length_m());
  return std::make_shared<PartOfShape>(std::move(whole), from_m, to_m);
}

std::shared_ptr<const SectionShape> reversed_shape(std::shared_ptr<const SectionShape> shape) {
  COSIVA_EXPECT(shape != nullptr);
  if (const auto* reversed = dynamic_cast<const ReversedShape*>(shape.get())) return reversed->shape();
  return std::make_shared<ReversedShape>(std::move(shape));
}

bool same_shape(const SectionShape* a, const SectionShape* b) {
  if (a == b) return true;
  return a != nullptr && b != nullptr && a->kind() == b->kind() && a->fields() == b->fields() &&
         a->length_m() == b->length_m();
}

}  // namespace cosiva::zone
