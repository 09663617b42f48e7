#include "cosiva/virtual/fleet/leaders.h"

#include <algorithm>

#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {

Leaders::Leaders(FleetTables& tables, const Paths& paths)
    : ground_{tables.ground},
      numbers_{tables.numbers},
      state_{tables.state},
      front_{tables.front},
      rear_{tables.rear},
      paths_{paths} {}

void Leaders::look_ahead(std::uint32_t i) {
  const auto [vehicle, offset_m] = find_ahead(i, numbers_.sensed_m);
  state_.leader[i] = vehicle;
  state_.offset_m[i] = offset_m;
}

Leaders::Found Leaders::find_ahead(std::uint32_t i, double sensed_m) const {
  const std::uint32_t copy = state_.own[i].copy;
  const zone::Circuit& circuit = ground_.circuit();
  Paths::Path path = paths_.path_of(i);
  double start_m = ground_.length_m(path.section);
  const double end_m = start_m + sensed_m;
  for (std::size_t steps = 0; start_m <= end_m && steps <= ground_.size(); ++steps) {
    const zone::SectionId to = paths_.beyond(path);
    if (to == zone::no_section) break;
    Found found{rear_[list_index(ground_, copy, to)], start_m};
    const auto branches = circuit.next(path.section);
    if (branches.size() > 1) {
      // A vehicle on another branch is an obstacle until its body has parted from this path.
      for (const zone::SectionId branch : branches) {
        const std::uint32_t other = rear_[list_index(ground_, copy, branch)];
        if (branch == to || other == Fleet::none || !(state_.s_m[other] < ground_.parted_m(branch))) continue;
        if (found.vehicle == Fleet::none || state_.s_m[other] < state_.s_m[found.vehicle]) found.vehicle = other;
      }
    }
    if (found.vehicle == i) return {i, far_m};  // a whole lap without another vehicle
    if (found.vehicle != Fleet::none) return found;
    start_m += ground_.length_m(to);
    Paths::advance(path, to);
  }
  return {i, far_m};
}

void Leaders::update_followers(Block& block, std::uint32_t copy, zone::SectionId section, zone::SectionId left) {
  const zone::Circuit& circuit = ground_.circuit();
  ++block.search;
  block.open.clear();
  for (const zone::SectionId changed : {left, section}) {
    if (changed == zone::no_section) continue;
    block.open.push_back(changed);
    block.detected_m[changed] = 0.0;
    block.detection_search[changed] = block.search;
  }
  for (std::size_t k = 0; k < block.open.size(); ++k) {
    const zone::SectionId to = block.open[k];
    const double path_distance_m = block.detected_m[to];
    for (const zone::SectionId from : circuit.previous(to)) {
      const std::uint32_t first = front_[list_index(ground_, copy, from)];
      if (first != Fleet::none) {
        look_ahead(first);
        continue;
      }
      const double on_m = path_distance_m + ground_.length_m(from);
      if (on_m > numbers_.sensed_m) continue;
      // A section found again at a shorter distance is searched again: sections behind it may only now be near enough.
      if (block.detection_search[from] == block.search && block.detected_m[from] <= on_m) continue;
      block.detection_search[from] = block.search;
      block.detected_m[from] = on_m;
      block.open.push_back(from);
    }
  }
}

void Leaders::unlink(std::uint32_t i) {
  const std::size_t here = list_index(ground_, state_.own[i].copy, state_.section[i]);
  const std::uint32_t behind = std::exchange(state_.own[i].behind, Fleet::none);
  std::uint32_t before = Fleet::none;
  for (std::uint32_t other = front_[here]; other != i; other = state_.own[other].behind) {
    COSIVA_EXPECT(other != Fleet::none);
    before = other;
  }
  (before == Fleet::none ? front_[here] : state_.own[before].behind) = behind;
  if (behind == Fleet::none) {
    rear_[here] = before;
  } else if (before == Fleet::none) {
    look_ahead(behind);
  } else {
    state_.leader[behind] = before;
    state_.offset_m[behind] = 0.0;
  }
}

void Leaders::link(std::uint32_t i) {
  const std::size_t here = list_index(ground_, state_.own[i].copy, state_.section[i]);
  std::uint32_t before = Fleet::none;
  std::uint32_t behind = front_[here];
  for (; behind != Fleet::none && state_.s_m[behind] >= state_.s_m[i]; behind = state_.own[behind].behind)
    before = behind;
  (before == Fleet::none ? front_[here] : state_.own[before].behind) = i;
  state_.own[i].behind = behind;
  if (behind == Fleet::none) {
    rear_[here] = i;
  } else {
    state_.leader[behind] = i;
    state_.offset_m[behind] = 0.0;
  }
  if (before == Fleet::none) {
    look_ahead(i);
  } else {
    state_.leader[i] = before;
    state_.offset_m[i] = 0.0;
  }
}

}  // namespace cosiva::virtual_side
