#include "cosiva/physical/boards/line_tracker.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::physical {

std::vector<std::string> line_tracking_names() {
  std::vector<std::string> names;
  for (const lt_algorithm& algorithm : lt_algorithms) names.emplace_back(algorithm.name);
  return names;
}

LineTracker::LineTracker(std::string_view algorithm) : algorithm_{lt_find(std::string(algorithm).c_str())} {
  COSIVA_EXPECT(algorithm_ != nullptr);
  algorithm_->init(&state_, &dems_geometry);
}

double LineTracker::pass(double dt_s, bool forwards) {
  if (forwards != forwards_) {
    restart();
    forwards_ = forwards;
  }
  since_us_ += static_cast<std::int32_t>(std::lround(1e6 * dt_s));
  if (since_us_ >= cycle_us || state_.started == 0) due_us_ = std::exchange(since_us_, 0);
  COSIVA_EXPECT(since_us_ < cycle_us);
  return 1e-6 * due_us_;
}

void LineTracker::step(const DemsRow& readings, double speed_mps) {
  COSIVA_EXPECT(due_us_ > 0);
  lt_input in{{}, static_cast<std::int32_t>(std::lround(1e3 * speed_mps)), std::exchange(due_us_, 0)};
  std::ranges::copy(readings, in.reading);
  algorithm_->step(&state_, &in, &out_);
  implausible_steps_ = lt_implausible(&dems_geometry, in.reading) != 0 ? implausible_steps_ + 1 : 0;
}

void LineTracker::restart() {
  if (state_.started == 0) return;
  algorithm_->init(&state_, &dems_geometry);
  out_ = {};
  since_us_ = 0;
  implausible_steps_ = 0;
}

}  // namespace cosiva::physical
