#include "cosiva/zone/geometry/section.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <initializer_list>
#include <limits>
#include <string>
#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::zone {
namespace {

constexpr double piece_turn_max_rad = 0.5;
// Half a piece away from its centre, the curvature's change alone may turn this much.
constexpr double piece_bend_max_rad = 0.015;
constexpr double length_min_m = 1e-6;  // shorter sections overflow the powers of their curvature and have no use
constexpr double length_max_m = 1e5;
constexpr double turned_max_rad = 1e4;

// Below this turn an arc's centre is so far away that p − centre loses significant digits; the search does not.
constexpr double arc_turn_min_rad = 0.05;

double dot(const SinCos& direction, double x, double y) { return direction.cos * x + direction.sin * y; }

bool all_finite(std::initializer_list<double> numbers) {
  return std::ranges::all_of(numbers, [](double number) { return std::isfinite(number); });
}

/// Beyond 1e6 rad the sine's own accuracy ends; such a heading is a mistake.
Result<void> check_heading(const Pose2& start) {
  if (std::fabs(start.heading_rad) > 1e6) return fail("section.invalid", "a section's heading is beyond 1e6 rad");
  return {};
}

/// So that each piece turns by at most piece_turn_max_rad.
std::size_t pieces_needed(double turn_rad) {
  return static_cast<std::size_t>(std::max(1.0, std::ceil(turn_rad / piece_turn_max_rad)));
}

Section::Nearest at_arc_length(const Section& section, Point2 p, double s_m) {
  const Pose2 pose = section.pose_at(s_m);
  const SinCos direction = sincos(pose.heading_rad);
  const double x = p.x_m - pose.x_m;
  const double y = p.y_m - pose.y_m;
  return {s_m, direction.cos * y - direction.sin * x, norm(x, y)};
}

/// X_MP of X_SP, in the frame of the start.
Pose2 in_map(const Pose2& X_MS, const SinCos& direction, const Pose2& X_SP) {
  return {X_MS.x_m + direction.cos * X_SP.x_m - direction.sin * X_SP.y_m,
          X_MS.y_m + direction.sin * X_SP.x_m + direction.cos * X_SP.y_m,
          wrap_angle(X_MS.heading_rad + X_SP.heading_rad)};
}

/// ∫|κ| ds of a curvature that is linear from one end to the other.
double turned_rad(double curvature_start, double curvature_end, double length_m) {
  const double a = std::fabs(curvature_start);
  const double b = std::fabs(curvature_end);
  if (curvature_start * curvature_end >= 0.0) return 0.5 * (a + b) * length_m;
  return 0.5 * (a * a + b * b) / (a + b) * length_m;
}

}  // namespace

std::string_view to_string(SectionKind kind) {
  switch (kind) {
    case SectionKind::straight: return "straight";
    case SectionKind::arc: return "arc";
    case SectionKind::clothoid: return "clothoid";
    case SectionKind::shaped: return "shaped";
  }
  return "unknown";
}

double distance(const Box& box, Point2 p) noexcept {
  const double x = std::max({box.low.x_m - p.x_m, p.x_m - box.high.x_m, 0.0});
  const double y = std::max({box.low.y_m - p.y_m, p.y_m - box.high.y_m, 0.0});
  return norm(x, y);
}

Result<Section> Section::make(const Pose2& start, double length_m, double curvature_per_m,
                              double curvature_rate_per_m2) {
  if (!all_finite({start.x_m, start.y_m, start.heading_rad, length_m, curvature_per_m, curvature_rate_per_m2}))
    return fail("section.invalid", "a section's numbers must be finite");
  if (auto checked = check_heading(start); !checked) return tl::unexpected(std::move(checked).error());
  if (length_m < length_min_m || length_m > length_max_m) {
    return fail("section.invalid",
                "a section's length must be from 0.000001 to 100000 m, not " + std::to_string(length_m) + " m");
  }
  const double curvature_end = curvature_per_m + curvature_rate_per_m2 * length_m;
  const double turned = turned_rad(curvature_per_m, curvature_end, length_m);
  if (!(turned <= turned_max_rad)) {
    return fail("section.invalid", "a section may turn at most 10000 rad, not " + std::to_string(turned) + " rad");
  }

  Section section;
  section.start_ = {start.x_m, start.y_m, wrap_angle(start.heading_rad)};
  section.length_m_ = length_m;
  section.curvature_per_m_ = curvature_per_m;
  section.curvature_rate_per_m2_ = curvature_rate_per_m2;
  section.finish();
  return section;
}

Result<Section> Section::make(const Pose2& start, std::shared_ptr<const SectionShape> shape) {
  COSIVA_EXPECT(shape != nullptr);
  if (!all_finite({start.x_m, start.y_m, start.heading_rad}))
    return fail("section.invalid", "a section's numbers must be finite");
  if (auto checked = check_heading(start); !checked) return tl::unexpected(std::move(checked).error());
  if (auto checked = check_shape(*shape); !checked) return tl::unexpected(std::move(checked).error());
  Section section;
  section.start_ = {start.x_m, start.y_m, wrap_angle(start.heading_rad)};
  section.length_m_ = shape->length_m();
  section.shape_ = std::move(shape);
  section.finish();
  return section;
}

Pose2 Section::shaped_pose_at(double s_m) const { return in_map(start_, direction_, shape_->pose_at(s_m)); }

NextPosition Section::shaped_next(double mDTCS_m, double DTT_m, bool indirect) const {
  const auto [X_SP, DT_m] = shape_->nextAIVposition(mDTCS_m, DTT_m, indirect);
  return {in_map(start_, direction_, X_SP), std::clamp(DT_m, 0.0, DTT_m)};
}

SectionKind Section::kind() const {
  if (shape_) return SectionKind::shaped;
  if (curvature_rate_per_m2_ != 0.0) return SectionKind::clothoid;
  return curvature_per_m_ != 0.0 ? SectionKind::arc : SectionKind::straight;
}

double Section::curvature_at(double s_m) const {
  if (shape_) return shape_->curvature_at(std::clamp(s_m, 0.0, length_m_));
  return curvature_per_m_ + curvature_rate_per_m2_ * std::clamp(s_m, 0.0, length_m_);
}

double Section::curvature_max_per_m() const {
  if (shape_) return shape_->curvature_max_per_m();
  return std::max(std::fabs(curvature_per_m_), std::fabs(curvature_at(length_m_)));
}

/// z(u) = ∫ exp(i(θm + κm·v + κ₁·v²/2)) dv from 0 to u, as a Taylor series about the centre of each piece. With f the
/// integrand over exp(iθm), f' = i(κm + κ₁·v)·f gives f_{n+1} = i(κm·f_n + κ₁·f_{n−1})/(n + 1), and z_{n+1} = f_n/(n +
/// 1). Where the curvature is constant, the thirteenth term at 0.25 rad is under 1e-16 of the radius; where it changes,
/// κ₁·v²/2 turns alone when κm is small, and 0.015 rad of it keep the omitted terms under 1e-13 of the piece.
void Section::lay_pieces() {
  using Complex = std::complex<double>;
  const double turn_rad = curvature_max_per_m() * length_m_;
  const double by_turn = turn_rad / piece_turn_max_rad;
  const double by_bend = length_m_ * std::sqrt(std::fabs(curvature_rate_per_m2_) / (8.0 * piece_bend_max_rad));
  const auto count = static_cast<std::size_t>(std::max(1.0, std::ceil(std::max(by_turn, by_bend))));
  const double piece_m = length_m_ / static_cast<double>(count);
  pieces_per_m_ = static_cast<double>(count) / length_m_;
  pieces_.resize(count);

  Point2 from = position(start_);
  for (std::size_t i = 0; i < count; ++i) {
    Piece& piece = pieces_[i];
    piece.centre_m = (static_cast<double>(i) + 0.5) * piece_m;
    const double heading_rad =
        start_.heading_rad + piece.centre_m * (curvature_per_m_ + 0.5 * curvature_rate_per_m2_ * piece.centre_m);
    const SinCos centre = sincos(heading_rad);
    const double curvature = curvature_at(piece.centre_m);

    Complex before{0.0, 0.0};
    Complex f{centre.cos, centre.sin};
    piece.x[0] = 0.0;
    piece.y[0] = 0.0;
    for (std::size_t n = 0; n + 1 < coefficient_count; ++n) {
      const double order = static_cast<double>(n + 1);
      piece.x[n + 1] = f.real() / order;
      piece.y[n + 1] = f.imag() / order;
      const Complex g = curvature * f + curvature_rate_per_m2_ * before;
      before = f;
      f = Complex{-g.imag(), g.real()} / order;
    }
    // The pieces form a chain: each begins exactly at the end of the one before it.
    const Point2 back = piece.at(-0.5 * piece_m);
    piece.x[0] = from.x_m - back.x_m;
    piece.y[0] = from.y_m - back.y_m;
    from = piece.at(0.5 * piece_m);
  }
}

void Section::finish() {
  direction_ = sincos(start_.heading_rad);
  if (kind() != SectionKind::straight && !shape_) lay_pieces();
  end_ = pose_at(length_m_);

  box_ = {position(start_), position(start_)};
  const auto hold = [this](Point2 p, double margin_m) {
    box_.low.x_m = std::min(box_.low.x_m, p.x_m - margin_m);
    box_.low.y_m = std::min(box_.low.y_m, p.y_m - margin_m);
    box_.high.x_m = std::max(box_.high.x_m, p.x_m + margin_m);
    box_.high.y_m = std::max(box_.high.y_m, p.y_m + margin_m);
  };
  if (kind() == SectionKind::straight) return hold(position(end_), 0.0);
  // Between points h apart with a turn of at most 0.25 rad the curve strays at most 0.25·h/8 from its chord.
  if (shape_) {
    const double parts = std::max(1.0, std::ceil(curvature_max_per_m() * length_m_ / 0.25));
    for (double i = 0.0; i <= parts; i += 1.0)
      hold(position(pose_at(i == parts ? length_m_ : i * (length_m_ / parts))), length_m_ / parts * (0.25 / 8.0));
    return;
  }
  const double piece_m = 1.0 / pieces_per_m_;
  const double margin_m = 0.5 * piece_m * (0.25 / 8.0);
  for (const Piece& piece : pieces_) {
    for (const double u : {-0.5, 0.0, 0.5}) hold(piece.at(u * piece_m), margin_m);
  }
}

Section::Nearest Section::nearest(Point2 p) const {
  switch (kind()) {
    case SectionKind::straight: return nearest_on_straight(p);
    case SectionKind::arc:
      if (std::fabs(curvature_per_m_) * length_m_ > arc_turn_min_rad) return nearest_on_arc(p);
      break;
    case SectionKind::clothoid:
    case SectionKind::shaped: break;
  }
  return nearest_by_search(p);
}

Section::Nearest Section::nearest_on_straight(Point2 p) const {
  const double x = p.x_m - start_.x_m;
  const double y = p.y_m - start_.y_m;
  const double along_m = dot(direction_, x, y);
  const double left_m = direction_.cos * y - direction_.sin * x;
  const double s = std::clamp(along_m, 0.0, length_m_);
  return {s, left_m, norm(along_m - s, left_m)};
}

Section::Nearest Section::nearest_on_arc(Point2 p) const {
  const double radius_m = 1.0 / curvature_per_m_;  // negative when the centre is on the right
  const Point2 centre{start_.x_m - radius_m * direction_.sin, start_.y_m + radius_m * direction_.cos};
  const double x = p.x_m - centre.x_m;
  const double y = p.y_m - centre.y_m;
  // The spoke to the start has direction (sin θ, −cos θ)·R; turn from it to the spoke to p, in the direction of the
  // arc.
  const double sign = radius_m > 0.0 ? 1.0 : -1.0;
  const double across = sign * (direction_.sin * x - direction_.cos * y);
  const double ahead = dot(direction_, x, y);
  double turn_rad = det_atan2(ahead, across);
  if (turn_rad < 0.0) turn_rad += 2.0 * pi;

  // The circle's nearest point is the arc's, if the arc goes there; else one of its ends is.
  const double s = turn_rad / std::fabs(curvature_per_m_);
  if (s <= length_m_) {
    const double inward_m = std::fabs(radius_m) - norm(x, y);
    return {s, sign * inward_m, std::fabs(inward_m)};
  }
  const Nearest at_start = at_arc_length(*this, p, 0.0);
  const Nearest at_end = at_arc_length(*this, p, length_m_);
  return at_end.distance_m < at_start.distance_m ? at_end : at_start;
}

/// One Newton step on (p − P(s))·T(s) = 0 removes the rounding errors of the centre and the angle.
double Section::polish(Point2 p, double s_m, double low_m, double high_m) const {
  const Pose2 pose = pose_at(s_m);
  const SinCos direction = sincos(pose.heading_rad);
  const double x = p.x_m - pose.x_m;
  const double y = p.y_m - pose.y_m;
  const double slope = 1.0 - curvature_at(s_m) * (direction.cos * y - direction.sin * x);
  if (slope < 1e-3) return s_m;  // p is about the centre of curvature: every s here is as near
  return std::clamp(s_m + dot(direction, x, y) / slope, low_m, high_m);
}

/// Samples a quarter of a piece apart, then bisection helped by Newton around each sample at least as good as its
/// neighbours.
Section::Nearest Section::nearest_by_search(Point2 p) const {
  const std::size_t count = 4 * (shape_ ? pieces_needed(curvature_max_per_m() * length_m_) : pieces_.size());
  const double step_m = length_m_ / static_cast<double>(count);
  const auto s_of = [&](std::size_t i) { return i == count ? length_m_ : static_cast<double>(i) * step_m; };
  const auto distance_of = [&](std::size_t i) { return distance(position_at(s_of(i)), p); };
  const auto ahead_of = [&](double s) {  // > 0 where p is still ahead
    const Pose2 pose = pose_at(s);
    return dot(sincos(pose.heading_rad), p.x_m - pose.x_m, p.y_m - pose.y_m);
  };

  Nearest best = at_arc_length(*this, p, 0.0);
  constexpr double beyond_m = std::numeric_limits<double>::infinity();  // there is no sample before the first
  double before_m = beyond_m;
  double here_m = best.distance_m;
  for (std::size_t i = 0; i <= count; ++i) {
    const double after_m = i < count ? distance_of(i + 1) : beyond_m;
    // The true minimum is within half a step of some sample, so a sample that far above the best hides nothing.
    if (here_m <= before_m && here_m <= after_m && here_m <= best.distance_m + step_m) {
      const bool ahead = ahead_of(s_of(i)) > 0.0;
      double low = ahead || i == 0 ? s_of(i) : s_of(i - 1);
      double high = !ahead || i == count ? s_of(i) : s_of(i + 1);
      double s = s_of(i);
      for (int round = 0; round < 60 && high - low > 1e-13 * (1.0 + length_m_); ++round) {
        const double newton = polish(p, s, low, high);
        const double next = newton > low && newton < high && round % 4 != 3 ? newton : 0.5 * (low + high);
        const double moved_m = std::fabs(next - s);
        s = next;
        (ahead_of(s) > 0.0 ? low : high) = s;
        if (moved_m < 1e-14 * (1.0 + length_m_)) break;
      }
      const Nearest found = at_arc_length(*this, p, s);
      if (found.distance_m < best.distance_m) best = found;
      const Nearest sample = at_arc_length(*this, p, s_of(i));
      if (sample.distance_m < best.distance_m) best = sample;
    }
    before_m = here_m;
    here_m = after_m;
  }
  return best;
}

std::string_view kind_name(const Section& section) {
  return section.shape() ? section.shape()->kind() : to_string(section.kind());
}

Section part_of(const Section& section, double from_m, double to_m) {
  COSIVA_EXPECT(0.0 <= from_m && from_m < to_m && to_m <= section.length_m());
  const Pose2 start = section.pose_at(from_m);
  auto made = section.shape()
                  ? Section::make(start, part_of_shape(section.shape(), from_m, to_m))
                  : Section::make(start, to_m - from_m, section.curvature_at(from_m), section.curvature_rate_per_m2());
  COSIVA_EXPECT(made.has_value());
  return std::move(*made);
}

Section reversed(const Section& section) {
  const Pose2 start = turned_round(section.end());
  const double length_m = section.length_m();
  auto made = section.shape()
                  ? Section::make(start, reversed_shape(section.shape()))
                  : Section::make(start, length_m, -section.curvature_at(length_m), section.curvature_rate_per_m2());
  COSIVA_EXPECT(made.has_value());
  return std::move(*made);
}

}  // namespace cosiva::zone
