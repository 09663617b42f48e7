#include "cosiva/physical/plant/dems.h"

#include <algorithm>
#include <cmath>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::physical {
namespace {

constexpr double pitch_m = 1e-6 * dems_geometry.pitch_um;
constexpr double half_line_m = 0.5e-6 * dems_geometry.line_um;
/// Each sensor averages the floor over its field, as wide as the pitch.
constexpr double half_field_m = 0.5 * pitch_m;

}  // namespace

Dems::Dems(double line_sd_m, Random random)
    : line_sd_m_{line_sd_m}, random_{random}, unevenness_m_{random_.gaussian(0.0, line_sd_m)} {}

void Dems::read(double offset_m, double distance_m) {
  if (line_sd_m_ > 0.0) {
    constexpr double correlation_m = 0.05;
    const double keep = correlation_m / (correlation_m + distance_m);
    unevenness_m_ = keep * unevenness_m_ + std::sqrt(1.0 - keep * keep) * random_.gaussian(0.0, line_sd_m_);
  }
  const double line_m = offset_m + unevenness_m_;
  for (std::size_t i = 0; i < LT_SENSORS; ++i) {
    const double sensor_m = pitch_m * (static_cast<double>(i) - 0.5 * (LT_SENSORS - 1));
    const double covered = (half_line_m + half_field_m - std::fabs(sensor_m - line_m)) / (2.0 * half_field_m);
    // Not negative, and a call of lround for each sensor costs more than the rest of the row.
    // NOLINTNEXTLINE(bugprone-incorrect-roundings)
    exact_[i] = static_cast<std::uint8_t>(255.0 * std::clamp(covered, 0.0, 1.0) + 0.5);
  }
  overlay_fault();
}

void Dems::read_nothing() {
  exact_.fill(0);
  overlay_fault();
}

void Dems::overlay_fault() {
  COSIVA_EXPECT(stuck_ <= LT_SENSORS);
  readings_ = exact_;
  if (stuck_ < LT_SENSORS) readings_[stuck_] = stuck_reading_;
}

double Dems::lateral_error_m() { return line_sd_m_ > 0.0 ? random_.gaussian(0.0, line_sd_m_) : 0.0; }

double Dems::heading_error_rad() {
  constexpr double sensors_m = 0.1;
  return line_sd_m_ > 0.0 ? random_.gaussian(0.0, line_sd_m_ / sensors_m) : 0.0;
}

void Dems::stick(std::size_t sensor, std::uint8_t reading) {
  COSIVA_EXPECT(sensor <= LT_SENSORS);
  stuck_ = sensor;
  stuck_reading_ = reading;
  overlay_fault();
}

void Dems::archive(Archive& archive) { archive(unevenness_m_, exact_, readings_, stuck_, stuck_reading_); }

}  // namespace cosiva::physical
