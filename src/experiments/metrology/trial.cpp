#include "experiments/metrology/trial.h"

#include <cmath>

#include "base/math.h"

namespace cosiva::experiments {
namespace {

using estimation::Estimate;

/// Beyond what a covariance with no width in some direction could tell.
double nees_of(double x, double y, const estimation::Matrix3& c) {
  if (!std::isfinite(c(0, 0))) return c(0, 0);  // it states none
  const double det = c(0, 0) * c(1, 1) - c(0, 1) * c(1, 0);
  if (!(det > 0.0)) return x == 0.0 && y == 0.0 ? 0.0 : 1e9;
  return (c(1, 1) * x * x - 2.0 * c(0, 1) * x * y + c(0, 0) * y * y) / det;
}

void judge(const Moment& moment, const Estimate& estimate, Trace& trace) {
  const double x = estimate.pose.x_m - moment.truth.x_m;
  const double y = estimate.pose.y_m - moment.truth.y_m;
  const SinCos h = sincos(moment.truth.heading_rad);
  trace.error_m.push_back(norm(x, y));
  trace.along_m.push_back(h.cos * x + h.sin * y);
  trace.across_m.push_back(-h.sin * x + h.cos * y);
  trace.heading_rad.push_back(wrap_angle(estimate.pose.heading_rad - moment.truth.heading_rad));
  trace.nees.push_back(nees_of(x, y, estimate.covariance));
}

void forget(Trace& trace) {
  for (auto* column : {&trace.error_m, &trace.along_m, &trace.across_m, &trace.heading_rad, &trace.nees, &trace.nis})
    column->clear();
  trace.refused = 0;
  trace.estimates.clear();
}

void tell(estimation::Algorithm& algorithm, const Event& event, Trace& trace, std::size_t& predictions) {
  if (const auto* odometry = std::get_if<estimation::Odometry>(&event)) {
    algorithm.predict(*odometry);
    ++predictions;
    return;
  }
  const auto* reading = std::get_if<estimation::Reading>(&event);
  const estimation::Rectified rectified =
      reading != nullptr ? algorithm.rectify(*reading) : algorithm.rectify(std::get<estimation::Range>(event));
  if (!rectified.accepted) ++trace.refused;
  if (rectified.nis && rectified.dimensions > 0) trace.nis.push_back(*rectified.nis / rectified.dimensions);
}

}  // namespace

Result<void> apply(estimation::Algorithm& algorithm, const Trial& run, Trace& trace) {
  forget(trace);
  std::vector<std::size_t> predictions_at;
  predictions_at.reserve(run.moments.size());
  std::size_t told = 0;
  std::size_t predictions = 0;
  for (const Moment& moment : run.moments) {
    while (told < moment.events) tell(algorithm, run.events[told++], trace, predictions);
    trace.estimates.push_back(algorithm.estimate());
    if (const Error* fault = algorithm.fault()) return tl::unexpected(*fault);
    predictions_at.push_back(predictions);
  }
  const std::vector<Estimate> revised = algorithm.revised();
  if (const Error* fault = algorithm.fault()) return tl::unexpected(*fault);
  for (std::size_t i = 0; i < run.moments.size(); ++i) {
    // Nothing to revise before the first step.
    if (!revised.empty() && predictions_at[i] > 0) trace.estimates[i] = revised[predictions_at[i] - 1];
    judge(run.moments[i], trace.estimates[i], trace);
  }
  return {};
}

}  // namespace cosiva::experiments
