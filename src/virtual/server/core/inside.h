#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/virtual/server/context/augmented_parts.h"
#include "cosiva/virtual/server/context/master_control.h"
#include "cosiva/virtual/server/context/server_context.h"
#include "cosiva/virtual/server/core/command_router.h"
#include "cosiva/virtual/server/core/ownership.h"
#include "cosiva/virtual/server/core/persisted_state.h"
#include "cosiva/virtual/server/core/position_view.h"
#include "cosiva/virtual/server/core/report_follow_up.h"
#include "cosiva/virtual/server/core/server_core.h"
#include "cosiva/virtual/server/core/server_view.h"
#include "cosiva/virtual/server/core/twin_placement.h"
#include "cosiva/virtual/server/core/v2x_intake.h"
#include "cosiva/virtual/server/core/vehicle_lifecycle.h"
#include "cosiva/virtual/server/core/vehicle_reports.h"
#include "cosiva/virtual/server/core/virtual_world.h"
#include "cosiva/virtual/server/core/zone_session.h"
#include "cosiva/virtual/simulator/simulator.h"

namespace cosiva::virtual_side {

/// The server's parts and how news travels between them. server_core.cpp: life and links; zone.cpp: zones as they come
/// and their edits; zone_switch.cpp: from one zone to another while vehicles drive; operator.cpp: what is asked of it;
/// virtual_world.cpp: what is added only virtually; hand_over.cpp: from hall to hall; memory.cpp: what is kept over a
/// crash; reports.cpp and own_reports.cpp: what vehicles say; talk.cpp: what they say to each other; snapshot.cpp and
/// vehicle_json.cpp: what the page reads.
struct ServerCore::Inside : ServerContext, MasterControl, AugmentedParts, InstrumentParts {
  explicit Inside(ServerOptions given);

  // server_core.cpp
  void begin(SimTime now);
  void on_message(const wire::Input& input);
  void on_link(bool up);
  void on_tick();
  void settle();
  [[nodiscard]] bool settled() const;
  void on_battery(const wire::Input& input);
  void on_gvs(const wire::Input& input);

  VehicleLifecycle vehicles{*this, *this, *this};
  TwinPlacement twins{*this, *this};
  ZoneSession zones{*this, *this, *this, vehicles, twins};
  VehicleReports reports{*this, *this, *this, *this, vehicles, twins};
  Ownership ownership{*this, *this, vehicles, twins, reports, zones};
  VirtualWorld world{*this, *this, vehicles};
  CommandRouter router{*this, *this, *this, *this, zones, world};
  PersistedState persisted{*this, *this, *this, vehicles, zones, world};
  ReportFollowUp follow_up{*this, *this, zones};
  V2xIntake v2x{*this, *this};
  ServerView view{*this, *this, *this, zones, *this};
  PositionView position_view{*this, *this};
  std::optional<SimTime> ticked_at;
  bool begun{false};
};

}  // namespace cosiva::virtual_side
