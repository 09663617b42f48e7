#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "cosiva/aiv/decision/speed_rules.h"
#include "cosiva/base/result.h"
#include "cosiva/base/time.h"
#include "cosiva/wire/messages/topics.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::aiv {

/// What a vehicle is told before it starts; the payload of its `configure` input (JSON, docs/protocols/journal.md).
struct OnboardOptions {
  std::uint32_t number{1};
  wire::VehicleId id{std::string(wire::our_manufacturer), "AIV1"};
  std::string interface_name{wire::default_interface};
  std::optional<zone::ZoneConfiguration> zone;  ///< nothing: waits for the retained one from the broker
  /// Where it stands at first; nothing: not known until a memory, an initPosition or its first tag tells.
  struct Start {
    std::string section;
    double s_m;
  };
  std::optional<Start> start;
  SpeedRules rules;  ///< by what it chooses its speed; custom ones can be used (checked)
  bool v2x{true};    ///< it says to those near it what it is about to do, and heeds what they say
  SimDuration cycle{std::chrono::milliseconds{20}};  ///< it decides at least so often; when slower, at a new order too
  SimDuration visualization_period{std::chrono::milliseconds{100}};
  SimDuration state_period{std::chrono::seconds{1}};
  SimDuration link_timeout{std::chrono::milliseconds{500}};
  bool as_values{false};  ///< everybody is in this process: messages are passed on as values
                          ///< (wire/in_process/typed_message.h); not in JSON
};
[[nodiscard]] std::string to_json(const OnboardOptions& options);
[[nodiscard]] Result<OnboardOptions> onboard_options_from_json(std::string_view json);

}  // namespace cosiva::aiv
