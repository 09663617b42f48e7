#include "cosiva/zone/layout/rounding.h"

#include <charconv>
#include <cmath>

namespace cosiva::zone {

double rounded_m(double value_m) { return std::nearbyint(value_m * 1e4) / 1e4; }

double rounded_deg(double angle_rad) { return rounded_m(angle_rad / rad_per_deg); }
double rounded_rad(double angle_rad) { return rounded_deg(angle_rad) * rad_per_deg; }

TrackPosition position_as_written(const Circuit& circuit, TrackPosition position) {
  const double length_m = circuit.section(position.section).length_m();
  position.s_m = rounded_m(position.s_m);
  // Rounding must not move the position off the section's end.
  if (position.s_m > length_m) position.s_m = std::floor(length_m * 1e4) / 1e4;
  return position;
}

std::string metres_text(double value_m) {
  char buffer[48];
  std::string text{buffer,
                   std::to_chars(buffer, buffer + sizeof buffer, rounded_m(value_m), std::chars_format::fixed, 4).ptr};
  for (int i = 0; i < 2 && text.back() == '0'; ++i) text.pop_back();
  return text;
}

}  // namespace cosiva::zone
