#pragma once

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "cosiva/zone/geometry/fit.h"
#include "cosiva/zone/opendrive/reference_line.h"

namespace cosiva::zone::opendrive {

/// A piecewise cubic over [from, to] of a road's s.
using Pieces = std::vector<Polynomial>;

/// Records that begin this near to each other, or to an end of their lane section, begin together: 5 cm, or a tenth of
/// the section. What is shorter is an exporter's crumb.
[[nodiscard]] double nearness(double from, double to);
/// Those of a file's records that hold between two values of s, the first from there on.
/// @param before  whether what holds before the first record is its first value; else it is 0
[[nodiscard]] Pieces holding(std::vector<Polynomial> records, double from, double to, bool before);
/// a·left + b·right.
[[nodiscard]] Pieces sum(const Pieces& left, double a, const Pieces& right, double b, double near);
[[nodiscard]] const Polynomial& piece_at(const Pieces& pieces, double s);

/// Where a lane's centre line runs beside the reference line: pieces whose jumps and kinks are smoothed.
class Lateral {
 public:
  /// Nothing where it jumps further than can be smoothed.
  [[nodiscard]] static std::optional<Lateral> make(Pieces pieces, double to);

  struct Value {
    double t;      ///< to the left
    double slope;  ///< by s
  };
  [[nodiscard]] Value at(double s) const;
  [[nodiscard]] const std::vector<double>& breaks() const { return breaks_; }
  [[nodiscard]] double greatest_jump() const { return jump_; }
  [[nodiscard]] double greatest_kink() const { return kink_; }

 private:
  Pieces pieces_;
  std::vector<double> ends_;
  std::vector<Easing> at_start_;
  std::vector<Easing> at_end_;
  std::vector<double> breaks_;
  double jump_{};
  double kink_{};
};

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
  /// Where it is at the road's s, and where it heads when driven.
  [[nodiscard]] Pose2 pose_at(double s) const;

  /// Moves its entry (or exit) to `target`, and eases back over at most `reach_m`.
  void move_end(bool entry, const Pose2& target, double reach_m);

  /// Inside a bend that is tighter than the lane's distance from the reference line, the lane would run backwards: such
  /// stretches are cut short by a curve between their ends.
  /// @param work  samples that may still be taken for this; counted down
  /// @return how much of it was replaced, in s
  double cut_folds(std::size_t& work);

  /// For fit(): the parameter runs with the direction of travel, and both coordinates are `scale` times the file's.
  /// Lives no longer than this curve.
  [[nodiscard]] PlaneCurve curve(double scale, const std::vector<double>& more_breaks) const;

 private:
  struct Moved {
    Easing x{};
    Easing y{};
  };
  /// A cubic between two places of the lane, with its derivatives there by u = 0 … 1.
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
  /// Beside the reference line: the point, its derivative by s, and how far the lane is from folding there: 1 on the
  /// line, 0 at the centre of the line's bend, negative beyond.
  struct Beside {
    Point2 p;
    Point2 d;
    double room{1.0};
    double along{1.0};  ///< share of the derivative that leads along the line
    [[nodiscard]] bool folds() const;
  };
  [[nodiscard]] Beside beside(double s) const;
  [[nodiscard]] Bridge bridge(double from, double to) const;
  [[nodiscard]] std::optional<Bridge> bridge_over(double from, double to) const;
  [[nodiscard]] std::vector<std::pair<double, double>> folds(std::size_t& work) const;
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
