#include "cosiva/zone/geometry/fit.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::zone {
namespace {

constexpr double piece_min_m = 1e-6;  // Section's own least length
constexpr double kink_max_rad = 0.2;
// A piece whose chord nearly vanishes against its length has no initial direction.
constexpr double piece_turn_max_rad = 1.75 * pi;
// A larger turn between two samples is no bend that 32 samples resolve.
constexpr double sample_turn_max_rad = 0.5;
constexpr int samples = 32;
constexpr double fillet_radius_m = 0.3;  // of a rounded kink, where the tolerance leaves room for it
// A straight line or an arc is accepted where it deviates by this ratio of the tolerance: a file's own rounding.
constexpr double simple_ratio = 0.01;
// Joints this close need no correction: the next piece begins on the curve, not at the last one's end.
constexpr double joint_exact = 5e-10;

std::string position_text(const Pose2& pose) {
  return "(" + std::to_string(pose.x_m) + ", " + std::to_string(pose.y_m) + ")";
}

bool finite(const Pose2& pose) {
  return std::isfinite(pose.x_m) && std::isfinite(pose.y_m) && std::fabs(pose.heading_rad) <= 1e6;
}

/// Shape of a section without its position.
struct Shape {
  double length_m;
  double curvature_per_m;
  double rate_per_m2;
};

/// ∫ exp(i(A·t² + (δ − A)·t + φ0)) dt over [0, 1], and the derivative of its imaginary part by A.
struct Moments {
  double cosine{};
  double sine{};
  double slope{};
};
Moments moments(double bend, double turn, double phi) {
  // Gauss-Legendre with eight points on each of enough panels that the angle turns at most 3 rad on one: the remainder
  // is under 1e-14.
  constexpr double nodes[] = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267, 0.9602898564975363};
  constexpr double weights[] = {0.3626837833783620, 0.3137066458778873, 0.2223810344533745, 0.1012285362903763};
  const int panels = static_cast<int>(std::ceil(std::fabs(turn) + std::fabs(bend))) + 1;
  const double half = 0.5 / panels;
  Moments sum;
  for (int panel = 0; panel < panels; ++panel) {
    const double centre = (2 * panel + 1) * half;
    for (int i = 0; i < 8; ++i) {
      const double t = centre + half * (i % 2 == 0 ? nodes[i / 2] : -nodes[i / 2]);
      const SinCos angle = sincos(phi + t * (turn - bend + bend * t));
      const double weight = half * weights[i / 2];
      sum.cosine += weight * angle.cos;
      sum.sine += weight * angle.sin;
      sum.slope += weight * angle.cos * t * (t - 1.0);
    }
  }
  return sum;
}

/// G¹ Hermite: the clothoid from one pose to another position, that turns `turn_rad` along its length. After E.
/// Bertolazzi and M. Frego, "G1 fitting with clothoids" (2015): with the chord along x and of length 1, one unknown is
/// left, the quadratic part A of the turn, and the sine's integral must vanish.
std::optional<Shape> hermite(const Pose2& from, const Pose2& to, double turn_rad) {
  const double chord_m = distance(from, to);
  if (chord_m < piece_min_m) return std::nullopt;
  const double phi = wrap_angle(from.heading_rad - det_atan2(to.y_m - from.y_m, to.x_m - from.x_m));
  double bend = 3.0 * (2.0 * phi + turn_rad);
  for (int round = 0; round < 20; ++round) {
    if (!(std::fabs(bend) <= 50.0)) return std::nullopt;
    const Moments here = moments(bend, turn_rad, phi);
    if (std::fabs(here.slope) < 1e-9) return std::nullopt;
    const double step = here.sine / here.slope;
    bend -= step;
    if (std::fabs(step) < 1e-14 + 1e-13 * std::fabs(bend)) break;
  }
  const Moments found = moments(bend, turn_rad, phi);
  if (std::fabs(found.sine) > 1e-11 || found.cosine < 0.05) return std::nullopt;
  const double length_m = chord_m / found.cosine;
  return Shape{length_m, (turn_rad - bend) / length_m, 2.0 * bend / (length_m * length_m)};
}

/// The arc with this turn, which is not 0, over this chord.
Shape arc_over(double chord_m, double turn_rad) {
  const double length_m = chord_m * (0.5 * turn_rad) / det_sin(0.5 * turn_rad);
  return {length_m, turn_rad / length_m, 0.0};
}

/// A stretch of the curve, sampled.
struct Stretch {
  double from;
  double to;
  bool rounds;  ///< across a kink: no heading to keep to
  std::vector<Pose2> poses{};
  double chords_m{};     ///< length of the polygon through the samples
  double chord_max_m{};  ///< longest side of it
  double turn_rad{};
  double turn_max_rad{};  ///< greatest distance between two samples
};

struct Miss {
  double position_m{};
  double heading_rad{};
};

/// Appends section after section along the curve. Invariant: each section begins where the one before it ends.
class Fitter {
 public:
  Fitter(const PlaneCurve& curve, FitTolerance tolerance, std::size_t pieces_max)
      : curve_{curve}, tolerance_{tolerance}, pieces_max_{pieces_max} {}

  Result<Fit> run();

 private:
  [[nodiscard]] std::vector<Stretch> stretches();
  [[nodiscard]] std::optional<std::pair<double, double>> window(double before, double at, double after, double kink_rad,
                                                                double jump_m) const;
  [[nodiscard]] bool sample(Stretch& stretch);
  [[nodiscard]] bool take(const Stretch& stretch);
  [[nodiscard]] bool tries(const Stretch& stretch, const Pose2& start, const Shape& shape, FitTolerance tolerance);
  [[nodiscard]] Miss miss(const Stretch& stretch, const Section& section) const;
  void stop(const Pose2& at, std::string what);

  const PlaneCurve& curve_;
  FitTolerance tolerance_;
  std::size_t pieces_max_;
  Fit fit_;
  std::optional<Error> error_;
};

void Fitter::stop(const Pose2& at, std::string what) {
  if (error_) return;
  error_ = Error{"fit.curve", "the curve " + std::move(what) + " near " + position_text(at), ""};
}

/// The reach of a kink's rounding to both sides: a fillet with tangents this long misses the corner by
/// tangent·tan(kink/4), and half of the length on each side is left to the neighbours. The rounding is no larger than
/// necessary: a tenth of the tolerance, or enough for a bend that a small vehicle can follow.
std::optional<std::pair<double, double>> Fitter::window(double before, double at, double after, double kink_rad,
                                                        double jump_m) const {
  const double most_m = kink_rad > 0.0 ? 3.2 * tolerance_.position_m / kink_rad : 1e9;
  const double least_m = std::clamp(0.5 * fillet_radius_m * kink_rad, 0.1 * most_m, most_m);
  const double tangent_m = std::clamp(4.0 * jump_m / tolerance_.heading_rad, least_m, most_m);
  const Pose2 corner = curve_.at(at);
  const auto reach = [&](double limit) {
    double u = at + 0.5 * (limit - at);
    for (int round = 0; round < 60 && distance(curve_.at(u), corner) > tangent_m; ++round) u = at + 0.5 * (u - at);
    return u;
  };
  const std::pair<double, double> found{reach(before), reach(after)};
  if (!(found.first < at && at < found.second)) return std::nullopt;
  return found;
}

std::vector<Stretch> Fitter::stretches() {
  // Breaks so near to each other that a piece between them could not be distinguished from its joints are one break.
  const auto near = [this](double u, double v) {
    return distance(curve_.at(u), curve_.at(v)) < 2.0 * tolerance_.position_m;
  };
  std::vector<double> ends{curve_.from};
  for (const double u : curve_.breaks) {
    if (u > ends.back() && u < curve_.to && !near(ends.back(), u)) ends.push_back(u);
  }
  while (ends.size() > 1 && near(ends.back(), curve_.to)) ends.pop_back();
  ends.push_back(curve_.to);

  const double hair = 1e-13 * std::max({std::fabs(curve_.from), std::fabs(curve_.to), curve_.to - curve_.from});
  std::vector<Stretch> all;
  double from = curve_.from;
  for (std::size_t i = 1; i + 1 < ends.size(); ++i) {
    const Pose2 left = curve_.at(ends[i] - hair);
    const Pose2 right = curve_.at(ends[i] + hair);
    const double kink_rad = std::fabs(wrap_angle(right.heading_rad - left.heading_rad));
    const double jump_m = distance(left, right);
    if (!(kink_rad <= kink_max_rad)) stop(right, "has a sharp corner");
    if (!(jump_m <= tolerance_.position_m)) stop(right, "jumps");
    if (error_) return all;
    std::optional<std::pair<double, double>> rounding;
    if (kink_rad > 0.05 * tolerance_.heading_rad || jump_m > 0.01 * tolerance_.position_m)
      rounding = window(from, ends[i], ends[i + 1], kink_rad, jump_m);
    all.push_back({from, rounding ? rounding->first : ends[i], false});
    if (rounding) all.push_back({rounding->first, rounding->second, true});
    from = rounding ? rounding->second : ends[i];
  }
  all.push_back({from, curve_.to, false});
  return all;
}

/// False where the curve is not finite, which ends the whole fit.
bool Fitter::sample(Stretch& stretch) {
  stretch.poses.resize(samples + 1);
  for (int i = 0; i <= samples; ++i) {
    const double u = i == samples ? stretch.to : stretch.from + (stretch.to - stretch.from) * i / samples;
    Pose2& pose = stretch.poses[static_cast<std::size_t>(i)];
    pose = curve_.at(u);
    if (finite(pose)) continue;
    error_ = Error{"fit.curve", "the curve is not finite at parameter " + std::to_string(u), ""};
    return false;
  }
  for (std::size_t i = 1; i < stretch.poses.size(); ++i) {
    const Pose2& before = stretch.poses[i - 1];
    const Pose2& here = stretch.poses[i];
    const double chord_m = distance(before, here);
    const double turn_rad = wrap_angle(here.heading_rad - before.heading_rad);
    stretch.chords_m += chord_m;
    stretch.chord_max_m = std::max(stretch.chord_max_m, chord_m);
    stretch.turn_rad += turn_rad;
    stretch.turn_max_rad = std::max(stretch.turn_max_rad, std::fabs(turn_rad));
  }
  return true;
}

/// Worst distance from the sampled curve to the section, or between their ends, and heading between them there.
Miss Fitter::miss(const Stretch& stretch, const Section& section) const {
  Miss worst;
  double s = 0.0;
  for (std::size_t i = 0; i < stretch.poses.size(); ++i) {
    const Pose2& pose = stretch.poses[i];
    if (i > 0) s += distance(stretch.poses[i - 1], pose);
    // Newton to the foot of the perpendicular; the running sum of chords gives a close start.
    Pose2 foot;
    for (int round = 0; round < 4; ++round) {
      s = std::clamp(s, 0.0, section.length_m());
      foot = section.pose_at(s);
      const SinCos direction = sincos(foot.heading_rad);
      const double x = pose.x_m - foot.x_m;
      const double y = pose.y_m - foot.y_m;
      const double ahead_m = direction.cos * x + direction.sin * y;
      const double slope = 1.0 - section.curvature_at(s) * (direction.cos * y - direction.sin * x);
      s += ahead_m / std::max(slope, 0.1);
      if (std::fabs(ahead_m) < 1e-12) break;
    }
    s = std::clamp(s, 0.0, section.length_m());
    foot = section.pose_at(s);
    worst.position_m = std::max(worst.position_m, distance(foot, pose));
    worst.heading_rad = std::max(worst.heading_rad, std::fabs(wrap_angle(foot.heading_rad - pose.heading_rad)));
  }
  // An arc may end too early or too late by more than its deviation from the curve anywhere.
  worst.position_m = std::max(worst.position_m, distance(section.end(), stretch.poses.back()));
  return worst;
}

/// Appends the section if it follows the stretch within the tolerance.
bool Fitter::tries(const Stretch& stretch, const Pose2& start, const Shape& shape, FitTolerance tolerance) {
  auto section = Section::make(start, shape.length_m, shape.curvature_per_m, shape.rate_per_m2);
  if (!section) return false;
  const Miss missed = miss(stretch, *section);
  if (missed.position_m > tolerance.position_m || (missed.heading_rad > tolerance.heading_rad && !stretch.rounds))
    return false;
  COSIVA_EXPECT(fit_.sections.empty() || distance(fit_.sections.back().end(), section->start()) < 1e-9);
  fit_.length_m += section->length_m();
  fit_.worst_position_m = std::max(fit_.worst_position_m, missed.position_m);
  fit_.worst_heading_rad = std::max(fit_.worst_heading_rad, missed.heading_rad);
  fit_.sections.push_back(std::move(*section));
  return true;
}

/// False where the stretch must be cut in two.
bool Fitter::take(const Stretch& stretch) {
  if (stretch.turn_max_rad > sample_turn_max_rad || std::fabs(stretch.turn_rad) > piece_turn_max_rad) return false;
  // A chord longer than half of the polygon is a jump, or so nearly one that the samples carry no information.
  if (stretch.chord_max_m > std::max(0.5 * stretch.chords_m, tolerance_.position_m)) return false;
  const Pose2& target = stretch.poses.back();
  Pose2 start = stretch.poses.front();
  // Each piece begins at the end of the one before it, and ends on the curve: the next piece corrects a small
  // deviation.
  if (!fit_.sections.empty()) {
    const Pose2& end = fit_.sections.back().end();
    const double off_rad = wrap_angle(end.heading_rad - start.heading_rad);
    if (distance(end, start) > joint_exact || std::fabs(off_rad) > joint_exact) start = end;
  }
  const double turn_rad = stretch.turn_rad - wrap_angle(start.heading_rad - stretch.poses.front().heading_rad);

  const FitTolerance close{simple_ratio * tolerance_.position_m, simple_ratio * tolerance_.heading_rad};
  const double chord_m = distance(start, target);
  if (!stretch.rounds) {
    if (std::fabs(turn_rad) <= 2.0 * close.heading_rad && tries(stretch, start, {chord_m, 0.0, 0.0}, close))
      return true;
    if (std::fabs(turn_rad) > 1e-9 && tries(stretch, start, arc_over(chord_m, turn_rad), close)) return true;
  }
  const auto shape = hermite(start, target, turn_rad);
  return shape && tries(stretch, start, *shape, tolerance_);
}

Result<Fit> Fitter::run() {
  if (!std::isfinite(curve_.from) || !std::isfinite(curve_.to) || !(curve_.from < curve_.to))
    return fail("fit.curve", "the curve has no length");
  std::vector<Stretch> ahead = stretches();
  std::reverse(ahead.begin(), ahead.end());
  std::size_t cuts = 0;
  while (!ahead.empty() && !error_) {
    Stretch stretch = std::move(ahead.back());
    ahead.pop_back();
    if (!(stretch.to > stretch.from) || !sample(stretch)) continue;

    // A piece too short to be a section is left to the next, or the last, whose end it moves by less than a micrometre.
    const bool stub = stretch.chords_m < 2.0 * piece_min_m;
    if (stub && stretch.turn_max_rad <= kink_max_rad) continue;
    // An unannounced kink is found here: cut down until its rounding stays within the tolerance.
    if (stretch.chords_m < 2.0 * tolerance_.position_m && std::fabs(stretch.turn_rad) <= kink_max_rad)
      stretch.rounds = true;
    if (take(stretch)) continue;

    const double centre = 0.5 * (stretch.from + stretch.to);
    if (stub || !(stretch.from < centre && centre < stretch.to)) {
      stop(stretch.poses.front(), "has a sharp corner or turns back on itself");
    } else if (++cuts > pieces_max_) {
      stop(stretch.poses.front(), "needs more than " + std::to_string(pieces_max_) + " pieces");
    } else {
      ahead.push_back({centre, stretch.to, stretch.rounds});
      ahead.push_back({stretch.from, centre, stretch.rounds});
    }
  }
  if (error_) return tl::unexpected(std::move(*error_));
  if (fit_.sections.empty()) return fail("fit.curve", "the curve is shorter than 0.000001 m");
  return std::move(fit_);
}

}  // namespace

Result<Fit> fit(const PlaneCurve& curve, FitTolerance tolerance, std::size_t pieces_max) {
  return Fitter{curve, tolerance, pieces_max}.run();
}

}  // namespace cosiva::zone
