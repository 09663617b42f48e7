#pragma once

#include <string>

#include "cosiva/base/math.h"
#include "cosiva/zone/circuit/circuit.h"

/// Numbers as zone files and edits write them.
namespace cosiva::zone {

inline constexpr double rad_per_deg = pi / 180.0;

/// A length rounded to 0.1 mm, the resolution of edits: finer than a tag can be positioned.
[[nodiscard]] double rounded_m(double value_m);
/// The position with its s rounded, but still on the section.
[[nodiscard]] TrackPosition position_as_written(const Circuit& circuit, TrackPosition position);
/// "1.4137", "0.20": the rounded length, with at least two decimals.
[[nodiscard]] std::string metres_text(double value_m);

/// An angle as edits write it: degrees with four decimals, and the radians that a reader computes from them.
[[nodiscard]] double rounded_deg(double angle_rad);
[[nodiscard]] double rounded_rad(double angle_rad);

}  // namespace cosiva::zone
