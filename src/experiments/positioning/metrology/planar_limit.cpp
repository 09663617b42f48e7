#include "cosiva/experiments/positioning/metrology/planar_limit.h"

#include <algorithm>
#include <cmath>

#include "cosiva/aiv/estimation/planar.h"
#include "cosiva/base/expect.h"
#include "cosiva/base/math.h"

namespace cosiva::experiments {
namespace {

using estimation::Odometry;
using estimation::Range;
using estimation::Reading;
using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;

/// The unknowns: pose, scales of odometry and a gyroscope's offset, the common error of all ranges, then a bias of each
/// station.
enum Part : Eigen::Index { x, y, heading, distance_scale, turn_scale, turn_drift, range_scale, range_common, stations };

double squared(double v) { return v * v; }

/// The shortest distance that defines a course, where the ground truth has no heading.
constexpr double course_m = 0.1;

/// The ground truth at the moments, with a heading: its own, or the course of its positions.
std::vector<Pose2> drive_of(const Trial& run) {
  std::vector<Pose2> drive;
  drive.reserve(run.moments.size());
  for (const Moment& moment : run.moments) drive.push_back(moment.ground_truth);
  if (run.heading_known) return drive;
  std::size_t before = 0;
  std::size_t after = 0;
  for (std::size_t i = 0; i < drive.size(); ++i) {
    while (before + 1 < i && distance(drive[before + 1], drive[i]) >= course_m) ++before;
    after = std::max(after, i);
    while (after + 1 < drive.size() && distance(drive[i], drive[after]) < course_m) ++after;
    const double dx = drive[after].x_m - drive[before].x_m;
    const double dy = drive[after].y_m - drive[before].y_m;
    if (dx != 0.0 || dy != 0.0) drive[i].heading_rad = det_atan2(dy, dx);
  }
  return drive;
}

Pose2 between(const Pose2& a, const Pose2& b, double ratio) {
  return {a.x_m + ratio * (b.x_m - a.x_m), a.y_m + ratio * (b.y_m - a.y_m),
          wrap_angle(a.heading_rad + ratio * wrap_angle(b.heading_rad - a.heading_rad))};
}

/// The matrix F of a step: the identity plus some entries of the pose's rows, and stations' biases that decay.
struct Move {
  double x_heading, y_heading;
  double x_distance, y_distance;
  double x_turn, y_turn, heading_turn;
  double drifts_s;  ///< time over which a gyroscope measured
  double keeps;
};

/// A step to be processed backwards for the smoother.
struct Step {
  enum class Kind { move, measure, moment } kind;
  Move move{};
  Vector slope{};  ///< of a measurement
  Vector gain{};   ///< P·h/s
  double s{};      ///< variance of its innovation
  Matrix ahead{};  ///< of a moment: P's rows of x and y
};

class PlanarInformation {
 public:
  explicit PlanarInformation(const Trial& run)
      : run_{run}, sensors_{run.setting.sensors}, drive_{drive_of(run)}, numbers_{numbers_of(run)} {
    const auto n = stations + static_cast<Eigen::Index>(numbers_.size());
    Vector variances = Vector::Constant(n, squared(sensors_.range_station_sigma_m));
    variances(x) = variances(y) = squared(run.setting.start_sigma_m);
    // With an unknown heading a step ends anywhere on a circle: in the linear model this equals 1 rad. A larger value
    // would not be a limit, since no estimator is as bad.
    variances(heading) = squared(std::fmin(1.0, run.setting.start_heading_sigma_rad));
    variances(distance_scale) = squared(sensors_.distance_scale_sigma);
    variances(turn_scale) = squared(sensors_.turn_scale_sigma);
    variances(turn_drift) = squared(sensors_.turn_drift_sigma_radps);
    variances(range_scale) = squared(sensors_.range_scale_sigma);
    variances(range_common) = squared(sensors_.range_common_sigma_m);
    p_ = variances.asDiagonal();
  }

  RunLimit limit() {
    forwards();
    const auto count = static_cast<double>(run_.moments.size());
    return {filter_m2_ / count, backwards() / count};
  }

 private:
  static std::vector<std::uint32_t> numbers_of(const Trial& run) {
    std::vector<std::uint32_t> numbers;
    for (const Event& event : run.events) {
      if (const auto* range = std::get_if<Range>(&event)) numbers.push_back(range->station);
    }
    std::ranges::sort(numbers);
    numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
    return numbers;
  }

  void forwards() {
    std::size_t inputs = 0;
    for (std::size_t k = 0; k < run_.moments.size(); ++k) {
      const std::size_t until = run_.moments[k].events;
      const Pose2 from = k > 0 ? drive_[k - 1] : began_at(until);
      double lasts_s = 0.0;
      for (std::size_t i = inputs; i < until; ++i) {
        if (const auto* odometry = std::get_if<Odometry>(&run_.events[i])) lasts_s += odometry->duration_s;
      }
      double passed_s = 0.0;
      const auto here = [&](double t_s) { return between(from, drive_[k], lasts_s > 0.0 ? t_s / lasts_s : 1.0); };
      for (; inputs < until; ++inputs) {
        if (const auto* odometry = std::get_if<Odometry>(&run_.events[inputs])) {
          move(*odometry, here(passed_s + 0.5 * odometry->duration_s).heading_rad);
          passed_s += odometry->duration_s;
        } else if (const auto* range = std::get_if<Range>(&run_.events[inputs])) {
          measure(*range, here(passed_s));
        } else {
          measure(std::get<Reading>(run_.events[inputs]), here(passed_s));
        }
      }
      filter_m2_ += p_(x, x) + p_(y, y);
      steps_.push_back({Step::Kind::moment, {}, {}, {}, 0.0, p_.topRows(2)});
    }
  }

  /// The start of the drive to the first moment, from the odometry up to it.
  [[nodiscard]] Pose2 began_at(std::size_t until) const {
    Pose2 step_pose;
    for (std::size_t i = 0; i < until; ++i) {
      if (const auto* odometry = std::get_if<Odometry>(&run_.events[i]))
        step_pose = estimation::moved(step_pose, *odometry);
    }
    return drive_[0] * inverse(step_pose);
  }

  void move(const Odometry& odometry, double centre_rad) {
    // A course has no backward direction.
    const estimation::StepCourse course = estimation::course_of(odometry);
    const double d = run_.heading_known ? course.distance_m : std::fabs(course.distance_m);
    const SinCos h = sincos(run_.heading_known ? centre_rad + course.aside_rad : centre_rad);
    const double turn = odometry.turn_rad;
    const Move f{-d * h.sin,
                 d * h.cos,
                 -d * h.cos,
                 -d * h.sin,
                 0.5 * d * h.sin * turn,
                 -0.5 * d * h.cos * turn,
                 -turn,
                 turn != 0.0 ? odometry.duration_s : 0.0,
                 det_exp(-std::fabs(d) / sensors_.range_station_length_m)};
    const auto go = [&](auto&& of) {
      of(x) += f.x_heading * of(heading) + f.x_distance * of(distance_scale) + f.x_turn * of(turn_scale);
      of(y) += f.y_heading * of(heading) + f.y_distance * of(distance_scale) + f.y_turn * of(turn_scale);
      of(heading) += f.heading_turn * of(turn_scale);
      // The turn affects x and y by half: its error builds up during the step.
      of(x) += -0.5 * f.x_heading * f.drifts_s * of(turn_drift);
      of(y) += -0.5 * f.y_heading * f.drifts_s * of(turn_drift);
      of(heading) -= f.drifts_s * of(turn_drift);
      for (Eigen::Index i = stations; i < p_.rows(); ++i) of(i) *= f.keeps;
    };
    for (Eigen::Index i = 0; i < p_.cols(); ++i) go(p_.col(i));
    for (Eigen::Index i = 0; i < p_.rows(); ++i) go(p_.row(i));
    const estimation::Vector2 variances = estimation::step_variances(sensors_, odometry);
    const estimation::Vector3 along{h.cos, h.sin, 0.0};
    const estimation::Vector3 about{-0.5 * d * h.sin, 0.5 * d * h.cos, 1.0};
    p_.topLeftCorner<3, 3>() += variances(0) * along * along.transpose() + variances(1) * about * about.transpose();
    for (Eigen::Index i = stations; i < p_.rows(); ++i)
      p_(i, i) += squared(sensors_.range_station_sigma_m) * (1.0 - f.keeps * f.keeps);
    estimation::make_symmetric(p_);
    steps_.push_back({Step::Kind::move, f, {}, {}, 0.0, {}});
  }

  void measure(const Range& range, const Pose2& ground_truth) {
    const double dx = ground_truth.x_m - range.station_M.x_m;
    const double dy = ground_truth.y_m - range.station_M.y_m;
    const double distance_m = norm(dx, dy);
    if (distance_m < 1e-6) return;
    Vector slope = Vector::Zero(p_.rows());
    slope(x) = dx / distance_m;
    slope(y) = dy / distance_m;
    slope(range_scale) = distance_m;
    slope(range_common) = 1.0;
    slope(stations + (std::ranges::lower_bound(numbers_, range.station) - numbers_.begin())) = 1.0;
    learn(std::move(slope), squared(sensors_.range_sigma_m));
  }

  void measure(const Reading& reading, const Pose2& ground_truth) {
    const Point2 detected_B = inverse(ground_truth) * reading.fiducial_M;
    const SinCos h = sincos(ground_truth.heading_rad);
    Vector along = Vector::Zero(p_.rows());
    along.head<3>() = estimation::Vector3(-h.cos, -h.sin, detected_B.y_m);
    learn(std::move(along), squared(sensors_.fiducial_along_sigma_m));
    Vector across = Vector::Zero(p_.rows());
    across.head<3>() = estimation::Vector3(h.sin, -h.cos, -detected_B.x_m);
    learn(std::move(across), squared(sensors_.fiducial_across_sigma_m));
  }

  void learn(Vector slope, double variance) {
    const Vector ph = p_.lazyProduct(slope);
    const double s = slope.dot(ph) + variance;
    // Without uncertainty in the state and in the measurement there is nothing to learn.
    if (!(s > 0.0)) return;
    Vector gain = ph / s;
    p_ -= gain.lazyProduct(ph.transpose());
    estimation::make_symmetric(p_);
    steps_.push_back({Step::Kind::measure, {}, std::move(slope), std::move(gain), s, {}});
  }

  /// Λ of the following steps: the smoother's covariance is P − P·Λ·P. Sum over the moments.
  [[nodiscard]] double backwards() const {
    double sum_m2 = 0.0;
    Matrix later = Matrix::Zero(p_.rows(), p_.rows());
    for (std::size_t i = steps_.size(); i-- > 0;) {
      const Step& step = steps_[i];
      if (step.kind == Step::Kind::move) {
        back(step.move, later);
      } else if (step.kind == Step::Kind::measure) {
        // (I − g·hᵀ)ᵀ·Λ·(I − g·hᵀ) + h·hᵀ/s
        const Vector lg = later.lazyProduct(step.gain);
        const double both = step.gain.dot(lg) + 1.0 / step.s;
        later += both * step.slope.lazyProduct(step.slope.transpose());
        later -= step.slope.lazyProduct(lg.transpose());
        later -= lg.lazyProduct(step.slope.transpose());
        estimation::make_symmetric(later);
      } else {
        for (Eigen::Index row = 0; row < 2; ++row) {
          const Vector p = step.ahead.row(row).transpose();
          sum_m2 += p(row) - p.dot(Vector(later.lazyProduct(p)));
        }
      }
    }
    return sum_m2;
  }

  /// Fᵀ·Λ·F.
  static void back(const Move& f, Matrix& later) {
    const auto go = [&](auto&& of) {
      of(turn_scale) += f.x_turn * of(x) + f.y_turn * of(y) + f.heading_turn * of(heading);
      of(turn_drift) -= f.drifts_s * (0.5 * f.x_heading * of(x) + 0.5 * f.y_heading * of(y) + of(heading));
      of(distance_scale) += f.x_distance * of(x) + f.y_distance * of(y);
      of(heading) += f.x_heading * of(x) + f.y_heading * of(y);
      for (Eigen::Index i = stations; i < later.rows(); ++i) of(i) *= f.keeps;
    };
    for (Eigen::Index i = 0; i < later.cols(); ++i) go(later.col(i));
    for (Eigen::Index i = 0; i < later.rows(); ++i) go(later.row(i));
  }

  const Trial& run_;
  const estimation::SensorModel& sensors_;
  std::vector<Pose2> drive_;
  std::vector<std::uint32_t> numbers_;
  Matrix p_;
  std::vector<Step> steps_;
  double filter_m2_{0.0};
};

}  // namespace

RunLimit planar_limit_of(const Trial& run) {
  COSIVA_EXPECT(!run.moments.empty() && run.setting.start_known);
  return PlanarInformation{run}.limit();
}

}  // namespace cosiva::experiments
