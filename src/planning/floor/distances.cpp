#include "cosiva/planning/floor/distances.h"

#include <algorithm>

#include "cosiva/base/expect.h"

namespace cosiva::planning {

Distances::Distances(const Floor& floor, std::size_t bytes_max)
    : floor_{&floor},
      tables_max_{std::max<std::size_t>(1, bytes_max / (sizeof(Steps) * std::max<std::size_t>(1, floor.states())))},
      tables_(floor.goals()) {}

const Distances::Steps* Distances::to(GoalId goal) {
  COSIVA_EXPECT(goal < tables_.size());
  Table& table = tables_[goal];
  if (!table.steps.empty()) {
    recent_.splice(recent_.begin(), recent_, table.recent);
    return table.steps.data();
  }
  if (recent_.size() >= tables_max_) {
    table.steps.swap(tables_[recent_.back()].steps);
    recent_.pop_back();
  }
  search(goal, table.steps);
  recent_.push_front(goal);
  table.recent = recent_.begin();
  return table.steps.data();
}

void Distances::search(GoalId goal, std::vector<Steps>& steps) {
  steps.assign(floor_->states(), unreachable);
  queue_.clear();
  for (const StateId state : floor_->goal(goal)) {
    steps[state] = 0;
    queue_.push_back(state);
  }
  for (std::size_t i = 0; i < queue_.size(); ++i) {
    const Steps next = static_cast<Steps>(steps[queue_[i]] + 1);
    if (next == unreachable) break;
    for (const StateId before : floor_->predecessors(queue_[i])) {
      if (steps[before] != unreachable) continue;
      steps[before] = next;
      queue_.push_back(before);
    }
  }
}

}  // namespace cosiva::planning
