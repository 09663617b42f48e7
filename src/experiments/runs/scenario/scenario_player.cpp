#include "cosiva/experiments/runs/scenario/scenario_player.h"

#include "cosiva/base/expect.h"

namespace cosiva::experiments {

std::vector<Scenario::Step> ScenarioPlayer::due(SimTime now) {
  std::vector<Scenario::Step> steps;
  if (!begun_) return steps;
  for (; next_ < steps_.size() && *begun_ + steps_[next_].at <= now; ++next_) {
    COSIVA_EXPECT(next_ == 0 || steps_[next_ - 1].at <= steps_[next_].at);
    steps.push_back(steps_[next_]);
  }
  return steps;
}

std::optional<SimTime> ScenarioPlayer::next_due() const {
  if (!begun_ || done()) return std::nullopt;
  return *begun_ + steps_[next_].at;
}

}  // namespace cosiva::experiments
