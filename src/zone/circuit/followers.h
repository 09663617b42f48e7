#pragma once

#include <cstddef>
#include <vector>

#include "cosiva/zone/circuit/circuit.h"

namespace cosiva::zone {

/// The sections that begin near after the end of each section: a vehicle that drives there follows, and does not
/// obstruct. Invariant: after a successful search each section has its followers, which may be none.
class Followers {
 public:
  explicit Followers(const Circuit& circuit) : circuit_{circuit} {}

  /// Of every section, finds those that begin within `follow_m` of its end. Each step takes its cost from `work_left`;
  /// false, and unfinished, when the work is not enough.
  [[nodiscard]] bool find(double follow_m, std::size_t& work_left);

  /// Whether `after` continues `before` so nearly straight that a vehicle merely follows.
  [[nodiscard]] bool follows(SectionId before, SectionId after) const;
  /// From the end of one section to the start of the other [m]; infinity where that is none of those found.
  [[nodiscard]] double gap_m(SectionId before, SectionId after) const;

 private:
  struct Follower {
    SectionId section;
    double gap_m;
  };
  const Circuit& circuit_;
  std::vector<Follower> all_;
  std::vector<std::size_t> first_;  ///< of each section's, and one past the last
};

}  // namespace cosiva::zone
