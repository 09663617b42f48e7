#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "cosiva/virtual/fleet/fleet_tables.h"
#include "cosiva/virtual/fleet/paths.h"

namespace cosiva::virtual_side {

/// Stores for each vehicle the body ahead of it: its leader. Invariant: the vehicles on a section are listed from the
/// farthest to the one that entered last, and every vehicle in the zone is on the list of its section.
class Leaders {
 public:
  struct Found {
    std::uint32_t vehicle;
    double offset_m;  ///< start of its section, counted from the start of the follower's section
  };
  Leaders(FleetTables& tables, const Paths& paths);

  /// Finds the leader of vehicle i, the first on its section.
  void look_ahead(std::uint32_t i);
  /// The first body on the path of vehicle i after its section, at most `sensed_m` behind the section's end; i itself
  /// if there is none.
  [[nodiscard]] Found find_ahead(std::uint32_t i, double sensed_m) const;
  /// A vehicle has entered `section`, or has cleared it for other branches; `left`, its former section, may be empty
  /// now. The first vehicles on the sections before these find their leaders again.
  void update_followers(Block& block, std::uint32_t copy, zone::SectionId section,
                        zone::SectionId left = zone::no_section);
  /// From vehicle i to its leader [m]; nearly far_m without a leader.
  [[nodiscard]] double gap_m(std::uint32_t i) const {
    return state_.offset_m[i] + state_.s_m[state_.leader[i]] - state_.s_m[i] - numbers_.length_m;
  }
  /// Removes vehicle i from the list of its section.
  void unlink(std::uint32_t i);
  /// Inserts vehicle i into the list of its section, in order.
  void link(std::uint32_t i);

 private:
  const Ground& ground_;
  const Numbers& numbers_;
  State& state_;
  std::vector<std::uint32_t>& front_;
  std::vector<std::uint32_t>& rear_;
  const Paths& paths_;
};

}  // namespace cosiva::virtual_side
