#include "cosiva/app/gvs/gvs_calibrate_command.h"

#include <algorithm>
#include <map>
#include <utility>

#include "cosiva/adapters/files.h"
#include "cosiva/app/cli/console.h"
#include "cosiva/app/gvs/images.h"
#include "cosiva/app/resources/reference_budget.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/base/text.h"
#include "cosiva/experiments/reporting/report.h"
#include "cosiva/physical/vision/board.h"
#include "cosiva/physical/vision/calibration.h"
#include "cosiva/physical/vision/calibration_json.h"
#include "cosiva/physical/vision/floor_fit.h"
#include "cosiva/physical/vision/residual_svg.h"

namespace cosiva::app {
namespace {

constexpr double degree_rad = pi / 180.0;

struct Material {
  std::vector<vision::FloorPoint> points;
  vision::ImageSize frame;
};

Result<vision::ImageSize> size_of(const std::string& text) {
  const std::size_t cross = text.find('x');
  const auto width = number_of<std::size_t>(std::string_view{text}.substr(0, cross));
  const auto height =
      cross == std::string::npos ? std::nullopt : number_of<std::size_t>(std::string_view{text}.substr(cross + 1));
  constexpr std::size_t most = 65536;
  if (!width || !height || *width == 0 || *height == 0 || *width > most || *height > most)
    return fail("gvs.size", "expected a size such as 2048x2048, found '" + text + "'", "--size");
  return vision::ImageSize{*width, *height};
}

Result<Material> points_of(const GvsCalibrateArguments& a) {
  const auto text = adapters::read_file(a.points_file);
  if (!text) return tl::unexpected(text.error());
  auto points = vision::read_points(*text, a.points_file);
  if (!points) return tl::unexpected(points.error());
  const auto frame = size_of(a.size);
  if (!frame) return tl::unexpected(frame.error());
  for (const vision::FloorPoint& point : *points) {
    if (point.pixel.u >= 0.0 && point.pixel.v >= 0.0 && point.pixel.u <= static_cast<double>(frame->width) &&
        point.pixel.v <= static_cast<double>(frame->height))
      continue;
    return fail("gvs.points",
                "the pixel (" + decimals(point.pixel.u, 1) + ", " + decimals(point.pixel.v, 1) +
                    ") lies outside an image of " + a.size + "; --size is the image's size",
                a.points_file);
  }
  return Material{std::move(*points), *frame};
}

Result<Material> board_of(const GvsCalibrateArguments& a) {
  if (a.images_folder.empty()) return fail("gvs.board", "a board needs --images, images of it", "--board");
  const auto text = adapters::read_file(a.board_file);
  if (!text) return tl::unexpected(text.error());
  const auto board = vision::read_board(*text, a.board_file);
  if (!board) return tl::unexpected(board.error());
  auto images = folder_images(a.images_folder, 1.0);
  if (!images) return tl::unexpected(images.error());
  vision::BoardReader reader{*board};
  for (;;) {
    auto frame = (*images)->next();
    if (!frame) return tl::unexpected(frame.error());
    if (!*frame) break;
    if (auto added = reader.add((*frame)->image); !added) {
      Error error = added.error();
      error.location = (*frame)->name;
      return tl::unexpected(error);
    }
  }
  return Material{reader.points(), reader.frame()};
}

Result<std::vector<vision::SurveyedPose>> poses_of(const GvsCalibrateArguments& a) {
  const auto text = adapters::read_file(a.poses_file);
  if (!text) return tl::unexpected(text.error());
  if (a.pose_xs_m.empty() && a.pose_ys_m.empty()) return vision::read_poses(*text, a.poses_file);
  vision::PoseGrid grid{a.pose_xs_m, a.pose_ys_m, {}};
  for (std::uint32_t i = 0; i < a.pose_headings; ++i) grid.headings_rad.push_back(2.0 * pi * i / a.pose_headings);
  return vision::read_pose_stops(*text, a.poses_file, grid);
}

/// Fits a full matrix and a scale, and chooses the fit with the smaller error of left-out poses.
Result<vision::PoseResiduals> fit_of(const GvsCalibrateArguments& a) {
  const auto poses = poses_of(a);
  if (!poses) return tl::unexpected(poses.error());
  auto scale = vision::fit_poses(*poses, false);
  auto full = vision::fit_poses(*poses, true);
  auto best = !scale || (full && full->rms_m < scale->rms_m) ? full : scale;
  if (!best) {
    Error error = scale.error();
    error.location = a.poses_file;
    return tl::unexpected(error);
  }
  return best;
}

void write(JsonWriter& json, std::string_view key, const vision::Residuals& r) {
  json.key(key).begin_object().field("points", r.points).field("rms_mm", 1e3 * r.rms_m).field("max_mm", 1e3 * r.max_m);
  json.end_object();
}

std::string metrics_json(const vision::Calibrated& made, const std::optional<vision::PoseResiduals>& poses) {
  JsonWriter json{2};
  json.begin_object().field("model", name_of(made.calibration.model)).key("tried").begin_array();
  for (const vision::Tried& tried : made.tried) {
    json.begin_object().field("model", name_of(tried.options.model));
    write(json, "fitted", tried.fitted);
    write(json, "colours", tried.colour.metrics);
    write(json, "blocks", tried.block.metrics);
    json.end_object();
  }
  json.end_array();
  json.key("camera").begin_object().field("height_m", made.calibration.camera.height_m);
  json.field("foot_x_m", made.calibration.camera.foot.x_m).field("foot_y_m", made.calibration.camera.foot.y_m);
  json.end_object().key("poses");
  if (poses) {
    json.begin_object().field("poses", poses->left_out.size()).field("rms_mm", 1e3 * poses->rms_m);
    json.field("max_mm", 1e3 * poses->max_m).field("heading_sd_deg", poses->heading_sd_rad / degree_rad);
    json.field("heading_left_out_deg", poses->heading_rms_rad / degree_rad);
    json.field("lean_deg_per_m", poses->fit.lean_per_m / degree_rad);
    json.field("stopped_mm", 1e3 * poses->stopped_m).end_object();
  } else {
    json.null();
  }
  json.end_object();
  return json.take();
}

std::string both(const vision::Residuals& r) {
  return decimals(1e3 * r.rms_m, 2) + " (" + decimals(1e3 * r.max_m, 1) + ")";
}

std::string text_of(const vision::Calibrated& made, const std::optional<vision::PoseResiduals>& poses) {
  std::string text = "rms (max) in mm    fitted           other colour     left-out block\n";
  for (std::size_t i = 0; i < made.tried.size(); ++i) {
    const vision::Tried& tried = made.tried[i];
    std::string line = (i == made.chosen ? "* " : "  ") + std::string(name_of(tried.options.model));
    for (const vision::Residuals* r : {&tried.fitted, &tried.colour.metrics, &tried.block.metrics}) {
      line.resize(std::max<std::size_t>(line.size() + 1, r == &tried.fitted           ? 19
                                                         : r == &tried.colour.metrics ? 36
                                                                                      : 53),
                  ' ');
      line += both(*r);
    }
    text += line + "\n";
  }
  const vision::CameraPose& camera = made.calibration.camera;
  text += camera.height_m > 0.0 ? "camera " + decimals(camera.height_m, 3) + " m above (" +
                                      decimals(camera.foot.x_m, 3) + ", " + decimals(camera.foot.y_m, 3) + ")"
                                : "camera's height not given: nothing above the floor is corrected";
  if (poses) {
    text += "\nsurveyed poses: " + decimals(1e3 * poses->rms_m, 2) + " mm rms, " + decimals(1e3 * poses->max_m, 2) +
            " at most, each left out in turn; headings " + decimals(poses->heading_sd_rad / degree_rad, 3) +
            " degrees about the fit, " + decimals(poses->heading_rms_rad / degree_rad, 3) + " left out";
    if (const vision::PoseFit& fit = poses->fit; fit.lean_per_m != 0.0)
      text += "; the marker leans, by " + decimals(fit.lean_per_m / degree_rad, 3) + " degrees per metre from (" +
              decimals(-fit.lean.x_m / fit.lean_per_m, 1) + ", " + decimals(-fit.lean.y_m / fit.lean_per_m, 1) + ")";
  }
  return text;
}

std::string page_of(const vision::Calibrated& made, const std::optional<vision::PoseResiduals>& poses,
                    const std::string& map, const std::string& name) {
  experiments::Report report{"Calibration of a camera over the floor", name};
  const vision::Tried& best = made.tried[made.chosen];
  report.metadata({{decimals(1e3 * best.colour.metrics.rms_m, 2) + " mm", "rms on the other colour"},
                   {decimals(1e3 * best.block.metrics.rms_m, 2) + " mm", "rms on left-out blocks"},
                   {decimals(1e3 * best.block.metrics.max_m, 1) + " mm", "at most, there"},
                   {std::string(name_of(best.options.model)), "model chosen"}});
  report.heading("Where the calibration is valid, and its error")
      .figure(map, "Every point was evaluated by a fit that did not contain it.");
  std::vector<std::vector<std::string>> rows;
  for (const vision::Tried& tried : made.tried)
    rows.push_back({std::string(name_of(tried.options.model)), both(tried.fitted), both(tried.colour.metrics),
                    both(tried.block.metrics)});
  report.heading("Models tried").table({"model", "fitted, rms (max) mm", "other colour", "left-out block"}, rows);
  report.paragraph("The print's or the survey's own error is not visible here: it is equal in all points.");
  if (poses)
    report.heading("Surveyed poses").paragraph(text_of(made, poses).substr(text_of(made, poses).rfind('\n') + 1));
  return report.html();
}

vision::MarkerProfile marker_of(const GvsCalibrateArguments& a, const std::optional<vision::PoseResiduals>& poses) {
  vision::MarkerProfile marker;
  marker.height_m = a.tag_height_m;
  if (a.mount.size() == 3) marker.X_BT = {a.mount[0], a.mount[1], wrap_angle(a.mount[2] * degree_rad)};
  if (poses) marker.surveyed = poses->fit;
  return marker;
}

}  // namespace

int run_gvs_calibrate(const GvsCalibrateArguments& a) {
  if (a.points_file.empty() && a.board_file.empty())
    return report_error({"gvs.points",
                         "the input of the calibration is missing: --points FILE, or --board FILE --images DIR",
                         "gvs calibrate"});
  const auto material = a.points_file.empty() ? board_of(a) : points_of(a);
  if (!material) return report_error(material.error());
  vision::CalibrationOptions options;
  options.block_m = a.block_m;
  options.camera_height_m = a.camera_height_m;
  for (const vision::FloorModel model : vision::floor_models)
    if (a.model == name_of(model)) options.models = {{model, a.degree}};
  if (options.models.empty() && a.degree != vision::FitOptions{}.degree)
    return report_error({"gvs.degree", "needs --model polynomial or lens_polynomial", "--degree"});
  auto made = vision::calibrate(material->points, material->frame, options);
  if (!made) {
    Error error = made.error();
    if (error.location.empty()) error.location = a.points_file.empty() ? a.images_folder : a.points_file;
    return report_error(error);
  }
  made->calibration.name = a.name;
  if (!a.camera_foot_m.empty()) {
    if (!(a.camera_height_m > 0.0)) return report_error({"gvs.height", "needs --camera-height", "--camera-foot"});
    made->calibration.camera.foot = {a.camera_foot_m[0], a.camera_foot_m[1]};
  }
  std::optional<vision::PoseResiduals> poses;
  if (!a.poses_file.empty()) {
    auto fit = fit_of(a);
    if (!fit) return report_error(fit.error());
    poses = std::move(*fit);
  }
  if (a.tag_height_m > 0.0 && !(a.camera_height_m > a.tag_height_m) && !poses)
    return report_error({"gvs.height", "needs --camera-height, and the camera above the tags", "--tag-height"});
  made->calibration.markers = {marker_of(a, poses)};
  if (!a.out_folder.empty()) {
    const std::string budget =
        to_json(budget_of(made->calibration, "calibration.json", {a.tag_height_error_m, a.mount_error_m, poses}));
    const std::string map = vision::residual_svg(material->points, *made);
    if (auto written = adapters::write_files(a.out_folder, {{"calibration.json", to_json(made->calibration)},
                                                            {"reference_budget.json", budget},
                                                            {"residual_map.svg", map},
                                                            {"points.csv", vision::write_points(material->points)},
                                                            {"result.json", metrics_json(*made, poses) + "\n"},
                                                            {"report.html", page_of(*made, poses, map, a.name)}});
        !written)
      return report_error(written.error());
    print_info("written into " + a.out_folder);
  }
  print(a.json ? metrics_json(*made, poses) : text_of(*made, poses));
  return exit_done;
}

}  // namespace cosiva::app
