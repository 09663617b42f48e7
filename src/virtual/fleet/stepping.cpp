// One step: everybody perceives and decides, everybody moves, then what is more than arithmetic, in vehicle order.
#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "cosiva/base/math.h"
#include "cosiva/virtual/fleet/inside.h"

namespace cosiva::virtual_side {
namespace {

/// Vehicles of one large copy that a worker takes at a time.
constexpr std::uint32_t part_vehicles = 2048;

}  // namespace

void Fleet::Inside::step(Workers& workers, std::uint32_t steps) {
  const bool in_parts = blocks.size() == 1 && blocks.front().last > 2 * part_vehicles;
  const auto all = [&](Block& block) {
    block.arrivals = 0;
    for (block.now = step_number; block.now < step_number + steps; ++block.now) {
      if (in_parts)
        step_in_parts(workers, block);
      else
        step_block(block);
    }
    std::sort(arrived.begin() + block.first, arrived.begin() + block.first + block.arrivals);
  };
  if (in_parts)
    all(blocks.front());
  else
    workers.for_each(blocks.size(), [&](std::size_t b) { all(blocks[b]); });
  step_number += steps;
  gather_arrivals();
}

void Fleet::Inside::step_block(Block& block) {
  const FleetRules* const by = rules ? &*rules : nullptr;
  const bool more = told_vehicles > 0;
  const auto b = static_cast<std::size_t>(&block - blocks.data());
  alignas(64) std::array<double, forgets_vehicles> forgotten;
  double* const next =
      block.last - block.first > forgets_vehicles ? state.next_mps.data() + block.first : forgotten.data();
  note_gap(block, smallest_gap_m[b], decide(state, numbers, by, more, block.first, block.last, next));
  move(state, numbers, block.first, block.last, next);
  settle(block);
  draw(block.first, block.last);
}

void Fleet::Inside::step_in_parts(Workers& workers, Block& block) {
  const FleetRules* const by = rules ? &*rules : nullptr;
  const bool more = told_vehicles > 0;
  const std::size_t parts = (block.last + part_vehicles - 1) / part_vehicles;
  const auto of_part = [&](std::size_t part, auto work) {
    const auto first = static_cast<std::uint32_t>(part * part_vehicles);
    work(first, std::min(block.last, first + part_vehicles));
  };
  workers.for_each(parts, [&](std::size_t part) {
    of_part(part, [&](std::uint32_t first, std::uint32_t last) {
      part_gap_m[part] = decide(state, numbers, by, more, first, last, state.next_mps.data() + first);
    });
  });
  note_gap(block, smallest_gap_m.front(), *std::min_element(part_gap_m.begin(), part_gap_m.end()));
  workers.for_each(parts, [&](std::size_t part) {
    of_part(part, [&](std::uint32_t first, std::uint32_t last) {
      move(state, numbers, first, last, state.next_mps.data() + first);
    });
  });
  settle(block);
  workers.for_each(parts, [&](std::size_t part) {
    of_part(part, [&](std::uint32_t first, std::uint32_t last) { draw(first, last); });
  });
}

void Fleet::Inside::note_gap(Block& block, double& smallest, double seen_m) const {
  smallest = std::min(smallest, seen_m);
  if (seen_m >= 0.0) return;
  for (std::uint32_t i = block.first; i < block.last; ++i)
    if (state.offset_m[i] + state.s_m[state.leader[i]] - state.s_m[i] < numbers.length_m) ++block.collisions;
}

void Fleet::Inside::settle(Block& block) {
  const std::uint8_t* const events = state.event.data();
  // Found first and seen to then: meanwhile what the latter needs is on its way from the memory.
  std::array<std::uint32_t, part_vehicles> found;
  for (std::uint32_t begin = block.first; begin < block.last; begin += part_vehicles) {
    const std::uint32_t end = std::min(block.last, begin + part_vehicles);
    std::size_t count = 0;
    for (std::uint32_t i = begin; i < end;) {
      // Most have nothing to be seen to: eight at a time.
      std::uint64_t eight = 0;
      if (end - i >= 8) {
        std::memcpy(&eight, events + i, 8);
        if (eight == 0) {
          i += 8;
          continue;
        }
      }
      for (const std::uint32_t last = std::min(end, i + 8); i < last; ++i) {
        if (events[i] == 0) continue;
        found[count++] = i;
        __builtin_prefetch(&state.own[i], 1);
        __builtin_prefetch(&state.own[i].priority, 1);
      }
    }
    for (std::size_t k = 0; k < count; ++k) see_to(block, found[k]);
  }
  for (std::uint32_t copy = block.first_copy; copy < block.last_copy; ++copy)
    if (copies[copy].waiting > 0 && copies[copy].due_step <= block.now) serve(block, copy);
}

void Fleet::Inside::draw(std::uint32_t first, std::uint32_t last) {
  const std::size_t count = last - first;
  const auto part = [&](auto& values) { return std::span(values).subspan(first, count); };
  poses.poses(part(state.section), part(state.s_m), part(state.x_m), part(state.y_m), part(state.heading_rad));
  if (!numbers.has_turns) return;
  for (std::uint32_t i = first; i < last; ++i) {
    if ((state.mode[i] & Mode::turning) == 0) continue;
    const double whole_rad = ground.turn_rad(state.section[i], next(way_of(i)));
    state.heading_rad[i] = wrap_angle(state.heading_rad[i] + (whole_rad - state.turn_left_rad[i]));
  }
}

void Fleet::Inside::gather_arrivals() {
  arrivals = 0;
  for (const Block& block : blocks) {
    std::copy_n(arrived.begin() + block.first, block.arrivals, arrived.begin() + static_cast<std::ptrdiff_t>(arrivals));
    arrivals += block.arrivals;
  }
}

}  // namespace cosiva::virtual_side
