#include "cosiva/virtual/fleet/placement.h"

#include <algorithm>
#include <string>
#include <utility>

#include "cosiva/aiv/motion/formulas.h"
#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {
namespace {

/// Number of vehicles of whole copies that are stepped together: few enough that their data stays in the processor's
/// second-level cache from one pass to the next.
constexpr std::uint32_t block_vehicles = 512;

}  // namespace

Placement::Placement(FleetTables& tables, Leaders& leaders, PathSurvey& survey, Presence& presence)
    : ground_{tables.ground},
      numbers_{tables.numbers},
      state_{tables.state},
      copies_{tables.copies},
      front_{tables.front},
      rear_{tables.rear},
      crossings_{tables.crossings},
      blocks_{tables.blocks},
      arrived_{tables.arrived},
      commanded_vehicles_{tables.commanded_vehicles},
      leaders_{leaders},
      survey_{survey},
      presence_{presence} {}

Result<void> Placement::put(std::span<const FleetStart> starts) {
  state_.resize(starts.size(), numbers_.has_limits, numbers_.has_turns);
  arrived_.assign(starts.size(), 0);
  for (std::uint32_t i = 0; i < starts.size(); ++i) {
    const auto& [copy, position, priority] = starts[i];
    const auto refuse = [&](const char* why) {
      return fail("fleet.start", "vehicle " + std::to_string(i) + " cannot start there: " + why, "starts");
    };
    const bool is_away = position.section == zone::no_section;
    if (i > 0 && copy < starts[i - 1].copy) return refuse("its copy comes before that of the vehicle before it");
    while (copies_.size() <= copy) copies_.push_back({i});
    state_.own[i].copy = copy;
    state_.own[i].priority = static_cast<std::int16_t>(std::clamp(priority, 0, zone::priority_max));
    if (is_away) {
      presence_.make_absent(i);
      ++commanded_vehicles_;
      continue;
    }
    if (position.section >= ground_.size() ||
        !(position.s_m >= 0.0 && position.s_m <= ground_.length_m(position.section)))
      return refuse("no such track position in the zone");
    if (!ground_.may_stop(position)) return refuse("the position is in a crossing, or between two close to each other");
    state_.section[i] = position.section;
    state_.own[i].began_on = position.section;
    state_.s_m[i] = position.s_m;
    state_.own[i].traversed_m = -position.s_m;
  }
  copies_.push_back({static_cast<std::uint32_t>(starts.size())});
  const std::size_t count = copies_.size() - 1;
  front_.assign(count * ground_.size(), Fleet::none);
  rear_.assign(count * ground_.size(), Fleet::none);
  crossings_.assign(count * ground_.zone().crossings.size(), {});
  lay_blocks();
  COSIVA_EXPECT(blocks_.empty() || blocks_.back().last == starts.size());
  return line_up();
}

void Placement::lay_blocks() {
  const auto count = static_cast<std::uint32_t>(copies_.size() - 1);
  for (std::uint32_t copy = 0; copy < count;) {
    Block block;
    block.first_copy = copy;
    block.first = copies_[copy].first;
    do {
      ++copy;
    } while (copy < count && copies_[copy].first - block.first < block_vehicles);
    block.last_copy = copy;
    block.last = copies_[copy].first;
    block.occupied_steps.assign(ground_.size(), 0);
    block.grants.assign(ground_.zone().crossings.size(), 0);
    block.waited_steps.assign(ground_.zone().crossings.size(), 0);
    block.detected_m.assign(ground_.size(), 0.0);
    block.detection_search.assign(ground_.size(), 0);
    // A section is opened again only at a shorter distance; on a real zone hardly ever.
    block.open.reserve(4 * ground_.size());
    if (block.last - block.first > forgets_vehicles) state_.next_mps.resize(state_.s_m.size());
    blocks_.push_back(std::move(block));
  }
}

Result<void> Placement::line_up() {
  const auto count = static_cast<std::uint32_t>(state_.s_m.size());
  std::vector<std::uint32_t> order(count);
  for (std::uint32_t i = 0; i < count; ++i) order[i] = i;
  std::ranges::sort(order, [&](std::uint32_t a, std::uint32_t b) {
    if (state_.own[a].copy != state_.own[b].copy) return state_.own[a].copy < state_.own[b].copy;
    if (state_.section[a] != state_.section[b]) return state_.section[a] < state_.section[b];
    return state_.s_m[a] != state_.s_m[b] ? state_.s_m[a] > state_.s_m[b] : a < b;
  });
  std::erase_if(order, [&](std::uint32_t i) { return (state_.mode[i] & Mode::absent) != 0; });
  for (const std::uint32_t i : order) {
    const std::size_t here = list_index(ground_, state_.own[i].copy, state_.section[i]);
    const std::uint32_t last = rear_[here];
    rear_[here] = i;
    if (last == Fleet::none) {
      front_[here] = i;
    } else {
      state_.own[last].behind = i;
      state_.leader[i] = last;
      state_.offset_m[i] = 0.0;
    }
  }
  std::ranges::sort(order);
  for (const std::uint32_t i : order) {
    if (front_[list_index(ground_, state_.own[i].copy, state_.section[i])] == i) leaders_.look_ahead(i);
    survey_.survey(i);
    const double gap_m = leaders_.gap_m(i);
    if (gap_m < aiv::clearance_m)
      return fail(
          "fleet.start",
          "vehicle " + std::to_string(i) + " starts too close behind vehicle " + std::to_string(state_.leader[i]),
          "starts");
  }
  return {};
}

}  // namespace cosiva::virtual_side
