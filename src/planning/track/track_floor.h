#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/planning/floor/floor.h"
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
  /// @param closed  sections that no move enters; a vehicle on one may leave it
  [[nodiscard]] static TrackFloor make(const zone::TrafficZone& zone, std::span<const zone::SectionId> closed = {});

  [[nodiscard]] const Floor& floor() const noexcept { return floor_; }

  /// Where the vehicle is in this state; s is the section's length at a joint.
  [[nodiscard]] zone::TrackPosition position(StateId state) const noexcept { return states_[state]; }
  /// Sections of a move after the one where it begins, in driving order; the last contains its end.
  [[nodiscard]] std::span<const zone::SectionId> sections(StateId from, StateId to) const;
  /// The state of a vehicle that is stopped at this position, within `tolerance_m` along the section; none: the
  /// position is between two waypoints.
  [[nodiscard]] std::optional<StateId> state_at(zone::TrackPosition position, double tolerance_m = 0.05) const;
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
  };
  class Builder;

  explicit TrackFloor(Floor floor) : floor_{std::move(floor)} {}
  [[nodiscard]] StateId first_on(zone::SectionId section) const;  // the first not before that section
  [[nodiscard]] bool is_on(StateId state, zone::SectionId section) const {
    return state < states_.size() && states_[state].section == section;
  }

  Floor floor_;
  std::vector<zone::TrackPosition> states_;  // sorted by section, s
  std::vector<std::vector<Move>> moves_;     // by first state
  std::map<std::string, GoalId, std::less<>> goals_;
};

}  // namespace cosiva::planning
