#pragma once

#include <cstddef>
#include <vector>

#include "cosiva/base/pose.h"
#include "cosiva/zone/opendrive/lateral.h"
#include "cosiva/zone/opendrive/reference_line.h"

namespace cosiva::zone::opendrive {

/// A lane's point at an offset from the reference line: the point, its derivative by s, and the lane's distance from
/// folding there: 1 on the line, 0 at the centre of the line's bend, negative beyond.
struct LanePoint {
  Point2 p;
  Point2 d;
  double room{1.0};
  double along{1.0};  ///< part of the derivative that leads along the line
  [[nodiscard]] bool folds() const;
};
[[nodiscard]] LanePoint lane_point(const ReferenceLine& line, const Lateral& lateral, double s);

/// A cubic between two positions of the lane, with its derivatives there by u = 0 … 1.
struct Bridge {
  double from{};
  double to{};
  Point2 start{};
  Point2 start_d{};
  Point2 end{};
  Point2 end_d{};

  [[nodiscard]] Point2 at(double s) const;
  [[nodiscard]] Point2 slope_at(double s) const;  ///< by s
  [[nodiscard]] double tightest_m() const;        ///< its least radius
};

/// The bridges over all stretches of [from, to] in which the lane folds, ascending, none overlapping another.
/// @param work  samples that may still be taken; counted down, and nothing is found once it is used up
[[nodiscard]] std::vector<Bridge> bridge_folds(const ReferenceLine& line, const Lateral& lateral, double from,
                                               double to, std::size_t& work);

}  // namespace cosiva::zone::opendrive
