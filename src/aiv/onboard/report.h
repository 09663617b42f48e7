#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cosiva/aiv/decision/agent.h"
#include "cosiva/aiv/onboard/boards_link.h"
#include "cosiva/aiv/onboard/supervision.h"
#include "cosiva/aiv/onboard/warnings.h"
#include "cosiva/aiv/order/instant_actions.h"
#include "cosiva/aiv/order/order_actions.h"
#include "cosiva/wire/messages/messages.h"
#include "cosiva/wire/own/own_messages.h"

namespace cosiva::aiv {

/// The sources of a state message; all of them belong to the on-board core.
struct ReportSources {
  SimTime now;
  const Agent* agent;                      ///< null while there is no zone
  const std::vector<wire::MapInfo>& maps;  ///< the map in force first; none while there is no zone
  const std::string& zone_refused;         ///< why the zone announced last is not used; empty: it is
  const BoardsLink& boards;
  const Supervision& supervision;
  const InstantActionBook& actions;
  const Warnings& warnings;
  const std::optional<wire::Power>& power;
  const OrderActions* order_actions{nullptr};  ///< null: the vehicle performs no actions of orders
};

[[nodiscard]] wire::State compose_state(const ReportSources& sources);
/// Health of the boards, for the page (A18); without header.
/// @param ranges  the last from DOBS
[[nodiscard]] wire::BoardsReport compose_boards_report(const ReportSources& sources,
                                                       const std::optional<wire::Ranges>& ranges);
[[nodiscard]] wire::Visualization compose_visualization(const Agent& agent, const std::string& map_id);

/// The text on AFFI: name and status of the vehicle, in 32 bytes.
[[nodiscard]] std::string display_text(const std::string& serial_number, const Agent& agent);

/// The flags whose change causes a state of its own (VDA 5050 2.1 §6.10); compared from tick to tick.
struct ReportFlags {
  std::uint8_t holds{};
  bool driving{};
  bool blocked{};
  bool wants_base{};
  bool position_known{};
  bool near_path{};
  int charge_percent{};
  unsigned boards_lost{};
  friend bool operator==(const ReportFlags&, const ReportFlags&) = default;
};
[[nodiscard]] ReportFlags flags_of(const ReportSources& sources);

}  // namespace cosiva::aiv
