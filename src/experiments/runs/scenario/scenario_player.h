#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "cosiva/base/time.h"
#include "cosiva/experiments/runs/scenario/scenario.h"

namespace cosiva::experiments {

/// Returns the steps of a scenario when they are due.
///
/// Invariant: the steps are in the order of their times, and each is returned once.
class ScenarioPlayer {
 public:
  explicit ScenarioPlayer(const Scenario& scenario) : steps_{scenario.steps} {}
  void begin(SimTime now) { begun_ = now; }
  [[nodiscard]] bool begun() const { return begun_.has_value(); }
  /// The steps due up to `now`, each once; none before begin().
  [[nodiscard]] std::vector<Scenario::Step> due(SimTime now);
  [[nodiscard]] std::optional<SimTime> next_due() const;
  [[nodiscard]] bool done() const { return next_ == steps_.size(); }

 private:
  std::vector<Scenario::Step> steps_;
  std::size_t next_{0};
  std::optional<SimTime> begun_;
};

}  // namespace cosiva::experiments
