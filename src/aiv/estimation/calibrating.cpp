#include "cosiva/aiv/estimation/calibrating.h"

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <utility>

#include "cosiva/aiv/estimation/calibrating_model.h"
#include "cosiva/aiv/estimation/planar.h"
#include "cosiva/base/expect.h"
#include "cosiva/base/math.h"

namespace cosiva::estimation {
namespace {

using State = CalibratedState;

/// Directions that are tried where none is known, evenly spaced.
constexpr int directions = 24;
/// A hypothesis this much less likely than the best is dropped: e^-12, one in 160 000.
constexpr double hopeless = 12.0;
/// A heading less certain than this is unknown.
constexpr double lost_rad = 1.0;

}  // namespace

Estimate CalibratedState::estimate() const {
  Estimate estimate{{mean(x), mean(y), wrap_angle(mean(heading))}, covariance.topLeftCorner<3, 3>(), std::nullopt};
  return estimate;
}

int Stations::index(std::uint32_t station) {
  for (int i = 0; i < count_; ++i) {
    if (ids_[static_cast<std::size_t>(i)] == station) return State::common_size + i;
  }
  if (count_ == count_max) return -1;
  ids_[static_cast<std::size_t>(count_)] = station;
  const int added = State::common_size + count_++;
  COSIVA_EXPECT(added < State::turn_drift);
  return added;
}

CalibratingFilter::CalibratingFilter(Setting setting) : configured{std::move(setting)} {
  if (configured.start_heading_sigma_rad <= lost_rad) {
    hypotheses.push_back({start_state(configured.start.heading_rad, configured.start_heading_sigma_rad), 0.0,
                          configured.start.heading_rad});
    return;
  }
  constexpr double apart_rad = 2.0 * pi / directions;
  for (int i = 0; i < directions; ++i) {
    const double heading_rad = wrap_angle(i * apart_rad);
    hypotheses.push_back({start_state(heading_rad, 0.5 * apart_rad), 0.0, heading_rad});
  }
}

State CalibratingFilter::start_state(double heading_rad, double heading_sigma_rad) const {
  return model::start_state(configured, heading_rad, heading_sigma_rad);
}

std::size_t CalibratingFilter::best() const {
  const auto likelier = [](const Hypothesis& a, const Hypothesis& b) { return a.log_weight < b.log_weight; };
  return static_cast<std::size_t>(std::ranges::max_element(hypotheses, likelier) - hypotheses.begin());
}

void CalibratingFilter::prune() {
  const double least = hypotheses[best()].log_weight - hopeless;
  std::erase_if(hypotheses, [&](const Hypothesis& hypothesis) { return hypothesis.log_weight < least; });
  COSIVA_EXPECT(!hypotheses.empty());
}

void CalibratingFilter::predict(const Odometry& odometry) {
  for (Hypothesis& hypothesis : hypotheses) {
    const model::Motion motion = model::motion_of(configured.sensors, hypothesis.state.mean, odometry);
    model::move(hypothesis.state, motion);
  }
  if (hypotheses[best()].state.covariance(State::heading, State::heading) > lost_rad * lost_rad) scan_headings();
  ++inputs_count;
}

void CalibratingFilter::scan_headings() {
  const Hypothesis lost = hypotheses[best()];
  const Estimate all = estimate();
  const double variance = lost.state.covariance(State::heading, State::heading);
  constexpr double apart_rad = 2.0 * pi / directions;
  hypotheses.clear();
  for (int i = -directions / 2; i < directions / 2; ++i) {
    Hypothesis one = lost;
    const double by_rad = i * apart_rad;
    one.state.mean(State::heading) += by_rad;
    one.state.mean.head<2>() = Vector2(all.pose.x_m, all.pose.y_m);
    // The position no longer depends much on the heading.
    one.state.covariance.row(State::heading).setZero();
    one.state.covariance.col(State::heading).setZero();
    one.state.covariance(State::heading, State::heading) = 0.25 * apart_rad * apart_rad;
    one.state.covariance.topLeftCorner<2, 2>() = all.covariance.topLeftCorner<2, 2>();
    one.log_weight = -0.5 * by_rad * by_rad / variance;
    one.turned.push_back({inputs_count, by_rad});
    hypotheses.push_back(std::move(one));
  }
}

template <typename Input>
Rectified CalibratingFilter::rectify_all(const Input& input) {
  Rectified rectified;
  const std::size_t leader = best();
  for (std::size_t i = 0; i < hypotheses.size(); ++i) {
    Hypothesis& hypothesis = hypotheses[i];
    const model::PredictedReading predicted =
        model::predicted_reading(configured.sensors, stations, hypothesis.state.mean, input);
    double nis = 0.0;
    const State::Vector before = hypothesis.state.mean;
    for (int k = 0; k < predicted.count; ++k) {
      Measured measured = predicted.measured[static_cast<std::size_t>(k)];
      measured.residual -= measured.slope.dot(hypothesis.state.mean - before);
      const model::Update update = model::update(hypothesis.state, measured, false);
      hypothesis.log_weight += update.log_likelihood;
      nis += update.nis;
    }
    // A fiducial under the reader measures the position itself; only ranges leave a direction unobserved.
    if constexpr (std::is_same_v<Input, Range>) model::carry(hypothesis.state, before);
    if (i == leader) rectified = {predicted.count > 0, nis, predicted.count};
  }
  prune();
  ++inputs_count;
  return rectified;
}

Rectified CalibratingFilter::rectify(const Reading& reading) { return rectify_all(reading); }
Rectified CalibratingFilter::rectify(const Range& range) { return rectify_all(range); }

Estimate CalibratingFilter::estimate() const {
  const Hypothesis& leader = hypotheses[best()];
  if (hypotheses.size() == 1) return leader.state.estimate();
  // Mean and covariance of the mixture, headings as deviations from the leader's.
  double total = 0.0;
  Vector3 mean = Vector3::Zero();
  const auto deviation = [&](const Hypothesis& hypothesis) {
    Vector3 d = hypothesis.state.mean.head<3>() - leader.state.mean.head<3>();
    d(2) = wrap_angle(d(2));
    return d;
  };
  for (const Hypothesis& hypothesis : hypotheses) {
    const double w = det_exp(hypothesis.log_weight - leader.log_weight);
    total += w;
    mean += w * deviation(hypothesis);
  }
  mean /= total;
  Matrix3 covariance = Matrix3::Zero();
  for (const Hypothesis& hypothesis : hypotheses) {
    const double w = det_exp(hypothesis.log_weight - leader.log_weight) / total;
    const Vector3 d = deviation(hypothesis) - mean;
    covariance += w * (hypothesis.state.covariance.topLeftCorner<3, 3>() + d * d.transpose());
  }
  const Vector3 m = mean + leader.state.mean.head<3>();
  return {{m(0), m(1), wrap_angle(m(2))}, covariance, std::nullopt};
}

// ---- smoother ------------------------------------------------------------------------------------------------------

void CalibratingSmoother::predict(const Odometry& odometry) {
  CalibratingFilter::predict(odometry);
  inputs_.emplace_back(odometry);
}
Rectified CalibratingSmoother::rectify(const Reading& reading) {
  inputs_.emplace_back(reading);
  return CalibratingFilter::rectify(reading);
}
Rectified CalibratingSmoother::rectify(const Range& range) {
  inputs_.emplace_back(range);
  return CalibratingFilter::rectify(range);
}

void CalibratingSmoother::forwards(const State& start, const std::vector<State>& about,
                                   const std::vector<Turned>& turned, std::vector<Step>& steps) {
  State now = start;
  auto turn = turned.begin();
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    Step& step = steps[i];
    step.measured_count = 0;
    // Linearised about the last round's result where there is one, otherwise about the present state.
    const State::Vector before = about.empty() ? now.mean : about[i].mean;
    if (const auto* odometry = std::get_if<Odometry>(&inputs_[i])) {
      model::Motion motion = model::motion_of(configured.sensors, before, *odometry);
      motion.offset += motion.slope.lazyProduct(now.mean - before);
      step.motion = motion.slope;
      model::move(now, motion);
      for (; turn != turned.end() && turn->input <= i; ++turn) now.mean(State::heading) += turn->by_rad;
    } else {
      step.before = now.covariance;
      const auto* reading = std::get_if<Reading>(&inputs_[i]);
      const model::PredictedReading predicted =
          reading != nullptr
              ? model::predicted_reading(configured.sensors, stations, before, *reading)
              : model::predicted_reading(configured.sensors, stations, before, std::get<Range>(inputs_[i]));
      for (int k = 0; k < predicted.count; ++k) {
        Measured measured = predicted.measured[static_cast<std::size_t>(k)];
        // The last round's result gives the residual better than the filter could.
        if (!about.empty())
          measured.variance /= model::credit(measured.residual * measured.residual, measured.variance);
        measured.residual -= measured.slope.dot(now.mean - before);
        measured.variance = model::update(now, measured, !about.empty()).variance;
        // The innovation against the state just before; the backward pass needs both.
        step.measured[static_cast<std::size_t>(k)] = measured;
      }
      step.measured_count = predicted.count;
    }
    step.state = now;
  }
}

void CalibratingSmoother::backwards(const std::vector<Step>& steps, std::vector<State>& smoothed, const State& start,
                                    State& start_smoothed) {
  const Eigen::Index n = start.mean.size();
  State::Vector lambda = State::Vector::Zero(n);
  State::Matrix big = State::Matrix::Zero(n, n);
  const auto smooth = [&](const State& filtered, State& out) {
    out.mean = filtered.mean - filtered.covariance.lazyProduct(lambda);
    const State::Matrix pb = filtered.covariance.lazyProduct(big);
    out.covariance = filtered.covariance;
    out.covariance -= pb.lazyProduct(filtered.covariance);
    make_symmetric(out.covariance);
  };
  for (std::size_t i = steps.size(); i-- > 0;) {
    const Step& step = steps[i];
    smooth(step.state, smoothed[i]);
    if (step.measured_count == 0) {
      const State::Matrix lf = big.lazyProduct(step.motion);
      const State::Matrix transposed = step.motion.transpose();
      lambda = State::Vector(transposed.lazyProduct(lambda));
      big = transposed.lazyProduct(lf);
      continue;
    }
    model::back_through(step.before, std::span(step.measured).first(static_cast<std::size_t>(step.measured_count)),
                        lambda, big);
  }
  smooth(start, start_smoothed);
}

std::vector<Estimate> CalibratingSmoother::revised() {
  COSIVA_EXPECT(inputs_.size() == inputs_count);
  const Hypothesis& chosen = hypotheses[best()];
  const bool knows = configured.start_heading_sigma_rad <= lost_rad;
  // Without any information on the heading there is no drive to linearise about: the estimates of estimate() remain.
  if (!knows && estimate().covariance(2, 2) > lost_rad * lost_rad) return {};
  const State start = start_state(chosen.start_heading_rad, knows ? configured.start_heading_sigma_rad : pi);
  // The first round needs a heading to linearise about, and takes the hypothesis'; the other rounds have one.
  const State first = start_state(chosen.start_heading_rad, knows ? configured.start_heading_sigma_rad : 0.13);
  std::vector<Step> steps(inputs_.size());
  std::vector<State> smoothed(inputs_.size());
  std::vector<State> about;
  State start_smoothed = first;
  constexpr int rounds_most = 8;
  constexpr double steady_m = 1e-5;
  double moved_m = 1.0;
  for (int round = 0; round < rounds_most && moved_m > steady_m; ++round) {
    const State& from = round == 0 ? first : start;
    forwards(from, about, round == 0 ? chosen.turned : std::vector<Turned>{}, steps);
    backwards(steps, smoothed, from, start_smoothed);
    // Converged when no state has moved since the last round, about whose result this round was linearised.
    moved_m = about.empty() ? 1.0 : 0.0;
    for (std::size_t i = 1; i < about.size(); ++i)
      moved_m = std::fmax(moved_m, (about[i].mean - smoothed[i - 1].mean).head<2>().lpNorm<Eigen::Infinity>());
    // An input is linearised about the state before it.
    about.clear();
    about.push_back(start_smoothed);
    about.insert(about.end(), smoothed.begin(), smoothed.end() - (smoothed.empty() ? 0 : 1));
  }
  std::vector<Estimate> all;
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    if (!std::holds_alternative<Odometry>(inputs_[i])) {
      if (!all.empty()) all.back() = smoothed[i].estimate();
    } else {
      all.push_back(smoothed[i].estimate());
    }
  }
  return all;
}

}  // namespace cosiva::estimation
