#include "cosiva/aiv/decision/motion_state.h"

#include <algorithm>
#include <cmath>

#include "cosiva/aiv/motion/formulas.h"
#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::aiv {
namespace {

/// Consecutive readings under that before the vehicle counts as stopped: one alone may be a jerk's zero crossing.
constexpr int stopped_readings = 2;
/// Consecutive readings without any progress before a manoeuvre counts as interrupted.
constexpr int still_readings_max = 5;
/// Likewise before a vehicle that is commanded to drive counts as waiting at a joint.
constexpr int stuck_readings_max = 25;
constexpr double stuck_m = 0.0005;

}  // namespace

void MotionState::on_odometry(const wire::Odometry& odometry) {
  speed_mps_ = 0.001 * odometry.speed_mmps;
  slow_readings_ = std::fabs(speed_mps_) < stopped_mps ? std::min(slow_readings_ + 1, stopped_readings) : 0;
  turn_radps_ = 0.0;
  if (odometry.manoeuvre) {
    const bool still = manoeuvre_ == odometry.manoeuvre;
    still_readings_ = still ? std::min(still_readings_ + 1, still_readings_max) : 0;
    const std::uint32_t since_ms = odometry.board_ms - manoeuvre_ms_;
    if (manoeuvre_ && since_ms > 0 && since_ms < 1000)
      turn_radps_ = (odometry.manoeuvre->turned_mrad - manoeuvre_->turned_mrad) / static_cast<double>(since_ms);
    manoeuvre_ms_ = odometry.board_ms;
  }
  manoeuvre_ = odometry.manoeuvre;
  stopped_ = slow_readings_ >= stopped_readings && (!manoeuvre_ || still_readings_ >= still_readings_max);
}

void MotionState::on_odometry_lost() {
  speed_mps_ = 0.0;
  turn_radps_ = 0.0;
  slow_readings_ = stopped_readings;
  still_readings_ = still_readings_max;
  stopped_ = true;
}

bool MotionState::stuck(bool driving, double travelled_m) {
  const bool waits = driving && !manoeuvre_ && std::fabs(travelled_m - stuck_travelled_m_) < stuck_m;
  if (!waits) stuck_travelled_m_ = travelled_m;
  stuck_readings_ = waits ? stuck_readings_ + 1 : 0;
  if (stuck_readings_ < stuck_readings_max) return false;
  stuck_readings_ = 0;
  return true;
}

void MotionState::take_over(const MotionState& before) {
  COSIVA_EXPECT(slow_readings_ >= stopped_readings);  // the vehicle has not moved in this zone yet
  const int stuck_readings = stuck_readings_;
  const double stuck_travelled_m = stuck_travelled_m_;
  const double turn_radps = turn_radps_;
  *this = before;
  stuck_readings_ = stuck_readings;
  stuck_travelled_m_ = stuck_travelled_m;
  turn_radps_ = turn_radps;
}

void MotionState::archive(Archive& archive) {
  archive(speed_mps_, slow_readings_, stopped_, manoeuvre_, manoeuvre_ms_, still_readings_, turn_radps_,
          stuck_readings_, stuck_travelled_m_);
}

}  // namespace cosiva::aiv
