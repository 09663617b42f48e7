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

/// The delay of one clock's stamps: a detection with stamp t was made at t − offset of the reference's clock.
struct TimeOffset {
  double offset_s{};
  double standard_error_s{};  ///< from blocks of time that are left out, since errors of neighbours are correlated
  double before_rms_m{};      ///< distance of the detections from the reference, with a constant lever removed
  double after_rms_m{};       ///< and with the offset removed, too
  Point2 lever;               ///< of the detected position in the reference's body frame [m]
  std::size_t pairs{};
};

/// An offset causes an error along the path in proportion to speed; a lever on the vehicle, one that is the same at all
/// speeds. Hence both can be distinguished only where speed changes: a bend turns both alike. For display: nothing is
/// shifted by it.
/// @param limit_s  no offset is further from 0
/// Fails ("gvs.offset") where fewer than twenty stamps lie within the reference's times (interpolated over gaps of at
/// most half a second), and where speed never changes.
[[nodiscard]] Result<TimeOffset> time_offset(const std::vector<Timed>& detected, const std::vector<Timed>& reference,
                                             double limit_s = 0.5);

}  // namespace cosiva::vision
