#pragma once

#include <optional>
#include <variant>
#include <vector>

#include "cosiva/zone/geometry/section.h"
#include "cosiva/zone/opendrive/cubic_path.h"
#include "cosiva/zone/opendrive/easing.h"
#include "cosiva/zone/opendrive/model.h"
#include "cosiva/zone/opendrive/report.h"

namespace cosiva::zone::opendrive {

/// One geometry record of a road's plan view as a curve, with the corrections that let it meet its neighbours. Lengths
/// are metres of the file.
struct PlanRecord {
  /// A correction of both coordinates.
  struct Eased {
    Easing x;
    Easing y;
  };
  double from;    ///< s
  double factor;  ///< arc length by s: the ratio of the file's two lengths
  double arc;     ///< its length
  std::variant<Section, CubicPath> path;
  double slack{0.0};  ///< of its length against its s: its successor is left out, or the record is redrawn
  std::optional<Eased> at_start{};
  std::optional<Eased> at_end{};
};

/// Shorter records are artefacts of the exporter: their neighbours meet without them. [m]
inline constexpr double record_min_m = 5e-3;

/// A file's record as a curve from s = 0 on, without corrections. Nothing, and a diagnostic with the reason, where its
/// polynomials do not move or lead further than 100 km.
[[nodiscard]] std::optional<PlanRecord> make_record(const Geometry& geometry, Report& report);

/// The record's curve at the road's s, by s, without corrections.
[[nodiscard]] Jet raw(const PlanRecord& record, double s);

/// Whether two records that follow each other can be made to meet.
/// @param left   where the first one ends
/// @param right  where the second one begins
[[nodiscard]] bool can_close(const PlanRecord& before, const Jet& left, const Jet& right, const PlanRecord& after);

/// Leaves out records of a few centimetres that do not meet their neighbours: they are no reason to lose the road.
/// @param plan  the file's record of each of `records`; shrinks with them
void drop_crumbs(std::vector<const Geometry*>& plan, std::vector<PlanRecord>& records, Report& report);

}  // namespace cosiva::zone::opendrive
