#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::zone {

/// The part of `on` where the body of a vehicle comes too near to a vehicle on `other`.
struct Contact {
  SectionId on;
  SectionId other;
  double from_m;
  double to_m;
  double other_from_m;  ///< the part of the other centre line that is touched
  double other_to_m;
  Point2 position;  ///< halfway between the two centre lines, where they are nearest
};

/// The criteria of find_crossings, and their bounds.
struct ContactRules {
  ContactRules(const VehicleShape& shape, double clearance);

  double half_length_m;
  double half_width_m;
  double near_m;    ///< a body's edge this near to a centre line may touch a vehicle there
  double disc_m;    ///< a body's edge this near to the centre of a vehicle that turns on the spot may touch it
  double reach_m;   ///< further than this from a body's centre nothing is that near
  double follow_m;  ///< along one section, vehicles this near follow each other; that is no crossing
  double step_m;    ///< between samples along a section
};

/// All contacts, sorted by (on, other, from). Nothing when the sections lie so densely on one another that it would
/// take minutes: the allowed work grows with the length of the sections, so that it bounds their density.
[[nodiscard]] std::optional<std::vector<Contact>> find_contacts(const Circuit& circuit, const ContactRules& rules);

}  // namespace cosiva::zone
