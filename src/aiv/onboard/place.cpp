// Where the vehicle stands when its program starts, and what it keeps of that for the next start.
#include <array>
#include <cmath>
#include <utility>

#include "aiv/onboard/inside.h"

namespace cosiva::aiv {
namespace {

/// A memory whose odometer differs by more is not of this drive.
constexpr double memory_way_m_max = 100.0;
/// A body off the line that has rolled further than this is no longer where it was.
constexpr double off_line_way_m_max = 0.005;
/// A section lies where it lay when it was remembered.
constexpr double same_place_m = 0.02;
constexpr double same_heading_rad = 0.05;

}  // namespace

void OnboardCore::Inside::find_place() {
  if (!agent) return;
  const bool of_this_zone = memory && memory->zone == zone->name;
  if (agent->position().pose_known() && !(of_this_zone && !start_counts)) return;
  // Another zone's memory is kept: that zone may be the broker's, and yet to come.
  if (memory && (!pils_session || !agent->position().odometer_um())) return;  // not yet comparable
  if (of_this_zone) {
    const bool stands = stand_as_remembered();
    memory.reset();
    if (stands) return;
  }
  if (agent->position().pose_known() || !options.start || !start_counts) return;
  if (const auto section = zone->circuit.find(options.start->section)) agent->stand_at({*section, options.start->s_m});
}

bool OnboardCore::Inside::stand_as_remembered() {
  if (memory->session != *pils_session) return false;
  const double way_m =
      1e-6 * (static_cast<double>(*agent->position().odometer_um()) - static_cast<double>(memory->odometer_um));
  if (!(std::fabs(way_m) <= memory_way_m_max)) return false;
  // A place that was believed before and has driven on since is no longer where the memory was written.
  if (agent->position().pose_known() && std::fabs(way_m) > off_line_way_m_max) return false;
  if (!memory->off_line) {
    if (const auto place = remembered_place(way_m)) {
      agent->stand_at(*place);
      const auto next = memory->next ? zone->circuit.find(*memory->next) : std::nullopt;
      if (memory->manoeuvre) agent->resume_manoeuvre(*memory->manoeuvre, next);
      return true;
    }
  }
  if (!memory->pose || std::fabs(way_m) > off_line_way_m_max) return false;
  // What PILS says of a manoeuvre now is younger than what was remembered.
  const auto& seen = agent->position().manoeuvred();
  const Pose2 X_OB = seen ? *seen : memory->manoeuvre.value_or(Pose2{});
  agent->stand_off(*memory->pose * X_OB);
  if (memory->manoeuvre) agent->resume_manoeuvre(*memory->manoeuvre, std::nullopt);
  return true;
}

std::optional<zone::Place> OnboardCore::Inside::remembered_place(double way_m) const {
  const auto section = zone->circuit.find(memory->section);
  if (!section || !std::isfinite(memory->s_m)) return std::nullopt;
  const zone::Place place{*section, memory->s_m};
  if (memory->pose) {
    // The same name may be another way by now.
    if (!(memory->s_m >= 0.0 && memory->s_m <= zone->circuit.section(*section).length_m() + same_place_m))
      return std::nullopt;
    const Pose2 X_MP = zone->circuit.pose_at(zone->circuit.advance(place, 0.0));
    if (distance(X_MP, *memory->pose) > same_place_m ||
        std::fabs(wrap_angle(X_MP.heading_rad - memory->pose->heading_rad)) > same_heading_rad)
      return std::nullopt;
  }
  const auto next = memory->next ? zone->circuit.find(*memory->next) : std::nullopt;
  if (!next) return zone->circuit.advance(place, way_m);
  return zone->circuit.advance(place, way_m, std::array{*next});
}

void OnboardCore::Inside::remember_place(bool due, wire::Effects& effects) {
  if (!agent || !agent->position().pose_known() || !pils_session) return;
  const PositionEstimator& position = agent->position();
  const auto odometer_um = position.odometer_um();
  if (!odometer_um) return;
  if (odometer_um == remembered_um && position.manoeuvred() == remembered_manoeuvre && !must_remember) return;
  const bool stopped = agent->standing();
  if (!due && !(stopped && !was_standing) && !must_remember) return;
  Memory now_here;
  now_here.zone = zone->name;
  now_here.odometer_um = *odometer_um;
  now_here.session = *pils_session;
  now_here.paused = agent->holds(Hold::paused);
  now_here.imposed = agent->imposed();
  now_here.off_line = position.away() || position.beside();
  now_here.manoeuvre = position.manoeuvred();
  now_here.pose = position.left_line_at() ? *position.left_line_at() : position.pose();
  if (position.known()) {
    const zone::Place place = position.place();
    now_here.section = zone->circuit.part(place.section).name;
    now_here.s_m = place.s_m;
  }
  if (const auto coming = position.course().coming(); !coming.empty())
    now_here.next = zone->circuit.part(coming.front()).name;
  if (options.as_values)
    kept = std::move(now_here);
  else
    effects.emplace_back(wire::Remember{to_json(now_here)});
  remembered_um = odometer_um;
  remembered_manoeuvre = position.manoeuvred();
  must_remember = false;
}

}  // namespace cosiva::aiv
