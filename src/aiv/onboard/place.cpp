// Where the vehicle stands when its program starts, and what it keeps of that for the next start.
#include <cmath>

#include "aiv/onboard/inside.h"

namespace cosiva::aiv {
namespace {

/// A memory whose odometer differs by more is not of this drive.
constexpr double memory_way_m_max = 100.0;

}  // namespace

void OnboardCore::Inside::find_place() {
  if (!agent || agent->position().known()) return;
  if (memory && memory->zone == zone->name) {
    if (!pils_session || !agent->position().odometer_um()) return;  // not yet comparable
    if (const auto place = remembered_place()) {
      agent->stand_at(*place);
      return;
    }
  }
  memory.reset();
  if (!options.start) return;
  if (const auto section = zone->circuit.find(options.start->section)) agent->stand_at({*section, options.start->s_m});
}

std::optional<zone::Place> OnboardCore::Inside::remembered_place() const {
  const auto section = zone->circuit.find(memory->section);
  if (!section || memory->session != *pils_session) return std::nullopt;
  const double way_m =
      1e-6 * (static_cast<double>(*agent->position().odometer_um()) - static_cast<double>(memory->odometer_um));
  if (!(std::fabs(way_m) <= memory_way_m_max) || !std::isfinite(memory->s_m)) return std::nullopt;
  return zone->circuit.advance({*section, memory->s_m}, way_m);
}

void OnboardCore::Inside::remember_place(bool due, wire::Effects& effects) {
  if (!agent || !agent->position().known() || !pils_session) return;
  const auto odometer_um = agent->position().odometer_um();
  if (!odometer_um) return;
  if (odometer_um == remembered_um && !must_remember) return;
  const bool stopped = agent->standing();
  if (!due && !(stopped && !was_standing) && !must_remember) return;
  const zone::Place place = agent->position().place();
  effects.emplace_back(
      wire::Remember{to_json(Memory{zone->name, zone->circuit.part(place.section).name, place.s_m, *odometer_um,
                                    *pils_session, agent->holds(Hold::paused), agent->imposed()})});
  remembered_um = odometer_um;
  must_remember = false;
}

}  // namespace cosiva::aiv
