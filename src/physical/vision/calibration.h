#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "cosiva/physical/vision/floor_fit.h"
#include "cosiva/physical/vision/height.h"
#include "cosiva/physical/vision/points.h"

/// A camera's calibration: the map to the floor, its uncertainty over the floor, and the correction of height.
namespace cosiva::vision {

/// Size of the errors, over many points.
struct Residuals {
  std::size_t points{};
  double rms_m{};
  double max_m{};
};

/// Residuals of points left out of the fit: the mapped position minus the surveyed one.
struct LeftOut {
  Residuals metrics;
  std::vector<Point2> residuals;  ///< of all points, in their order [m]
};

/// A partition of the points for cross-validation: the group of each point. A group is evaluated by the fit to all
/// others.
using Groups = std::vector<std::size_t>;
/// The two colours of a checkerboard; of points that form no grid, every second one. Measures the fit *between* points.
[[nodiscard]] Groups colours(const std::vector<FloorPoint>& points);
/// Squares of the floor of this size: no point of a square takes part in the fit that evaluates the square. Measures
/// the fit where points are missing. A floor smaller than four squares a side has smaller squares.
[[nodiscard]] Groups blocks(const std::vector<FloorPoint>& points, double side_m);
/// Fails as fit_floor does, where a fit without a group does.
[[nodiscard]] Result<LeftOut> cross_validate(const std::vector<FloorPoint>& points, ImageSize frame,
                                             const FitOptions& options, const Groups& groups);

/// The reference's own uncertainty over the floor: for each square the rms of left-out residuals in it (the worse of
/// both partitions), or of the nearest square that has any.
struct ResidualMap {
  double x0_m{};  ///< of the lower left corner
  double y0_m{};
  double side_m{1.0};
  std::size_t columns{};
  std::size_t rows{};
  std::vector<double> rms_m;        ///< row by row, from below
  std::vector<std::size_t> points;  ///< in each

  /// Outside: of the nearest square.
  [[nodiscard]] double at(Point2 floor) const;
  friend bool operator==(const ResidualMap&, const ResidualMap&) = default;
};
[[nodiscard]] ResidualMap residual_map(const std::vector<FloorPoint>& points,
                                       const std::vector<const LeftOut*>& left_out, double side_m);

/// A camera over a floor, as stored in a calibration file.
struct Calibration {
  std::string name;
  FloorModel model{FloorModel::polynomial};
  FloorMap map;
  /// Of the points it was fitted to, and of those left out.
  Residuals fitted;
  Residuals colour;
  Residuals block;
  ResidualMap uncertainty;
  CameraPose camera;  ///< for objects above the floor
  std::vector<MarkerProfile> markers;
};

/// One of the models tried.
struct Tried {
  FitOptions options;
  Residuals fitted;
  LeftOut colour;
  LeftOut block;
};
struct CalibrationOptions {
  /// Nothing: of all models that have enough points, the one with the best fit to left-out blocks.
  std::vector<FitOptions> models;
  double block_m{0.8};
  double cell_m{0.25};        ///< of the residual map
  double camera_height_m{0};  ///< above the floor; 0: not known, and heights are not corrected
};
struct Calibrated {
  Calibration calibration;
  std::vector<Tried> tried;
  std::size_t chosen{};  ///< of those
};
[[nodiscard]] Result<Calibrated> calibrate(const std::vector<FloorPoint>& points, ImageSize frame,
                                           const CalibrationOptions& options);

}  // namespace cosiva::vision
