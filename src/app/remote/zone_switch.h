#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/result.h"

namespace cosiva::app {

/// The last switch of a running platform, from its snapshot.
struct SwitchedZone {
  std::string name;
  std::uint64_t snapped{};
  std::vector<std::string> off_route;
  std::optional<double> first_moving_ms;
  std::uint64_t vehicles{};  ///< of the fleet, able to move or not
};
/// Reads the snapshot's JSON. Nothing where the snapshot contains no switch.
[[nodiscard]] std::optional<SwitchedZone> switched_in(std::string_view snapshot_json);
/// "12 snapped, 1 off-route: AIV7; the first moved after 431 ms"
[[nodiscard]] std::string to_text(const SwitchedZone& switched);

/// The message of a response that refuses a request, as an error with its code.
[[nodiscard]] Error refusal_in(std::string_view body, unsigned status);

}  // namespace cosiva::app
