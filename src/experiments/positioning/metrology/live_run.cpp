#include "cosiva/experiments/positioning/metrology/live_run.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::experiments {
namespace {

using wire::EstimateResponse;

/// An iteration of the article's loop is a move; a stopped vehicle adds no iteration.
constexpr double move_m_min = 0.001;

estimation::SensorModel sensors_of(const wire::EstimateSensors& inputs) {
  estimation::SensorModel sensors;
  sensors.distance_variance_per_m = inputs.distance_variance_per_m;
  sensors.turn_variance_per_m = inputs.turn_variance_per_m;
  sensors.turn_variance_per_rad = inputs.turn_variance_per_rad;
  sensors.distance_scale_sigma = inputs.distance_scale_sigma;
  sensors.turn_scale_sigma = inputs.turn_scale_sigma;
  sensors.fiducial_along_sigma_m = inputs.fiducial_along_sigma_m;
  sensors.fiducial_across_sigma_m = inputs.fiducial_across_sigma_m;
  sensors.line_sigma_m = inputs.line_sigma_m;
  sensors.line_heading_sigma_rad = inputs.line_heading_sigma_rad;
  return sensors;
}

estimation::Estimate estimate_of(const EstimateResponse::Estimate& inputs) {
  estimation::Estimate estimate;
  estimate.pose = inputs.X_MB;
  estimate.along_m = inputs.along_m;
  for (int i = 0; i < 9; ++i) {
    estimate.covariance(i / 3, i % 3) = inputs.covariance ? (*inputs.covariance)[static_cast<std::size_t>(i)]
                                                          : std::numeric_limits<double>::quiet_NaN();
  }
  return estimate;
}

/// Repeats, input by input, the recorded responses of an algorithm on board.
class Recited final : public estimation::Algorithm {
 public:
  Recited(std::shared_ptr<const LiveRun> run, std::size_t which)
      : run_{std::move(run)}, said_{&run_->published[which]} {
    if (!said_->fault.empty()) fault_ = Error{"algorithm.on_board", said_->fault, to_string(run_->vehicle)};
  }
  void predict(const estimation::Odometry&) override { ++inputs_; }
  estimation::Rectified rectify(const estimation::Reading&) override {
    ++inputs_;
    return read_ < said_->rectified.size() ? said_->rectified[read_++] : estimation::Rectified{};
  }
  estimation::Rectified rectify(const estimation::Range&) override { return {}; }
  [[nodiscard]] estimation::Estimate estimate() const override {
    // The vehicle moved between two moments, so each has inputs of its own.
    const auto& moments = run_->trial.moments;
    const auto at = std::ranges::lower_bound(moments, inputs_, {}, &Moment::events);
    const auto index = static_cast<std::size_t>(at - moments.begin());
    return index < said_->estimates.size() ? said_->estimates[index] : estimation::Estimate{};
  }
  [[nodiscard]] const Error* fault() const override { return fault_ ? &*fault_ : nullptr; }

 private:
  std::shared_ptr<const LiveRun> run_;
  const OnBoardMessage* said_;
  std::optional<Error> fault_;
  std::size_t inputs_{0};
  std::size_t read_{0};
};

}  // namespace

std::optional<Pose2> true_pose(const std::vector<TrueFix>& fixes, SimTime at, SimDuration gap_max) {
  const auto after = std::ranges::lower_bound(fixes, at, {}, &TrueFix::at);
  if (after != fixes.end() && after->at == at) return after->X_MB;
  if (after == fixes.begin() || after == fixes.end()) return std::nullopt;
  const TrueFix& a = *(after - 1);
  const TrueFix& b = *after;
  if (b.at - a.at > gap_max) return std::nullopt;
  const double u = to_seconds(at - a.at) / to_seconds(b.at - a.at);
  // A straight line would cut an arc of 0.6 m by 0.5 mm; a cubic with the body's direction at its ends does not.
  const SinCos from = sincos(a.X_MB.heading_rad);
  const SinCos to = sincos(b.X_MB.heading_rad);
  const double x = b.X_MB.x_m - a.X_MB.x_m;
  const double y = b.X_MB.y_m - a.X_MB.y_m;
  const double distance_m = norm(x, y) * (from.cos * x + from.sin * y < 0.0 ? -1.0 : 1.0);
  const double goes = u * u * (3.0 - 2.0 * u);
  const double leaves = u * (1.0 - u) * (1.0 - u) * distance_m;
  const double arrives = u * u * (u - 1.0) * distance_m;
  const double turned_rad = wrap_angle(b.X_MB.heading_rad - a.X_MB.heading_rad);
  return Pose2{a.X_MB.x_m + goes * x + leaves * from.cos + arrives * to.cos,
               a.X_MB.y_m + goes * y + leaves * from.sin + arrives * to.sin,
               wrap_angle(a.X_MB.heading_rad + u * turned_rad)};
}

RunLog::RunLog(std::string name, wire::VehicleId vehicle, std::uint64_t seed, std::uint32_t particles,
               std::uint32_t horizon) {
  run_.vehicle = std::move(vehicle);
  run_.trial.name = std::move(name);
  run_.trial.sensors_assumed = true;  // by a data sheet
  run_.trial.setting.seed = seed;
  run_.trial.setting.particles = particles;
  run_.trial.setting.horizon = horizon;
}

std::optional<SimTime> RunLog::last_moment() const {
  return stamps_.empty() ? std::nullopt : std::optional{stamps_.back()};
}

void RunLog::report(const EstimateResponse::Input& input) {
  std::vector<Event>& events = run_.trial.events;
  if (const auto* odometry = std::get_if<EstimateResponse::Odometry>(&input)) {
    events.emplace_back(estimation::Odometry{odometry->distance_m, odometry->turn_rad, odometry->duration_s});
    since_fiducial_m_ += std::fabs(odometry->distance_m);
  } else {
    const auto& reading = std::get<EstimateResponse::Reading>(input);
    events.emplace_back(estimation::Reading{reading.fiducial, reading.fiducial_M, reading.detected_B});
    since_fiducial_m_ = 0.0;
  }
}

void RunLog::receive(const EstimateResponse::Estimate& estimate, bool moment) {
  const auto found = std::ranges::find(run_.published, estimate.algorithm, &OnBoardMessage::algorithm);
  OnBoardMessage& published = found != run_.published.end()
                                  ? *found
                                  : run_.published.emplace_back(OnBoardMessage{estimate.algorithm, {}, {}, {}});
  if (!estimate.fault.empty() && published.fault.empty()) published.fault = estimate.fault;
  for (const EstimateResponse::Rectified& one : estimate.rectified)
    published.rectified.push_back({one.accepted, one.nis, one.dimensions});
  if (moment) published.estimates.push_back(estimate_of(estimate));
}

void RunLog::add(const EstimateResponse& response) {
  if (response.start) start_ = response.start;
  map_id_ = response.map_id;
  for (const EstimateResponse::Input& input : response.inputs) report(input);
  travelled_m_ = response.travelled_m;
  const bool moment = travelled_m_ - moment_m_ >= move_m_min;
  for (const EstimateResponse::Estimate& estimate : response.estimates) receive(estimate, moment);
  if (!moment) return;
  moment_m_ = travelled_m_;
  stamps_.push_back(response.timestamp);
  run_.trial.moments.push_back({run_.trial.events.size(), 0.0, {}, travelled_m_, since_fiducial_m_, std::nullopt});
  COSIVA_EXPECT(stamps_.size() == run_.trial.moments.size());
}

Result<LiveRun> RunLog::finish(const std::shared_ptr<const zone::TrafficZone>& zone,
                               const std::vector<TrueFix>& ground_truth, SimDuration gap_max,
                               std::size_t& without_ground_truth) && {
  estimation::Setting& setting = run_.trial.setting;
  if (!start_) return fail("live.response", "the vehicle never reported its start", to_string(run_.vehicle));
  setting.sensors = sensors_of(start_->sensors);
  setting.start = start_->X_MB;
  setting.start_sigma_m = start_->sigma_m;
  setting.start_heading_sigma_rad = start_->heading_sigma_rad;
  setting.start_along_m = start_->along_m;
  if (start_->section) {
    const auto section = zone->circuit.find(*start_->section);
    if (!section) return fail("live.zone", "there is no section '" + *start_->section + "'", zone->name);
    auto track = estimation::Track::round(zone, *section);
    if (!track) return tl::unexpected(track.error());
    setting.track = std::make_shared<const estimation::Track>(std::move(*track));
  }
  std::vector<Moment> moments = std::exchange(run_.trial.moments, {});
  std::vector<std::vector<estimation::Estimate>> estimates;
  for (OnBoardMessage& published : run_.published) estimates.push_back(std::exchange(published.estimates, {}));
  for (std::size_t i = 0; i < moments.size(); ++i) {
    const auto X_MB = true_pose(ground_truth, stamps_[i], gap_max);
    if (!X_MB) {
      ++without_ground_truth;
      continue;
    }
    Moment& moment = run_.trial.moments.emplace_back(moments[i]);
    moment.t_s = to_seconds(stamps_[i] - stamps_.front());
    moment.ground_truth = *X_MB;
    moment.section =
        zone->circuit.section(zone->circuit.locate(position(*X_MB), X_MB->heading_rad).position.section).kind();
    for (std::size_t k = 0; k < estimates.size(); ++k) run_.published[k].estimates.push_back(estimates[k][i]);
  }
  if (run_.trial.moments.empty())
    return fail("live.ground_truth", "no actual position of the vehicle during the run is known",
                to_string(run_.vehicle));
  return std::move(run_);
}

Candidate on_board(std::string name, std::string what, const std::vector<std::shared_ptr<const LiveRun>>& runs) {
  const auto make = [name, runs](const estimation::Setting& setting) -> Result<std::unique_ptr<estimation::Algorithm>> {
    for (const auto& run : runs) {
      if (run->trial.setting.seed != setting.seed) continue;
      const auto published = std::ranges::find(run->published, name, &OnBoardMessage::algorithm);
      if (published == run->published.end())
        return fail("algorithm.on_board", "the vehicle sent no estimates of " + name, to_string(run->vehicle));
      return std::make_unique<Recited>(run, static_cast<std::size_t>(published - run->published.begin()));
    }
    return fail("algorithm.on_board", "there was no such run", name);
  };
  return {std::move(name), std::move(what), false, make};
}

}  // namespace cosiva::experiments
