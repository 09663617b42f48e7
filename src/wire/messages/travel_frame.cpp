#include "cosiva/wire/messages/travel_frame.h"

#include <algorithm>
#include <cstdlib>
#include <limits>

namespace cosiva::wire {
namespace {

constexpr std::int16_t half_turn_crad = 314;

/// The lowest value has no opposite of its own type.
std::int16_t opposite(std::int16_t value) {
  return static_cast<std::int16_t>(
      -std::max(value, static_cast<std::int16_t>(-std::numeric_limits<std::int16_t>::max())));
}

int centre_crad(const Ranges& ranges) {
  const int beams = static_cast<int>(ranges.range_mm.size());
  return ranges.first_bearing_crad + std::max(0, beams - 1) * ranges.beam_width_crad / 2;
}

}  // namespace

bool points_forwards(const Ranges& ranges) { return std::abs(centre_crad(ranges)) <= half_turn_crad / 2; }

Manoeuvre turned_round(const Manoeuvre& manoeuvre) {
  return {opposite(manoeuvre.x_mm), opposite(manoeuvre.y_mm), manoeuvre.turned_mrad};
}

Odometry turned_round(const Odometry& odometry) {
  Odometry turned = odometry;
  turned.distance_um = -std::max(odometry.distance_um, -std::numeric_limits<std::int64_t>::max());
  turned.speed_mmps = opposite(odometry.speed_mmps);
  turned.line_offset_01mm = opposite(odometry.line_offset_01mm);
  if (odometry.manoeuvre) turned.manoeuvre = turned_round(*odometry.manoeuvre);
  return turned;
}

Drive turned_round(const Drive& drive) {
  Drive turned = drive;
  turned.speed_mmps = opposite(drive.speed_mmps);
  if (drive.goal) turned.goal = turned_round(*drive.goal);
  return turned;
}

Ranges turned_round(const Ranges& ranges) {
  Ranges turned = ranges;
  // A fan from beam to beam has increasing bearings; its centre beam stays within one turn.
  const int turn_crad = centre_crad(ranges) > 0 ? -half_turn_crad : half_turn_crad;
  turned.first_bearing_crad = static_cast<std::int16_t>(std::clamp<int>(ranges.first_bearing_crad + turn_crad,
                                                                        std::numeric_limits<std::int16_t>::min(),
                                                                        std::numeric_limits<std::int16_t>::max()));
  return turned;
}

}  // namespace cosiva::wire
