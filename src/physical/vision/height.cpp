#include "cosiva/physical/vision/height.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <string>

#include "cosiva/base/least_squares.h"
#include "cosiva/base/math.h"

namespace cosiva::vision {
namespace {

using Vector3 = std::array<double, 3>;

double dot(const Vector3& a, const Vector3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

Vector3 column(const SquareMatrix<3>& m, std::size_t j) { return {m[0][j], m[1][j], m[2][j]}; }

Vector3 cross(const Vector3& a, const Vector3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// The camera's position in the floor's frame if its focal length is f (in the map's scale), by the homography's
/// columns. Source: Zhang, A flexible new technique for camera calibration, 2000, section 3.1.
Vector3 pose_with(const SquareMatrix<3>& floor_to_image, double f) {
  SquareMatrix<3> m = floor_to_image;
  for (std::size_t j = 0; j < 3; ++j) {
    m[0][j] /= f;
    m[1][j] /= f;
  }
  const double scale =
      std::sqrt(std::sqrt(dot(column(m, 0), column(m, 0))) * std::sqrt(dot(column(m, 1), column(m, 1))));
  for (auto& row : m)
    for (double& value : row) value /= scale;
  const Vector3 third = cross(column(m, 0), column(m, 1));
  SquareMatrix<3> rotation = m;
  for (std::size_t i = 0; i < 3; ++i) rotation[i][2] = third[i];
  rotation = nearest_orthogonal(rotation);
  const Vector3 shift = column(m, 2);
  return {-dot(column(rotation, 0), shift), -dot(column(rotation, 1), shift), -dot(column(rotation, 2), shift)};
}

/// A direction mapped by A.
double direction(const std::array<double, 4>& linear, double heading_rad) {
  const auto [s, c] = sincos(heading_rad);
  return det_atan2(linear[2] * c + linear[3] * s, linear[0] * c + linear[1] * s);
}

/// The mean angle from `detected`, turned by A, to `surveyed`. Nothing where they contradict each other.
std::optional<double> turn_of(const std::vector<SurveyedPose>& poses, const std::array<double, 4>& linear) {
  double s = 0.0;
  double c = 0.0;
  for (const SurveyedPose& pose : poses) {
    const SinCos turn = sincos(pose.surveyed.heading_rad - direction(linear, pose.detected.heading_rad));
    s += turn.sin;
    c += turn.cos;
  }
  if (norm(s, c) < 1e-6) return std::nullopt;
  return det_atan2(s, c);
}

/// The vehicle's heading, if the marker were level.
double level_heading(const PoseFit& fit, double detected_rad) {
  return wrap_angle(direction(fit.linear, detected_rad) + fit.turn_rad);
}

/// The vehicle's heading.
double heading_of(const PoseFit& fit, const Pose2& detected) {
  const auto [s, c] = sincos(detected.heading_rad);
  const double lean =
      c * (fit.lean_per_m * detected.y_m + fit.lean.y_m) - s * (fit.lean_per_m * detected.x_m + fit.lean.x_m);
  return wrap_angle(level_heading(fit, detected.heading_rad) + lean);
}

constexpr double rank_threshold = 1e-4;

bool all_finite(const std::vector<double>& values) {
  return std::ranges::all_of(values, [](double value) { return std::isfinite(value); });
}

void set_row(Matrix& matrix, std::size_t row, std::initializer_list<double> values) {
  std::size_t column = 0;
  for (const double value : values) matrix(row, column++) = value;
}

/// Turn and, if requested, lean: small angles, hence least squares of the residuals of the turn alone.
bool fit_heading(const std::vector<SurveyedPose>& poses, bool leans, PoseFit& fit) {
  const auto turn = turn_of(poses, fit.linear);
  if (!turn) return false;
  fit.turn_rad = *turn;
  fit.lean_per_m = 0.0;
  fit.lean = {};
  if (!leans) return true;
  Matrix left{poses.size(), 4};
  std::vector<double> right(poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const SurveyedPose& pose = poses[i];
    const auto [s, c] = sincos(pose.detected.heading_rad);
    set_row(left, i, {1.0, c * pose.detected.y_m - s * pose.detected.x_m, -s, c});
    right[i] = wrap_angle(pose.surveyed.heading_rad - heading_of(fit, pose.detected));
  }
  const auto x = least_squares(left, right, rank_threshold);
  if (!x) return false;
  fit.turn_rad += (*x)[0];
  fit.lean_per_m = (*x)[1];
  fit.lean = {(*x)[2], (*x)[3]};
  return all_finite(*x);
}

struct Rows {
  Matrix left;
  std::vector<double> right;
};

/// One pose makes two equations in A, b and the lever.
Rows rows_of(const std::vector<SurveyedPose>& poses, const PoseFit& before, bool full) {
  Rows rows{Matrix{2 * poses.size(), full ? 8U : 5U}, std::vector<double>(2 * poses.size(), 0.0)};
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Pose2& detected = poses[i].detected;
    const auto [s, c] = sincos(level_heading(before, detected.heading_rad));
    const std::size_t k = 2 * i;
    if (full) {
      set_row(rows.left, k, {detected.x_m, detected.y_m, 0.0, 0.0, 1.0, 0.0, c, -s});
      set_row(rows.left, k + 1, {0.0, 0.0, detected.x_m, detected.y_m, 0.0, 1.0, s, c});
    } else {
      set_row(rows.left, k, {detected.x_m, 1.0, 0.0, c, -s});
      set_row(rows.left, k + 1, {detected.y_m, 0.0, 1.0, s, c});
    }
    rows.right[k] = poses[i].surveyed.x_m;
    rows.right[k + 1] = poses[i].surveyed.y_m;
  }
  return rows;
}

bool solve(const std::vector<SurveyedPose>& poses, bool full, bool leans, PoseFit& fit) {
  if (!fit_heading(poses, leans, fit)) return false;
  const Rows rows = rows_of(poses, fit, full);
  const auto found = least_squares(rows.left, rows.right, rank_threshold);
  if (!found || !all_finite(*found)) return false;
  const std::vector<double>& x = *found;
  const std::size_t rest = full ? 4 : 1;
  fit.linear = full ? std::array{x[0], x[1], x[2], x[3]} : std::array{x[0], 0.0, 0.0, x[0]};
  fit.shift = {x[rest], x[rest + 1]};
  fit.lever = {x[rest + 2], x[rest + 3]};
  return true;
}

std::optional<PoseFit> fit_once(const std::vector<SurveyedPose>& poses, bool full, bool leans) {
  // The lever's direction depends on A, which is nearly the identity: the result is stable after three rounds.
  PoseFit fit;
  for (int round = 0; round < 3; ++round)
    if (!solve(poses, full, leans, fit)) return std::nullopt;
  if (!fit_heading(poses, leans, fit)) return std::nullopt;
  return fit;
}

}  // namespace

Point2 at_height(Point2 detected, double height_m, const CameraPose& camera) {
  if (camera.height_m <= 0.0) return detected;
  const double ratio = height_m / camera.height_m;
  return {detected.x_m + ratio * (camera.foot.x_m - detected.x_m),
          detected.y_m + ratio * (camera.foot.y_m - detected.y_m)};
}

Point2 detected_from(Point2 there, double height_m, const CameraPose& camera) {
  if (camera.height_m <= 0.0) return there;
  const double ratio = height_m / camera.height_m;
  return {(there.x_m - ratio * camera.foot.x_m) / (1.0 - ratio), (there.y_m - ratio * camera.foot.y_m) / (1.0 - ratio)};
}

std::optional<CameraPose> camera_over(const FloorMap& map, double height_m) {
  SquareMatrix<3> floor_from_image{};
  for (std::size_t i = 0; i < 9; ++i) floor_from_image[i / 3][i % 3] = map.homography[i];
  const auto back = inverse(floor_from_image);
  if (!back || !(height_m > 0.0)) return std::nullopt;
  // The longer the lens, the higher the camera that shows the same floor: the wanted height is between.
  double short_f = 0.05;
  double long_f = 50.0;
  const auto height_with = [&](double f) { return std::fabs(pose_with(*back, f)[2]); };
  if (height_with(short_f) > height_m || height_with(long_f) < height_m) return std::nullopt;
  constexpr int halvings = 60;
  for (int i = 0; i < halvings; ++i) {
    const double f = std::sqrt(short_f * long_f);
    (height_with(f) < height_m ? short_f : long_f) = f;
  }
  const Vector3 track_position = pose_with(*back, short_f);
  return CameraPose{{track_position[0], track_position[1]}, height_m};
}

Pose2 PoseFit::apply(const Pose2& detected) const {
  // The lever is in the same image as the marker's direction: it leans with it.
  const auto [s, c] = sincos(level_heading(*this, detected.heading_rad));
  return {linear[0] * detected.x_m + linear[1] * detected.y_m + shift.x_m + c * lever.x_m - s * lever.y_m,
          linear[2] * detected.x_m + linear[3] * detected.y_m + shift.y_m + s * lever.x_m + c * lever.y_m,
          heading_of(*this, detected)};
}

const MarkerProfile& profile_of(int id, const std::vector<MarkerProfile>& profiles) {
  static const MarkerProfile flat;
  const MarkerProfile* everybodys = &flat;
  for (const MarkerProfile& profile : profiles) {
    if (profile.id == id) return profile;
    if (profile.id < 0) everybodys = &profile;
  }
  return *everybodys;
}

Pose2 vehicle_at(const Pose2& detected, const MarkerProfile& profile, const CameraPose& camera) {
  if (profile.surveyed) return profile.surveyed->apply(detected);
  const Point2 there = at_height(position(detected), profile.height_m, camera);
  return Pose2{there.x_m, there.y_m, detected.heading_rad} * inverse(profile.X_BT);
}

namespace {

/// Nothing where the poses are too few or too similar for a result.
std::optional<PoseResiduals> residuals_of(const std::vector<SurveyedPose>& poses, bool full, bool leans) {
  const auto all = fit_once(poses, full, leans);
  if (!all) return std::nullopt;
  PoseResiduals result;
  result.fit = *all;
  double spread = 0.0;
  for (const SurveyedPose& pose : poses) {
    const double off = wrap_angle(all->apply(pose.detected).heading_rad - pose.surveyed.heading_rad);
    spread += off * off / static_cast<double>(poses.size());
  }
  result.heading_sd_rad = std::sqrt(spread);
  double squares = 0.0;
  double turns = 0.0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    std::vector<SurveyedPose> others = poses;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
    const auto fit = fit_once(others, full, leans);
    if (!fit) return std::nullopt;
    const Pose2 put = fit->apply(poses[i].detected);
    const Pose2& there = poses[i].surveyed;
    result.left_out.push_back(
        {put.x_m - there.x_m, put.y_m - there.y_m, wrap_angle(put.heading_rad - there.heading_rad)});
    const double off = distance(put, there);
    const double turn = std::fabs(result.left_out.back().heading_rad);
    squares += off * off;
    turns += turn * turn;
    result.max_m = std::max(result.max_m, off);
    result.heading_max_rad = std::max(result.heading_max_rad, turn);
    result.stopped_m += poses[i].stopped_m / static_cast<double>(poses.size());
  }
  result.rms_m = std::sqrt(squares / static_cast<double>(poses.size()));
  result.heading_rms_rad = std::sqrt(turns / static_cast<double>(poses.size()));
  return result;
}

}  // namespace

Result<PoseResiduals> fit_poses(const std::vector<SurveyedPose>& poses, bool full) {
  constexpr std::size_t fewest = 6;
  if (poses.size() < fewest)
    return fail("gvs.poses",
                "holds " + std::to_string(poses.size()) + " poses, and a fit needs " + std::to_string(fewest));
  const auto level = residuals_of(poses, full, false);
  if (!level)
    return fail(
        "gvs.poses",
        "do not determine a marker's height and position: drive to at least three positions that are not on one line, "
        "with at least three headings");
  const auto leaning = residuals_of(poses, full, true);
  return leaning && leaning->heading_rms_rad < level->heading_rms_rad ? *leaning : *level;
}

}  // namespace cosiva::vision
