#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/base/result.h"
#include "cosiva/base/time.h"
#include "cosiva/wire/messages/messages.h"

namespace cosiva::aiv {

/// What an order action does to the vehicle, besides taking time.
enum class ActionEffect : std::uint8_t {
  none,            ///< noop, finePositioning, and the actions of a vehicle file
  pick,            ///< adds a load
  drop,            ///< removes a load
  start_charging,  ///< the battery is charged from its end on
  stop_charging,   ///< the battery is charged no longer
  await_trigger,   ///< ends with the instant action `trigger`
  detect           ///< its result exists only when its time has passed
};

/// A type of action that the vehicle performs at nodes or on edges (VDA 5050 2.1 §6.8.1).
struct ActionType {
  std::string name;
  ActionEffect effect{ActionEffect::none};
  bool at_nodes{true};
  bool on_edges{false};
  bool instant{false};                    ///< also an instant action
  bool pausable{true};                    ///< a startPause interrupts it (§6.8.2)
  SimDuration preparation{};              ///< INITIALIZING
  std::optional<SimDuration> duration{};  ///< RUNNING; nothing: until its trigger
  std::string description{};
  friend bool operator==(const ActionType&, const ActionType&) = default;
};

/// Where an order has an action.
enum class ActionScope : std::uint8_t { node, edge };

/// Actions and load handling devices of a vehicle; a value that options carry. Empty: the vehicle only drives.
struct ActionCatalogue {
  std::vector<ActionType> types;
  std::vector<std::string> load_positions;  ///< one load each
  friend bool operator==(const ActionCatalogue&, const ActionCatalogue&) = default;
};

/// Null: the vehicle does not perform it.
[[nodiscard]] const ActionType* find_action(const ActionCatalogue& catalogue, std::string_view name);
/// Whether the vehicle can perform the action there. Error code: orderError (§6.6.4.2).
[[nodiscard]] Result<void> check_action(const ActionCatalogue& catalogue, const wire::Action& action,
                                        ActionScope scope);
/// Whether the vehicle must not drive while one of these actions runs: one is SOFT or HARD (§6.12).
[[nodiscard]] bool block_driving(const std::vector<wire::Action>& actions);

/// The predefined actions with their usual durations, and one load handling device, "deck".
[[nodiscard]] ActionCatalogue usual_actions();
/// An action of a vehicle file: predefined ones have their usual values, others a duration of 0.
[[nodiscard]] ActionType action_named(std::string_view name);
/// The name belongs to an instant action with another effect.
[[nodiscard]] bool reserved_action(std::string_view name);
/// Without load handling devices no pick and no drop is possible.
void remove_impossible(ActionCatalogue& catalogue);

/// The longest time that a file or options may give an action.
inline constexpr double action_s_max = 86'400.0;
inline constexpr std::size_t action_types_max = 64;
inline constexpr std::size_t load_positions_max = 16;
/// The name of a type or of a load position: letters, digits and _ . : - only, at most 64 of them.
[[nodiscard]] bool valid_action_name(std::string_view name);

void write_json(JsonWriter& json, const ActionCatalogue& catalogue);
/// Fails ("options.actions") on anything that write_json() does not write.
[[nodiscard]] Result<ActionCatalogue> action_catalogue_from_json(const JsonValue& json);

}  // namespace cosiva::aiv
