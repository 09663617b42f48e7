#include "cosiva/physical/vision/calibration.h"

#include <cmath>

#include "cosiva/physical/vision/board.h"
#include "cosiva/physical/vision/calibration_json.h"
#include "cosiva/physical/vision/floor_fit.h"
#include "cosiva/physical/vision/image.h"
#include "target.h"

/// Every input of the vision system: points, poses, boards, calibration files, images.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cosiva;
  using namespace cosiva::vision;
  const auto text = fuzz::as_text(data, size);
  const auto points = read_points(text, "fuzz");
  if (!points) {
    COSIVA_EXPECT(points.error().code == "gvs.points" && points.error().location.starts_with("fuzz"));
  } else {
    COSIVA_EXPECT(read_points(write_points(*points), "again") == points);
    // Valid points may not fit a floor, and are then refused with a code.
    const auto map = fit_floor(*points, {2048, 2048}, {FloorModel::homography, 5});
    if (!map) COSIVA_EXPECT(map.error().code == "gvs.points" || map.error().code == "gvs.fit");
    if (map)
      for (const FloorPoint& point : *points) COSIVA_EXPECT(map->floor_at(point.pixel).has_value());
  }
  const auto calibration = read_calibration(text, "fuzz");
  if (!calibration) {
    COSIVA_EXPECT(calibration.error().code == "gvs.calibration" && calibration.error().location.starts_with("fuzz"));
  } else {
    COSIVA_EXPECT(to_json(*read_calibration(to_json(*calibration), "again")) == to_json(*calibration));
    for (const PixelPoint pixel : {PixelPoint{0.0, 0.0}, PixelPoint{1000.0, 700.0}}) {
      const auto floor = calibration->map.floor_at(pixel);
      if (!floor) continue;
      COSIVA_EXPECT(std::isfinite(floor->x_m) && std::isfinite(floor->y_m));
      COSIVA_EXPECT(calibration->uncertainty.at(*floor) >= 0.0);
      if (const auto back = calibration->map.pixel_at(*floor)) COSIVA_EXPECT(std::isfinite(back->u));
    }
  }
  const auto board = read_board(text, "fuzz");
  if (board) COSIVA_EXPECT(read_board(write_board(*board), "again")->size() == board->size());
  const auto poses = read_poses(text, "fuzz");
  if (poses) (void)fit_poses(*poses, true);
  const auto is_stopped = read_pose_stops(text, "fuzz", {{0.0}, {0.0}, {0.0}});
  if (!is_stopped) COSIVA_EXPECT(is_stopped.error().code == "gvs.poses");
  const auto image = read_netpbm(text, "fuzz");
  if (image) COSIVA_EXPECT(read_netpbm(write_pgm(*image), "again") == image);
  return 0;
}
