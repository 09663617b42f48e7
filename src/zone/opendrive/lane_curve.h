#pragma once

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "cosiva/zone/geometry/fit.h"
#include "cosiva/zone/opendrive/folds.h"
#include "cosiva/zone/opendrive/lateral.h"
#include "cosiva/zone/opendrive/reference_line.h"

namespace cosiva::zone::opendrive {

/// A lane's centre line over one lane section, in the direction in which it is driven.
class LaneCurve {
 public:
  LaneCurve(std::shared_ptr<const ReferenceLine> line, Lateral lateral, double from, double to, bool forward)
      : line_{std::move(line)}, lateral_{std::move(lateral)}, from_{from}, to_{to}, forward_{forward} {}

  [[nodiscard]] Pose2 entry() const { return pose_at(forward_ ? from_ : to_); }
  [[nodiscard]] Pose2 exit() const { return pose_at(forward_ ? to_ : from_); }
  [[nodiscard]] bool forward() const { return forward_; }
  [[nodiscard]] double from() const { return from_; }
  [[nodiscard]] double to() const { return to_; }
  [[nodiscard]] double span() const { return to_ - from_; }  ///< in s
  /// The position at the road's s, and the heading in the direction of travel.
  [[nodiscard]] Pose2 pose_at(double s) const;

  /// Moves its entry (or exit) to `target`, and eases back over at most `reach_m`.
  void move_end(bool entry, const Pose2& target, double reach_m);

  /// Inside a bend that is tighter than the lane's distance from the reference line, the lane would run backwards: such
  /// stretches are replaced by a curve between their ends.
  /// @param work  samples that may still be taken for this; counted down
  /// @return the replaced length, in s
  double cut_folds(std::size_t& work);

  /// For fit(): the parameter runs with the direction of travel, and both coordinates are `scale` times the file's.
  /// Lives no longer than this curve.
  [[nodiscard]] PlaneCurve curve(double scale, const std::vector<double>& more_breaks) const;

 private:
  struct Moved {
    Easing x{};
    Easing y{};
  };
  [[nodiscard]] Point2 derivative(double s, Point2& p) const;

  std::shared_ptr<const ReferenceLine> line_;
  Lateral lateral_;
  double from_;
  double to_;
  bool forward_;
  std::vector<Bridge> bridges_{};
  std::optional<Moved> at_from_{};
  std::optional<Moved> at_to_{};
};

}  // namespace cosiva::zone::opendrive
