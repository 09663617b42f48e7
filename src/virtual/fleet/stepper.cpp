#include "cosiva/virtual/fleet/stepper.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {
namespace {

/// Number of vehicles of one large copy that a worker takes at a time.
constexpr std::uint32_t part_vehicles = 2048;

}  // namespace

Stepper::Stepper(FleetTables& tables, CrossingGrants& grants, SectionChanges& changes, PoseWriter& poses,
                 std::optional<FleetRules> rules, std::size_t vehicles)
    : numbers_{tables.numbers},
      state_{tables.state},
      copies_{tables.copies},
      blocks_{tables.blocks},
      arrived_{tables.arrived},
      arrivals_{tables.arrivals},
      step_number_{tables.step_number},
      commanded_vehicles_{tables.commanded_vehicles},
      grants_{grants},
      changes_{changes},
      poses_{poses},
      rules_{std::move(rules)},
      part_gap_m_(vehicles / part_vehicles + 1, far_m) {}

void Stepper::step(Workers& workers, std::uint32_t steps) {
  const bool in_parts = blocks_.size() == 1 && blocks_.front().last > 2 * part_vehicles;
  const auto all = [&](Block& block) {
    block.arrivals = 0;
    for (block.now = step_number_; block.now < step_number_ + steps; ++block.now) {
      if (in_parts)
        step_in_parts(workers, block);
      else
        step_block(block);
    }
    std::sort(arrived_.begin() + block.first, arrived_.begin() + block.first + block.arrivals);
  };
  if (in_parts)
    all(blocks_.front());
  else
    workers.for_each(blocks_.size(), [&](std::size_t b) { all(blocks_[b]); });
  step_number_ += steps;
  for (const Block& block : blocks_) COSIVA_EXPECT(block.now == step_number_);
  gather_arrivals();
}

void Stepper::step_block(Block& block) {
  const FleetRules* const by = rules_ ? &*rules_ : nullptr;
  const bool more = commanded_vehicles_ > 0;
  alignas(64) std::array<double, forgets_vehicles> forgotten;
  double* const next =
      block.last - block.first > forgets_vehicles ? state_.next_mps.data() + block.first : forgotten.data();
  record_gap(block, decide(state_, numbers_, by, more, block.first, block.last, next));
  move(state_, numbers_, block.first, block.last, next);
  warm_up(block);
  poses_.write(block.first, block.last);
}

void Stepper::step_in_parts(Workers& workers, Block& block) {
  const FleetRules* const by = rules_ ? &*rules_ : nullptr;
  const bool more = commanded_vehicles_ > 0;
  const std::size_t parts = (block.last + part_vehicles - 1) / part_vehicles;
  const auto of_part = [&](std::size_t part, auto work) {
    const auto first = static_cast<std::uint32_t>(part * part_vehicles);
    work(first, std::min(block.last, first + part_vehicles));
  };
  workers.for_each(parts, [&](std::size_t part) {
    of_part(part, [&](std::uint32_t first, std::uint32_t last) {
      part_gap_m_[part] = decide(state_, numbers_, by, more, first, last, state_.next_mps.data() + first);
    });
  });
  record_gap(block, *std::min_element(part_gap_m_.begin(), part_gap_m_.end()));
  workers.for_each(parts, [&](std::size_t part) {
    of_part(part, [&](std::uint32_t first, std::uint32_t last) {
      move(state_, numbers_, first, last, state_.next_mps.data() + first);
    });
  });
  warm_up(block);
  workers.for_each(parts, [&](std::size_t part) {
    of_part(part, [&](std::uint32_t first, std::uint32_t last) { poses_.write(first, last); });
  });
}

void Stepper::record_gap(Block& block, double detected_m) const {
  block.smallest_gap_m = std::min(block.smallest_gap_m, detected_m);
  if (detected_m >= 0.0) return;
  for (std::uint32_t i = block.first; i < block.last; ++i)
    if (state_.offset_m[i] + state_.s_m[state_.leader[i]] - state_.s_m[i] < numbers_.length_m) ++block.collisions;
}

void Stepper::warm_up(Block& block) {
  const std::uint8_t* const events = state_.event.data();
  // First found, then handled: meanwhile the data for the handling is fetched from memory.
  std::array<std::uint32_t, part_vehicles> found;
  for (std::uint32_t begin = block.first; begin < block.last; begin += part_vehicles) {
    const std::uint32_t end = std::min(block.last, begin + part_vehicles);
    std::size_t count = 0;
    for (std::uint32_t i = begin; i < end;) {
      // Most vehicles have no event: check eight at a time.
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
        __builtin_prefetch(&state_.own[i], 1);
        __builtin_prefetch(&state_.own[i].priority, 1);
      }
    }
    for (std::size_t k = 0; k < count; ++k) changes_.handle_events(block, found[k]);
  }
  for (std::uint32_t copy = block.first_copy; copy < block.last_copy; ++copy)
    if (copies_[copy].waiting > 0 && copies_[copy].due_step <= block.now) grants_.grant_due(block, copy);
}

void Stepper::gather_arrivals() {
  arrivals_ = 0;
  for (const Block& block : blocks_) {
    std::copy_n(arrived_.begin() + block.first, block.arrivals,
                arrived_.begin() + static_cast<std::ptrdiff_t>(arrivals_));
    arrivals_ += block.arrivals;
  }
}

}  // namespace cosiva::virtual_side
