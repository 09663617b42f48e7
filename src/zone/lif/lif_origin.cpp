#include "cosiva/zone/lif/lif_origin.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace cosiva::zone::lif {
namespace {

/// Beyond this a file's origin is moved: positions are sent as numbers that keep a millimetre up to here.
constexpr double coordinate_max_m = 1e5;

}  // namespace

void move_origin(Document& document, LifDiagnostics& diagnostics) {
  if (document.nodes.empty()) return;
  Point2 low = document.nodes.front().at;
  Point2 high = low;
  for (const Node& node : document.nodes) {
    low = {std::min(low.x_m, node.at.x_m), std::min(low.y_m, node.at.y_m)};
    high = {std::max(high.x_m, node.at.x_m), std::max(high.y_m, node.at.y_m)};
  }
  const auto far = [](Point2 p) { return std::max(std::fabs(p.x_m), std::fabs(p.y_m)) > coordinate_max_m; };
  if (!far(low) && !far(high)) return;
  // Whole kilometres, so that coordinates remain easy to compare.
  const auto kilometres = [](double a, double b) { return 1000.0 * std::round(0.5 * (a + b) / 1000.0); };
  const Point2 origin{kilometres(low.x_m, high.x_m), kilometres(low.y_m, high.y_m)};
  for (Node& node : document.nodes) node.at = {node.at.x_m - origin.x_m, node.at.y_m - origin.y_m};
  for (Edge& edge : document.edges) {
    if (!edge.trajectory) continue;
    for (Point2& point : edge.trajectory->points) point = {point.x_m - origin.x_m, point.y_m - origin.y_m};
  }
  const auto whole = [](double value) { return std::to_string(static_cast<long long>(value)); };
  diagnostics.add(Diagnostic::Kind::mended, "layouts",
                  "coordinates beyond 100 km: the zone's origin is the file's (" + whole(origin.x_m) + " m, " +
                      whole(origin.y_m) + " m)");
}

}  // namespace cosiva::zone::lif
