#include "cosiva/aiv/decision/back_up.h"

#include <algorithm>
#include <cmath>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::aiv {
namespace {

constexpr double back_up_mps = 0.10;
/// Largest number of readings of a backUp, 50 a second, and distance before its end at which it ends.
constexpr int readings_max = 750;
constexpr double ends_m = 0.005;

}  // namespace

void BackUp::begin(double distance_m, double travelled_m) {
  COSIVA_EXPECT(distance_m > 0.0 && distance_m <= distance_m_max);
  end_at_m_ = travelled_m - distance_m;
  readings_ = 0;
  completed_ = false;
}

void BackUp::on_odometry(double travelled_m, bool on_line) {
  if (!end_at_m_) return;
  const bool there = travelled_m <= *end_at_m_ + ends_m;
  if (there || !on_line || ++readings_ > readings_max) {
    completed_ = there;
    end_at_m_.reset();
  }
}

double BackUp::speed_mps(const zone::SpeedProfile& slow, double travelled_m) const {
  COSIVA_EXPECT(active());
  const double left_m = std::max(0.0, travelled_m - *end_at_m_);
  return std::min({back_up_mps, slow.speed_mps, std::sqrt(2.0 * slow.braking_mps2 * left_m)});
}

void BackUp::archive(Archive& archive) { archive(end_at_m_, completed_, readings_); }

}  // namespace cosiva::aiv
