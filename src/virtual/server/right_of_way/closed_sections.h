#pragma once

#include <string>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/virtual/server/right_of_way/waypoint_graph.h"

namespace cosiva::virtual_side {

/// The sections that no vehicle may enter: those that the zone's configuration closes, as changed by operators.
///
/// Invariant: the sections are in ascending order, each once.
class ClosedSections {
 public:
  /// Takes the sections that a zone's configuration closes, in ascending order; an operator's changes are void.
  void configure(std::vector<zone::SectionId> sections);
  void set(std::vector<zone::SectionId> sections);

  [[nodiscard]] const std::vector<zone::SectionId>& all() const { return closed_; }
  /// Those that the zone's configuration closes.
  [[nodiscard]] const std::vector<zone::SectionId>& configured() const { return configured_; }
  [[nodiscard]] bool contains(zone::SectionId section) const;
  /// The sections that are closed or in `avoided`, both in ascending order.
  [[nodiscard]] std::vector<zone::SectionId> with(Sections avoided) const;
  /// @param map  of the zone in force; null: none, and no names
  [[nodiscard]] std::vector<std::string> names(const WaypointGraph* map) const;
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  std::vector<zone::SectionId> closed_;
  std::vector<zone::SectionId> configured_;
};

}  // namespace cosiva::virtual_side
