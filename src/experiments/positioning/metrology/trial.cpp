#include "cosiva/experiments/positioning/metrology/trial.h"

#include <cmath>

#include "cosiva/base/expect.h"
#include "cosiva/base/math.h"
#include "cosiva/base/math_inline.h"
#include "cosiva/base/vector_clones.h"

namespace cosiva::experiments {
namespace {

using estimation::Estimate;

/// Larger than any plausible value: for a covariance without width in some direction.
double nees_of(double x, double y, const estimation::Matrix3& c) {
  if (!std::isfinite(c(0, 0))) return c(0, 0);  // no covariance is stated
  const double det = c(0, 0) * c(1, 1) - c(0, 1) * c(1, 0);
  if (!(det > 0.0)) return x == 0.0 && y == 0.0 ? 0.0 : 1e9;
  return (c(1, 1) * x * x - 2.0 * c(0, 1) * x * y + c(0, 0) * y * y) / det;
}

/// The ground truth's directions, many at a time.
COSIVA_VECTOR_CLONES
void turn(const double* __restrict heading_rad, double* __restrict sin, double* __restrict cos, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    const SinCos h = plain::sincos(heading_rad[i]);
    sin[i] = h.sin;
    cos[i] = h.cos;
  }
}

void evaluate(const Moment& moment, std::size_t i, Trace& trace) {
  const Estimate& estimate = trace.estimates[i];
  const SinCos h{trace.ground_truth_sin[i], trace.ground_truth_cos[i]};
  const double x = estimate.pose.x_m - moment.ground_truth.x_m;
  const double y = estimate.pose.y_m - moment.ground_truth.y_m;
  trace.error_m.push_back(std::sqrt(x * x + y * y));
  trace.along_m.push_back(h.cos * x + h.sin * y);
  trace.across_m.push_back(-h.sin * x + h.cos * y);
  trace.heading_rad.push_back(wrap_angle(estimate.pose.heading_rad - moment.ground_truth.heading_rad));
  trace.nees.push_back(nees_of(x, y, estimate.covariance));
}

void turn_all(const Trial& run, Trace& trace) {
  const std::size_t n = run.moments.size();
  std::vector<double>& headings = trace.ground_truth_heading_rad;
  headings.clear();
  for (const Moment& moment : run.moments) headings.push_back(moment.ground_truth.heading_rad);
  trace.ground_truth_sin.resize(n);
  trace.ground_truth_cos.resize(n);
  turn(headings.data(), trace.ground_truth_sin.data(), trace.ground_truth_cos.data(), n);
}

void forget_judgement(Trace& trace) {
  for (auto* column : {&trace.error_m, &trace.along_m, &trace.across_m, &trace.heading_rad, &trace.nees})
    column->clear();
}

void forget(Trace& trace) {
  forget_judgement(trace);
  trace.nis.clear();
  trace.nis_dimensions = 0;
  trace.refused = 0;
  trace.estimates.clear();
}

void report(estimation::Algorithm& algorithm, const Event& event, Trace& trace, std::size_t& predictions) {
  if (const auto* odometry = std::get_if<estimation::Odometry>(&event)) {
    algorithm.predict(*odometry);
    ++predictions;
    return;
  }
  const auto* reading = std::get_if<estimation::Reading>(&event);
  const estimation::Rectified rectified =
      reading != nullptr ? algorithm.rectify(*reading) : algorithm.rectify(std::get<estimation::Range>(event));
  if (!rectified.accepted) ++trace.refused;
  if (!rectified.nis || rectified.dimensions <= 0) return;
  trace.nis.push_back(*rectified.nis / rectified.dimensions);
  trace.nis_dimensions += static_cast<std::size_t>(rectified.dimensions);
}

Result<Pose2> alignment_of(Alignment how, const Trial& run, const Trace& trace) {
  if (how == Alignment::origin) {
    if (!run.heading_known)
      return fail("align.heading", "the ground truth has no heading to align the first pose with; se2 needs none",
                  run.name);
    return run.moments.front().ground_truth * inverse(trace.estimates.front().pose);
  }
  std::vector<Point2> ground_truth;
  std::vector<Point2> estimate;
  ground_truth.reserve(run.moments.size());
  estimate.reserve(run.moments.size());
  for (std::size_t i = 0; i < run.moments.size(); ++i) {
    ground_truth.push_back(position(run.moments[i].ground_truth));
    estimate.push_back(position(trace.estimates[i].pose));
  }
  auto found = rigid_alignment(ground_truth, estimate);
  if (!found) found.error().location = run.name;
  return found;
}

}  // namespace

Result<Pose2> align(Alignment how, const Trial& run, Trace& trace) {
  COSIVA_EXPECT(how == Alignment::se2 || how == Alignment::origin);
  auto move = alignment_of(how, run, trace);
  if (!move) return move;
  const SinCos turn = sincos(move->heading_rad);
  estimation::Matrix3 r = estimation::Matrix3::Identity();
  r.topLeftCorner<2, 2>() << turn.cos, -turn.sin, turn.sin, turn.cos;
  forget_judgement(trace);
  for (std::size_t i = 0; i < run.moments.size(); ++i) {
    Estimate& estimate = trace.estimates[i];
    estimate.pose = *move * estimate.pose;
    estimate.covariance = r * estimate.covariance * r.transpose();
    evaluate(run.moments[i], i, trace);
  }
  return move;
}

Result<void> apply(estimation::Algorithm& algorithm, const Trial& run, Trace& trace) {
  forget(trace);
  turn_all(run, trace);
  std::vector<std::size_t> predictions_at;
  predictions_at.reserve(run.moments.size());
  trace.estimates.reserve(run.moments.size());
  std::size_t inputs = 0;
  std::size_t predictions = 0;
  for (const Moment& moment : run.moments) {
    while (inputs < moment.events) report(algorithm, run.events[inputs++], trace, predictions);
    trace.estimates.push_back(algorithm.estimate());
    if (const Error* fault = algorithm.fault()) return tl::unexpected(*fault);
    evaluate(moment, trace.estimates.size() - 1, trace);
    predictions_at.push_back(predictions);
  }
  const std::vector<Estimate> revised = algorithm.revised();
  if (const Error* fault = algorithm.fault()) return tl::unexpected(*fault);
  if (revised.empty()) return {};
  forget_judgement(trace);
  for (std::size_t i = 0; i < run.moments.size(); ++i) {
    // Before the first step there is nothing to revise.
    if (predictions_at[i] > 0) trace.estimates[i] = revised[predictions_at[i] - 1];
    evaluate(run.moments[i], i, trace);
  }
  return {};
}

}  // namespace cosiva::experiments
