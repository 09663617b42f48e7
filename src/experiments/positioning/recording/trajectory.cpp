#include "cosiva/experiments/positioning/recording/trajectory.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

#include "cosiva/base/math.h"
#include "cosiva/experiments/positioning/recording/fields.h"

namespace cosiva::experiments {
namespace {

/// A larger deviation of a quaternion or a matrix from a rotation is an error, not rounding.
constexpr double rotation_slack = 0.05;

Result<void> normalise(std::array<double, 4>& q, const std::string& location) {
  const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  if (!(std::fabs(length - 1.0) < rotation_slack))
    return fail("recording.rotation", "the quaternion's length is " + std::to_string(length) + ", not 1", location);
  // A length of 1 up to rounding stays unchanged.
  if (std::fabs(length - 1.0) > 1e-9) {
    for (double& v : q) v /= length;
  }
  return {};
}

/// The rotation part of a matrix as a quaternion (Shepperd's choice of the largest).
std::array<double, 4> quaternion_of(const std::array<double, 12>& m) {
  const double xx = m[0];
  const double yy = m[5];
  const double zz = m[10];
  const double trace = xx + yy + zz;
  std::array<double, 4> q{};
  if (trace >= xx && trace >= yy && trace >= zz) {
    q = {m[9] - m[6], m[2] - m[8], m[4] - m[1], 1.0 + trace};
  } else if (xx >= yy && xx >= zz) {
    q = {1.0 + xx - yy - zz, m[1] + m[4], m[2] + m[8], m[9] - m[6]};
  } else if (yy >= zz) {
    q = {m[1] + m[4], 1.0 - xx + yy - zz, m[6] + m[9], m[2] - m[8]};
  } else {
    q = {m[2] + m[8], m[6] + m[9], 1.0 - xx - yy + zz, m[4] - m[1]};
  }
  const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  for (double& v : q) v /= length > 0.0 ? length : 1.0;
  return q;
}

Result<std::vector<double>> numbers(const std::vector<std::string_view>& fields, std::size_t count,
                                    const std::string& location) {
  std::vector<double> values;
  for (std::size_t i = 0; i < count; ++i) {
    const auto value = finite_number(fields[i]);
    if (!value) return fail("recording.number", "'" + std::string(fields[i]) + "' is no finite number", location);
    values.push_back(*value);
  }
  return values;
}

Result<Stamped> read_kitti(const std::vector<std::string_view>& fields, double line, const std::string& location) {
  auto values = numbers(fields, 12, location);
  if (!values) return tl::unexpected(values.error());
  std::array<double, 12> m{};
  std::copy_n(values->begin(), 12, m.begin());
  for (std::size_t row = 0; row < 3; ++row) {
    const double length = m[4 * row] * m[4 * row] + m[4 * row + 1] * m[4 * row + 1] + m[4 * row + 2] * m[4 * row + 2];
    if (!(std::fabs(length - 1.0) < rotation_slack))
      return fail("recording.rotation", "the matrix is no rotation", location);
  }
  return Stamped{line, {m[3], m[7], m[11]}, quaternion_of(m)};
}

Result<Stamped> read_line(TrajectoryFormat format, std::string_view line, double index, const std::string& location) {
  const bool commas = format == TrajectoryFormat::euroc;
  const auto fields = commas ? cut_at_commas(line) : cut_at_spaces(line);
  const std::size_t wanted = format == TrajectoryFormat::kitti ? 12 : 8;
  if (commas ? fields.size() < wanted : fields.size() != wanted)
    return fail("recording.width",
                "here are " + std::to_string(fields.size()) + " numbers instead of " + std::to_string(wanted),
                location);
  if (format == TrajectoryFormat::kitti) return read_kitti(fields, index, location);
  auto values = numbers(fields, 8, location);
  if (!values) return tl::unexpected(values.error());
  const std::vector<double>& v = *values;
  Stamped pose{v[0], {v[1], v[2], v[3]}, {v[4], v[5], v[6], v[7]}};
  if (commas) {
    if (fields[0].find('.') != std::string_view::npos && v[0] < 1e15)
      return fail("recording.stamp",
                  "EuRoC's stamps are whole nanoseconds, and '" + std::string(fields[0]) +
                      "' seems to be in seconds: TUM's numbers are separated by blanks",
                  location);
    pose.t_s *= 1e-9;
    pose.q = {v[5], v[6], v[7], v[4]};
  }
  if (auto fine = normalise(pose.q, location); !fine) return tl::unexpected(fine.error());
  return pose;
}

bool begins_with_a_word(std::string_view line) {
  const std::string_view first = trimmed(line);
  const char c = first.empty() ? '0' : first.front();
  return (c >= 'a' && c <= 'z' && !first.starts_with("nan") && !first.starts_with("inf")) || (c >= 'A' && c <= 'Z');
}

void append(std::string& text, double number) {
  std::array<char, 32> digits{};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr;
  text.append(digits.data(), end);
}

Stamped between(const Stamped& a, const Stamped& b, double t_s) {
  const double u = (t_s - a.t_s) / (b.t_s - a.t_s);
  Stamped out{t_s, {}, {}};
  for (std::size_t i = 0; i < 3; ++i) out.p_m[i] = a.p_m[i] + u * (b.p_m[i] - a.p_m[i]);
  double dot = 0.0;
  for (std::size_t i = 0; i < 4; ++i) dot += a.q[i] * b.q[i];
  double squared = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    out.q[i] = (1.0 - u) * a.q[i] + u * (dot < 0.0 ? -b.q[i] : b.q[i]);
    squared += out.q[i] * out.q[i];
  }
  for (double& v : out.q) v /= squared > 0.0 ? std::sqrt(squared) : 1.0;
  return out;
}

std::optional<Stamped> interpolated(const std::vector<Stamped>& poses, double t_s, double gap_s) {
  const auto after = std::ranges::lower_bound(poses, t_s, {}, &Stamped::t_s);
  if (after != poses.end() && after->t_s == t_s) return *after;
  if (after == poses.begin() || after == poses.end()) return std::nullopt;
  const Stamped& before = *(after - 1);
  if (after->t_s - before.t_s > gap_s) return std::nullopt;
  return between(before, *after, t_s);
}

std::optional<Stamped> nearest(const std::vector<Stamped>& poses, double t_s, double gap_s) {
  const auto after = std::ranges::lower_bound(poses, t_s, {}, &Stamped::t_s);
  const Stamped* best = nullptr;
  if (after != poses.begin()) best = &*(after - 1);
  if (after != poses.end() && (best == nullptr || after->t_s - t_s < t_s - best->t_s)) best = &*after;
  if (best == nullptr || std::fabs(best->t_s - t_s) > gap_s) return std::nullopt;
  return *best;
}

std::string span_of(const Trajectory& trajectory) {
  std::string text = trajectory.name + " from ";
  append(text, trajectory.poses.front().t_s);
  text += " to ";
  append(text, trajectory.poses.back().t_s);
  return text + " s";
}

}  // namespace

Pose2 Stamped::pose() const {
  const double heading_rad = det_atan2(2.0 * (q[3] * q[2] + q[0] * q[1]), 1.0 - 2.0 * (q[1] * q[1] + q[2] * q[2]));
  return {p_m[0], p_m[1], heading_rad};
}

Stamped stamped(double t_s, const Pose2& pose) {
  const SinCos half = sincos(0.5 * pose.heading_rad);
  return {t_s, {pose.x_m, pose.y_m, 0.0}, {0.0, 0.0, half.sin, half.cos}};
}

Result<Trajectory> read_trajectory(TrajectoryFormat format, std::string_view file, std::string_view text) {
  Trajectory trajectory{std::string(file), {}};
  Lines lines{text};
  std::string_view line;
  while (lines.next(line)) {
    if (trimmed(line).empty() || trimmed(line).starts_with('#')) continue;
    const std::string location = location_of(file, lines.number());
    // Some programs write EuRoC's header without a #.
    if (format == TrajectoryFormat::euroc && trajectory.poses.empty() && lines.number() == 1 &&
        begins_with_a_word(line))
      continue;
    auto pose = read_line(format, line, static_cast<double>(trajectory.poses.size()), location);
    if (!pose) return tl::unexpected(pose.error());
    if (!trajectory.poses.empty() && !(pose->t_s > trajectory.poses.back().t_s))
      return fail("recording.stamp", "the stamp is not later than the previous stamp", location);
    trajectory.poses.push_back(*pose);
  }
  if (trajectory.poses.empty()) return fail("recording.empty", "there is no pose in it", std::string(file));
  return trajectory;
}

Result<Trajectory> read_trajectory(std::string_view file, std::string_view text) {
  Lines lines{text};
  std::string_view line;
  while (lines.next(line)) {
    if (trimmed(line).empty() || trimmed(line).starts_with('#')) continue;
    if (line.find(',') != std::string_view::npos) return read_trajectory(TrajectoryFormat::euroc, file, text);
    const bool twelve = cut_at_spaces(line).size() == 12;
    return read_trajectory(twelve ? TrajectoryFormat::kitti : TrajectoryFormat::tum, file, text);
  }
  return fail("recording.empty", "there is no pose in it", std::string(file));
}

std::string write_tum(const Trajectory& trajectory) {
  std::string text;
  for (const Stamped& pose : trajectory.poses) {
    append(text, pose.t_s);
    for (const double v : pose.p_m) {
      text += ' ';
      append(text, v);
    }
    for (const double v : pose.q) {
      text += ' ';
      append(text, v);
    }
    text += '\n';
  }
  return text;
}

Result<std::vector<Pair>> associate(const Trajectory& reference, const Trajectory& estimate,
                                    const AssociationOptions& options) {
  std::vector<Pair> pairs;
  if (options.how == Association::interpolate) {
    for (const Stamped& pose : estimate.poses) {
      if (const auto ground_truth = interpolated(reference.poses, pose.t_s, options.gap_s))
        pairs.push_back({*ground_truth, pose});
    }
  } else if (estimate.poses.size() <= reference.poses.size()) {
    for (const Stamped& pose : estimate.poses) {
      if (const auto ground_truth = nearest(reference.poses, pose.t_s, options.gap_s))
        pairs.push_back({*ground_truth, pose});
    }
  } else {
    for (const Stamped& ground_truth : reference.poses) {
      if (const auto pose = nearest(estimate.poses, ground_truth.t_s, options.gap_s))
        pairs.push_back({ground_truth, *pose});
    }
  }
  if (pairs.empty())
    return fail("recording.overlap",
                "no stamps match: " + span_of(reference) + ", " + span_of(estimate) + ", gap at most " +
                    std::to_string(options.gap_s) + " s",
                estimate.name);
  return pairs;
}

ApeMetrics ape(const std::vector<Pair>& pairs) {
  ApeMetrics metrics;
  metrics.pairs = pairs.size();
  if (pairs.empty()) return metrics;
  std::vector<double> errors;
  for (const Pair& pair : pairs) {
    double squared = 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
      const double d = pair.estimate.p_m[i] - pair.reference.p_m[i];
      squared += d * d;
    }
    errors.push_back(std::sqrt(squared));
    metrics.sse += squared;
  }
  const auto n = static_cast<double>(errors.size());
  for (const double e : errors) metrics.mean += e / n;
  for (const double e : errors) metrics.std += (e - metrics.mean) * (e - metrics.mean) / n;
  metrics.std = std::sqrt(metrics.std);
  metrics.rmse = std::sqrt(metrics.sse / n);
  std::ranges::sort(errors);
  const std::size_t half = errors.size() / 2;
  metrics.median = errors.size() % 2 == 1 ? errors[half] : 0.5 * (errors[half - 1] + errors[half]);
  metrics.min = errors.front();
  metrics.max = errors.back();
  return metrics;
}

double time_offset_s(const std::vector<Pair>& pairs, double limit_s) {
  // A vehicle that is late by τ is behind by v·τ: least squares of the error along the path over the speed.
  double numerator = 0.0;
  double denominator = 0.0;
  for (std::size_t i = 1; i + 1 < pairs.size(); ++i) {
    const Stamped& before = pairs[i - 1].reference;
    const Stamped& after = pairs[i + 1].reference;
    const double dt = after.t_s - before.t_s;
    if (!(dt > 0.0)) continue;
    for (std::size_t k = 0; k < 2; ++k) {
      const double v = (after.p_m[k] - before.p_m[k]) / dt;
      numerator += v * (pairs[i].estimate.p_m[k] - pairs[i].reference.p_m[k]);
      denominator += v * v;
    }
  }
  if (denominator <= 0.0) return 0.0;
  return std::clamp(-numerator / denominator, -limit_s, limit_s);
}

}  // namespace cosiva::experiments
