#include "cosiva/physical/plant/marking.h"

#include <algorithm>

#include "cosiva/aiv/motion/manoeuvre.h"
#include "cosiva/base/expect.h"

namespace cosiva::physical {
namespace {

/// A curve that is continued by pieces of linear curvature.
struct Course {
  double left_m{0.0};
  double slope{0.0};
  void add(double length_m, double curvature_begin, double curvature_end) {
    left_m += length_m * (slope + length_m * (2.0 * curvature_begin + curvature_end) / 6.0);
    slope += 0.5 * length_m * (curvature_begin + curvature_end);
  }
};

zone::SectionId smooth_before(const zone::Circuit& circuit, zone::SectionId section, zone::SectionId previous) {
  if (previous != zone::no_section) return previous;
  for (const zone::SectionId id : circuit.previous(section))
    if (circuit.turn_at(id, section) == 0.0) return id;
  return zone::no_section;
}

}  // namespace

double marking_before_m(const zone::Circuit& circuit, zone::TrackPosition from, double distance_m, std::size_t branch) {
  COSIVA_EXPECT(distance_m >= 0.0);
  Course course;
  for (;;) {
    const zone::Section& section = circuit.section(from.section);
    const double part_m = std::min(distance_m, std::max(0.0, section.length_m() - from.s_m));
    course.add(part_m, section.curvature_at(from.s_m), section.curvature_at(from.s_m + part_m));
    distance_m -= part_m;
    if (distance_m <= 0.0) return course.left_m;
    const aiv::Onward onward = aiv::onward(circuit, from.section, branch);
    if (onward.section == zone::no_section || onward.turn_rad != 0.0) break;
    from = {onward.section, 0.0};
  }
  course.add(distance_m, 0.0, 0.0);
  return course.left_m;
}

double marking_behind_m(const zone::Circuit& circuit, zone::TrackPosition from, double behind_m,
                        zone::SectionId previous) {
  COSIVA_EXPECT(behind_m >= 0.0);
  // Driven backwards, a left bend still lies to the left of the tangent: the same sum.
  Course course;
  for (;;) {
    const zone::Section& section = circuit.section(from.section);
    const double part_m = std::min(behind_m, std::max(0.0, from.s_m));
    course.add(part_m, section.curvature_at(from.s_m), section.curvature_at(from.s_m - part_m));
    behind_m -= part_m;
    if (behind_m <= 0.0) return course.left_m;
    const zone::SectionId before = smooth_before(circuit, from.section, previous);
    if (before == zone::no_section) break;
    previous = zone::no_section;
    from = {before, circuit.section(before).length_m()};
  }
  course.add(behind_m, 0.0, 0.0);
  return course.left_m;
}

}  // namespace cosiva::physical
