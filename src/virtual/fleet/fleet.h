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
  SimDuration step{std::chrono::milliseconds{100}};  ///< of time, in (0, 200 ms]
  /// By which the agents choose their speeds; null: the crisp rules.
  std::shared_ptr<const aiv::AgentRules> rules{};
  /// A vehicle that has waited so long at a crossing is overtaken by nobody (as virtual/server's Traffic has it).
  SimDuration overtaken_at_most{std::chrono::seconds{10}};
};

/// Where a vehicle begins, standing.
struct FleetStart {
  std::uint32_t copy{0};         ///< of the zone; from one start to the next it never falls
  zone::TrackPosition position;  ///< on no_section: it is not in the zone yet
  std::int32_t priority{0};      ///< 0…999
};

/// A fleet that is only virtual, in a core of its own, for times far beyond real time: `step` moves all vehicles on by
/// one step. They drive by the agents' own rules and formulas (src/aiv), with perfect senses and no messages; whoever
/// wants boards, noise and VDA 5050 takes virtual/vehicle. There may be many copies of the zone, each with vehicles of
/// its own that know nothing of the other copies.
///
/// Each vehicle circulates: round the zone's first loop, or where there is none along default successors (of those from
/// which one can go on for ever); or it follows a route to a goal and stays there. Crossings are reserved in whole
/// chains, and only with room for the vehicle beyond, so nobody ever stops in one. Who may go first is decided as in
/// virtual/server's Traffic. What can still deadlock is a circle of vehicles each of which has no room beyond its
/// crossing because the next of them stands there, and a goal that is on everybody's way: stuck() counts the former.
///
/// The same starts and calls give the same bits, whatever the workers, the compiler and its options. A step allocates
/// nothing. Vehicles are numbered in the order of their starts.
class Fleet {
 public:
  using Vehicle = std::uint32_t;
  static constexpr Vehicle none = std::numeric_limits<Vehicle>::max();

  /// Fails ("fleet.start") where a start is not on the circuit, lies in a crossing or between two that are too close to
  /// stand between, or is less than occupied_m() + aiv::clearance_m behind the next one; ("fleet.options") on options
  /// out of range; ("fleet.zone") on a zone without sections or with chains of crossings too long to be reserved.
  /// @param zone  shared by all copies
  [[nodiscard]] static Result<Fleet> make(std::shared_ptr<const zone::TrafficZone> zone, const FleetOptions& options,
                                          std::span<const FleetStart> starts);
  /// At most `count` starts in one copy, spread over the zone; as many as there is room for.
  [[nodiscard]] static std::vector<FleetStart> spread(const zone::TrafficZone& zone, std::size_t count,
                                                      std::uint32_t copy = 0);
  Fleet(Fleet&&) noexcept;
  Fleet& operator=(Fleet&&) noexcept;
  ~Fleet();

  void step();  ///< all by itself
  /// With whoever helps; what comes out is the same.
  /// @param steps  so many at once: each part of the fleet that knows nothing of the others goes all of them before the
  ///               next part begins, so that even a fleet far larger than the processor's caches is worked on in them
  void step(Workers& workers, std::uint32_t steps = 1);
  [[nodiscard]] std::uint64_t steps() const;
  [[nodiscard]] SimDuration time() const;  ///< steps() · the step's length

  // What can be told a vehicle, between steps.

  /// Goes along `route`, the section that it is on first, each a successor of the one before, to `goal_s_m` on the last
  /// of them, and stays there. It must begin as committed() does; the goal must not lie nearer than the vehicle can
  /// stop, nor before the end of crossings that it holds; and it must not turn back within crossings that are reserved
  /// together. Whose goal was in crossings holds all that the default way on from there needs; for another way the rest
  /// must be free. False, and nothing changed: it is no such route, or not now.
  [[nodiscard]] bool send(Vehicle vehicle, std::span<const zone::SectionId> route, double goal_s_m);
  /// Circulates from where it is, once it has come to the end of what it is committed to. What it was sent for is void.
  void circulate(Vehicle vehicle);
  /// Sections that it will drive in any case, because it could not stop before them or holds a crossing in them; the
  /// one it is on first. A new route is planned from the end of the last of these. Of one that stands outside crossings
  /// only the section it is on. Valid until the next call of anything that is not const.
  [[nodiscard]] std::span<const zone::SectionId> committed(Vehicle vehicle);
  void set_priority(Vehicle vehicle, std::int32_t priority);          ///< at crossings, 0…999
  void limit_speed(Vehicle vehicle, double speed_mps);                ///< > 0; infinite: no limit of its own
  void impose(Vehicle vehicle, std::optional<aiv::Profile> profile);  ///< an operator's instruction; nothing: none

  /// Takes one out of the zone that stands at its goal, and whatever it was told with it. False: it does not stand
  /// there.
  [[nodiscard]] bool take_away(Vehicle vehicle);
  /// Puts one into the zone that is not in it, standing; it circulates. What it has driven and waited goes on counting.
  /// False, and nothing changed: it is there already, the place is none to begin at, or somebody is too near, who could
  /// not stop or whom it would stand too close to.
  [[nodiscard]] bool bring(Vehicle vehicle, zone::TrackPosition position, std::int32_t priority = 0);
  /// Whether bring() may ever put somebody there: outside crossings, and not between two that are too close.
  [[nodiscard]] bool may_stop(zone::TrackPosition position) const;
  [[nodiscard]] bool is_away(Vehicle vehicle) const;  ///< its place, pose and gap then mean nothing

  // What can be asked. Spans have one entry per vehicle and stay where they are; they show the end of the last step.

  [[nodiscard]] std::size_t size() const;
  [[nodiscard]] std::uint32_t copies() const;
  [[nodiscard]] const zone::TrafficZone& zone() const;
  /// Who has come to its goal in the last call of step, ascending.
  [[nodiscard]] std::span<const Vehicle> arrived() const;
  [[nodiscard]] bool has_goal(Vehicle vehicle) const;    ///< is sent somewhere, there or not
  [[nodiscard]] bool is_at_goal(Vehicle vehicle) const;  ///< and stands there
  [[nodiscard]] std::uint32_t copy_of(Vehicle vehicle) const;
  [[nodiscard]] zone::TrackPosition track_position(Vehicle vehicle) const;  ///< of its middle
  [[nodiscard]] Pose2 pose(Vehicle vehicle) const;                          ///< X_MB
  [[nodiscard]] std::span<const double> x_m() const;
  [[nodiscard]] std::span<const double> y_m() const;
  [[nodiscard]] std::span<const double> heading_rad() const;  ///< in (−π, π]
  [[nodiscard]] std::span<const double> speed_mps() const;
  [[nodiscard]] aiv::Profile profile(Vehicle vehicle) const;  ///< what its agent has chosen last
  /// The next body ahead on its way, and the distance between the two: the arc length between their middles less
  /// occupied_m() (spacing.h), which is a vehicle's length unless the zone has very tight bends. Bodies nearer than
  /// sensed_m() past the end of its section are found at least.
  struct Ahead {
    Vehicle vehicle{none};
    double gap_m{std::numeric_limits<double>::infinity()};
  };
  /// Also one that has just turned off to another branch, until their bodies have parted.
  [[nodiscard]] Ahead ahead(Vehicle vehicle) const;
  [[nodiscard]] double sensed_m() const;  ///< so far ahead bodies count, from a vehicle's front
  [[nodiscard]] Vehicle holder(std::uint32_t copy, std::size_t crossing) const;  ///< none: it is free

  // Figures, since the start.

  [[nodiscard]] double distance_m(Vehicle vehicle) const;
  /// Standing without being at its goal; turning on the spot is not standing.
  [[nodiscard]] SimDuration waiting(Vehicle vehicle) const;
  /// How often it has come back to the section it began on.
  [[nodiscard]] std::uint32_t laps(Vehicle vehicle) const;
  struct CrossingMetrics {
    std::uint64_t grants{};
    SimDuration waiting{};  ///< from asking to grant, of all who were granted it
  };
  [[nodiscard]] CrossingMetrics crossing(std::size_t crossing) const;  ///< of all copies together
  /// Time that vehicles spent on a section, of all copies together, up to now.
  [[nodiscard]] SimDuration occupancy(zone::SectionId section) const;
  [[nodiscard]] double smallest_gap_m() const;     ///< ever, from front to rear; infinite: nobody saw anybody
  [[nodiscard]] std::uint64_t collisions() const;  ///< vehicle-steps with a gap below 0 or in a crossing not held
  /// Vehicles that wait for each other in a circle now: without help they never go on.
  [[nodiscard]] std::size_t stuck() const;
  /// Of everything that decides what comes next, and of the figures.
  [[nodiscard]] std::uint64_t digest() const;
  [[nodiscard]] std::size_t bytes() const;  ///< of memory, all in all

 private:
  struct Impl;
  explicit Fleet(std::unique_ptr<Impl> inside);
  std::unique_ptr<Impl> in_;
};

}  // namespace cosiva::virtual_side
