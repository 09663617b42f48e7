#include "cosiva/physical/vision/tracker.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "cosiva/physical/vision/floor_fit.h"
#include "cosiva/physical/vision/painter.h"
#include "cosiva/physical/vision/test_floor.h"

namespace cosiva::vision {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

/// 1024 px under the roof: the results hold for the larger image too, and rendering is four times as fast.
SceneCamera small_camera() {
  SceneCamera camera;
  camera.frame = {1024, 1024};
  camera.focal_px = 950.0;
  camera.principal = {516.0, 508.0};
  camera.line_s = 10e-6;
  return camera;
}

Calibration calibration_of(const SceneCamera& camera) {
  const auto points = detected_corners(camera);
  CalibrationOptions options;
  options.models = {{FloorModel::lens, 5}};
  Calibration made = calibrate(points, camera.frame, options).value().calibration;
  made.camera = {camera.foot, camera.height_m};  // by a plumb line and a tape measure
  MarkerProfile marker;
  marker.height_m = SceneBody{}.height_m;
  made.markers = {marker};
  return made;
}

std::vector<SceneBody> fleet(int count, double side_m) {
  std::vector<SceneBody> bodies;
  Random random{11, "fleet"};
  for (int i = 0; i < count; ++i) {
    SceneBody body;
    body.tag = i;
    body.side_m = side_m;
    body.X_MB = {-1.1 + 0.55 * (i % 5), -1.05 + 0.7 * (i / 5), wrap_angle(0.61 * i)};
    body.speed_mps = random.uniform(0.0, 0.5);
    body.turn_radps = random.gaussian(0.0, 0.5);
    body.X_BT = {0.01, 0.0, 0.0};
    bodies.push_back(body);
  }
  return bodies;
}

TrackerOptions options_for(const SceneCamera& camera, double side_m) {
  TrackerOptions options;
  options.exposure_s = camera.exposure_s;
  options.line_s = camera.line_s;
  options.side_m = side_m;
  return options;
}

struct Evaluated {
  std::size_t fixes{};
  double rms_m{}, max_m{}, heading_rms_rad{}, heading_max_rad{};
};

/// Drives `bodies` before the camera and compares each fix with the vehicle's ground truth at the fix's own time.
Evaluated evaluate(const SceneCamera& camera, Calibration calibration, const std::vector<SceneBody>& bodies,
                   int images) {
  calibration.markers[0].X_BT = bodies[0].X_BT;
  const Painter painter{camera, {SceneLine{{{-1.2, -0.3}, {1.2, 0.4}}, 0.02}}, 5};
  Tracker tracker{calibration, options_for(camera, bodies[0].side_m)};
  Evaluated evaluated;
  for (int k = 0; k < images; ++k) {
    const double t_s = 0.05 * k;
    std::vector<SceneBody> now = bodies;
    for (SceneBody& body : now) body.X_MB = body.after(t_s);
    const auto fixes = tracker.see(painter.paint(now, static_cast<std::uint64_t>(k)), t_s);
    for (const Fix& fix : fixes.value()) {
      const Pose2 ground_truth = bodies[static_cast<std::size_t>(fix.tag)].after(fix.t_s);
      const double off = distance(fix.X_MB, ground_truth);
      const double turn = std::fabs(wrap_angle(fix.X_MB.heading_rad - ground_truth.heading_rad));
      ++evaluated.fixes;
      evaluated.rms_m += off * off;
      evaluated.heading_rms_rad += turn * turn;
      evaluated.max_m = std::max(evaluated.max_m, off);
      evaluated.heading_max_rad = std::max(evaluated.heading_max_rad, turn);
    }
  }
  evaluated.rms_m = std::sqrt(evaluated.rms_m / static_cast<double>(evaluated.fixes));
  evaluated.heading_rms_rad = std::sqrt(evaluated.heading_rms_rad / static_cast<double>(evaluated.fixes));
  return evaluated;
}

TEST(Gvs, follows_twenty_vehicles_within_2_mm_and_a_third_of_a_degree) {
  const SceneCamera camera;  // 2048²
  const Evaluated evaluated = evaluate(camera, calibration_of(camera), fleet(20, 0.08), 6);
  EXPECT_EQ(evaluated.fixes, 120U);
  EXPECT_LE(evaluated.rms_m, 1e-3);
  EXPECT_LE(evaluated.max_m, 2e-3);
  EXPECT_LE(evaluated.heading_rms_rad, 0.15 * degree_rad);
  EXPECT_LE(evaluated.heading_max_rad, 0.30 * degree_rad);
}

TEST(Gvs, follows_them_with_a_rolling_shutter_and_motion_blur_too) {
  SceneCamera camera = small_camera();
  camera.exposure_s = 0.008;
  camera.line_s = 20e-6;  // 20 ms from top to bottom: 10 mm at 0.5 m/s without compensation
  const Evaluated evaluated = evaluate(camera, calibration_of(camera), fleet(8, 0.10), 6);
  EXPECT_EQ(evaluated.fixes, 48U);
  EXPECT_LE(evaluated.max_m, 2e-3);
}

TEST(Gvs, without_height_correction_would_be_tens_of_millimetres_off) {
  const SceneCamera camera = small_camera();
  Calibration flat = calibration_of(camera);
  flat.camera = {};
  EXPECT_GT(evaluate(camera, flat, fleet(8, 0.10), 2).max_m, 0.02);
}

TEST(Gvs, detects_in_dim_and_glaring_light) {
  for (const double brightness : {0.35, 1.3}) {
    SceneCamera camera = small_camera();
    camera.brightness = brightness;
    camera.noise_grey = 3.0;
    EXPECT_EQ(evaluate(camera, calibration_of(camera), fleet(8, 0.10), 2).fixes, 16U) << brightness;
  }
}

TEST(Tracker, finds_vehicles_that_come_later_and_drops_those_that_leave) {
  const SceneCamera camera = small_camera();
  const Painter painter{camera, {}, 5};
  Tracker tracker{calibration_of(camera), options_for(camera, 0.10)};
  std::vector<SceneBody> bodies = fleet(3, 0.10);
  bodies[2].speed_mps = 0.0;
  std::vector<SceneBody> all = bodies;
  bodies.pop_back();
  EXPECT_EQ(tracker.see(painter.paint(bodies, 0), 0.0)->size(), 2U);
  double t_s = 0.0;
  std::size_t detected = 0;
  for (int k = 1; k <= 16; ++k) detected = tracker.see(painter.paint(all, 1), t_s += 0.01)->size();
  EXPECT_EQ(detected, 3U);  // all bands have been searched
  for (int k = 0; k < 10; ++k) detected = tracker.see(painter.paint({all[1]}, 2), t_s += 0.01)->size();
  EXPECT_EQ(detected, 1U);
  EXPECT_THAT(tracker.followed(), ElementsAre(1));
  EXPECT_GT(tracker.metrics().lost, 0U);
}

TEST(Tracker, accepts_no_tag_that_is_not_expected_or_of_another_size) {
  const SceneCamera camera = small_camera();
  const Painter painter{camera, {}, 5};
  std::vector<SceneBody> bodies = fleet(3, 0.10);
  bodies[1].side_m = 0.20;
  bodies[1].X_MB = {0.9, 0.9, 0.0};
  TrackerOptions options = options_for(camera, 0.10);
  options.expected = {0, 1};
  Tracker tracker{calibration_of(camera), options};
  const auto fixes = tracker.see(painter.paint(bodies, 0), 0.0);
  ASSERT_EQ(fixes->size(), 1U);
  EXPECT_EQ(fixes->front().tag, 0);
  EXPECT_EQ(tracker.metrics().strange, 2U);
}

TEST(Tracker, refuses_an_image_of_another_size) {
  Tracker tracker{calibration_of(small_camera()), {}};
  const auto fixes = tracker.see(Image::filled({640, 480}, 0), 0.0);
  ASSERT_FALSE(fixes);
  EXPECT_THAT(fixes.error().message, HasSubstr("is 640 x 480 pixels large, and the calibration is for 1024 x 1024"));
}

TEST(Tracker, detects_nothing_in_an_empty_image) {
  Tracker tracker{calibration_of(small_camera()), {}};
  EXPECT_TRUE(tracker.see(Image::filled({1024, 1024}, 128), 0.0)->empty());
}

// ---- Images

TEST(Painter, gives_the_same_bytes_for_the_same_seed_and_others_for_another) {
  SceneCamera camera = small_camera();
  camera.frame = {256, 256};
  camera.principal = {128.0, 128.0};
  camera.focal_px = 240.0;
  const std::vector<SceneBody> bodies = fleet(2, 0.3);
  const Image first = Painter{camera, {}, 5}.paint(bodies, 3);
  EXPECT_EQ(first, (Painter{camera, {}, 5}.paint(bodies, 3)));
  EXPECT_NE(first, (Painter{camera, {}, 6}.paint(bodies, 3)));
  EXPECT_NE(first, (Painter{camera, {}, 5}.paint(bodies, 4)));
}

TEST(Painter, shows_a_floor_position_at_the_pixel_that_maps_to_it) {
  const SceneCamera camera;
  for (const Point2 position : {Point2{0.0, 0.0}, Point2{1.2, -1.1}, Point2{-1.3, 1.3}}) {
    const auto pixel = camera.pixel_of(position, 0.0);
    ASSERT_TRUE(pixel);
    EXPECT_LE(distance(camera.floor_of(*pixel).value(), position), 1e-9);
  }
}

TEST(Frame, is_read_as_it_was_written) {
  Image image = Image::filled({3, 2}, 0);
  for (std::size_t i = 0; i < 6; ++i) image.pixels[i] = static_cast<std::uint8_t>(40 * i);
  EXPECT_EQ(read_netpbm(write_pgm(image), "a.pgm").value(), image);
  EXPECT_EQ(read_netpbm("P6 1 1 255 " + std::string("\xff\x00\x00", 3), "c.ppm")->pixels[0], 76);  // red is dark
  EXPECT_EQ(read_netpbm("P5\n# a remark\n1 1\n65535\n" + std::string("\x80\x00", 2), "d.pgm")->pixels[0], 128);
}

TEST(Frame, that_is_truncated_or_invalid_is_refused_with_the_missing_part) {
  const auto error = [](std::string_view bytes) { return to_string(read_netpbm(bytes, "a.pgm").error()); };
  const std::string good = write_pgm(Image::filled({4, 4}, 9));
  EXPECT_THAT(error(good.substr(0, good.size() - 1)),
              HasSubstr("a.pgm: ends too early: 4 x 4 pixels need 16 bytes, there are 15"));
  for (std::size_t cut = 0; cut < good.size(); ++cut) EXPECT_FALSE(read_netpbm(good.substr(0, cut), "a.pgm"));
  EXPECT_THAT(error("\x89PNG"), HasSubstr("no Netpbm image"));
  EXPECT_THAT(error("P5 0 4 255 "), HasSubstr("has no size"));
  EXPECT_THAT(error("P5 99999999999999999999 4 255 "), HasSubstr("has no size"));
  EXPECT_THAT(error("P5 30000 30000 255 x"), HasSubstr("ends too early"));
}

}  // namespace
}  // namespace cosiva::vision
