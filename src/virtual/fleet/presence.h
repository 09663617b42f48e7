#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "cosiva/virtual/fleet/crossing_grants.h"
#include "cosiva/virtual/fleet/fleet_orders.h"
#include "cosiva/virtual/fleet/fleet_tables.h"
#include "cosiva/virtual/fleet/leaders.h"
#include "cosiva/virtual/fleet/path_survey.h"
#include "cosiva/virtual/fleet/pose_writer.h"

namespace cosiva::virtual_side {

/// Removes vehicles from the zone and adds them. Invariant: an absent vehicle holds no crossing and is on no section's
/// list.
class Presence {
 public:
  Presence(FleetTables& tables, Leaders& leaders, PathSurvey& survey, CrossingGrants& grants, FleetOrders& orders,
           PoseWriter& poses);

  /// Removes vehicle i, which is on no list, from the zone: all passes treat an absent vehicle like one at its goal.
  void make_absent(std::uint32_t i);
  /// As Fleet::take_away().
  [[nodiscard]] bool take_away(std::uint32_t i);
  /// As Fleet::bring().
  [[nodiscard]] bool bring(std::uint32_t i, zone::TrackPosition position, std::int16_t priority);

 private:
  [[nodiscard]] bool leaves_room_behind(Block& block, std::uint32_t i) const;
  [[nodiscard]] Block& block_of(std::uint32_t i);

  const Ground& ground_;
  const Numbers& numbers_;
  State& state_;
  std::vector<Copy>& copies_;
  std::vector<std::uint32_t>& front_;
  std::vector<Block>& blocks_;
  std::vector<FleetTables::Route>& routes_;
  std::uint32_t& step_number_;
  std::size_t& commanded_vehicles_;
  Leaders& leaders_;
  PathSurvey& survey_;
  CrossingGrants& grants_;
  FleetOrders& orders_;
  PoseWriter& poses_;
};

}  // namespace cosiva::virtual_side
