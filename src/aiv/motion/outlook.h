#pragma once

#include <optional>
#include <span>

#include "cosiva/base/pose.h"
#include "cosiva/zone/circuit/course.h"

namespace cosiva::aiv {

/// The position of a vehicle and its route from there. Refers to the list of sections, which must outlive the outlook.
struct Outlook {
  // A position alone is an outlook, too: along default successors.
  // NOLINTNEXTLINE(google-explicit-constructor)
  Outlook(zone::TrackPosition at, std::span<const zone::SectionId> coming_sections = {})
      : here{at}, remaining{coming_sections} {}
  Outlook(zone::SectionId section, double s_m) : here{section, s_m} {}

  zone::TrackPosition here;
  std::span<const zone::SectionId> remaining;  ///< after here.section; beyond their end default successors
  /// The pose of the body where it differs from `here`: the body turns on the spot there, or has yet to join the path
  /// there.
  std::optional<Pose2> X_MB{};
};

[[nodiscard]] inline zone::SectionLookAhead section_look_ahead(const zone::Circuit& circuit, const Outlook& outlook) {
  return {circuit, outlook.here.section, outlook.remaining};
}

/// The angle that a vehicle turns on the spot from one section to the next; 0 where the vehicle continues without a
/// turn.
[[nodiscard]] inline double bend_rad(const zone::Circuit& circuit, zone::SectionId from, zone::SectionId to) {
  return circuit.part(from).pivots ? circuit.turn_at(from, to) : 0.0;
}

/// Whether the circuit has no branches and no turns on the spot: each section has at most one before and one after it.
[[nodiscard]] inline bool one_way_only(const zone::Circuit& circuit) {
  for (zone::SectionId id = 0; id < circuit.size(); ++id) {
    const auto branches = circuit.next(id);
    if (branches.size() > 1 || circuit.previous(id).size() > 1) return false;
    if (!branches.empty() && bend_rad(circuit, id, branches.front()) != 0.0) return false;
  }
  return true;
}

}  // namespace cosiva::aiv
