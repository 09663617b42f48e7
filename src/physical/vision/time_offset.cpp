#include "cosiva/physical/vision/time_offset.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <optional>

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

/// Sums of the normal equations of: detected − reference(t − τ) = R·lever − v·dτ.
struct Sums {
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  Eigen::Vector3d pulls = Eigen::Vector3d::Zero();
  double left{0.0};
  std::size_t pairs{0};

  void add(const Timed& detected, const State& there) {
    const auto [s, c] = sincos(there.pose.heading_rad);
    const Eigen::Vector3d x{-there.velocity_mps.x_m, c, -s};
    const Eigen::Vector3d y{-there.velocity_mps.y_m, s, c};
    const double ex = detected.pose.x_m - there.pose.x_m;
    const double ey = detected.pose.y_m - there.pose.y_m;
    squares += x * x.transpose() + y * y.transpose();
    pulls += x * ex + y * ey;
    left += ex * ex + ey * ey;
    ++pairs;
  }
  void take(const Sums& other) {
    squares -= other.squares;
    pulls -= other.pulls;
    left -= other.left;
    pairs -= other.pairs;
  }
  /// The residual after the best lever, with no shift in time or with the best one.
  [[nodiscard]] double rms(const Eigen::Vector3d& x) const {
    const double sum = left - 2.0 * x.dot(pulls) + x.dot(squares * x);
    return std::sqrt(std::max(0.0, sum) / static_cast<double>(pairs));
  }
  [[nodiscard]] Eigen::Vector3d lever_alone() const {
    Eigen::Vector3d x = Eigen::Vector3d::Zero();
    x.tail<2>() = squares.bottomRightCorner<2, 2>().ldlt().solve(pulls.tail<2>());
    return x;
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
  for (const Sums& block : blocks) {
    all.squares += block.squares;
    all.pulls += block.pulls;
    all.left += block.left;
    all.pairs += block.pairs;
  }
  return all;
}

/// The part of the velocity that no lever explains, as a ratio. 0: an offset and a lever look the same.
double separability(const Sums& sums) {
  const double all = sums.squares(0, 0);
  if (!(all > 1e-9)) return 0.0;
  const Eigen::Vector2d cross = sums.squares.bottomLeftCorner<2, 1>();
  const Eigen::Vector2d explained = sums.squares.bottomRightCorner<2, 2>().ldlt().solve(cross);
  return 1.0 - cross.dot(explained) / all;
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
  Eigen::Vector3d x = Eigen::Vector3d::Zero();
  // Where the reference bends, its line at one time is not its line at another: a few iterations.
  for (int round = 0; round < 8; ++round) {
    parts = sums_at(detected, reference, found.offset_s);
    sums = total(parts);
    if (sums.pairs < fewest) return fail("gvs.offset", "no offset within the limit brings the two together");
    x = sums.squares.ldlt().solve(sums.pulls);
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
    const double shift = others.squares.ldlt().solve(others.pulls)[0] - x[0];
    spread += shift * shift;
  }
  const auto n = static_cast<double>(blocks_of_time);
  found.standard_error_s = std::sqrt(spread * (n - 1.0) / n);
  return found;
}

}  // namespace cosiva::vision
