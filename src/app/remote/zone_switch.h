#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/result.h"

namespace cosiva::app {

/// What a running platform's table says of its last switch.
struct SwitchedZone {
  std::string name;
  std::uint64_t snapped{};
  std::vector<std::string> off_route;
  std::optional<double> first_moving_ms;
  std::uint64_t vehicles{};  ///< of the fleet, whether they can move or not
};
/// From the snapshot's JSON. Nothing where it tells of no switch.
[[nodiscard]] std::optional<SwitchedZone> switched_in(std::string_view snapshot_json);
/// "12 anchored, 1 parked: AIV7; the first moved after 431 ms"
[[nodiscard]] std::string to_text(const SwitchedZone& switched);

/// The sentence of an answer that refuses, as an error with its code.
[[nodiscard]] Error refusal_in(std::string_view body, unsigned status);

}  // namespace cosiva::app
