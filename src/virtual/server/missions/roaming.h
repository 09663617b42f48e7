#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/virtual/server/right_of_way/closed_sections.h"
#include "cosiva/virtual/server/right_of_way/waypoint_graph.h"

namespace cosiva::virtual_side {

/// The branches that a roaming vehicle has taken: at each fork it takes the least recently taken one of those that do
/// not end in a dead end.
///
/// Invariant: no branch was taken at a later fork than the last one.
class Roaming {
 public:
  /// Which branches a vehicle can take.
  struct Open {
    const ClosedSections& closed;
    Sections avoided;                           ///< in ascending order
    const std::vector<bool>& goes_on_for_ever;  ///< by section: it does not lead into a dead end
  };
  /// Of the open sections in `choice`; no_section: none is open.
  [[nodiscard]] zone::SectionId least_recent(Sections choice, const Open& open) const;
  /// The vehicle takes `section` at a fork.
  void take(zone::SectionId section);
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  std::map<zone::SectionId, std::uint64_t> taken_;  ///< when each branch was last taken, counted in forks
  std::uint64_t forks_{0};
};

}  // namespace cosiva::virtual_side
