#include "cosiva/physical/plant/trip_counter.h"

#include <algorithm>
#include <cmath>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::physical {

void TripCounter::add(double moved_m) { distance_m_ += std::fabs(moved_m); }

void TripCounter::begin_floor(double loop_length_m) {
  laps_before_ = laps();
  distance_before_m_ = distance_m_;
  loop_length_m_ = loop_length_m;
}

std::uint32_t TripCounter::laps() const {
  return laps_before_ +
         (loop_length_m_ > 0.0 ? static_cast<std::uint32_t>((distance_m_ - distance_before_m_) / loop_length_m_) : 0);
}

void TripCounter::on_moving() {
  has_moved_ = true;
  wait_ = {};
}

void TripCounter::on_waiting(SimDuration dt) {
  if (!has_moved_) return;
  wait_ += dt;
  longest_wait_ = std::max(longest_wait_, wait_);
  COSIVA_EXPECT(wait_ <= longest_wait_);
}

void TripCounter::archive(Archive& archive) {
  archive(loop_length_m_, distance_m_, distance_before_m_, laps_before_, has_moved_, wait_, longest_wait_);
}

}  // namespace cosiva::physical
