#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "cosiva/virtual/fleet/fleet_tables.h"
#include "cosiva/virtual/fleet/leaders.h"
#include "cosiva/virtual/fleet/path_survey.h"

namespace cosiva::virtual_side {

/// Decides which vehicle may enter which crossings.
/// Invariant: a crossing of a copy has one holder at most, and a vehicle holds the crossings of one chain at most.
class CrossingGrants {
 public:
  CrossingGrants(FleetTables& tables, Leaders& leaders, PathSurvey& survey);

  /// Adds vehicle i, which approaches a stop line, to the queue of its copy.
  void request(const Block& block, std::uint32_t i);
  /// Removes vehicle i from the queue.
  void withdraw(std::uint32_t i);
  /// Vehicle i has left the next of the crossings that it holds.
  void release(std::uint32_t i);
  /// Grants the due chains in copy `index`.
  void grant_due(Block& block, std::uint32_t index);
  /// Sets the priority of vehicle i, in the queue as well.
  void set_priority(std::uint32_t i, std::int16_t priority);
  /// A vehicle that stays in crossings holds the chain that leads on from there by default. Another route needs other
  /// crossings as well; the vehicle takes all of those at once. Returns false if they are not free, or if there is no
  /// such chain.
  [[nodiscard]] bool exchange_chain(std::uint32_t i, std::span<const zone::SectionId> route);
  /// Number of vehicles that wait for each other in a cycle.
  [[nodiscard]] std::size_t stuck() const;
  /// The queue of `copy` is evaluated again in the next step.
  static void recheck(Copy& copy);

 private:
  void clear_hold(std::uint32_t i);
  [[nodiscard]] std::span<Waiting> waiting(std::uint32_t copy);
  void sort_waiting(Copy& copy, std::span<Waiting> all, std::uint32_t now);
  [[nodiscard]] bool goes_before(const Waiting& a, const Waiting& b, std::uint32_t now) const;
  [[nodiscard]] bool has_room(std::uint32_t i, const Ground::Chain& chain) const;
  void grant(Block& block, std::uint32_t i, std::uint32_t waited);
  [[nodiscard]] std::uint32_t blocker_of(std::uint32_t i) const;

  const Ground& ground_;
  const FleetOptions& options_;
  const Numbers& numbers_;
  State& state_;
  std::vector<Copy>& copies_;
  std::vector<CrossingState>& crossings_;
  Leaders& leaders_;
  PathSurvey& survey_;
  std::uint32_t overtaken_after_steps_;  ///< rounded up
};

}  // namespace cosiva::virtual_side
