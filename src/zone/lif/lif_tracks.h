#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "cosiva/base/pose.h"
#include "cosiva/zone/geometry/fit.h"
#include "cosiva/zone/geometry/section.h"
#include "cosiva/zone/lif/lif_diagnostics.h"
#include "cosiva/zone/lif/lif_document.h"

namespace cosiva::zone::lif {

/// The path of an edge: sections end to end, from its one node to its other.
struct Track {
  std::vector<Section> sections;
  std::vector<bool> corner;  ///< by section: vehicles turn on the spot at its end, before the edge's next section
};

/// Makes paths of edges, within a tolerance, with diagnostics.
class TrackMaker {
 public:
  TrackMaker(FitTolerance tolerance, LifDiagnostics& diagnostics) : tolerance_{tolerance}, diagnostics_{diagnostics} {}

  /// A straight line, or the trajectory: moved, turned and stretched where it does not meet the nodes, a straight line
  /// where that is not possible. No sections where the nodes are one point and the trajectory is not a loop.
  [[nodiscard]] Track make(const Edge& edge, Point2 from, Point2 to);
  /// One section along sections that lie end to end, within the tolerance; nothing where there is none.
  [[nodiscard]] std::optional<Section> as_one(const std::vector<Section>& sections) const;
  /// Reports the results of all fits.
  void record_worst();

 private:
  [[nodiscard]] bool meet(Nurbs& curve, const Edge& edge, Point2 from, Point2 to);
  [[nodiscard]] bool follow(const Nurbs& curve, const Edge& edge, Track& track);
  [[nodiscard]] bool follow_span(const Nurbs& curve, double from, double to, Track& track, std::string& why);

  FitTolerance tolerance_;
  LifDiagnostics& diagnostics_;
  double work_left_{2e9};  ///< additions and multiplications that all curves of a file may take
  std::size_t fitted_{0};
  double worst_position_m_{0.0};
  double worst_heading_rad_{0.0};
};

}  // namespace cosiva::zone::lif
