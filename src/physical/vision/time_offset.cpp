#include "cosiva/physical/vision/time_offset.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "cosiva/base/least_squares.h"

namespace cosiva::vision {
namespace {

constexpr double gap_s = 0.5;

struct State {
  Pose2 pose;
  Point2 velocity_mps;
};

/// The reference at a time, between its stamps.
std::optional<State> at(const std::vector<Timed>& reference, double t_s) {
  const auto after = std::ranges::upper_bound(reference, t_s, {}, &Timed::t_s);
  if (after == reference.begin() || after == reference.end()) return std::nullopt;
  const Timed& a = *(after - 1);
  const double span_s = after->t_s - a.t_s;
  if (!(span_s > 0.0) || span_s > gap_s) return std::nullopt;
  const double ratio = (t_s - a.t_s) / span_s;
  const double dx = after->pose.x_m - a.pose.x_m;
  const double dy = after->pose.y_m - a.pose.y_m;
  const double turn = wrap_angle(after->pose.heading_rad - a.pose.heading_rad);
  return State{{a.pose.x_m + ratio * dx, a.pose.y_m + ratio * dy, a.pose.heading_rad + ratio * turn},
               {dx / span_s, dy / span_s}};
}

/// Unknowns: the offset in time, and the lever.
using Unknowns = std::array<double, 3>;

double dot(const Unknowns& a, const Unknowns& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/// The lever that explains the second and third of these pulls.
std::array<double, 2> lever_of(const SquareMatrix<3>& squares, const std::array<double, 2>& pulls) {
  const SquareMatrix<2> of_lever{{{squares[1][1], squares[1][2]}, {squares[2][1], squares[2][2]}}};
  return solve_symmetric(of_lever, pulls);
}

/// Sums of the normal equations of: detected − reference(t − τ) = R·lever − v·dτ.
struct Sums {
  SquareMatrix<3> squares{};
  Unknowns pulls{};
  double left{0.0};
  std::size_t pairs{0};

  void add(const Timed& detected, const State& there) {
    const auto [s, c] = sincos(there.pose.heading_rad);
    const Unknowns x{-there.velocity_mps.x_m, c, -s};
    const Unknowns y{-there.velocity_mps.y_m, s, c};
    const double ex = detected.pose.x_m - there.pose.x_m;
    const double ey = detected.pose.y_m - there.pose.y_m;
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) squares[i][j] += x[i] * x[j] + y[i] * y[j];
      pulls[i] += x[i] * ex + y[i] * ey;
    }
    left += ex * ex + ey * ey;
    ++pairs;
  }
  void put(const Sums& other) {
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) squares[i][j] += other.squares[i][j];
      pulls[i] += other.pulls[i];
    }
    left += other.left;
    pairs += other.pairs;
  }
  void take(const Sums& other) {
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) squares[i][j] -= other.squares[i][j];
      pulls[i] -= other.pulls[i];
    }
    left -= other.left;
    pairs -= other.pairs;
  }
  [[nodiscard]] Unknowns best() const { return solve_symmetric(squares, pulls); }
  /// The residual after the best lever, with no shift in time or with the best one.
  [[nodiscard]] double rms(const Unknowns& x) const {
    Unknowns explained{};
    for (std::size_t i = 0; i < 3; ++i)
      explained[i] = squares[i][0] * x[0] + (squares[i][1] * x[1] + squares[i][2] * x[2]);
    const double sum = left - 2.0 * dot(x, pulls) + dot(x, explained);
    return std::sqrt(std::max(0.0, sum) / static_cast<double>(pairs));
  }
  [[nodiscard]] Unknowns lever_alone() const {
    const auto lever = lever_of(squares, {pulls[1], pulls[2]});
    return {0.0, lever[0], lever[1]};
  }
};

constexpr std::size_t blocks_of_time = 10;

std::vector<Sums> sums_at(const std::vector<Timed>& detected, const std::vector<Timed>& reference, double offset_s) {
  std::vector<Sums> blocks(blocks_of_time);
  for (std::size_t i = 0; i < detected.size(); ++i) {
    const auto there = at(reference, detected[i].t_s - offset_s);
    if (there) blocks[i * blocks_of_time / detected.size()].add(detected[i], *there);
  }
  return blocks;
}

Sums total(const std::vector<Sums>& blocks) {
  Sums all;
  for (const Sums& block : blocks) all.put(block);
  return all;
}

/// The part of the velocity that no lever explains, as a ratio. 0: an offset and a lever look the same.
double separability(const Sums& sums) {
  const double all = sums.squares[0][0];
  if (!(all > 1e-9)) return 0.0;
  const std::array<double, 2> cross{sums.squares[1][0], sums.squares[2][0]};
  const std::array<double, 2> explained = lever_of(sums.squares, cross);
  return 1.0 - (cross[0] * explained[0] + cross[1] * explained[1]) / all;
}

}  // namespace

Result<TimeOffset> time_offset(const std::vector<Timed>& detected, const std::vector<Timed>& reference,
                               double limit_s) {
  constexpr std::size_t fewest = 20;
  Sums sums = total(sums_at(detected, reference, 0.0));
  if (sums.pairs < fewest) {
    return fail("gvs.offset", "only " + std::to_string(sums.pairs) + " stamps lie within the reference's times; " +
                                  std::to_string(fewest) + " determine an offset");
  }
  if (separability(sums) < 0.005)
    return fail("gvs.offset",
                "speed never changes enough: an offset in time cannot be distinguished from a lever on the vehicle");
  TimeOffset found;
  found.pairs = sums.pairs;
  found.before_rms_m = sums.rms(sums.lever_alone());
  std::vector<Sums> parts;
  Unknowns x{};
  // Where the reference bends, its line at one time is not its line at another: a few iterations.
  for (int round = 0; round < 8; ++round) {
    parts = sums_at(detected, reference, found.offset_s);
    sums = total(parts);
    if (sums.pairs < fewest) return fail("gvs.offset", "no offset within the limit brings the two together");
    x = sums.best();
    found.offset_s = std::clamp(found.offset_s + x[0], -limit_s, limit_s);
    if (std::fabs(x[0]) < 1e-7) break;
  }
  found.after_rms_m = sums.rms(x);
  found.lever = {x[1], x[2]};
  // Jackknife over blocks of time.
  double spread = 0.0;
  for (const Sums& part : parts) {
    Sums others = sums;
    others.take(part);
    const double shift = others.best()[0] - x[0];
    spread += shift * shift;
  }
  const auto n = static_cast<double>(blocks_of_time);
  found.standard_error_s = std::sqrt(spread * (n - 1.0) / n);
  return found;
}

}  // namespace cosiva::vision
