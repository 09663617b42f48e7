#include "cosiva/aiv/estimation/particles.h"

#include <cmath>
#include <utility>

#include "cosiva/aiv/estimation/planar.h"
#include "cosiva/base/expect.h"
#include "cosiva/base/math.h"

namespace cosiva::estimation {
namespace {

/// Ratio of readings of a fiducial that does not exist, or of the wrong one.
constexpr double wrong_ratio = 0.01;

}  // namespace

ParticleFilter::ParticleFilter(Setting setting)
    : setting_{std::move(setting)}, random_{setting_.seed, "estimation/particles"}, particles_(setting_.particles) {
  drawn_.reserve(particles_.size());
  if (!setting_.start_known) {
    spread_over_circuit();
    return;
  }
  for (Particle& particle : particles_) {
    particle.along_m = setting_.start_along_m + random_.gaussian(0.0, setting_.start_sigma_m);
    particle.position = setting_.track->position_at(particle.along_m);
    particle.weight = 1.0 / static_cast<double>(particles_.size());
  }
}

void ParticleFilter::spread_over_circuit() {
  const zone::Circuit& circuit = setting_.track->circuit();
  const double total_m = circuit.total_length_m();
  const auto n = static_cast<double>(particles_.size());
  zone::SectionId id = 0;
  double before_m = 0.0;
  for (std::size_t i = 0; i < particles_.size(); ++i) {
    const double wanted_m = total_m * (static_cast<double>(i) + random_.uniform()) / n;
    while (id + 1 < circuit.size() && wanted_m >= before_m + circuit.section(id).length_m())
      before_m += circuit.section(id++).length_m();
    particles_[i] = {{id, wanted_m - before_m}, 0.0, 1.0 / n};
  }
}

void ParticleFilter::predict(const Odometry& odometry) {
  const double sigma_m = std::sqrt(setting_.sensors.distance_variance_per_m * std::fabs(odometry.distance_m) +
                                   odometry.distance_variance_m2);
  const zone::Circuit& circuit = setting_.track->circuit();
  for (Particle& particle : particles_) {
    const double step_m = odometry.distance_m + sigma_m * random_.gaussian();
    particle.along_m += step_m;
    particle.position.s_m += step_m;
    // Over as many joints as necessary; at a fork each particle takes one branch.
    while (particle.position.s_m > circuit.section(particle.position.section).length_m()) {
      const auto next = circuit.next(particle.position.section);
      const double length_m = circuit.section(particle.position.section).length_m();
      if (next.empty()) {
        particle.position.s_m = length_m;
        break;
      }
      particle.position.s_m -= length_m;
      particle.position.section = next.size() == 1 ? next.front() : next[random_.below(next.size())];
    }
    while (particle.position.s_m < 0.0) {
      const auto previous = circuit.previous(particle.position.section);
      if (previous.empty()) {
        particle.position.s_m = 0.0;
        break;
      }
      particle.position.section = previous.size() == 1 ? previous.front() : previous[random_.below(previous.size())];
      particle.position.s_m += circuit.section(particle.position.section).length_m();
    }
  }
}

template <typename Likelihood>
void ParticleFilter::weigh(const Likelihood& likelihood) {
  double total = 0.0;
  for (Particle& particle : particles_) {
    const double squared = likelihood(setting_.track->circuit().pose_at(particle.position));
    particle.weight *= wrong_ratio + (1.0 - wrong_ratio) * (squared < 700.0 ? det_exp(-0.5 * squared) : 0.0);
    total += particle.weight;
  }
  double squares = 0.0;
  for (Particle& particle : particles_) {
    particle.weight /= total;
    squares += particle.weight * particle.weight;
  }
  if (squares * static_cast<double>(particles_.size()) > 2.0) resample();
}

void ParticleFilter::resample() {
  // Systematic: one random number, and as many evenly spaced positions in the sum of weights.
  drawn_.clear();
  const auto n = static_cast<double>(particles_.size());
  const double first = random_.uniform();
  double sum = 0.0;
  std::size_t k = 0;
  for (const Particle& particle : particles_) {
    sum += particle.weight * n;
    while (k < particles_.size() && first + static_cast<double>(k) < sum) {
      drawn_.push_back({particle.position, particle.along_m, 1.0 / n});
      ++k;
    }
  }
  while (drawn_.size() < particles_.size())
    drawn_.push_back({particles_.back().position, particles_.back().along_m, 1.0 / n});
  COSIVA_EXPECT(drawn_.size() == particles_.size());
  particles_.swap(drawn_);
}

Rectified ParticleFilter::rectify(const Reading& reading) {
  const SensorModel& sensors = setting_.sensors;
  // Laterally, the particles are on the path and the vehicle near it.
  const double across =
      sensors.fiducial_across_sigma_m * sensors.fiducial_across_sigma_m + sensors.line_sigma_m * sensors.line_sigma_m;
  const double along = sensors.fiducial_along_sigma_m * sensors.fiducial_along_sigma_m;
  weigh([&](const Pose2& pose) {
    const Point2 fiducial_B = inverse(pose) * reading.fiducial_M;
    const double ahead = fiducial_B.x_m - reading.detected_B.x_m;
    const double left = fiducial_B.y_m - reading.detected_B.y_m;
    return ahead * ahead / along + left * left / across;
  });
  return {true, std::nullopt, 0};
}

Rectified ParticleFilter::rectify(const Range& range) {
  const double variance = range_variance(setting_.sensors, range.range_m);
  weigh([&](const Pose2& pose) {
    const double off = distance(position(pose), range.station_M) - range.range_m;
    return off * off / variance;
  });
  return {true, std::nullopt, 0};
}

Estimate ParticleFilter::estimate() const {
  Vector2 mean = Vector2::Zero();
  double along_m = 0.0;
  double cosine = 0.0;
  double sine = 0.0;
  for (const Particle& particle : particles_) {
    const Pose2 pose = setting_.track->circuit().pose_at(particle.position);
    const SinCos h = sincos(pose.heading_rad);
    mean += particle.weight * Vector2(pose.x_m, pose.y_m);
    cosine += particle.weight * h.cos;
    sine += particle.weight * h.sin;
    along_m += particle.weight * particle.along_m;
  }
  const double heading_rad = det_atan2(sine, cosine);
  Estimate estimate{{mean(0), mean(1), heading_rad}, Matrix3::Zero(), std::nullopt};
  if (setting_.start_known) estimate.along_m = along_m;
  for (const Particle& particle : particles_) {
    const Pose2 pose = setting_.track->circuit().pose_at(particle.position);
    const Vector3 d(pose.x_m - mean(0), pose.y_m - mean(1), wrap_angle(pose.heading_rad - heading_rad));
    estimate.covariance += particle.weight * d * d.transpose();
  }
  const double line = setting_.sensors.line_sigma_m * setting_.sensors.line_sigma_m;
  estimate.covariance(0, 0) += line;
  estimate.covariance(1, 1) += line;
  estimate.covariance(2, 2) += setting_.sensors.line_heading_sigma_rad * setting_.sensors.line_heading_sigma_rad;
  return estimate;
}

}  // namespace cosiva::estimation
