#pragma once

#include <cstdint>

namespace cosiva::aiv {

/// What a tag, a beacon or the end of a manoeuvre did to the estimate.
enum class FixKind : std::uint8_t {
  none,       ///< an unknown number, or a beacon without information
  corrected,  ///< the estimate moved a little along the circuit
  relocated,  ///< the estimate was wrong, and jumped
  outlier,    ///< contradicts the estimate, and no other reading supports it
};

struct PositionFix {
  FixKind kind{FixKind::none};
  double correction_m{};  ///< for `corrected`: along the circuit, forwards positive
};

/// What a reading of the odometer did to the estimate.
struct EstimateStep {
  double step_m{};  ///< along the circuit, corrections included
  FixKind kind{FixKind::none};
};

}  // namespace cosiva::aiv
