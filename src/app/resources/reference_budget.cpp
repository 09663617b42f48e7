#include "cosiva/app/resources/reference_budget.h"

#include <cmath>

#include "cosiva/adapters/files.h"
#include "cosiva/app/cli/console.h"
#include "cosiva/base/json_value.h"
#include "cosiva/physical/vision/calibration_json.h"

namespace cosiva::app {
namespace {

using experiments::ReferencePart;

/// Root mean square of the distance between the calibrated floor points and the camera's foot.
double from_foot_m(const vision::Calibration& calibration) {
  const vision::ResidualMap& map = calibration.uncertainty;
  double squares = 0.0;
  double points = 0.0;
  for (std::size_t row = 0; row < map.rows; ++row) {
    for (std::size_t column = 0; column < map.columns; ++column) {
      const auto count = static_cast<double>(map.points[row * map.columns + column]);
      const double x = map.x0_m + (static_cast<double>(column) + 0.5) * map.side_m - calibration.camera.foot.x_m;
      const double y = map.y0_m + (static_cast<double>(row) + 0.5) * map.side_m - calibration.camera.foot.y_m;
      squares += count * (x * x + y * y);
      points += count;
    }
  }
  return points > 0.0 ? std::sqrt(squares / points) : 0.0;
}

ReferencePart height_part(const vision::Calibration& calibration, const CalibrationFiles& local_path) {
  const double camera_m = calibration.camera.height_m;
  double tag_m = 0.0;
  for (const vision::MarkerProfile& marker : calibration.markers) tag_m = std::fmax(tag_m, marker.height_m);
  if (!(camera_m > tag_m)) return {"tag height", std::nullopt, "the camera's height is not known"};
  const double out_m = from_foot_m(calibration);
  const auto error_of = [&](double height_error_m) {
    return experiments::height_uncertainty_m(out_m, height_error_m, tag_m, camera_m);
  };
  const std::string where =
      ", observed " + decimals(out_m, 2) + " m from the foot of a camera " + decimals(camera_m, 2) + " m up";
  if (!local_path.tag_height_error_m)
    return {"tag height", std::nullopt,
            "not given: 1 mm of it would be " + decimals(1e3 * error_of(1e-3), 2) + " mm" + where};
  return {"tag height", error_of(*local_path.tag_height_error_m),
          "--tag-height-error " + decimals(1e3 * *local_path.tag_height_error_m, 2) + " mm" + where};
}

}  // namespace

experiments::ReferenceBudget budget_of(const vision::Calibration& calibration, const std::string& file,
                                       const CalibrationFiles& local_path) {
  experiments::ReferenceBudget budget;
  auto& parts = budget.parts;
  parts.push_back({"floor fit", calibration.block.rms_m,
                   file + ": rms of " + std::to_string(calibration.block.points) +
                       " floor points, each block left out (" + std::string(name_of(calibration.model)) + ")"});
  if (local_path.poses) {
    const std::string many = std::to_string(local_path.poses->left_out.size()) + " surveyed poses";
    parts.push_back({"tag noise", local_path.poses->stopped_m, many + ": spread of a stationary tag's fixes"});
    parts.push_back({"height and mounting", local_path.poses->rms_m, many + ", each left out: rms"});
  } else {
    parts.push_back({"tag noise", std::nullopt, "not given: the spread of the fixes of a stopped vehicle"});
    const bool surveyed = !calibration.markers.empty() && calibration.markers.front().surveyed;
    if (surveyed) {
      parts.push_back({"height and mounting", std::nullopt,
                       "not given: the rms of the surveyed poses is in the calibration's result.json"});
    } else {
      parts.push_back(height_part(calibration, local_path));
      parts.push_back({"mounting", local_path.mount_error_m,
                       local_path.mount_error_m ? "--mount-error" : "not given: the tag's position on its vehicle"});
    }
  }
  parts.push_back({"time stamp", std::nullopt,
                   "not given: gvs track --against gives the clock's offset and its standard error, times the speed"});
  return budget;
}

Result<experiments::ReferenceBudget> load_reference_budget(const std::string& file) {
  const auto text = adapters::read_file(file);
  if (!text) return tl::unexpected(text.error());
  const auto json = JsonValue::parse(*text);
  const std::string format = json && json->object() != nullptr ? json->text("format").value_or("") : "";
  if (!format.starts_with("cosiva.gvs.calibration")) return experiments::read_reference_budget(*text, file);
  const auto calibration = vision::read_calibration(*text, file);
  if (!calibration) return tl::unexpected(calibration.error());
  return budget_of(*calibration, file, {});
}

}  // namespace cosiva::app
