#include "cosiva/app/gvs/gvs_render_command.h"

#include <algorithm>
#include <cmath>

#include "cosiva/adapters/files.h"
#include "cosiva/app/cli/console.h"
#include "cosiva/app/cli/progress.h"
#include "cosiva/app/gvs/gvs_scene.h"
#include "cosiva/app/resources/zone_files.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/experiments/positioning/recording/trajectory.h"
#include "cosiva/physical/vision/board.h"
#include "cosiva/physical/vision/painter.h"
#include "cosiva/physical/vision/scene.h"
#include "cosiva/virtual/fleet/fleet.h"
#include "cosiva/zone/drawing/draw.h"

namespace cosiva::app {
namespace {

SceneChoice choice_of(const GvsRenderArguments& a) {
  return {a.size_px, a.height_m, a.tag_height_m, a.exposure_ms, a.rolling_ms, a.noise_grey, a.brightness};
}

/// Tags spread over the floor, each 40 px wide or as large as a vehicle's tag.
std::vector<vision::BoardTag> board_of(const vision::SceneCamera& camera, const GvsRenderArguments& a) {
  constexpr int half = 5;
  constexpr int first_id = 200;
  const double reach_m = 0.92 * camera.height_m * 0.5 * static_cast<double>(camera.frame.width) / camera.focal_px;
  const double side_m = std::max(a.tag_side_m, 40.0 * camera.height_m / camera.focal_px);
  std::vector<vision::BoardTag> board;
  for (int j = -half; j <= half; ++j)
    for (int i = -half; i <= half; ++i)
      board.push_back({first_id + static_cast<int>(board.size()),
                       {camera.foot.x_m + reach_m * i / half, camera.foot.y_m + reach_m * j / half, 0.0},
                       side_m});
  return board;
}

class Render {
 public:
  Render(const GvsRenderArguments& a, std::shared_ptr<const zone::TrafficZone> zone, virtual_side::Fleet fleet)
      : a_{a},
        fleet_{std::move(fleet)},
        primitives_{zone::draw(*zone)},
        zone_{std::move(zone)},
        camera_{camera_over(zone::bounds(primitives_), choice_of(a))},
        painter_{camera_, lines_of(primitives_), a.seed} {}

  Result<void> run() {
    const double step_s = 1.0 / a_.rate_hz;
    for (double warm_s = 0.0; warm_s < a_.warm_up_s; warm_s += step_s) fleet_.step();
    const auto images = static_cast<std::uint64_t>(std::max(1.0, std::nearbyint(a_.seconds * a_.rate_hz)));
    ground_truth_.resize(fleet_.size());
    std::string stamps = "file,stamp_s\n";
    Progress progress{"render"};
    for (std::uint64_t k = 0; k < images; ++k) {
      const double t_s = static_cast<double>(k) * step_s;
      const auto bodies = bodies_until_next(step_s);
      persist(bodies, t_s, step_s);
      const std::string name = name_of(k);
      if (auto written =
              adapters::write_files(a_.out_folder + "/images", {{name, write_pgm(painter_.paint(bodies, k))}});
          !written)
        return written;
      stamps += name + "," + number(t_s + 1e-3 * a_.late_ms) + "\n";
      progress.at(t_s, a_.seconds);
    }
    images_ = images;
    return write_rest(stamps);
  }

  [[nodiscard]] std::string json() const {
    JsonWriter json{2};
    json.begin_object().field("images", images_).field("aivs", fleet_.size()).field("width_px", a_.size_px);
    json.field("camera_height_m", camera_.height_m).field("camera_foot_x_m", camera_.foot.x_m);
    json.field("camera_foot_y_m", camera_.foot.y_m)
        .field("tag_height_m", a_.tag_height_m)
        .field("tag_side_m", a_.tag_side_m);
    json.field("tag_px", tag_px()).field("exposure_ms", a_.exposure_ms).field("line_us", 1e6 * camera_.line_s);
    json.field("late_ms", a_.late_ms).field("seed", a_.seed).end_object();
    return json.take();
  }
  [[nodiscard]] std::string phrase() const {
    std::string text = std::to_string(images_) + " images of " + std::to_string(fleet_.size()) + " AIVs, tags " +
                       decimals(tag_px(), 0) + " px wide; a camera " + decimals(camera_.height_m, 2) + " m above (" +
                       decimals(camera_.foot.x_m, 3) + ", " + decimals(camera_.foot.y_m, 3) + ")";
    if (tag_px() < 24.0) text += "\ntags under 24 px are missed: a larger --size or --tag-side, or a smaller zone";
    return text + "\nnow: cosiva gvs calibrate --points " + a_.out_folder + "/points.csv --size " +
           std::to_string(a_.size_px) + "x" + std::to_string(a_.size_px) + " --camera-height " +
           decimals(camera_.height_m, 3) + " --camera-foot " + decimals(camera_.foot.x_m, 4) + "," +
           decimals(camera_.foot.y_m, 4) + " --tag-height " + decimals(a_.tag_height_m, 3) + " --out cal";
  }

 private:
  static std::string number(double value) {
    JsonWriter json;
    return json.value(value).take();
  }
  static std::string name_of(std::uint64_t k) {
    const std::string digits = std::to_string(k);
    return std::string(digits.size() < 6 ? 6 - digits.size() : 0, '0') + digits + ".pgm";
  }
  [[nodiscard]] double tag_px() const {
    return a_.tag_side_m * camera_.focal_px / (camera_.height_m - a_.tag_height_m);
  }

  /// Steps the fleet; returns all bodies at their pose before the step, moving so that they reach their pose after the
  /// step.
  std::vector<vision::SceneBody> bodies_until_next(double step_s) {
    std::vector<vision::SceneBody> bodies(fleet_.size());
    const zone::VehicleShape shape = zone_->vehicle;
    for (std::size_t i = 0; i < bodies.size(); ++i) bodies[i].X_MB = fleet_.pose(static_cast<std::uint32_t>(i));
    fleet_.step();
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      vision::SceneBody& body = bodies[i];
      const Pose2 next = fleet_.pose(static_cast<std::uint32_t>(i));
      body.tag = static_cast<int>(i) + 1;
      body.turn_radps = wrap_angle(next.heading_rad - body.X_MB.heading_rad) / step_s;
      body.speed_mps = distance(body.X_MB, next) / step_s;
      body.height_m = a_.tag_height_m;
      body.side_m = a_.tag_side_m;
      body.length_m = shape.length_m;
      body.width_m = shape.width_m;
    }
    return bodies;
  }

  void persist(const std::vector<vision::SceneBody>& bodies, double t_s, double step_s) {
    constexpr int finer = 5;
    for (std::size_t i = 0; i < bodies.size(); ++i)
      for (int k = 0; k < finer; ++k)
        ground_truth_[i].poses.push_back(
            experiments::stamped(t_s + step_s * k / finer, bodies[i].after(step_s * k / finer)));
  }

  Result<void> write_rest(const std::string& stamps) {
    if (auto written = adapters::write_files(a_.out_folder + "/images", {{"stamps.csv", stamps}}); !written)
      return written;
    std::vector<std::pair<std::string, std::string>> ground_truth;
    for (std::size_t i = 0; i < ground_truth_.size(); ++i)
      ground_truth.emplace_back("tag_" + std::to_string(i + 1) + ".tum", experiments::write_tum(ground_truth_[i]));
    if (auto written = adapters::write_files(a_.out_folder + "/ground_truth", ground_truth); !written) return written;
    const auto board = board_of(camera_, a_);
    std::vector<vision::SceneBody> lying;
    lying.reserve(board.size());
    for (const vision::BoardTag& tag : board)
      lying.push_back({tag.id, tag.X_MT, 0.0, 0.0, 0.0, tag.side_m, {}, 0.0, 0.0});
    if (auto written = adapters::write_files(a_.out_folder + "/board",
                                             {{"000000.pgm", write_pgm(painter_.paint(lying, 1'000'000))}});
        !written)
      return written;
    return adapters::write_files(a_.out_folder, {{"points.csv", vision::write_points(corners_of(camera_, a_.seed))},
                                                 {"board.csv", vision::write_board(board)},
                                                 {"scene.json", json() + "\n"}});
  }

  const GvsRenderArguments& a_;
  virtual_side::Fleet fleet_;
  std::vector<zone::Primitive> primitives_;
  std::shared_ptr<const zone::TrafficZone> zone_;
  vision::SceneCamera camera_;
  vision::Painter painter_;
  std::vector<experiments::Trajectory> ground_truth_;
  std::uint64_t images_{0};
};

}  // namespace

int run_gvs_render(const GvsRenderArguments& a) {
  const auto rtm = open_zone(a.zone);
  if (!rtm) return report_error(rtm.error());
  if (!(a.tag_height_m < a.height_m)) return report_error({"gvs.height", "lies not below the camera", "--tag-height"});
  const auto zone = rtm->shared_zone();
  const auto starts = virtual_side::Fleet::spread(*zone, a.aivs);
  if (starts.size() < a.aivs) {
    return report_error({"gvs.room",
                         "has room for " + std::to_string(starts.size()) + " AIVs, not for " + std::to_string(a.aivs),
                         a.zone});
  }
  virtual_side::FleetOptions options;
  options.step = from_seconds(1.0 / a.rate_hz);
  auto fleet = virtual_side::Fleet::make(zone, options, starts);
  if (!fleet) return report_error(fleet.error());
  Render render{a, zone, std::move(*fleet)};
  if (auto done = render.run(); !done) return report_error(done.error());
  print(a.json ? render.json() : render.phrase());
  return exit_done;
}

}  // namespace cosiva::app
