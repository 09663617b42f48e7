// A camera over a running platform: what it publishes about its images, and the preview.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <filesystem>

#include "cosiva/adapters/event_loop.h"
#include "cosiva/adapters/files.h"
#include "cosiva/adapters/test_fixture.h"
#include "cosiva/app/command_line_fixture.h"
#include "cosiva/app/gvs/camera_pipeline.h"
#include "cosiva/app/gvs/gvs_scene.h"
#include "cosiva/app/gvs/preview_feed.h"
#include "cosiva/app/resources/zone_files.h"
#include "cosiva/base/json_value.h"
#include "cosiva/base/text.h"
#include "cosiva/physical/vision/calibration_json.h"

namespace cosiva::app {
namespace {

using namespace std::chrono_literals;
using adapters::testing::Scratch;
using fixture::cosiva;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;

constexpr double degree_rad = pi / 180.0;

zone::Rtm lacet4() { return std::move(open_zone(fixture::zones + "lacet4.toml").value()); }

/// Four vehicles that drive and turn over lacet4, as published by a plant.
GroundTruth ground_truth_at(SimTime at) {
  GroundTruth ground_truth{at, {}};
  const double t_s = to_seconds(at - virtual_epoch);
  const double side[] = {-0.6, 0.6};
  std::uint32_t number = 0;
  for (const double x : side) {
    for (const double y : side) {
      vision::SceneBody body;
      body.X_MB = {x, y, 0.7 * number};
      body.speed_mps = 0.3;
      body.turn_radps = 0.5;
      ground_truth.vehicles.push_back({++number, body.after(t_s), body.speed_mps});
    }
  }
  return ground_truth;
}

struct Watched {
  Watched() : camera{EmulatedCamera::over(lacet4().zone()).value()} {
    GvsSource source;
    source.tag_side_m = camera.tag_side_m();
    source.exposure_ms = 1e3 * camera.exposure_s();
    watched_camera.emplace(camera.calibration(), tracker_options(source), std::map<int, std::string>{{3, "ACME/cart"}});
  }
  wire::GvsDetections detect(SimTime at) {
    const GroundTruth ground_truth = ground_truth_at(at);
    image = camera.take(ground_truth, ground_truth_at(at - 100ms));
    return watched_camera->see(image, at, 0.25).value();
  }
  EmulatedCamera camera;
  std::optional<GvsCamera> watched_camera;
  vision::Image image;
};

TEST(GvsCamera, detects_every_vehicle_of_an_emulated_world_within_3_mm_of_its_position_at_mid_exposure) {
  Watched watched;
  for (int k = 0; k < 4; ++k) {
    const SimTime at = virtual_epoch + 250ms * k;
    const wire::GvsDetections detections = watched.detect(at);
    ASSERT_THAT(detections.detections, SizeIs(4));
    for (const auto& detection : detections.detections) {
      EXPECT_EQ(detection.at - at, 2ms) << "half of the exposure of 4 ms";
      const auto ground_truth = ground_truth_at(detection.at).vehicles[detection.tag - 1];
      EXPECT_LT(distance(detection.pose, ground_truth.X_MB), 0.003) << "AIV" << detection.tag;
      EXPECT_LT(std::fabs(wrap_angle(detection.pose.heading_rad - ground_truth.X_MB.heading_rad)), 0.5 * degree_rad);
      EXPECT_GT(detection.uncertainty_m, 0.0);
    }
  }
}

TEST(GvsCamera, names_vehicles_by_their_tags_and_others_as_configured) {
  Watched watched;
  std::vector<std::string> names;
  for (const auto& detection : watched.detect(virtual_epoch).detections) names.push_back(detection.vehicle);
  EXPECT_THAT(names, ElementsAre("CoSiVA/AIV1", "CoSiVA/AIV2", "ACME/cart", "CoSiVA/AIV4"));
}

TEST(GvsCamera, a_tag_whose_usual_aiv_carries_another_tag_belongs_to_no_vehicle) {
  EmulatedCamera camera = EmulatedCamera::over(lacet4().zone()).value();
  GvsSource source;
  source.tag_side_m = camera.tag_side_m();
  GvsCamera watched_camera{camera.calibration(), tracker_options(source), {{2, "CoSiVA/AIV1"}}};
  const auto detections =
      watched_camera.see(camera.take(ground_truth_at(virtual_epoch), std::nullopt), virtual_epoch, 0.25).value();
  std::vector<std::string> names;
  for (const auto& detection : detections.detections) names.push_back(detection.vehicle);
  EXPECT_THAT(names, ElementsAre("tag 1", "CoSiVA/AIV1", "CoSiVA/AIV3", "CoSiVA/AIV4"));
}

TEST(GvsCamera, reports_the_observed_part_of_the_floor) {
  const Watched watched;
  double low = 0.0;
  double high = 0.0;
  for (const Point2& corner : watched.watched_camera->field()) {
    low = std::min({low, corner.x_m, corner.y_m});
    high = std::max({high, corner.x_m, corner.y_m});
  }
  const double half_m = 0.5 * watched.camera.width_m();
  EXPECT_NEAR(low, -half_m, 0.25 * half_m);
  EXPECT_NEAR(high, half_m, 0.25 * half_m);
  // A vehicle that the image's border cuts off is not reported as missing: a whole tag is detected at each corner.
  const vision::Calibration& calibration = watched.camera.calibration();
  const double height_m = vision::profile_of(1, calibration.markers).height_m;
  for (const Point2& corner : watched.watched_camera->field()) {
    const auto pixel = calibration.map.pixel_at(vision::detected_from(corner, height_m, calibration.camera));
    ASSERT_TRUE(pixel);
    for (const double at : {pixel->u, pixel->v}) {
      EXPECT_GT(at, 39.0);
      EXPECT_LT(at, EmulatedCamera::size_px - 39.0);
    }
  }
}

TEST(GvsCamera, ignores_an_image_that_is_not_newer_and_refuses_another_size) {
  Watched watched;
  ASSERT_THAT(watched.detect(virtual_epoch + 1s).detections, SizeIs(4));
  EXPECT_THAT(watched.detect(virtual_epoch).detections, SizeIs(0));
  EXPECT_THAT(watched.detect(virtual_epoch + 2s).detections, SizeIs(4));
  const auto refused = watched.watched_camera->see(vision::Image::filled({64, 64}, 0), virtual_epoch + 3s, 0.25);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("64 x 64"));
}

TEST(GvsCamera, shows_a_preview_image_whose_comment_lists_the_vehicles_positions) {
  Watched watched;
  const wire::GvsDetections detections = watched.detect(virtual_epoch);
  const std::string shown = watched.watched_camera->shown(watched.image, detections, {0.2, 0.12});
  const auto image = vision::read_netpbm(shown, "shown");
  ASSERT_TRUE(image);
  EXPECT_EQ(image->size, (vision::ImageSize{480, 480}));
  ASSERT_TRUE(shown.starts_with("P5\n# {"));
  const auto reported = JsonValue::parse(shown.substr(5, shown.find('\n', 5) - 5));
  ASSERT_TRUE(reported);
  EXPECT_EQ(reported->text("timestamp"), to_iso8601(virtual_epoch));
  const auto& all = *reported->find("detections")->array();
  ASSERT_THAT(all, SizeIs(4));
  for (const JsonValue& detection : all) {
    const auto& outline = *detection.find("outline")->array();
    ASSERT_THAT(outline, SizeIs(4)) << detection.text("vehicle").value();
    double u = 0.0;
    double v = 0.0;
    for (const JsonValue& corner : outline) {
      u += 0.25 * *(*corner.array())[0].number();
      v += 0.25 * *(*corner.array())[1].number();
    }
    // The AIV's centre is its tag's, black and white; the floor next to the AIV is neither.
    const auto at = [&](double du, double dv) {
      return int{image->at(static_cast<std::size_t>(u + du), static_cast<std::size_t>(v + dv))};
    };
    int darkest = 255;
    int brightest = 0;
    for (int du = -5; du <= 5; ++du) {
      for (int dv = -5; dv <= 5; ++dv) {
        darkest = std::min(darkest, at(du, dv));
        brightest = std::max(brightest, at(du, dv));
      }
    }
    EXPECT_LT(darkest, 60);
    EXPECT_GT(brightest, 120);
  }
}

TEST(GvsCamera, observes_the_centre_of_a_zone_too_large_for_the_image_with_readable_tags) {
  const auto rtm = open_zone(fixture::zones + "plant1000.toml");
  ASSERT_TRUE(rtm);
  const auto camera = EmulatedCamera::over(rtm->zone());
  ASSERT_TRUE(camera);
  const double px_per_m = EmulatedCamera::size_px / camera->width_m();
  EXPECT_GE(px_per_m * camera->tag_side_m(), EmulatedCamera::tag_px_min - 1e-9);
}

TEST(GroundTruth, is_read_from_a_plant_s_message_and_from_no_other) {
  const auto ground_truth = read_plant_ground_truth(
      R"({"timestamp":"2026-01-01T00:00:00.100Z","vehicles":[{"number":2,"x":1,"y":2,"heading":0.5,"speed":0.3}],"obstacles":[]})");
  ASSERT_TRUE(ground_truth);
  EXPECT_EQ(ground_truth->at, parse_iso8601("2026-01-01T00:00:00.100Z").value());
  ASSERT_THAT(ground_truth->vehicles, SizeIs(1));
  EXPECT_EQ(ground_truth->vehicles[0].number, 2U);
  EXPECT_EQ(ground_truth->vehicles[0].X_MB, (Pose2{1.0, 2.0, 0.5}));
  for (const char* other :
       {"", "{}", "[]", R"({"timestamp":"now","vehicles":[]})",
        R"({"timestamp":"2026-01-01T00:00:00Z","vehicles":[{"number":1}]})",
        R"({"timestamp":"2026-01-01T00:00:00Z","vehicles":[{"number":587,"x":1,"y":2,"heading":0,"speed":0}]})",
        R"({"timestamp":"2026-01-01T00:00:00Z","vehicles":[{"number":-1,"x":1,"y":2,"heading":0,"speed":0}]})"})
    EXPECT_FALSE(read_plant_ground_truth(other)) << other;
}

// ---- Images for a loop

struct Fed {
  explicit Fed(std::string folder, double rate_hz = 100.0)
      : feed{loop,
             {[folder = std::move(folder)] { return folder_images(folder, 20.0); }, true, rate_hz},
             {[this](const Frame& frame, SimTime began) {
                names.push_back(frame.name);
                stamps.push_back(began);
              },
              [this](const std::string& why) { troubles.push_back(why); }}} {}
  bool until(const std::function<bool()>& done) { return loop.run_until(done, 10s); }
  adapters::EventLoop loop;
  std::vector<std::string> names;
  std::vector<SimTime> stamps;
  std::vector<std::string> troubles;
  PreviewFeed feed;
};

std::string images_in(const Scratch& scratch, int count) {
  const std::string folder = scratch / "images";
  std::vector<std::pair<std::string, std::string>> files;
  for (int i = 0; i < count; ++i)
    files.emplace_back(std::to_string(i) + ".pgm", write_pgm(vision::Image::filled({32, 32}, 100)));
  EXPECT_TRUE(adapters::write_files(folder, files));
  return folder;
}

TEST(PreviewFeed, delivers_recorded_images_at_their_recorded_rate_and_reports_their_end) {
  const Scratch scratch;
  Fed fed{images_in(scratch, 5)};
  const auto began = std::chrono::steady_clock::now();
  ASSERT_TRUE(fed.until([&] { return !fed.troubles.empty(); }));
  EXPECT_GE(std::chrono::steady_clock::now() - began, 190ms) << "five, a twentieth of a second apart";
  EXPECT_THAT(fed.names, ElementsAre("0.pgm", "1.pgm", "2.pgm", "3.pgm", "4.pgm"));
  EXPECT_NEAR(to_seconds(fed.stamps[4] - fed.stamps[0]), 0.2, 1e-6);
  EXPECT_THAT(fed.troubles, ElementsAre("there are no more images"));
}

TEST(PreviewFeed, drops_images_that_arrive_faster_than_they_are_processed) {
  const Scratch scratch;
  Fed fed{images_in(scratch, 12), 5.0};
  ASSERT_TRUE(fed.until([&] { return !fed.troubles.empty(); }));
  EXPECT_LE(fed.names.size(), 5U);
  EXPECT_GE(fed.names.size(), 3U);
}

TEST(PreviewFeed, reports_why_there_are_no_images_and_delivers_them_once_available) {
  const Scratch scratch;
  Fed fed{scratch / "images"};
  ASSERT_TRUE(fed.until([&] { return !fed.troubles.empty(); }));
  EXPECT_THAT(fed.troubles[0], HasSubstr(scratch / "images"));
  images_in(scratch, 1);
  EXPECT_TRUE(fed.until([&] { return !fed.names.empty(); }));
}

TEST(PreviewFeed, reports_which_image_cannot_be_read) {
  const Scratch scratch;
  const std::string folder = images_in(scratch, 1);
  ASSERT_TRUE(adapters::write_file(folder + "/1.pgm", "P5\n8 8\n255\nshort"));
  Fed fed{folder};
  ASSERT_TRUE(fed.until([&] { return !fed.troubles.empty(); }));
  EXPECT_THAT(fed.troubles[0], HasSubstr("1.pgm"));
}

// ---- Invalid options are reported before anything is started

TEST(GvsWatch, refuses_invalid_input_with_2_and_names_the_option) {
  const Scratch scratch;
  const std::string bad = scratch.write("bad.json", R"({"name":"x"})");
  const std::string folder = images_in(scratch, 1);
  const auto refused = [](std::vector<std::string> arguments, const std::string& standard_error) {
    const auto output = cosiva(arguments);
    EXPECT_EQ(output.status, 2) << output.standard_error;
    EXPECT_THAT(output.standard_error, HasSubstr(standard_error));
  };
  refused({"gvs", "watch", "--images", folder}, "--calibration");
  refused({"gvs", "watch", "--calibration", bad}, "--camera N");
  refused({"gvs", "watch", "--calibration", bad, "--images", folder}, "bad.json");
  refused({"gvs", "watch", "--calibration", scratch / "none.json", "--images", folder}, "none.json");
  refused({"gvs", "watch", "--vehicle", "AIV1"}, "7=CoSiVA/AIV1");
  refused({"gvs", "watch", "--vehicle", "587=CoSiVA/AIV1"}, "from 0 to 586");
  refused({"gvs", "watch", "--vehicle", "1=CoSiVA/AIV1", "--vehicle", "1=CoSiVA/AIV2"}, "two vehicles");
  refused({"gvs", "watch", "--images", folder, "--camera", "0"}, "--camera");
  refused({"gvs", "watch", "--exposure", "4"}, "of a real camera");
  refused({"gvs", "watch", "--rate", "0"}, "--rate");
  refused({"up", "--gvs-camera", "0"}, "--gvs");
  refused({"up", "--gvs", "--gvs-images", folder}, "--gvs-calibration");
  refused({"up", "--gvs", "--virtual-time"}, "live runs only");
}

TEST(GvsWatch, refuses_a_camera_that_is_not_there_and_a_folder_without_images) {
  const Scratch scratch;
  const std::string calibration = scratch / "calibration.json";
  ASSERT_TRUE(adapters::write_file(calibration, vision::to_json(Watched{}.camera.calibration())));
  const auto camera = cosiva({"up", "--gvs", "--gvs-calibration", calibration, "--gvs-camera", "250"});
  EXPECT_EQ(camera.status, 2);
  EXPECT_THAT(camera.standard_error, HasSubstr("/dev/video250: there is no such camera"));
  std::filesystem::create_directories(scratch / "empty");
  const auto empty = cosiva({"gvs", "watch", "--calibration", calibration, "--images", scratch / "empty"});
  EXPECT_EQ(empty.status, 2);
  EXPECT_THAT(empty.standard_error, HasSubstr("contains no images"));
}

}  // namespace
}  // namespace cosiva::app
