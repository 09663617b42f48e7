#pragma once

#include "cosiva/zone/geometry/section_kinds.h"

namespace example {

/// A kind of section for zone files: a sine wave whose crests are `amplitude_m` from its axis, of `waves` waves that
/// are `wavelength_m` long. The section begins where the wave crosses its axis to the left, and heads along the curve.
[[nodiscard]] cosiva::zone::ShapedKind sine_section();

}  // namespace example
