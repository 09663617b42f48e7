#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/planning/floor/floor.h"
#include "cosiva/planning/track/swept_area.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::planning {

/// The floor of a traffic zone, for vehicles of the zone's shape. A state is a waypoint of the zone and the section on
/// which a vehicle has reached it; at the joint of several sections a vehicle waits at the end of the one it came by.
/// Only vehicles that begin there are at the beginning of a section, and have to follow that one. A move leads to the
/// next waypoint along one branch, the turn on the spot at its beginning included. Cells follow from the bodies'
/// geometry alone, so that the two directions of a track, crossing tracks and tracks that run near one another need no
/// description.
///
/// Invariant: the floor's states and moves are those of `states_` and `moves_`, with the same indices.
class TrackFloor {
 public:
  [[nodiscard]] static TrackFloor make(const zone::TrafficZone& zone);

  [[nodiscard]] const Floor& floor() const noexcept { return floor_; }

  /// Where the vehicle is in this state; s is the section's length at a joint.
  [[nodiscard]] zone::TrackPosition position(StateId state) const noexcept { return states_[state]; }
  /// Sections of a move after the one where it begins, in driving order; the last contains its end.
  [[nodiscard]] std::span<const zone::SectionId> sections(StateId from, StateId to) const;
  /// Distance driven in a move [m].
  [[nodiscard]] double length_m(StateId from, StateId to) const;
  /// Distance driven in a move from which on the body is clear of its beginning [m]: no state and no move, besides
  /// those that need a cell of the rest of this move, leads a body to where the rest of this move does. At most the
  /// length.
  [[nodiscard]] double clear_m(StateId from, StateId to) const;
  /// How far a vehicle at this position has driven in the move [m]; none: it is not on the move's sections.
  [[nodiscard]] std::optional<double> driven_m(StateId from, StateId to, zone::TrackPosition position) const;
  /// The moves that enter one of these sections: while these are closed, a vehicle on one may only leave it.
  [[nodiscard]] std::vector<FloorMove> moves_into(std::span<const zone::SectionId> sections) const;
  /// What a body that is, or drives, in this area obstructs.
  [[nodiscard]] Obstruction obstructed(const SweptArea& area) const;
  /// An area of the zone's vehicle, with the margin that all areas of this floor have.
  [[nodiscard]] SweptArea empty_area() const { return SweptArea{vehicle_, margin_m_}; }
  /// The state of a vehicle that is stopped at this position, within `tolerance_m` along the section; none: the
  /// position is between two waypoints.
  [[nodiscard]] std::optional<StateId> state_at(zone::TrackPosition position, double tolerance_m = 0.05) const;
  /// The last state at or before this position on its section; none: the position precedes them.
  [[nodiscard]] std::optional<StateId> state_before(zone::TrackPosition position) const;
  /// The first state at or after this position, along the sections that follow; none: there is none before they end.
  [[nodiscard]] std::optional<StateId> state_after(zone::TrackPosition position,
                                                   std::span<const zone::SectionId> remaining) const;
  /// The states at the point of a station or of a waypoint's id: any heading, either direction of a two-way track.
  /// None where the zone has no such name, or where no state is at its point.
  [[nodiscard]] std::optional<GoalId> goal(std::string_view name) const;

 private:
  struct Move {
    StateId from;
    StateId to;
    std::vector<zone::SectionId> sections;
    double length_m{0.0};
    double clear_m{0.0};
    SweptArea area;
    std::vector<double> driven_m;    // at each pose of the area
    std::vector<double> sections_m;  // lengths of the sections, the first one's from its state on
  };
  class Builder;

  TrackFloor(Floor floor, const zone::VehicleShape& vehicle, double margin_m)
      : floor_{std::move(floor)}, vehicle_{vehicle}, margin_m_{margin_m} {}
  [[nodiscard]] const Move& move(StateId from, StateId to) const;
  [[nodiscard]] StateId first_on(zone::SectionId section) const;  // the first not before that section
  [[nodiscard]] bool is_on(StateId state, zone::SectionId section) const {
    return state < states_.size() && states_[state].section == section;
  }

  Floor floor_;
  zone::VehicleShape vehicle_;
  double margin_m_;
  std::vector<zone::TrackPosition> states_;  // sorted by section, s
  std::vector<SweptArea> areas_;             // by state
  std::vector<std::vector<Move>> moves_;     // by first state
  std::map<std::string, GoalId, std::less<>> goals_;
};

}  // namespace cosiva::planning
