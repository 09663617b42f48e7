#pragma once

#include <cstddef>
#include <vector>

#include "cosiva/base/pose.h"
#include "cosiva/base/result.h"

namespace cosiva::vision {

struct Timed {
  double t_s{};
  Pose2 pose{};
};

/// By how much one clock's stamps are late: what was seen at its stamp t was so at t − offset of the reference's clock.
struct TimeOffset {
  double offset_s{};
  double standard_error_s{};  ///< from blocks of time that are left out, since errors of neighbours are one
  double before_rms_m{};      ///< distance of seen from reference, a constant lever taken out
  double after_rms_m{};       ///< and when the offset were taken out, too
  Point2 lever;               ///< of the seen place in the reference's body frame [m]
  std::size_t pairs{};
};

/// An offset makes an error along the way in proportion to speed; what sits elsewhere on the vehicle, one that is the
/// same at all speeds. Hence both are told apart only where speed changes: a bend turns both alike. For showing:
/// nothing is shifted by it.
/// @param limit_s  no offset is further from 0
/// Fails ("gvs.offset") where fewer than twenty stamps lie within the reference's times (interpolated over gaps of at
/// most half a second), and where speed never changes.
[[nodiscard]] Result<TimeOffset> time_offset(const std::vector<Timed>& detected, const std::vector<Timed>& reference,
                                             double limit_s = 0.5);

}  // namespace cosiva::vision
