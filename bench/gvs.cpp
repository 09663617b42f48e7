// The processor time of one core that the global vision system takes for an image of 2048² with twenty vehicles.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <vector>

#include "cosiva/app/cli/options.h"
#include "cosiva/base/random.h"
#include "cosiva/physical/vision/floor_fit.h"
#include "cosiva/physical/vision/painter.h"
#include "cosiva/physical/vision/scene.h"
#include "cosiva/physical/vision/tracker.h"

namespace {

using namespace cosiva;
using namespace cosiva::vision;

double processor_ms() { return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

std::vector<FloorPoint> corners_of(const SceneCamera& camera) {
  std::vector<FloorPoint> points;
  for (int i = -14; i <= 14; ++i) {
    for (int j = -14; j <= 14; ++j) {
      const Point2 floor{0.1 * i, 0.1 * j};
      if (const auto pixel = camera.pixel_of(floor, 0.0)) points.push_back({floor, *pixel});
    }
  }
  return points;
}

std::vector<SceneBody> fleet_of(int vehicles) {
  std::vector<SceneBody> bodies;
  Random random{1, "fleet"};
  const int across = static_cast<int>(std::ceil(std::sqrt(vehicles)));
  for (int i = 0; i < vehicles; ++i) {
    SceneBody body;
    body.tag = i;
    const int row = i / across;
    body.X_MB = {-1.1 + 2.6 * (i % across) / across, -1.1 + 2.6 * row / across, wrap_angle(0.37 * i)};
    body.speed_mps = random.uniform(0.0, 0.15);
    body.turn_radps = random.gaussian(0.0, 0.8);
    bodies.push_back(body);
  }
  return bodies;
}

double centre(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

}  // namespace

int main(int argc, char** argv) {
  const cosiva::app::CommandLine line{"Times the global vision system, by processor time of its one thread"};
  const cosiva::app::Command command = line.root();
  int vehicles = 20;
  int images = 40;
  std::size_t size = 2048;
  command.add_option("--vehicles", vehicles).in_range(1, 100);
  command.add_option("--image-count", images).in_range(2, 100000);
  command.add_option("--size", size).in_range(256, 8192);
  if (const auto status = line.parse(argc, argv)) return *status;

  SceneCamera camera;
  const double ratio = static_cast<double>(size) / 2048.0;
  camera.frame = {size, size};
  camera.focal_px *= ratio;
  camera.principal = {camera.principal.u * ratio, camera.principal.v * ratio};
  CalibrationOptions options;
  options.models = {{FloorModel::lens_polynomial, 5}};
  auto made = calibrate(corners_of(camera), camera.frame, options);
  if (!made) return 1;
  made->calibration.camera = {camera.foot, camera.height_m};
  MarkerProfile marker;
  marker.height_m = SceneBody{}.height_m;
  made->calibration.markers = {marker};
  const Painter painter{camera, {}, 1};
  const auto bodies = fleet_of(vehicles);
  TrackerOptions with_search;
  with_search.side_m = bodies[0].side_m;
  with_search.exposure_s = camera.exposure_s;
  TrackerOptions known = with_search;
  for (const SceneBody& body : bodies) known.expected.push_back(body.tag);
  Tracker searching{made->calibration, with_search};
  Tracker knowing{made->calibration, known};

  std::vector<double> searching_ms;
  std::vector<double> knowing_ms;
  double first_ms = 0.0;
  double squares = 0.0;
  double worst_m = 0.0;
  std::size_t fixes = 0;
  for (int k = 0; k < images; ++k) {
    const double t_s = 0.05 * k;
    std::vector<SceneBody> now = bodies;
    for (std::size_t i = 0; i < now.size(); ++i) now[i].X_MB = bodies[i].after(std::fmod(t_s, 1.0));
    const Image image = painter.paint(now, static_cast<std::uint64_t>(k));
    const double began_ms = processor_ms();
    const auto detected = searching.see(image, t_s);
    const double between_ms = processor_ms();
    const auto again = knowing.see(image, t_s);
    const double end_ms = processor_ms();
    if (!detected || !again) return 1;
    if (k == 0) {
      first_ms = between_ms - began_ms;
    } else {
      searching_ms.push_back(between_ms - began_ms);
      knowing_ms.push_back(end_ms - between_ms);
    }
    for (const Fix& fix : *detected) {
      const Pose2 ground_truth = bodies[static_cast<std::size_t>(fix.tag)].after(std::fmod(t_s, 1.0) + fix.t_s - t_s);
      const double off = distance(ground_truth, fix.X_MB);
      squares += off * off;
      worst_m = std::max(worst_m, off);
      ++fixes;
    }
  }
  std::printf("%zu x %zu, %d vehicles, %d images, one core (processor time):\n", size, size, vehicles, images);
  std::printf("  all known            median %6.2f ms\n", centre(knowing_ms));
  std::printf("  and a band searched  median %6.2f ms, worst %6.2f\n", centre(searching_ms),
              std::ranges::max(searching_ms));
  std::printf("  first image, searched whole %6.2f ms\n", first_ms);
  std::printf("  %zu of %d fixes, %.3f mm rms, %.3f at most\n", fixes, vehicles * images,
              1e3 * std::sqrt(squares / static_cast<double>(std::max<std::size_t>(1, fixes))), 1e3 * worst_m);
  return fixes == static_cast<std::size_t>(vehicles) * static_cast<std::size_t>(images) ? 0 : 1;
}
