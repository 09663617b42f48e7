#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "cosiva/aiv/decision/agent_rules.h"
#include "cosiva/aiv/motion/speed.h"
#include "cosiva/base/pose.h"
#include "cosiva/base/result.h"
#include "cosiva/base/time.h"
#include "cosiva/base/workers.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::virtual_side {

struct FleetOptions {
  SimDuration step{std::chrono::milliseconds{100}};  ///< the length of a step, in (0, 200 ms]
  /// The rules of the agents' speed choice; null: the crisp rules.
  std::shared_ptr<const aiv::AgentRules> rules{};
  /// After this waiting time at a crossing no other vehicle overtakes the waiting one (as in virtual/server's Traffic).
  SimDuration overtaken_at_most{std::chrono::seconds{10}};
};

/// Where a vehicle starts, at standstill.
struct FleetStart {
  std::uint32_t copy{0};         ///< of the zone; never decreases from one start to the next
  zone::TrackPosition position;  ///< no_section: the vehicle is not in the zone yet
  std::int32_t priority{0};      ///< 0…999
};

/// A purely virtual fleet in a core of its own, far faster than real time: `step` moves all vehicles by one step. The
/// vehicles drive by the agents' own rules and formulas (src/aiv), with perfect sensors and without messages;
/// virtual/vehicle models boards, noise and VDA 5050. There may be many copies of the zone, each with vehicles of its
/// own that do not interact with other copies.
///
/// Each vehicle circulates along the zone's first loop, or, in a zone without loops, along default successors (among
/// those that can be followed for ever); or the vehicle follows a route to a goal and stays there. Crossings are
/// reserved in whole chains, and only with room for the vehicle beyond, so no vehicle ever stops in one. The right of
/// way is decided as in virtual/server's Traffic. Two kinds of deadlock remain: a cycle of vehicles each of which has
/// no room beyond its crossing because the next vehicle is stopped there, and a goal on the path of all others: stuck()
/// counts the former.
///
/// The same starts and calls give the same bits for all workers, compilers and options. A step allocates nothing.
/// Vehicles are numbered in the order of their starts.
class Fleet {
 public:
  using Vehicle = std::uint32_t;
  static constexpr Vehicle none = std::numeric_limits<Vehicle>::max();

  /// Fails ("fleet.start") if a start is not on the circuit, is in a crossing or between two crossings too close for a
  /// vehicle to stop between, or is less than occupied_m() + aiv::clearance_m behind the next one; ("fleet.options") on
  /// options out of range; ("fleet.zone") on a zone without sections or with chains of crossings too long to be
  /// reserved. @param zone  shared by all copies
  [[nodiscard]] static Result<Fleet> make(std::shared_ptr<const zone::TrafficZone> zone, const FleetOptions& options,
                                          std::span<const FleetStart> starts);
  /// At most `count` starts in one copy, distributed over the zone; as many as there is room for.
  [[nodiscard]] static std::vector<FleetStart> spread(const zone::TrafficZone& zone, std::size_t count,
                                                      std::uint32_t copy = 0);
  Fleet(Fleet&&) noexcept;
  Fleet& operator=(Fleet&&) noexcept;
  ~Fleet();

  void step();  ///< in the calling thread alone
  /// The result does not depend on the workers. @param steps  number of steps at once: each independent part of the
  /// fleet makes all of them before the next part starts, so that even a fleet far larger than the processor's caches
  /// is processed within them
  void step(Workers& workers, std::uint32_t steps = 1);
  [[nodiscard]] std::uint64_t steps() const;
  [[nodiscard]] SimDuration time() const;  ///< steps() times the length of a step

  // Commands to vehicles, between steps.

  /// Drives along `route` to `goal_s_m` on its last section and stays there. The route begins with the vehicle's
  /// present section, and each section is a successor of the one before. The route must begin as committed() does; the
  /// goal must not be nearer than the stopping distance, nor before the end of crossings that the vehicle holds; and
  /// the route must not turn back within crossings that are reserved together. A vehicle whose goal was in crossings
  /// holds all that the default path on from there needs; for another path the rest must be free. Returns false and
  /// changes nothing if the route is invalid, or not possible now.
  [[nodiscard]] bool send(Vehicle vehicle, std::span<const zone::SectionId> route, double goal_s_m);
  /// Circulates from the end of the present commitment on. A previous goal is void.
  void circulate(Vehicle vehicle);
  /// Sections that the vehicle will drive in any case, because it could not stop before them or holds a crossing in
  /// them; its present section first. A new route is planned from the end of the last one. For a vehicle that is
  /// stopped outside crossings: the present section only. Valid until the next call of a non-const function.
  [[nodiscard]] std::span<const zone::SectionId> committed(Vehicle vehicle);
  void set_priority(Vehicle vehicle, std::int32_t priority);          ///< at crossings, 0…999
  void limit_speed(Vehicle vehicle, double speed_mps);                ///< > 0; infinite: no limit of its own
  void impose(Vehicle vehicle, std::optional<aiv::Profile> profile);  ///< an operator's instruction; nothing: none

  /// Removes a vehicle that is stopped at its goal from the zone, with all its commands. Returns false if the vehicle
  /// is not stopped at its goal.
  [[nodiscard]] bool take_away(Vehicle vehicle);
  /// Adds an absent vehicle to the zone at standstill; the vehicle circulates. Its driven distance and waiting time
  /// continue to count. Returns false and changes nothing if the vehicle is present, no vehicle may start at this track
  /// position, or another vehicle is too near: it could not stop, or the clearance would be too small.
  [[nodiscard]] bool bring(Vehicle vehicle, zone::TrackPosition position, std::int32_t priority = 0);
  /// Whether bring() may ever add a vehicle there: outside crossings, and not between two crossings too close.
  [[nodiscard]] bool may_stop(zone::TrackPosition position) const;
  [[nodiscard]] bool is_away(Vehicle vehicle) const;  ///< its track position, pose and gap are then meaningless

  // Queries. Spans have one entry per vehicle and remain valid; they show the end of the last step.

  [[nodiscard]] std::size_t size() const;
  [[nodiscard]] std::uint32_t copies() const;
  [[nodiscard]] const zone::TrafficZone& zone() const;
  /// The vehicles that reached their goals in the last call of step, ascending.
  [[nodiscard]] std::span<const Vehicle> arrived() const;
  [[nodiscard]] bool has_goal(Vehicle vehicle) const;    ///< was sent to a goal, reached or not
  [[nodiscard]] bool is_at_goal(Vehicle vehicle) const;  ///< and is stopped there
  [[nodiscard]] std::uint32_t copy_of(Vehicle vehicle) const;
  [[nodiscard]] zone::TrackPosition track_position(Vehicle vehicle) const;  ///< of its body origin
  [[nodiscard]] Pose2 pose(Vehicle vehicle) const;                          ///< X_MB
  [[nodiscard]] std::span<const double> x_m() const;
  [[nodiscard]] std::span<const double> y_m() const;
  [[nodiscard]] std::span<const double> heading_rad() const;  ///< in (−π, π]
  [[nodiscard]] std::span<const double> speed_mps() const;
  [[nodiscard]] aiv::Profile profile(Vehicle vehicle) const;  ///< the last choice of its agent
  /// The next body ahead on the vehicle's path, and the distance between the two: the arc length between their body
  /// origins less occupied_m() (spacing.h), which is a vehicle's length unless the zone has very tight bends. At least
  /// the bodies nearer than sensed_m() past the end of the present section are found.
  struct Ahead {
    Vehicle vehicle{none};
    double gap_m{std::numeric_limits<double>::infinity()};
  };
  /// Includes a vehicle that has just turned off to another branch, until their bodies have parted.
  [[nodiscard]] Ahead ahead(Vehicle vehicle) const;
  [[nodiscard]] double sensed_m() const;  ///< bodies count up to this distance from a vehicle's front
  [[nodiscard]] Vehicle holder(std::uint32_t copy, std::size_t crossing) const;  ///< none: it is free

  // Metrics since the start.

  [[nodiscard]] double distance_m(Vehicle vehicle) const;
  /// Time at standstill away from the goal; a turn on the spot is no standstill.
  [[nodiscard]] SimDuration waiting(Vehicle vehicle) const;
  /// Number of returns to the section of the start.
  [[nodiscard]] std::uint32_t laps(Vehicle vehicle) const;
  struct CrossingMetrics {
    std::uint64_t grants{};
    SimDuration waiting{};  ///< from request to grant, of all grants
  };
  [[nodiscard]] CrossingMetrics crossing(std::size_t crossing) const;  ///< of all copies together
  /// Time that vehicles spent on a section, of all copies together, until now.
  [[nodiscard]] SimDuration occupancy(zone::SectionId section) const;
  [[nodiscard]] double smallest_gap_m() const;     ///< of the whole run, from front to rear; infinite: no vehicle had a
                                                   ///< leader
  [[nodiscard]] std::uint64_t collisions() const;  ///< vehicle-steps with a gap below 0 or in a crossing not held
  /// Number of vehicles that wait for each other in a cycle now: they would wait for ever.
  [[nodiscard]] std::size_t stuck() const;
  /// Of the whole state that determines the next steps, and of the metrics.
  [[nodiscard]] std::uint64_t digest() const;
  [[nodiscard]] std::size_t bytes() const;  ///< of memory, all in all

 private:
  struct Impl;
  explicit Fleet(std::unique_ptr<Impl> inside);
  std::unique_ptr<Impl> in_;
};

}  // namespace cosiva::virtual_side
