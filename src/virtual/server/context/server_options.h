#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "cosiva/aiv/decision/speed_rules.h"
#include "cosiva/base/result.h"
#include "cosiva/base/time.h"
#include "cosiva/virtual/server/registry/registry.h"
#include "cosiva/virtual/simulator/bijection.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::virtual_side {

struct ServerOptions {
  std::string interface_name;  ///< empty: wire::default_interface
  /// Of several servers on one broker, the name of the control area that this one's zone is (wire/own/control_areas.h);
  /// empty: the only one.
  std::string area;
  /// The zone, when no physical side serves it; published retained so that vehicles get it too.
  std::optional<zone::ZoneConfiguration> zone;
  /// Built from `zone` already, where it is known; null: the server builds it. Not in JSON.
  std::shared_ptr<const zone::Rtm> rtm{};
  bool drive{true};  ///< give circulating orders to idle vehicles; false: watch only (a foreign master drives)
  SimDuration lost_after{std::chrono::seconds{1}};  ///< the shortest silence after which a vehicle is lost
  /// The longest time that a third-party vehicle may drive on after its last report, for example because broker or
  /// server are lost: limits the nodes released to it (BaseReach). Such a vehicle may have no watchdog, and drives on
  /// to the last released node. CoSiVA vehicles brake by themselves after OnboardOptions::link_timeout. 0: not limited,
  /// as in journals from before this option.
  SimDuration permitted_time{std::chrono::seconds{2}};
  BijectionContract contract;
  SimDuration cycle{std::chrono::milliseconds{20}};  ///< how often it looks after everything
  bool as_values{false};                             ///< everybody is in this process: orders are passed on as values
                                                     ///< (wire/in_process/typed_message.h); not in JSON
  std::size_t traces_max{20'000};                    ///< of the communications kept for the page
  /// Vehicles that the server accepts, 1 … Registry::vehicles_max_limit.
  std::size_t vehicles_max{Registry::vehicles_max_default};
  /// An entry that never proved to be a vehicle is removed this long after its last message; zero: never.
  SimDuration entries_expire_after{std::chrono::minutes{10}};
  /// Largest rate of messages that is accepted of one vehicle [1/s] (MessageRate); 0: unlimited.
  double vehicle_messages_per_s_max{500.0};
  /// Where vehicles that download their maps find the zone's; empty: nowhere, so they are not asked to.
  std::string map_download_link;
  bool v2x{true};                    ///< its virtual AIVs talk with those near them
  bool negotiated_crossings{false};  ///< its vehicles agree on crossings among themselves; virtual AIVs cannot be added
  bool convoys{true};                ///< vehicles of one way pass a crossing together when it pays (Traffic)
  /// The twins anticipate what the agents of their vehicles will decide; false: they move on at the reported speed.
  bool anticipation{true};
  /// By what the virtual AIVs choose their speeds; custom ones can be used (checked).
  aiv::SpeedRules virtual_rules{aiv::SpeedRules::Kind::fuzzy, {}, {}};
};
[[nodiscard]] std::string to_json(const ServerOptions& options);
[[nodiscard]] Result<ServerOptions> server_options_from_json(std::string_view json);

}  // namespace cosiva::virtual_side
