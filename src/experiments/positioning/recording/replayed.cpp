#include "cosiva/experiments/positioning/recording/replayed.h"

#include <algorithm>
#include <cmath>

#include "cosiva/aiv/estimation/calibrating.h"
#include "cosiva/base/math.h"
#include "cosiva/experiments/statistics/sample.h"

namespace cosiva::experiments {
namespace {

/// The ground truth at a time.
class GroundTruth {
 public:
  GroundTruth(const Recording& recording, double gap_s) : ground_truth_{recording.ground_truth}, gap_s_{gap_s} {}

  [[nodiscard]] std::optional<Pose2> at(double t_s) const {
    const auto after = std::ranges::lower_bound(ground_truth_, t_s, {}, &Recording::True::t_s);
    if (after != ground_truth_.end() && after->t_s == t_s) return pose(*after);
    if (after == ground_truth_.begin() || after == ground_truth_.end()) return std::nullopt;
    const Recording::True& a = *(after - 1);
    const Recording::True& b = *after;
    if (b.t_s - a.t_s > gap_s_) return std::nullopt;
    const double u = (t_s - a.t_s) / (b.t_s - a.t_s);
    return Pose2{a.position_M.x_m + u * (b.position_M.x_m - a.position_M.x_m),
                 a.position_M.y_m + u * (b.position_M.y_m - a.position_M.y_m),
                 wrap_angle(a.heading_rad + u * wrap_angle(b.heading_rad - a.heading_rad))};
  }

 private:
  static Pose2 pose(const Recording::True& t) {
    return {t.position_M.x_m, t.position_M.y_m, wrap_angle(t.heading_rad)};
  }
  const std::vector<Recording::True>& ground_truth_;
  double gap_s_;
};

/// Merges ranges and readings in the order of time into odometry's steps.
class Mixer {
 public:
  Mixer(const Recording& recording, Trial& trial) : recording_{recording}, trial_{trial} {}

  /// Adds one step of odometry and the measurements during it. Fails on a beacon without surveyed position.
  Result<void> step(const Recording::Step& step) {
    double from_s = step.t_s - step.duration_s;
    for (;;) {
      const double range_s = received_ < recording_.ranges.size() ? recording_.ranges[received_].t_s : 1e300;
      const double reading_s = detected_ < recording_.readings.size() ? recording_.readings[detected_].t_s : 1e300;
      const double next_s = std::fmin(range_s, reading_s);
      if (next_s > step.t_s) break;
      roll(step, from_s, next_s);
      from_s = std::fmax(from_s, next_s);
      auto reported =
          range_s <= reading_s ? report(recording_.ranges[received_++]) : report(recording_.readings[detected_++]);
      if (!reported) return reported;
    }
    roll(step, from_s, step.t_s);
    return {};
  }
  [[nodiscard]] double since_m() const { return since_m_; }
  [[nodiscard]] double travelled_m() const { return travelled_m_; }
  /// Skips measurements before the first odometry: the drive has not begun then.
  void skip_until(double t_s) {
    while (received_ < recording_.ranges.size() && recording_.ranges[received_].t_s < t_s) ++received_;
    while (detected_ < recording_.readings.size() && recording_.readings[detected_].t_s < t_s) ++detected_;
  }

 private:
  void roll(const Recording::Step& step, double from_s, double to_s) {
    if (!(to_s > from_s)) return;
    const double ratio = (to_s - from_s) / step.duration_s;
    trial_.events.emplace_back(estimation::Odometry{ratio * step.distance_m, ratio * step.turn_rad, to_s - from_s,
                                                    ratio * step.distance_variance_m2, ratio * step.turn_variance_rad2,
                                                    ratio * step.left_m});
    const double path_distance_m = step.left_m != 0.0 ? norm(step.distance_m, step.left_m) : std::fabs(step.distance_m);
    since_m_ += ratio * path_distance_m;
    travelled_m_ += ratio * path_distance_m;
  }
  [[nodiscard]] Result<Point2> surveyed(std::uint32_t beacon) const {
    const auto found = recording_.beacons.find(beacon);
    if (found != recording_.beacons.end()) return found->second;
    return fail("recording.beacon", "there is no surveyed position of beacon " + std::to_string(beacon),
                recording_.name);
  }
  Result<void> report(const Recording::ReceivedRange& received) {
    const auto location = surveyed(received.station);
    if (!location) return tl::unexpected(location.error());
    trial_.events.emplace_back(estimation::Range{received.station, *location, received.range_m});
    since_m_ = 0.0;
    return {};
  }
  Result<void> report(const Recording::Sighted& detected) {
    const auto location = surveyed(detected.fiducial);
    if (!location) return tl::unexpected(location.error());
    trial_.events.emplace_back(estimation::Reading{detected.fiducial, *location, detected.detected_B});
    since_m_ = 0.0;
    return {};
  }

  const Recording& recording_;
  Trial& trial_;
  std::size_t received_{0};
  std::size_t detected_{0};
  double since_m_{0.0};
  double travelled_m_{0.0};
};

/// The common error of ranges, and the part that depends on the position, increase with the noise of a single range.
void believe_ranges(double noise_m, estimation::SensorModel& sensors) {
  sensors.range_sigma_m = noise_m;
  sensors.range_common_sigma_m = noise_m;
  sensors.range_station_sigma_m = 0.75 * noise_m;
}

/// σ of single ranges that are too far apart to be compared with each other: the value for which the innovations of a
/// filter on the same inputs have their expected size. Needs no ground truth but the start, which every estimator is
/// given.
double range_noise_by_surprise(const Trial& trial) {
  // The median of the chi-squared distribution with one degree of freedom.
  constexpr double centre = 0.4549;
  constexpr int rounds_most = 16;
  constexpr double synchronised = 1.02;
  double noise_m = 1.0;
  for (int round = 0; round < rounds_most; ++round) {
    estimation::Setting setting = trial.setting;
    believe_ranges(noise_m, setting.sensors);
    estimation::CalibratingFilter filter{setting};
    std::vector<double> surprise;
    for (const Event& event : trial.events) {
      if (const auto* odometry = std::get_if<estimation::Odometry>(&event)) {
        filter.predict(*odometry);
      } else if (const auto* reading = std::get_if<estimation::Reading>(&event)) {
        filter.rectify(*reading);
      } else if (const auto reported = filter.rectify(std::get<estimation::Range>(event)); reported.nis) {
        surprise.push_back(*reported.nis);
      }
    }
    if (surprise.empty()) break;
    const double factor = std::clamp(std::sqrt(statistics::percentile(surprise, 0.5) / centre), 0.25, 4.0);
    noise_m = std::clamp(noise_m * factor, 1e-3, 1e3);
    if (factor < synchronised && factor > 1.0 / synchronised) break;
  }
  return noise_m;
}

/// Assumed parameters where a recording contains none: wheels on a real floor or lawn, whose slip and unevenness cause
/// 4 cm after a metre, four times the simulated value; an uncalibrated gyroscope, whose offset is some tenths of a
/// degree per second; single ranges with their observed scatter.
Result<void> take_sensors(const Recording& recording, estimation::SensorModel& sensors) {
  sensors.distance_variance_per_m = 0.04 * 0.04;
  if (!recording.turns_from_wheels) sensors.turn_drift_sigma_radps = 0.005;
  if (const auto noise = range_noise_m(recording)) believe_ranges(*noise, sensors);
  const std::map<std::string, double estimation::SensorModel::*> fields{
      {"distance_variance_per_m", &estimation::SensorModel::distance_variance_per_m},
      {"turn_variance_per_m", &estimation::SensorModel::turn_variance_per_m},
      {"turn_variance_per_rad", &estimation::SensorModel::turn_variance_per_rad},
      {"distance_scale_sigma", &estimation::SensorModel::distance_scale_sigma},
      {"turn_scale_sigma", &estimation::SensorModel::turn_scale_sigma},
      {"turn_drift_sigma_radps", &estimation::SensorModel::turn_drift_sigma_radps},
      {"fiducial_along_sigma_m", &estimation::SensorModel::fiducial_along_sigma_m},
      {"fiducial_across_sigma_m", &estimation::SensorModel::fiducial_across_sigma_m},
      {"line_sigma_m", &estimation::SensorModel::line_sigma_m},
      {"line_heading_sigma_rad", &estimation::SensorModel::line_heading_sigma_rad},
      {"range_sigma_m", &estimation::SensorModel::range_sigma_m},
      {"range_scale_sigma", &estimation::SensorModel::range_scale_sigma},
      {"range_common_sigma_m", &estimation::SensorModel::range_common_sigma_m},
      {"range_station_sigma_m", &estimation::SensorModel::range_station_sigma_m},
      {"range_station_length_m", &estimation::SensorModel::range_station_length_m},
  };
  for (const auto& [name, value] : recording.sensors) {
    const auto field = fields.find(name);
    if (field == fields.end())
      return fail("recording.sensors", "'" + name + "' is no sensor parameter", recording.name + "/sensors.csv");
    sensors.*field->second = value;
  }
  return {};
}

}  // namespace

std::optional<double> range_noise_m(const Recording& recording) {
  std::map<std::uint32_t, std::vector<const Recording::ReceivedRange*>> by_station;
  for (const Recording::ReceivedRange& received : recording.ranges) by_station[received.station].push_back(&received);
  std::vector<double> off;
  for (const auto& [station, received] : by_station) {
    for (std::size_t i = 1; i + 1 < received.size(); ++i) {
      const Recording::ReceivedRange& a = *received[i - 1];
      const Recording::ReceivedRange& b = *received[i + 1];
      if (!(b.t_s > a.t_s) || b.t_s - a.t_s > 5.0) continue;
      const double u = (received[i]->t_s - a.t_s) / (b.t_s - a.t_s);
      const double spread = std::sqrt(1.0 + u * u + (1.0 - u) * (1.0 - u));
      off.push_back(std::fabs(received[i]->range_m - (1.0 - u) * a.range_m - u * b.range_m) / spread);
    }
  }
  if (off.size() < 20) return std::nullopt;
  // Half of a Gaussian is within 0.6745 σ; outliers do not affect the median.
  const double noise = statistics::percentile(off, 0.5) / 0.6745;
  return noise > 0.0 ? std::optional(noise) : std::nullopt;
}

Result<Trial> replayed(const Recording& recording, const ReplayOptions& options) {
  Trial trial;
  trial.name = recording.name;
  trial.heading_known = recording.ground_truth_has_heading;
  trial.sensors_assumed = recording.sensors.empty();
  if (auto fine = take_sensors(recording, trial.setting.sensors); !fine) return tl::unexpected(fine.error());
  const GroundTruth ground_truth{recording, options.gap_s};
  Mixer mixer{recording, trial};
  bool begun = false;
  for (const Recording::Step& step : recording.odometry) {
    const double from_s = step.t_s - step.duration_s;
    if (!begun) {
      // The trial begins with the ground truth: at the step's beginning, or at its end.
      const auto start = ground_truth.at(from_s);
      const auto later = start ? start : ground_truth.at(step.t_s);
      if (!later) continue;
      trial.setting.start = *later;
      begun = true;
      mixer.skip_until(start ? from_s : step.t_s);
      if (!start) continue;
    }
    if (auto reported = mixer.step(step); !reported) return tl::unexpected(reported.error());
    const auto here = ground_truth.at(step.t_s);
    if (!here) continue;
    trial.moments.push_back({trial.events.size(), step.t_s, *here, mixer.travelled_m(), mixer.since_m(), std::nullopt});
  }
  if (trial.moments.empty())
    return fail("recording.overlap",
                "odometry and ground truth have no common time, or the gaps of the ground truth are longer than " +
                    std::to_string(options.gap_s) + " s",
                recording.name);
  trial.setting.start_sigma_m = options.start_sigma_m;
  trial.setting.start_heading_sigma_rad = recording.ground_truth_has_heading ? options.start_heading_sigma_rad : pi;
  const bool reported =
      std::ranges::any_of(recording.sensors, [](const auto& one) { return one.first.starts_with("range_"); });
  if (!recording.ranges.empty() && !reported && !range_noise_m(recording))
    believe_ranges(range_noise_by_surprise(trial), trial.setting.sensors);
  return trial;
}

}  // namespace cosiva::experiments
