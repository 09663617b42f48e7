#include "cosiva/experiments/positioning/metrology/alignment.h"

#include <cmath>

#include "cosiva/base/math.h"

namespace cosiva::experiments {
namespace {

Point2 centre_of(const std::vector<Point2>& points) {
  Point2 sum;
  for (const Point2 p : points) sum = {sum.x_m + p.x_m, sum.y_m + p.y_m};
  const auto n = static_cast<double>(points.size());
  return {sum.x_m / n, sum.y_m / n};
}

}  // namespace

std::string_view to_string(Alignment alignment) {
  switch (alignment) {
    case Alignment::none: return "none";
    case Alignment::se2: return "se2";
    case Alignment::se3: return "se3";
    case Alignment::origin: return "origin";
  }
  return "";
}

std::string_view text_of(Alignment alignment) {
  switch (alignment) {
    case Alignment::none: return "not aligned";
    case Alignment::se2: return "turned about the vertical and shifted onto the ground truth (least squares, no scale)";
    case Alignment::se3: return "turned and shifted onto the ground truth (Umeyama's least squares, no scale)";
    case Alignment::origin: return "moved with the first pose onto that of the ground truth";
  }
  return "";
}

Result<Pose2> rigid_alignment(const std::vector<Point2>& ground_truth, const std::vector<Point2>& estimate) {
  const auto cannot = [] {
    return fail("align.turn", "the positions are too close together to determine the rotation");
  };
  if (ground_truth.size() < 2) return cannot();
  const Point2 of_ground_truth = centre_of(ground_truth);
  const Point2 of_estimate = centre_of(estimate);
  double dot = 0.0;
  double cross = 0.0;
  double ground_truth_spread = 0.0;
  double estimate_spread = 0.0;
  for (std::size_t i = 0; i < ground_truth.size(); ++i) {
    const Point2 t{ground_truth[i].x_m - of_ground_truth.x_m, ground_truth[i].y_m - of_ground_truth.y_m};
    const Point2 e{estimate[i].x_m - of_estimate.x_m, estimate[i].y_m - of_estimate.y_m};
    dot += e.x_m * t.x_m + e.y_m * t.y_m;
    cross += e.x_m * t.y_m - e.y_m * t.x_m;
    ground_truth_spread += t.x_m * t.x_m + t.y_m * t.y_m;
    estimate_spread += e.x_m * e.x_m + e.y_m * e.y_m;
  }
  if (!(norm(dot, cross) > 1e-9 * std::sqrt(ground_truth_spread * estimate_spread))) return cannot();
  const Pose2 turned{0.0, 0.0, det_atan2(cross, dot)};
  const Point2 put = turned * of_estimate;
  return Pose2{of_ground_truth.x_m - put.x_m, of_ground_truth.y_m - put.y_m, turned.heading_rad};
}

}  // namespace cosiva::experiments
