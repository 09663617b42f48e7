#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/time.h"
#include "cosiva/virtual/server/exchange/agent_proxy.h"
#include "cosiva/virtual/server/registry/connection_record.h"
#include "cosiva/virtual/server/registry/factsheet_record.h"
#include "cosiva/virtual/server/registry/identity.h"
#include "cosiva/virtual/server/registry/membership.h"
#include "cosiva/virtual/server/registry/message_counters.h"
#include "cosiva/virtual/server/registry/on_board_reports.h"
#include "cosiva/virtual/server/registry/operator_settings.h"
#include "cosiva/virtual/server/registry/received_headers.h"
#include "cosiva/virtual/server/registry/report_clock.h"
#include "cosiva/virtual/server/registry/reported_position.h"
#include "cosiva/virtual/server/registry/reported_state.h"
#include "cosiva/virtual/server/registry/twin_link.h"
#include "cosiva/virtual/server/registry/vehicle_clock.h"
#include "cosiva/wire/messages/messages.h"

namespace cosiva::virtual_side {

/// Header ids of the messages to a vehicle, one for each topic: the number of messages published on it, modulo 2³².
struct SentHeaderIds {
  std::uint32_t order{0};
  std::uint32_t actions{0};
};

/// The server's proxy of a vehicle (A26): its messages pass through it, and it holds the content of the last ones and
/// what the next messages to the vehicle must carry. All vehicles are treated alike, whatever their manufacturer. Each
/// part keeps its own invariant; the functions here are the events that concern several parts.
struct AivProxy : AgentProxy {
  AivProxy(Identity its_identity, SimTime now)
      : AgentProxy{its_identity.name()}, identity{std::move(its_identity)}, membership{now} {}

  Identity identity;
  Membership membership;
  TwinLink twin_link;
  OperatorSettings settings;
  ConnectionRecord connection;
  FactsheetRecord factsheet;
  ReportClock reports;  ///< of its states, and of positions newer than them
  VehicleClock clock;
  ReportedState reported_state;
  ReportedPosition position;
  OnBoardReports on_board;
  ReceivedHeaders received;
  SentHeaderIds sent;
  MessageCounters counters;
  std::uint32_t diagnostics{};  ///< bits of the diagnostics that were already logged

  /// A session of the vehicle begins: header ids and possibly time stamps start again, and the vehicle has not reported
  /// anything yet.
  void on_session();
  /// The vehicle leaves the table and the traffic. The bijection monitor lists a virtual AIV as present even then.
  void on_retired(SimTime now);
  /// The life of the vehicle at this server begins again: only identity, priority, twin, counters of messages and the
  /// ids of sent headers are preserved.
  void on_returned(SimTime now);

  [[nodiscard]] const wire::VehicleId& id() const { return identity.id(); }
  [[nodiscard]] const std::string& name() const { return identity.name(); }
  [[nodiscard]] bool augmented() const { return identity.augmented(); }
  [[nodiscard]] bool retired() const { return membership.retired(); }
  [[nodiscard]] std::optional<std::size_t> twin() const { return twin_link.twin(); }
  [[nodiscard]] const wire::State* state() const { return reported_state.last(); }  ///< null: none yet

  /// A CoSiVA vehicle: takes the zone from its topic and drives onto the path by itself.
  [[nodiscard]] bool is_cosiva() const {
    return augmented() || on_board.boards() || id().manufacturer == wire::our_manufacturer;
  }
  /// Never proved to be a vehicle: it has no twin, no report made it present, and it was none before a restart. Its
  /// entry can be removed.
  [[nodiscard]] bool unconfirmed() const {
    return !augmented() && !twin() && !twin_link.present() && !membership.awaited();
  }
  /// Has a twin that is shown and that other vehicles take into account.
  [[nodiscard]] bool here() const { return twin().has_value() && !retired(); }
  /// Is in the table and on the map.
  [[nodiscard]] bool shown(SimTime now) const { return here() && !membership.hidden_by_handover(now); }
  [[nodiscard]] bool online() const { return connection.online(); }
  /// No report for longer than `after`, or than three usual gaps of a vehicle that reports more slowly than that.
  [[nodiscard]] bool lost(SimTime now, SimDuration after) const { return reports.lost(now, after); }
  /// Nothing while the factsheet is unknown.
  [[nodiscard]] std::optional<bool> supports(std::string_view instant_action) const {
    return factsheet.supports(instant_action);
  }
  void archive(Archive& archive);  ///< the state, for a snapshot
};

}  // namespace cosiva::virtual_side
