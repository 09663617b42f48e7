#include "cosiva/physical/vision/calibration.h"

#include <gmock/gmock.h>

#include <cmath>

#include "cosiva/physical/vision/calibration_json.h"
#include "cosiva/physical/vision/residual_svg.h"
#include "cosiva/physical/vision/test_floor.h"

namespace cosiva::vision {
namespace {

using testing::HasSubstr;

const Calibrated& cpm() {
  static const Calibrated calibrated = calibrate(cpm_points(), cpm_image, {}).value();
  return calibrated;
}

// ---- The requirements, on CPM Lab's floor (testdata/README.md)

TEST(Calibration, of_a_real_floor_is_within_075_mm_rms_and_5_mm_on_the_other_colour) {
  const Residuals& off = cpm().calibration.colour;
  EXPECT_EQ(off.points, 1716U);
  EXPECT_LE(off.rms_m, 0.75e-3);
  EXPECT_LE(off.max_m, 5e-3);
}

TEST(Calibration, of_a_real_floor_is_within_1_mm_rms_and_9_mm_on_blocks_left_out) {
  const Residuals& off = cpm().calibration.block;
  EXPECT_EQ(off.points, 1716U);
  EXPECT_LE(off.rms_m, 1.0e-3);
  EXPECT_LE(off.max_m, 9e-3);
}

TEST(Calibration, gives_the_known_results_of_simpler_models_on_a_real_floor) {
  // known results of the data: homography 26.8 (79) | 31.7 (108), with lens 1.45 (6.2) | 1.84 (11.1), in mm
  ASSERT_EQ(cpm().tried.size(), 4U);
  const Tried& plane = cpm().tried[0];
  EXPECT_NEAR(1e3 * plane.colour.metrics.rms_m, 26.8, 0.05);
  EXPECT_NEAR(1e3 * plane.block.metrics.rms_m, 31.7, 0.05);
  const Tried& lens = cpm().tried[1];
  EXPECT_NEAR(1e3 * lens.colour.metrics.rms_m, 1.45, 0.01);
  EXPECT_NEAR(1e3 * lens.colour.metrics.max_m, 6.2, 0.05);
  EXPECT_NEAR(1e3 * lens.block.metrics.rms_m, 1.84, 0.01);
  EXPECT_NEAR(1e3 * lens.block.metrics.max_m, 11.1, 0.05);
}

TEST(Calibration, chooses_the_model_whose_left_out_blocks_fit_best) {
  const Tried& chosen = cpm().tried[cpm().chosen];
  for (const Tried& tried : cpm().tried) EXPECT_LE(chosen.block.metrics.rms_m, tried.block.metrics.rms_m);
  EXPECT_EQ(chosen.options.model, cpm().calibration.model);
}

TEST(Calibration, of_surveyed_poses_is_within_1_mm_and_a_quarter_degree) {
  const auto poses = read_pose_stops(test_file("cpm-ips/pose_calibration.txt"), "poses", cpm_grid());
  ASSERT_TRUE(poses) << to_string(poses.error());
  ASSERT_EQ(poses->size(), 32U);
  const auto fit = fit_poses(*poses, true);
  ASSERT_TRUE(fit);
  EXPECT_LE(fit->rms_m, 1.0e-3);  // each pose evaluated by the fit to all others
  EXPECT_LE(fit->max_m, 1.75e-3);
  EXPECT_LE(fit->heading_sd_rad / degree_rad, 0.25);
  EXPECT_LE(fit->heading_rms_rad / degree_rad, 0.25);  // and this with each left out
  // A leaning marker appears to lean away from the camera's foot, and the camera is over the centre of 4.5 m × 4 m.
  // From 32 headings that scatter by 0.2 degrees the centre follows to about half a metre.
  ASSERT_NE(fit->fit.lean_per_m, 0.0);
  EXPECT_NEAR(-fit->fit.lean.x_m / fit->fit.lean_per_m, 2.25, 0.8);
  EXPECT_NEAR(-fit->fit.lean.y_m / fit->fit.lean_per_m, 2.0, 0.8);
  EXPECT_NEAR(fit->fit.lever.x_m, 0.079, 0.001);  // the marker is 79 mm from the vehicle's point
  EXPECT_LE(fit->stopped_m, 0.05e-3);
}

// ---- Stored values

TEST(Calibration, stores_the_residual_map_as_its_uncertainty) {
  const ResidualMap& map = cpm().calibration.uncertainty;
  double mean_square = 0.0;
  std::size_t points = 0;
  for (std::size_t i = 0; i < map.rms_m.size(); ++i) {
    mean_square += map.rms_m[i] * map.rms_m[i] * static_cast<double>(map.points[i]);
    points += map.points[i];
  }
  EXPECT_EQ(points, 1716U);
  const double rms_m = std::sqrt(mean_square / 1716.0);
  EXPECT_GE(rms_m, cpm().calibration.block.rms_m);  // the worse of the two partitions
  EXPECT_LE(rms_m, 1.5 * cpm().calibration.block.rms_m);
  EXPECT_GT(map.at({2.2, 2.0}), 0.0);
  EXPECT_EQ(map.at({-10.0, -10.0}), map.rms_m[0]);  // beyond: the nearest square's
}

TEST(Calibration, is_the_same_after_its_file_was_written_and_read) {
  Calibration made = cpm().calibration;
  made.name = "north \"area\"";
  made.camera = {{2.2, 2.0}, 3.3};
  MarkerProfile marker;
  marker.id = 7;
  marker.height_m = 0.1;
  marker.X_BT = {0.01, -0.02, 0.5};
  marker.surveyed = PoseFit{{1.001, 0.0, 0.0, 0.999}, {0.01, 0.02}, {0.079, 0.0}, -0.005, 0.002, {-0.004, -0.003}};
  made.markers = {MarkerProfile{}, marker};
  const std::string text = to_json(made);
  const auto again = read_calibration(text, "file");
  ASSERT_TRUE(again) << to_string(again.error());
  EXPECT_EQ(again->map, made.map);
  EXPECT_EQ(again->markers, made.markers);
  EXPECT_EQ(again->uncertainty, made.uncertainty);
  EXPECT_EQ(to_json(*again), text);
}

TEST(Calibration, draws_its_residual_map) {
  const std::string svg = residual_svg(cpm_points(), cpm());
  EXPECT_THAT(svg, testing::StartsWith("<svg"));
  EXPECT_THAT(svg, HasSubstr("Left-out blocks: 0.9"));
}

TEST(FloorMap, maps_from_the_floor_back_to_the_pixel) {
  const FloorMap& map = cpm().calibration.map;
  for (std::size_t i = 0; i < cpm_points().size(); i += 37) {
    const PixelPoint pixel = cpm_points()[i].pixel;
    const auto back = map.pixel_at(map.floor_at(pixel).value());
    ASSERT_TRUE(back);
    EXPECT_NEAR(back->u, pixel.u, 1e-3);
    EXPECT_NEAR(back->v, pixel.v, 1e-3);
  }
  EXPECT_FALSE(map.pixel_at({50.0, 0.0}));
}

// ---- Rendered floors with known results

TEST(Calibration, fits_a_distorted_lens_that_it_has_no_model_of) {
  const SceneCamera camera;
  const auto made = calibrate(detected_corners(camera, 0.0), camera.frame, {});
  ASSERT_TRUE(made);
  EXPECT_LE(made->calibration.block.max_m, 0.2e-3);
  const auto somewhere = camera.pixel_of({0.333, -0.777}, 0.0);
  EXPECT_LE(distance(made->calibration.map.floor_at(*somewhere).value(), {0.333, -0.777}), 0.1e-3);
}

TEST(Height, is_corrected_by_the_cameras_foot_and_height) {
  SceneCamera camera;
  camera.foot = {0.2, -0.1};
  const Point2 there{1.1, 0.7};
  const auto pixel = camera.pixel_of(there, 0.10);
  const Point2 detected = camera.floor_of(*pixel).value();
  EXPECT_GT(distance(detected, there), 0.03);  // 10 cm under 3.3 m, 1.2 m from the foot: 37 mm
  const CameraPose camera_pose{camera.foot, camera.height_m};
  EXPECT_LE(distance(at_height(detected, 0.10, camera_pose), there), 1e-9);
  EXPECT_LE(distance(detected_from(there, 0.10, camera_pose), detected), 1e-9);
}

TEST(Height, derives_the_cameras_foot_from_its_height_within_30_mm) {
  const SceneCamera camera;
  CalibrationOptions options;
  options.camera_height_m = camera.height_m;
  const auto made = calibrate(detected_corners(camera), camera.frame, options);
  ASSERT_TRUE(made);
  EXPECT_LE(distance(made->calibration.camera.foot, camera.foot), 0.030);
}

// ---- Bad input

std::string points_error(const std::string& text) {
  const auto points = read_points(text, "points.csv");
  return points ? "" : to_string(points.error());
}
constexpr const char* header = "world_x; world_y; image_x; image_y;\n";

TEST(Points, with_another_separator_are_refused_with_their_line) {
  EXPECT_THAT(points_error("world_x world_y image_x image_y\n0 0 1 1\n"),
              HasSubstr("points.csv:1: lacks the column 'world_x'"));
  EXPECT_THAT(points_error(std::string(header) + "0, 0, 1, 1\n"),
              HasSubstr("points.csv:2: expected 4 fields cut at ';'"));
  EXPECT_THAT(points_error(std::string(header) + "0,1; 0; 1; 1\n"), HasSubstr("decimals follow a point"));
}

TEST(Points, that_are_no_finite_numbers_are_refused_with_their_line) {
  for (const std::string bad : {"nan", "inf", "-inf", "1e400", "", "0x1p3", "1.0.0", "2000000"}) {
    const std::string error = points_error(std::string(header) + "0; 0; 1; 1;\n" + bad + "; 0; 1; 2;\n");
    EXPECT_THAT(error, HasSubstr("points.csv:3: expected a finite number")) << bad;
  }
}

TEST(Points, that_are_duplicate_or_missing_are_refused) {
  EXPECT_THAT(points_error(std::string(header) + "0; 0; 1; 1\n1; 0; 2; 1\n0; 0; 3; 1\n"),
              HasSubstr("points.csv:4: this position"));
  EXPECT_THAT(points_error(std::string(header) + "0; 0; 1; 1\n1; 0; 1; 1\n"), HasSubstr("points.csv:3: this pixel"));
  EXPECT_THAT(points_error(header), HasSubstr("holds no rows"));
  EXPECT_THAT(points_error(""), HasSubstr("holds no rows"));
  EXPECT_THAT(points_error("world_x; world_x; world_y; image_x; image_y\n"),
              HasSubstr("has twice the column 'world_x'"));
}

TEST(Points, are_read_back_as_they_were_written) {
  const std::vector<FloorPoint> points{{{0.1, -0.2}, {3.25, 4.0}}, {{1e-7, 3.0}, {1000.125, 1.0 / 3.0}}};
  EXPECT_EQ(read_points(write_points(points), "again").value(), points);
}

TEST(Calibration, of_too_few_points_reports_how_many_it_needs) {
  const std::vector<FloorPoint> few{cpm_points().begin(), cpm_points().begin() + 5};
  const auto made = calibrate(few, cpm_image, {});
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().code, "gvs.points");
  EXPECT_THAT(made.error().message, HasSubstr("holds 5 points"));
  EXPECT_THAT(made.error().message, HasSubstr("needs 6"));
}

TEST(Calibration, of_points_on_one_line_is_refused) {
  std::vector<FloorPoint> line;
  for (int i = 0; i < 50; ++i) line.push_back({{0.1 * i, 0.2 * i}, {20.0 * i + 3.0, 40.0 * i}});
  const auto made = calibrate(line, cpm_image, {});
  ASSERT_FALSE(made);
  EXPECT_THAT(made.error().message, HasSubstr("one line"));
}

TEST(Calibration, of_points_that_no_camera_can_map_so_is_refused_or_reports_its_error) {
  std::vector<FloorPoint> mixed = cpm_points();
  Random random{3, "mixed"};
  for (FloorPoint& point : mixed) point.pixel = {random.uniform(0.0, 2048.0), random.uniform(0.0, 2048.0)};
  mixed.resize(200);
  const auto made = calibrate(mixed, cpm_image, {});
  if (made) {
    EXPECT_GT(made->calibration.block.rms_m, 0.3);
  } else {
    EXPECT_EQ(made.error().code, "gvs.fit");
  }
}

TEST(Calibration, file_that_is_damaged_is_refused_with_the_field) {
  const std::string good = to_json(cpm().calibration);
  const auto error_after = [&](const std::string& from, const std::string& to) {
    std::string bad = good;
    bad.replace(bad.find(from), from.size(), to);
    const auto read = read_calibration(bad, "cam.json");
    return read ? std::string{} : to_string(read.error());
  };
  EXPECT_THAT(error_after("cosiva.gvs.calibration.v1", "v9"), HasSubstr("cam.json: expected a JSON object with"));
  EXPECT_THAT(error_after("\"model\": \"", "\"model\": \"x"), HasSubstr("'model'"));
  EXPECT_THAT(error_after("\"scale_px\": 1024", "\"scale_px\": 0"), HasSubstr("'scale_px'"));
  EXPECT_THAT(error_after("\"degree\": 5", "\"degree\": 4"), HasSubstr("'polynomial_m': expected a list of 30"));
  EXPECT_THAT(error_after("\"degree\": 5", "\"degree\": 1e9"), HasSubstr("'degree'"));
  EXPECT_THAT(error_after("2048", "0"), HasSubstr("'image_px'"));
  EXPECT_THAT(to_string(read_calibration(good.substr(0, 300), "cam.json").error()), HasSubstr("cam.json"));
}

TEST(Poses, of_another_number_than_the_grid_has_are_refused) {
  const std::string text = test_file("cpm-ips/pose_calibration.txt");
  const auto few = read_pose_stops(text.substr(0, text.size() / 2), "poses.txt", cpm_grid());
  ASSERT_FALSE(few);
  EXPECT_THAT(to_string(few.error()), HasSubstr("poses.txt: "));
  EXPECT_THAT(few.error().message, HasSubstr("the grid has 32 poses"));
  const auto bad = read_pose_stops("0.5, 0.6, nan, 0.01, 1,\n", "poses.txt", cpm_grid());
  ASSERT_FALSE(bad);
  EXPECT_THAT(to_string(bad.error()), HasSubstr("poses.txt:1: "));
}

TEST(Poses, that_do_not_distinguish_height_from_mounting_are_refused) {
  std::vector<SurveyedPose> same(8);
  for (std::size_t i = 0; i < same.size(); ++i) same[i] = {{1.0, 1.0, 0.1}, {1.01, 1.0, 0.1}, 1, 0.0};
  EXPECT_THAT(fit_poses(same, false).error().message, HasSubstr("three positions"));
  same.resize(3);
  EXPECT_THAT(fit_poses(same, false).error().message, HasSubstr("a fit needs 6"));
}

}  // namespace
}  // namespace cosiva::vision
