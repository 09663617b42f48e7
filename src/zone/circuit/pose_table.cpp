#include "cosiva/zone/circuit/pose_table.h"

#include "cosiva/base/expect.h"
#include "cosiva/base/math_inline.h"
#include "cosiva/base/vector_clones.h"

namespace cosiva::zone {
namespace {

/// wrap_angle without its division: at the very border the angle may turn the other way round first, and then back.
COSIVA_INLINE double wrapped(double angle_rad) {
  constexpr double per_turn = 1.0 / (2.0 * pi);
  const double turns = plain::round_even(angle_rad * per_turn);
  double left = (angle_rad - turns * 4.0 * plain::half_pi_high) - turns * 4.0 * plain::half_pi_low;
  left = left <= -pi ? left + 2.0 * pi : left;
  left = left > pi ? left - 2.0 * pi : left;
  return left;
}

COSIVA_VECTOR_CLONES void constant_curvature(const double* __restrict rows, const SectionId* __restrict sections,
                                             const double* __restrict s_m, std::size_t count, double* __restrict x_m,
                                             double* __restrict y_m, double* __restrict heading_rad) {
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t row = std::size_t{sections[i]} * 8;
    const double radius_m = rows[row + 2];
    const double angle = rows[row + 3] + rows[row + 4] * s_m[i];
    const double ahead_m = radius_m != 0.0 ? 0.0 : s_m[i];
    const auto [sin, cos] = plain::sincos(angle);
    x_m[i] = rows[row] + (radius_m * sin + ahead_m * cos);
    y_m[i] = rows[row + 1] + (ahead_m * sin - radius_m * cos);
    heading_rad[i] = wrapped(angle);
  }
}

/// The centre of a flatter arc is so far away that it would cost digits.
constexpr double flat_per_m = 1e-4;

}  // namespace

PoseTable::PoseTable(const Circuit& circuit) : circuit_{&circuit} {
  rows_.reserve(circuit.size() * stride);
  is_special_.reserve(circuit.size());
  for (SectionId id = 0; id < circuit.size(); ++id) {
    const Section& section = circuit.section(id);
    const Pose2& start = section.start();
    const double curvature = section.shape() ? 0.0 : section.curvature_at(0.0);
    const bool is_straight = section.kind() == SectionKind::straight;
    const bool is_arc = section.kind() == SectionKind::arc;
    const bool is_special = !is_straight && !(is_arc && (curvature >= flat_per_m || curvature <= -flat_per_m));
    const double radius_m = is_straight || is_special ? 0.0 : 1.0 / curvature;
    const auto [sin, cos] = sincos(start.heading_rad);
    const double row[stride] = {start.x_m - radius_m * sin, start.y_m + radius_m * cos, radius_m, start.heading_rad,
                                is_special ? 0.0 : curvature};
    rows_.insert(rows_.end(), std::begin(row), std::end(row));
    is_special_.push_back(is_special);
    none_special_ = none_special_ && !is_special;
  }
}

void PoseTable::poses(std::span<const SectionId> sections, std::span<const double> s_m, std::span<double> x_m,
                      std::span<double> y_m, std::span<double> heading_rad) const {
  const std::size_t count = sections.size();
  COSIVA_EXPECT(s_m.size() == count && x_m.size() == count && y_m.size() == count && heading_rad.size() == count);
  constant_curvature(rows_.data(), sections.data(), s_m.data(), count, x_m.data(), y_m.data(), heading_rad.data());
  if (none_special_) return;
  for (std::size_t i = 0; i < count; ++i) {
    if (!is_special_[sections[i]]) continue;
    const Pose2 pose = circuit_->pose_at({sections[i], s_m[i]});
    x_m[i] = pose.x_m;
    y_m[i] = pose.y_m;
    heading_rad[i] = pose.heading_rad;
  }
}

std::size_t PoseTable::bytes() const { return rows_.capacity() * sizeof(double) + is_special_.capacity() / 8; }

}  // namespace cosiva::zone
