#pragma once

#include <cstddef>
#include <deque>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/wire/messages/messages.h"

namespace cosiva::aiv {

/// The received instant actions and their states (VDA 5050 2.1 §6.8, §6.11). The list is bounded. A repeated actionId
/// repairs a lost message: the action is not performed again. Invariant: at most shown_max states, recent_max ids.
class InstantActionBook {
 public:
  static constexpr std::size_t shown_max = 32;    ///< states in actionStates
  static constexpr std::size_t recent_max = 128;  ///< ids that are not performed twice

  /// False when this actionId was received before.
  [[nodiscard]] bool begin(const wire::Action& action);
  void set(std::string_view action_id, wire::ActionStatus status, std::string result_description = {});
  /// Ends all running actions of a type; of all types where that is empty.
  void end_running(std::string_view action_type, wire::ActionStatus status, std::string_view result_description = {});
  [[nodiscard]] bool running(std::string_view action_type) const;

  /// 2.1 preserves the states until the next order. Running actions stay, and the last setSpeedLimit, because it is in
  /// force beyond the order.
  void on_new_order();

  [[nodiscard]] const std::vector<wire::ActionState>& states() const { return states_; }
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  std::vector<wire::ActionState> states_;
  std::deque<std::string> detected_;
};

/// The types that this vehicle supports.
namespace action {
inline constexpr std::string_view start_pause = "startPause";
inline constexpr std::string_view stop_pause = "stopPause";
inline constexpr std::string_view cancel_order = "cancelOrder";
inline constexpr std::string_view init_position = "initPosition";
inline constexpr std::string_view state_request = "stateRequest";
inline constexpr std::string_view factsheet_request = "factsheetRequest";
inline constexpr std::string_view set_speed_limit = "setSpeedLimit";
inline constexpr std::string_view enable_map = "enableMap";
inline constexpr std::string_view download_map = "downloadMap";
inline constexpr std::string_view join_line = "joinLine";
inline constexpr std::string_view back_up = "backUp";
inline constexpr std::string_view move = "move";
inline constexpr std::string_view self_test = "selfTest";
inline constexpr std::string_view start_charging = "startCharging";
inline constexpr std::string_view stop_charging = "stopCharging";
inline constexpr std::string_view trigger = "trigger";
}  // namespace action

}  // namespace cosiva::aiv
