#include "cosiva/virtual/simulator/anticipation.h"

#include <algorithm>
#include <cmath>

#include "cosiva/aiv/motion/formulas.h"
#include "cosiva/aiv/motion/speed.h"
#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {
namespace {

/// The speed that the vehicle's envelope permits (aiv::Envelope::limit) after `driven_m` and `since_s`.
double permitted_mps(const Expectation& expected, double driven_m, double since_s) {
  const double braking = expected.target.braking_mps2;
  const double to_end = aiv::stoppable_speed(expected.end_m - driven_m, braking, aiv::reaction_s);
  const double gap_m = expected.leader_gap_m + expected.leader_mps * since_s - driven_m - aiv::clearance_m;
  const double behind_leader = aiv::stoppable_speed(gap_m, braking, aiv::obstacle_reaction_s);
  return std::min({expected.target.speed_mps, to_end, behind_leader});
}

}  // namespace

Anticipation::Anticipation(double speed_mps, const Expectation& expected) : end_m_{std::max(0.0, expected.end_m)} {
  COSIVA_EXPECT(speed_mps >= 0.0 && expected.target.braking_mps2 > 0.0);
  double speed = speed_mps;
  double driven = 0.0;
  speed_mps_[0] = speed;
  for (std::size_t i = 1; i <= steps; ++i) {
    const double permitted = permitted_mps(expected, driven, static_cast<double>(i - 1) * step_s);
    const double rise_mps2 = std::min(expected.target.acceleration_mps2, expected.trend_mps2);
    const double lowest = std::max(0.0, speed - expected.target.braking_mps2 * step_s);
    const double next = std::max(lowest, std::min(permitted, speed + rise_mps2 * step_s));
    driven = std::min(driven + 0.5 * (speed + next) * step_s, end_m_);
    speed = next;
    distance_m_[i] = driven;
    speed_mps_[i] = speed;
    COSIVA_EXPECT(distance_m_[i] >= distance_m_[i - 1]);
  }
}

double Anticipation::distance_m(double since_s) const {
  COSIVA_EXPECT(since_s >= 0.0);
  const double at = since_s / step_s;
  if (at >= static_cast<double>(steps))
    return std::min(distance_m_[steps] + speed_mps_[steps] * (since_s - step_s * static_cast<double>(steps)), end_m_);
  const auto i = static_cast<std::size_t>(at);
  const double within_s = since_s - step_s * static_cast<double>(i);
  // The speed changes linearly within a step.
  const double change_mps = speed_mps_[i + 1] - speed_mps_[i];
  const double driven = speed_mps_[i] * within_s + 0.5 * change_mps / step_s * within_s * within_s;
  return std::clamp(distance_m_[i] + driven, distance_m_[i], distance_m_[i + 1]);
}

double Anticipation::speed_mps(double since_s) const {
  COSIVA_EXPECT(since_s >= 0.0);
  const double at = std::min(since_s / step_s, static_cast<double>(steps));
  const auto i = std::min(static_cast<std::size_t>(at), steps - 1);
  return speed_mps_[i] + (at - static_cast<double>(i)) * (speed_mps_[i + 1] - speed_mps_[i]);
}

void Anticipation::archive(Archive& archive) { archive(distance_m_, speed_mps_, end_m_); }

}  // namespace cosiva::virtual_side
