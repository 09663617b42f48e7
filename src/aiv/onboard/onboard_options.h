#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "cosiva/aiv/decision/speed_rules.h"
#include "cosiva/aiv/order/action_catalogue.h"
#include "cosiva/base/result.h"
#include "cosiva/base/time.h"
#include "cosiva/wire/messages/topics.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::aiv {

/// What a vehicle does once its broker or its server has sent nothing for the timeout.
enum class LinkLoss : std::uint8_t {
  brake,       ///< it brakes
  finish_base  ///< it drives to the end of its base, for as long as BaseWatch allows it
};
/// Who decides which vehicle enters a crossing.
enum class Autonomy : std::uint8_t {
  server,    ///< the server, by the bases of its orders
  negotiate  ///< the vehicles among themselves (CrossingNegotiation); bases lead through crossings
};
/// The configuration of a vehicle before it starts; the payload of its `configure` input (JSON,
/// docs/protocols/journal.md).
struct OnboardOptions {
  std::uint32_t number{1};
  wire::VehicleId id{std::string(wire::our_manufacturer), "AIV1"};
  std::string interface_name{wire::default_interface};
  std::optional<zone::ZoneConfiguration> zone;  ///< nothing: the program waits for the zone retained on the broker
  /// Built from `zone` already, where it is known; null: the program builds it. Not in JSON.
  std::shared_ptr<const zone::Rtm> rtm{};
  /// The initial position; nothing: not known until a state file, an initPosition or the first tag gives it.
  struct Start {
    std::string section;
    double s_m;
  };
  std::optional<Start> start;
  SpeedRules rules;                          ///< for the choice of the speed; custom ones can be used (checked)
  ActionCatalogue actions{usual_actions()};  ///< of orders
  bool rali{true};                           ///< the vehicle has this board; without it the charge is unknown
  bool v2x{true};                            ///< the vehicle publishes its intents to vehicles nearby, and uses theirs
  bool v2x_direct{false};                    ///< it sends them by the direct link, too (wire::v2x_port)
  LinkLoss link_loss{LinkLoss::brake};
  Autonomy autonomy{Autonomy::server};               ///< negotiate: only with v2x_direct
  SimDuration cycle{std::chrono::milliseconds{20}};  ///< interval between decisions; when it is long, a new order is
                                                     ///< decided on at once
  SimDuration visualization_period{std::chrono::milliseconds{100}};
  SimDuration state_period{std::chrono::seconds{1}};
  /// The vehicle brakes when broker, server or a board has sent nothing for longer than this (Supervision).
  SimDuration link_timeout{std::chrono::milliseconds{500}};
  bool as_values{false};  ///< all parties are in this process: messages are passed on as values
                          ///< (wire/in_process/typed_message.h); not in JSON
};
[[nodiscard]] std::string to_json(const OnboardOptions& options);
[[nodiscard]] Result<OnboardOptions> onboard_options_from_json(std::string_view json);

}  // namespace cosiva::aiv
