#include "cosiva/virtual/simulator/follow.h"

namespace cosiva::virtual_side {
namespace {

/// Maximum distance between two reports; if a course visits a section repeatedly, its next and its last visit are
/// further away than this.
constexpr double between_reports_m = 3.0;

}  // namespace

bool follow(zone::Course& course, const zone::Circuit& circuit, zone::SectionId section) {
  if (course.empty()) return false;
  double skipped_m = 0.0;
  std::size_t within = 0;
  for (const zone::SectionId next : course.remaining()) {
    if (skipped_m > between_reports_m) break;
    ++within;
    skipped_m += circuit.section(next).length_m();
  }
  skipped_m = 0.0;
  std::size_t back = 0;
  for (auto traversed = course.traversed(); !traversed.empty() && skipped_m <= between_reports_m;
       traversed = traversed.first(traversed.size() - 1)) {
    ++back;
    skipped_m += circuit.section(traversed.back()).length_m();
  }
  constexpr std::size_t kept = 8;
  constexpr std::size_t far_ahead = 64;
  const bool on = course.arrive(section, within, back) || course.arrive(section, far_ahead, back);
  if (on) course.forget_traversed(kept);
  return on;
}

}  // namespace cosiva::virtual_side
