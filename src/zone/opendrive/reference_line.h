#pragma once

#include <optional>
#include <variant>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/zone/geometry/section.h"
#include "cosiva/zone/opendrive/easing.h"
#include "cosiva/zone/opendrive/model.h"
#include "cosiva/zone/opendrive/report.h"

namespace cosiva::zone::opendrive {

/// A point of a curve with its first and second derivative by the road's s.
struct Jet {
  Point2 p;
  Point2 d;
  Point2 dd;
};

/// Cubics by their arc length.
class CubicPath {
 public:
  /// Fails (nothing) where its derivative vanishes everywhere or is not finite.
  [[nodiscard]] static std::optional<CubicPath> make(const Pose2& start, const Cubics& cubics, double length);

  [[nodiscard]] double length() const { return arc_.back(); }
  [[nodiscard]] Jet at(double arc) const;  ///< derivatives by arc length

 private:
  [[nodiscard]] double speed(double p) const;
  [[nodiscard]] double arc_between(double from, double to) const;

  Pose2 start_;
  Cubics cubics_;
  double cell_{};            ///< width of a cell of p
  std::vector<double> arc_;  ///< at each cell's edge
};

/// A road's plan view as one curve over s: what its records leave open at their joints is closed.
class ReferenceLine {
 public:
  /// Nothing, and a note why, where the road has no such line: no records, a gap or a corner too great to close.
  [[nodiscard]] static std::optional<ReferenceLine> make(const Road& road, Report& report);

  [[nodiscard]] double from() const { return records_.front().from; }  ///< s of its start
  [[nodiscard]] double length() const { return ends_.back(); }         ///< s of its end
  [[nodiscard]] Jet at(double s) const;
  /// Where its shape changes, ascending, between its ends.
  [[nodiscard]] const std::vector<double>& breaks() const { return breaks_; }

 private:
  struct Eased {
    Easing x;
    Easing y;
  };
  struct Record {
    double from;    ///< s
    double factor;  ///< arc length by s: how far the file's two lengths disagree
    double arc;     ///< its length
    std::variant<Section, CubicPath> path;
    double slack{0.0};  ///< of its length against its s: what stood behind it is left out, or it is redrawn
    std::optional<Eased> at_start{};
    std::optional<Eased> at_end{};
  };
  [[nodiscard]] static std::optional<Record> make_record(const Geometry& geometry, Report& report);
  /// Whether two records that follow each other can be made to meet.
  [[nodiscard]] static bool can_close(const Record& before, const Jet& left, const Jet& right, const Record& after);
  static void drop_crumbs(std::vector<const Geometry*>& plan, std::vector<Record>& records, Report& report);
  static void redraw_sloppy(const std::vector<const Geometry*>& plan, std::vector<Record>& records, Report& report);
  void lay(const Road& road, const std::vector<const Geometry*>& plan, std::vector<Record> records, Report& report);
  [[nodiscard]] static bool goes_on_too_long(const Record& record, const Geometry& geometry, const Pose2* next);
  [[nodiscard]] static Jet raw(const Record& record, double s);
  [[nodiscard]] bool close_joint(std::size_t index, const std::string& place, Report& report);
  [[nodiscard]] Jet at(const Record& record, double s) const;

  std::vector<Record> records_;
  std::vector<double> ends_;  ///< s where each record ends
  std::vector<double> breaks_;
};

/// What joints may leave open, of records and of lanes: more is not bent to meet. Roads drawn as polygons have corners
/// of a right angle; lanes that are linked go on nearly straight.
inline constexpr double gap_max_m = 2.0;
inline constexpr double corner_max_rad = 1.6;
inline constexpr double kink_max_rad = 0.8;

}  // namespace cosiva::zone::opendrive
