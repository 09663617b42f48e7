#include "cosiva/zone/circuit/followers.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "cosiva/base/expect.h"

namespace cosiva::zone {
namespace {

// A vehicle that enters a corner sharper than this does not merely follow the one that turns there: it obstructs it.
constexpr double follow_turn_max_rad = pi / 4.0;
constexpr double infinity = std::numeric_limits<double>::infinity();

}  // namespace

bool Followers::follows(SectionId before, SectionId after) const {
  return std::fabs(circuit_.turn_at(before, after)) <= follow_turn_max_rad;
}

bool Followers::find(double follow_m, std::size_t& work_left) {
  all_.clear();
  first_.assign(1, 0);
  for (SectionId id = 0; id < circuit_.size(); ++id) {
    const std::size_t first = all_.size();
    const auto go_on = [&](SectionId from, double gap_m) {
      for (const SectionId after : circuit_.next(from)) {
        const std::size_t found = all_.size() - first;
        if (work_left <= found) return false;
        work_left -= found + 1;
        if (!follows(from, after)) continue;
        const auto known = std::find_if(all_.begin() + static_cast<std::ptrdiff_t>(first), all_.end(),
                                        [&](const Follower& f) { return f.section == after; });
        if (known == all_.end())
          all_.push_back({after, gap_m});
        else
          known->gap_m = std::min(known->gap_m, gap_m);
      }
      return true;
    };
    if (!go_on(id, 0.0)) return false;
    for (std::size_t i = first; i < all_.size(); ++i) {
      const double gap_m = all_[i].gap_m + circuit_.section(all_[i].section).length_m();
      if (gap_m <= follow_m && !go_on(all_[i].section, gap_m)) return false;
    }
    first_.push_back(all_.size());
  }
  COSIVA_EXPECT(first_.size() == circuit_.size() + 1);
  return true;
}

double Followers::gap_m(SectionId before, SectionId after) const {
  for (std::size_t i = first_[before]; i < first_[before + 1]; ++i) {
    if (all_[i].section == after) return all_[i].gap_m;
  }
  return infinity;
}

}  // namespace cosiva::zone
