#include "cosiva/experiments/positioning/metrology/limit.h"

#include <cmath>

#include "cosiva/base/math.h"

namespace cosiva::experiments {

Sawtooth sawtooth(const Regime& regime) {
  const double q = regime.variance_per_m * regime.pitch_m;
  const double s = std::sqrt(q * q + 4.0 * q * regime.fiducial_variance_m2);
  return {0.5 * (s - q), 0.5 * (s + q)};
}

double filter_limit_m(const Regime& regime) {
  const Sawtooth p = sawtooth(regime);
  return std::sqrt(0.5 * (p.after_m2 + p.before_m2));
}

double smoother_limit_m(const Regime& regime) {
  const double q = regime.variance_per_m * regime.pitch_m;
  const double r = regime.fiducial_variance_m2;
  if (q == 0.0) return 0.0;
  return std::sqrt((q * r + q * q / 6.0) / std::sqrt(q * q + 4.0 * q * r));
}

double reset_rule_m(const Regime& regime) {
  return std::sqrt(regime.fiducial_variance_m2 + 0.5 * regime.variance_per_m * regime.pitch_m);
}

double precision_limit(const Regime& regime, double threshold_m) {
  const Sawtooth p = sawtooth(regime);
  // Simpson's rule over the distance between two beacons.
  constexpr int pieces = 200;
  double sum = 0.0;
  for (int i = 0; i <= pieces; ++i) {
    const double variance = p.after_m2 + (p.before_m2 - p.after_m2) * i / pieces;
    const double weight = i == 0 || i == pieces ? 1.0 : (i % 2 == 1 ? 4.0 : 2.0);
    sum += weight * (variance > 0.0 ? det_erf(threshold_m / std::sqrt(2.0 * variance)) : 1.0);
  }
  return sum / (3.0 * pieces);
}

std::optional<double> pitch_for(double rmse_m, double variance_per_m, double fiducial_variance_m2) {
  if (!(rmse_m > 0.0) || !(variance_per_m > 0.0)) return std::nullopt;
  // (Q² + 4QR)/4 = e⁴ solved for Q.
  const double e2 = rmse_m * rmse_m;
  const double q = 2.0 * (std::sqrt(fiducial_variance_m2 * fiducial_variance_m2 + e2 * e2) - fiducial_variance_m2);
  return q / variance_per_m;
}

RunLimit limit_of(const Trial& run) {
  const estimation::SensorModel& sensors = run.setting.sensors;
  const double r = sensors.fiducial_along_sigma_m * sensors.fiducial_along_sigma_m;
  struct Step {
    double predicted;  ///< variance before the step's readings
    double filtered;
    double moments;  ///< moments in this step
  };
  std::vector<Step> steps{{run.setting.start_sigma_m * run.setting.start_sigma_m,
                           run.setting.start_sigma_m * run.setting.start_sigma_m, 0.0}};
  steps.reserve(run.events.size() + 1);
  std::size_t inputs = 0;
  for (const Moment& moment : run.moments) {
    for (; inputs < moment.events; ++inputs) {
      if (const auto* odometry = std::get_if<estimation::Odometry>(&run.events[inputs])) {
        const double p = steps.back().filtered + sensors.distance_variance_per_m * std::fabs(odometry->distance_m);
        steps.push_back({p, p, 0.0});
      } else if (std::holds_alternative<estimation::Reading>(run.events[inputs])) {
        steps.back().filtered = steps.back().filtered * r / (steps.back().filtered + r);
      }
    }
    steps.back().moments += 1.0;
  }
  double filter = 0.0;
  double smoother = 0.0;
  double count = 0.0;
  double smoothed = steps.back().filtered;
  for (std::size_t i = steps.size(); i-- > 0;) {
    filter += steps[i].moments * steps[i].filtered;
    smoother += steps[i].moments * smoothed;
    count += steps[i].moments;
    if (i == 0 || steps[i].predicted <= 0.0) continue;
    const double gain = steps[i - 1].filtered / steps[i].predicted;
    smoothed = steps[i - 1].filtered + gain * gain * (smoothed - steps[i].predicted);
  }
  const double line = sensors.line_sigma_m * sensors.line_sigma_m;
  return {filter / count + line, smoother / count + line};
}

}  // namespace cosiva::experiments
