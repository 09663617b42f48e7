#include "cosiva/aiv/order/instant_actions.h"

#include <algorithm>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::aiv {
namespace {

bool ended(const wire::ActionState& state) {
  return state.status == wire::ActionStatus::finished || state.status == wire::ActionStatus::failed;
}

}  // namespace

bool InstantActionBook::begin(const wire::Action& action) {
  if (std::ranges::find(detected_, action.action_id) != detected_.end()) return false;
  detected_.push_back(action.action_id);
  if (detected_.size() > recent_max) detected_.pop_front();
  if (states_.size() == shown_max) {
    const auto oldest = std::ranges::find_if(states_, ended);
    states_.erase(oldest == states_.end() ? states_.begin() : oldest);
  }
  states_.push_back({action.action_id, action.action_type, wire::ActionStatus::waiting, {}});
  COSIVA_EXPECT(states_.size() <= shown_max && detected_.size() <= recent_max);
  return true;
}

void InstantActionBook::set(std::string_view action_id, wire::ActionStatus status, std::string result_description) {
  const auto state = std::ranges::find(states_, action_id, &wire::ActionState::action_id);
  if (state == states_.end()) return;
  state->status = status;
  state->result_description = std::move(result_description);
}

void InstantActionBook::end_running(std::string_view action_type, wire::ActionStatus status,
                                    std::string_view result_description) {
  for (wire::ActionState& state : states_) {
    if (state.status != wire::ActionStatus::running) continue;
    if (!action_type.empty() && state.action_type != action_type) continue;
    state.status = status;
    state.result_description = std::string(result_description);
  }
}

bool InstantActionBook::running(std::string_view action_type) const {
  return std::ranges::any_of(states_, [&](const wire::ActionState& state) {
    return state.action_type == action_type && state.status == wire::ActionStatus::running;
  });
}

void InstantActionBook::on_new_order() {
  const auto last_limit = std::find_if(states_.rbegin(), states_.rend(), [](const wire::ActionState& state) {
    return state.action_type == action::set_speed_limit;
  });
  const std::string kept = last_limit == states_.rend() ? std::string{} : last_limit->action_id;
  std::erase_if(states_, [&](const wire::ActionState& state) { return ended(state) && state.action_id != kept; });
}

void InstantActionBook::archive(Archive& archive) { archive(states_, detected_); }

}  // namespace cosiva::aiv
