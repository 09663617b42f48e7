#include "cosiva/virtual/server/missions/roaming.h"

#include <algorithm>
#include <limits>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {

zone::SectionId Roaming::least_recent(Sections choice, const Open& open) const {
  const auto worth = [&](zone::SectionId section) {
    const auto taken = taken_.find(section);
    // Branches that lead into a dead end come last, regardless of when they were taken.
    constexpr auto dead_end = std::numeric_limits<std::uint64_t>::max() / 2;
    return (taken == taken_.end() ? 0 : taken->second) + (open.goes_on_for_ever[section] ? 0 : dead_end);
  };
  zone::SectionId best = zone::no_section;
  for (const zone::SectionId section : choice)
    if (!open.closed.contains(section) && !std::ranges::binary_search(open.avoided, section) &&
        (best == zone::no_section || worth(section) < worth(best)))
      best = section;
  return best;
}

void Roaming::take(zone::SectionId section) {
  std::uint64_t& taken = taken_[section];
  COSIVA_EXPECT(taken <= forks_);
  taken = ++forks_;
}

void Roaming::archive(Archive& archive) { archive(taken_, forks_); }

}  // namespace cosiva::virtual_side
