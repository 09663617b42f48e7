#pragma once

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "cosiva/base/random.h"
#include "cosiva/base/test_paths.h"
#include "cosiva/physical/vision/calibration.h"
#include "cosiva/physical/vision/scene.h"

/// Fixture of the vision system's tests.
namespace cosiva::vision {

inline constexpr double degree_rad = pi / 180.0;
inline constexpr ImageSize cpm_image{2048, 2048};

inline std::string test_file(const std::string& name) {
  std::ifstream file{source_dir() + "/src/physical/vision/testdata/" + name, std::ios::binary};
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

inline const std::vector<FloorPoint>& cpm_points() {
  static const std::vector<FloorPoint> points =
      read_points(test_file("cpm-ips/calibration_points.csv"), "calibration_points.csv").value();
  return points;
}

inline PoseGrid cpm_grid() {
  PoseGrid grid{{0.6, 3.9}, {0.6, 3.4}, {}};
  for (int i = 0; i < 8; ++i) grid.headings_rad.push_back(45.0 * degree_rad * i);
  return grid;
}

/// Floor corners as a scene's camera shows them, measured with a little noise.
inline std::vector<FloorPoint> detected_corners(const SceneCamera& camera, double noise_px = 0.05) {
  std::vector<FloorPoint> points;
  Random random{7, "corners"};
  for (int i = -15; i <= 15; ++i) {
    for (int j = -15; j <= 15; ++j) {
      const Point2 floor{0.1 * i, 0.1 * j};
      const auto pixel = camera.pixel_of(floor, 0.0);
      if (!pixel || pixel->u < 5.0 || pixel->v < 5.0 || pixel->u > static_cast<double>(camera.frame.width) - 5.0 ||
          pixel->v > static_cast<double>(camera.frame.height) - 5.0)
        continue;
      points.push_back({floor, {random.gaussian(pixel->u, noise_px), random.gaussian(pixel->v, noise_px)}});
    }
  }
  return points;
}

}  // namespace cosiva::vision
