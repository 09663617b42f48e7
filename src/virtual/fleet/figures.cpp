// What a fleet says of itself.
#include <algorithm>

#include "cosiva/base/digest.h"
#include "cosiva/virtual/fleet/inside.h"

namespace cosiva::virtual_side {
namespace {

template <typename T>
std::size_t size_of(const std::vector<T>& values) {
  return values.capacity() * sizeof(T);
}

}  // namespace

std::size_t State::bytes() const {
  std::size_t bytes = size_of(own) + size_of(queue) + size_of(profile);
  for (const auto* values : {&s_m, &v_mps, &next_mps, &offset_m, &halt_at, &line_at, &goal_at, &event_at, &cap_mps,
                             &slow_at, &slow_mps, &x_m, &y_m, &heading_rad, &turn_left_rad, &turn_radps})
    bytes += size_of(*values);
  for (const auto* values : {&leader, &section, &waited_steps}) bytes += size_of(*values);
  for (const auto* values : {&imposed, &mode, &event}) bytes += size_of(*values);
  return bytes;
}

std::size_t Fleet::Inside::bytes() const {
  std::size_t bytes = sizeof(Inside) + ground.bytes() + poses.bytes() + state.bytes() + size_of(copies) +
                      size_of(front) + size_of(rear) + size_of(crossings) + size_of(blocks) + size_of(smallest_gap_m) +
                      size_of(part_gap_m) + size_of(routes) + size_of(committed_sections) + size_of(arrived);
  for (const Block& block : blocks)
    bytes += size_of(block.occupied_steps) + size_of(block.grants) + size_of(block.waited_steps) +
             size_of(block.seen_m) + size_of(block.seen_search) + size_of(block.open);
  for (const Route& route : routes) bytes += size_of(route.sections);
  return bytes;
}

std::size_t Fleet::Inside::stuck() const {
  const auto count = static_cast<std::uint32_t>(state.s_m.size());
  // Each waits for one other at most: go from one to the next, and where a walk meets itself there is a circle.
  std::vector<std::uint32_t> walk(count, 0);
  std::size_t in_circles = 0;
  for (std::uint32_t start = 0; start < count; ++start) {
    std::uint32_t i = start;
    while (walk[i] == 0) {
      walk[i] = start + 1;
      const std::uint32_t to = waits_for(i);
      if (to == i) break;
      i = to;
      if (walk[i] != start + 1) continue;
      std::uint32_t round = i;
      do {
        ++in_circles;
        round = waits_for(round);
      } while (round != i);
    }
  }
  return in_circles;
}

std::uint64_t Fleet::Inside::digest() const {
  Digest digest;
  digest.add(std::uint64_t{step_number});
  for (std::size_t i = 0; i < state.s_m.size(); ++i) {
    for (const auto* values : {&state.s_m, &state.v_mps, &state.offset_m, &state.halt_at, &state.line_at,
                               &state.goal_at, &state.x_m, &state.y_m, &state.heading_rad})
      digest.add((*values)[i]);
    for (const auto* values : {&state.leader, &state.section, &state.waited_steps})
      digest.add(std::uint64_t{(*values)[i]});
    const Own& own = state.own[i];
    digest.add(own.gone_m);
    for (const std::uint32_t value : {own.held_chain, own.laps}) digest.add(std::uint64_t{value});
    digest.add(static_cast<std::int64_t>(state.profile[i]));
    digest.add(std::uint64_t{state.mode[i]});
  }
  for (const Copy& copy : copies) {
    for (const Waiting& waiting : std::span(state.queue).subspan(copy.first, copy.waiting)) {
      digest.add(std::uint64_t{waiting.vehicle});
      digest.add(std::uint64_t{waiting.asked_step});
    }
  }
  for (const CrossingState& crossing : crossings) digest.add(std::uint64_t{crossing.holder});
  double smallest_m = far_m;
  for (const double seen_m : smallest_gap_m) smallest_m = std::min(smallest_m, seen_m);
  digest.add(smallest_m);
  for (std::size_t x = 0; x < ground.zone().crossings.size(); ++x) {
    std::uint64_t grants = 0;
    std::uint64_t waited = 0;
    for (const Block& block : blocks) {
      grants += block.grants[x];
      waited += block.waited_steps[x];
    }
    digest.add(grants);
    digest.add(waited);
  }
  return digest.value();
}

}  // namespace cosiva::virtual_side
