#include "cosiva/virtual/fleet/fleet_metrics.h"

#include <algorithm>
#include <limits>

#include "cosiva/base/digest.h"

namespace cosiva::virtual_side {
namespace {

double least_gap_m(const FleetTables& tables) {
  double least_m = far_m;
  for (const Block& block : tables.blocks) least_m = std::min(least_m, block.smallest_gap_m);
  return least_m;
}

}  // namespace

Fleet::CrossingMetrics crossing_metrics(const FleetTables& tables, std::size_t crossing) {
  Fleet::CrossingMetrics metrics;
  std::uint64_t waited = 0;
  for (const Block& block : tables.blocks) {
    metrics.grants += block.grants[crossing];
    waited += block.waited_steps[crossing];
  }
  metrics.waiting = tables.options.step * static_cast<std::int64_t>(waited);
  return metrics;
}

SimDuration occupancy(const FleetTables& tables, zone::SectionId section) {
  std::uint64_t steps = 0;
  for (const Block& block : tables.blocks) steps += block.occupied_steps[section];
  for (std::uint32_t copy = 0; copy + 1 < tables.copies.size(); ++copy)
    for (std::uint32_t i = tables.front[list_index(tables.ground, copy, section)]; i != Fleet::none;
         i = tables.state.own[i].behind)
      steps += tables.step_number - tables.state.own[i].entered_step;
  return tables.options.step * static_cast<std::int64_t>(steps);
}

double smallest_gap_m(const FleetTables& tables) {
  const double least_m = least_gap_m(tables);
  return least_m >= far_m ? std::numeric_limits<double>::infinity() : least_m;
}

std::uint64_t collisions(const FleetTables& tables) {
  std::uint64_t collisions = 0;
  for (const Block& block : tables.blocks) collisions += block.collisions;
  return collisions;
}

std::uint64_t fleet_digest(const FleetTables& tables) {
  Digest digest;
  digest.add(std::uint64_t{tables.step_number});
  for (std::size_t i = 0; i < tables.state.s_m.size(); ++i) {
    for (const auto* values :
         {&tables.state.s_m, &tables.state.v_mps, &tables.state.offset_m, &tables.state.halt_at, &tables.state.line_at,
          &tables.state.goal_at, &tables.state.x_m, &tables.state.y_m, &tables.state.heading_rad})
      digest.add((*values)[i]);
    for (const auto* values : {&tables.state.leader, &tables.state.section, &tables.state.waited_steps})
      digest.add(std::uint64_t{(*values)[i]});
    const Own& own = tables.state.own[i];
    digest.add(own.traversed_m);
    for (const std::uint32_t value : {own.held_chain, own.laps}) digest.add(std::uint64_t{value});
    digest.add(static_cast<std::int64_t>(tables.state.profile[i]));
    digest.add(std::uint64_t{tables.state.mode[i]});
  }
  for (const Copy& copy : tables.copies) {
    for (const Waiting& waiting : std::span(tables.state.queue).subspan(copy.first, copy.waiting)) {
      digest.add(std::uint64_t{waiting.vehicle});
      digest.add(std::uint64_t{waiting.requested_step});
    }
  }
  for (const CrossingState& crossing : tables.crossings) digest.add(std::uint64_t{crossing.holder});
  digest.add(least_gap_m(tables));
  for (std::size_t x = 0; x < tables.ground.zone().crossings.size(); ++x) {
    std::uint64_t grants = 0;
    std::uint64_t waited = 0;
    for (const Block& block : tables.blocks) {
      grants += block.grants[x];
      waited += block.waited_steps[x];
    }
    digest.add(grants);
    digest.add(waited);
  }
  return digest.value();
}

}  // namespace cosiva::virtual_side
