#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "cosiva/adapters/files.h"
#include "cosiva/adapters/test_fixture.h"
#include "cosiva/app/command_line_fixture.h"
#include "cosiva/app/gvs/images.h"
#include "cosiva/app/resources/reference_budget.h"
#include "cosiva/base/json_value.h"
#include "cosiva/base/test_paths.h"
#include "cosiva/base/text.h"
#include "cosiva/physical/vision/tags.h"

namespace cosiva::app {
namespace {

using adapters::testing::Scratch;
using fixture::CommandOutput;
using fixture::cosiva;
using ::testing::HasSubstr;

const std::string data = source_dir() + "/src/physical/vision/testdata/";

JsonValue json_of(const CommandOutput& output) {
  auto json = JsonValue::parse(output.data);
  EXPECT_TRUE(json) << output.data << output.standard_error;
  return json ? std::move(*json) : JsonValue{};
}

/// A small control area, drawn once for all tests: four AIVs start and drive for two seconds, stamps 30 ms late.
struct Bay {
  Bay() {
    const CommandOutput output =
        cosiva({"gvs", "render", "--aivs", "4", "--seconds", "2", "--rate", "20", "--size", "1200", "--tag-side", "0.1",
                "--warm-up", "0", "--late", "30", "--out", folder.path(), "--json"});
    EXPECT_EQ(output.status, 0) << output.standard_error;
    scene = json_of(output);
  }
  [[nodiscard]] std::string file(const std::string& name) const { return folder.path() + "/" + name; }
  [[nodiscard]] std::vector<std::string> calibrate(const std::string& out) const {
    return {"gvs", "calibrate",     "--points", file("points.csv"), "--size", "1200x1200", "--camera-height",
            "3.3", "--camera-foot", foot(),     "--tag-height",     "0.1",    "--out",     out};
  }
  [[nodiscard]] std::string foot() const {
    return std::to_string(*scene.number("camera_foot_x_m")) + "," + std::to_string(*scene.number("camera_foot_y_m"));
  }
  Scratch folder;
  JsonValue scene;
};
const Bay& bay() {
  static const Bay bay;
  return bay;
}

// ---- The complete procedure

TEST(Gvs, rendered_calibrated_and_tracked_reports_the_stamps_delay_and_shifts_no_pose) {
  const Scratch out;
  ASSERT_EQ(cosiva(bay().calibrate(out.path() + "/cal")).status, 0);
  const CommandOutput output =
      cosiva({"gvs", "track", "--calibration", out.path() + "/cal/calibration.json", "--images", bay().file("images"),
              "--exposure", "4", "--tag-side", "0.1", "--against", bay().file("ground_truth"), "--out",
              out.path() + "/seen", "--json"});
  ASSERT_EQ(output.status, 0) << output.standard_error;
  const JsonValue json = json_of(output);
  EXPECT_EQ(json.number("fixes"), 160.0);  // four in each of forty
  EXPECT_EQ(json.number("lost"), 0.0);
  const JsonValue& offset = *json.find("time_offset");
  EXPECT_EQ(offset.flag("applied"), false);
  EXPECT_NEAR(offset.number("late_ms").value_or(0.0), 30.0, 3.0);
  // With the delay removed the poses would equal the ground truth; they stay at the camera's stamps.
  for (const JsonValue& vehicle : *offset.find("vehicles")->array()) {
    if (!vehicle.number("late_ms")) continue;
    EXPECT_LE(vehicle.number("rms_without_offset_mm").value_or(9.0), 2.0);
    EXPECT_LE(std::abs(vehicle.number("lever_y_mm").value_or(9.0)), 2.0);
  }
  const std::string other = out.path() + "/other.tum";
  ASSERT_TRUE(adapters::write_file(other, adapters::read_file(out.path() + "/seen/tag_1.tum").value()));
  const CommandOutput compared = cosiva({"compare", "--reference", bay().file("ground_truth/tag_1.tum"), "--estimate",
                                         out.path() + "/seen/tag_1.tum", "--estimate", other});
  EXPECT_EQ(compared.status, 0) << compared.standard_error;
  for (const char* file : {"poses.csv", "timing.csv", "result.json", "tag_4.tum"})
    EXPECT_TRUE(std::filesystem::exists(out.path() + "/seen/" + file)) << file;
}

TEST(Gvs, calibrates_from_tags_on_the_floor) {
  const CommandOutput output =
      cosiva({"gvs", "calibrate", "--board", bay().file("board.csv"), "--images", bay().file("board"), "--json"});
  ASSERT_EQ(output.status, 0) << output.standard_error;
  const JsonValue json = json_of(output);
  const JsonValue& best = json.find("tried")->array()->back();
  EXPECT_GE(best.find("blocks")->number("points").value_or(0.0), 400.0);
  EXPECT_LE(best.find("blocks")->number("rms_mm").value_or(9.0), 1.0);
}

TEST(Gvs, calibrates_a_real_camera_with_its_surveyed_poses) {
  const Scratch out;
  const CommandOutput output = cosiva({"gvs", "calibrate", "--points", data + "cpm-ips/calibration_points.csv",
                                       "--poses", data + "cpm-ips/pose_calibration.txt", "--pose-xs", "0.6,3.9",
                                       "--pose-ys", "0.6,3.4", "--model", "polynomial", "--out", out.path(), "--json"});
  ASSERT_EQ(output.status, 0) << output.standard_error;
  const JsonValue json = json_of(output);
  EXPECT_LE(json.find("poses")->number("rms_mm").value_or(9.0), 1.0);
  EXPECT_LE(json.find("poses")->number("heading_sd_deg").value_or(9.0), 0.25);
  EXPECT_LE(json.find("poses")->number("heading_left_out_deg").value_or(9.0), 0.25);
  for (const char* file : {"calibration.json", "residual_map.svg", "report.html", "result.json"})
    EXPECT_TRUE(std::filesystem::exists(out.path() + "/" + file)) << file;
  // The known parts of the ground truth's uncertainty: the left-out poses yield height and mounting.
  const auto budget = load_reference_budget(out.path() + "/reference_budget.json");
  ASSERT_TRUE(budget) << to_string(budget.error());
  ASSERT_EQ(budget->parts.size(), 4U);
  EXPECT_EQ(budget->parts[0].name, "floor fit");
  EXPECT_NEAR(*budget->parts[0].uncertainty_m, 0.95e-3, 0.05e-3);
  EXPECT_NEAR(*budget->parts[1].uncertainty_m, 0.04e-3, 0.02e-3);
  EXPECT_NEAR(1e3 * *budget->parts[2].uncertainty_m, *json.find("poses")->number("rms_mm"), 1e-12);
  EXPECT_EQ(budget->untold(), 1U);  // the clock
}

TEST(Gvs, calibration_gives_its_own_error_budget_and_names_unknown_parts) {
  const Scratch out;
  std::vector<std::string> standard_error = bay().calibrate(out.path() + "/cal");
  standard_error.insert(standard_error.end(), {"--tag-height-error", "0.002", "--mount-error", "0.003"});
  ASSERT_EQ(cosiva(standard_error).status, 0);
  const auto reported = load_reference_budget(out.path() + "/cal/reference_budget.json");
  const auto alone = load_reference_budget(out.path() + "/cal/calibration.json");
  ASSERT_TRUE(reported && alone);
  const auto part = [](const experiments::ReferenceBudget& budget, const std::string& name) {
    for (const experiments::ReferencePart& one : budget.parts)
      if (one.name == name) return one;
    ADD_FAILURE() << name;
    return experiments::ReferencePart{};
  };
  EXPECT_EQ(*part(*reported, "floor fit").uncertainty_m, *part(*alone, "floor fit").uncertainty_m);
  EXPECT_EQ(*part(*reported, "mounting").uncertainty_m, 0.003);
  // 2 mm of height, 3.2 m below the camera, a metre or two out.
  EXPECT_GT(*part(*reported, "tag height").uncertainty_m, 0.002 * 0.8 / 3.2);
  EXPECT_LT(*part(*reported, "tag height").uncertainty_m, 0.002 * 2.5 / 3.2);
  EXPECT_EQ(reported->untold(), 2U);  // noise of tags, the clock
  EXPECT_EQ(alone->untold(), 4U);     // also height and mounting
  EXPECT_FALSE(part(*alone, "tag height").uncertainty_m);
  EXPECT_NE(part(*alone, "tag height").source.find("1 mm of it would be"), std::string::npos);
}

TEST(Gvs, rendering_gives_the_same_bytes_for_the_same_seed) {
  const auto frame = [](const std::string& seed) {
    const Scratch out;
    EXPECT_EQ(cosiva({"gvs", "render", "--aivs", "2", "--seconds", "0.05", "--size", "256", "--seed", seed, "--out",
                      out.path()})
                  .status,
              0);
    return adapters::read_file(out.path() + "/images/000000.pgm").value();
  };
  const std::string first = frame("3");
  EXPECT_EQ(first, frame("3"));
  EXPECT_NE(first, frame("4"));
}

// ---- Photographs, by OpenCV

/// The centres of the listed corners: "id, (x y), (x y), (x y), (x y)".
std::vector<std::pair<int, vision::PixelPoint>> listed(const std::string& text) {
  std::vector<std::pair<int, vision::PixelPoint>> tags;
  Lines lines{text};
  std::string_view line;
  while (lines.next(line)) {
    if (line.empty()) continue;
    vision::DetectedTag tag;
    EXPECT_EQ(std::sscanf(std::string(line).c_str(), "%d, (%lf %lf), (%lf %lf), (%lf %lf), (%lf %lf)", &tag.id,
                          &tag.corners[0].u, &tag.corners[0].v, &tag.corners[1].u, &tag.corners[1].v, &tag.corners[2].u,
                          &tag.corners[2].v, &tag.corners[3].u, &tag.corners[3].v),
              9)
        << line;
    tags.emplace_back(tag.id, tag.centre());
  }
  return tags;
}

/// The list is an earlier library's own output; 46 of its 47 tags are found by Debian's apriltag 3.3.0. The other tag
/// is found at no size, blur, sharpening or contrast that was tried; this test fails when it is found.
TEST(Photographs, show_all_listed_tags_but_one) {
  const auto is_not_found = [](const std::string& name, vision::PixelPoint position) {
    return name == "34085369442_304b6bafd9_c" && std::abs(position.u - 702.25) < 0.1 &&
           std::abs(position.v - 114.80) < 0.1;
  };
  std::size_t missed = 0;
  for (const std::string name : {"33369213973_9d9bb4cc96_c", "34085369442_304b6bafd9_c", "34139872896_defdb2f8d9_c"}) {
    const auto image = read_image(data + "apriltag/" + name + ".jpg");
    ASSERT_TRUE(image) << to_string(image.error());
    EXPECT_EQ(image->size, (vision::ImageSize{799, 533}));
    const auto found = vision::TagFinder{}.find_all(*image);
    const auto expected = listed(adapters::read_file(data + "apriltag/" + name + ".txt").value());
    ASSERT_GE(expected.size(), 10U);
    for (const auto& [id, position] : expected) {
      bool there = false;
      for (const vision::DetectedTag& tag : found) {
        const vision::PixelPoint centre = tag.centre();
        there =
            there || (tag.id == id && std::abs(centre.u - position.u) < 1.5 && std::abs(centre.v - position.v) < 1.5);
      }
      if (!there) ++missed;
      EXPECT_TRUE(there || is_not_found(name, position))
          << name << ": tag " << id << " at " << position.u << ", " << position.v;
    }
  }
  EXPECT_EQ(missed, 1U);
}

TEST(Photographs, that_are_truncated_or_invalid_are_refused_with_their_name) {
  const Scratch folder;
  const std::string file = folder.path() + "/broken.jpg";
  ASSERT_TRUE(adapters::write_file(file, "no image"));
  const auto image = read_image(file);
  ASSERT_FALSE(image);
  EXPECT_THAT(to_string(image.error()), HasSubstr("broken.jpg: is no image"));
  ASSERT_TRUE(adapters::write_file(file, ""));
  EXPECT_FALSE(read_image(file));
}

// ---- Bad input

TEST(Gvs, refuses_invalid_input_with_2_and_names_what_and_where) {
  const Scratch out;
  const std::string empty = out.path() + "/empty";
  std::filesystem::create_directories(empty);
  ASSERT_TRUE(
      adapters::write_file(out.path() + "/three.csv", "world_x;world_y;image_x;image_y\n0;0;1;1\n1;0;2;1\n0;1;1;2\n"));
  ASSERT_TRUE(adapters::write_file(out.path() + "/cal.json", "{}"));
  struct Case {
    std::vector<std::string> standard_error;
    std::string message;
  };
  const std::vector<Case> cases{
      {{"gvs"}, "a subcommand is missing: calibrate, track, render or watch"},
      {{"gvs", "calibrate"}, "--points FILE, or --board FILE"},
      {{"gvs", "calibrate", "--points", out.path() + "/none.csv"}, "none.csv"},
      {{"gvs", "calibrate", "--points", out.path() + "/three.csv"}, "three.csv: holds 3 points"},
      {{"gvs", "calibrate", "--points", data + "cpm-ips/calibration_points.csv", "--size", "640x480"},
       "lies outside an image of 640x480"},
      {{"gvs", "calibrate", "--points", data + "cpm-ips/calibration_points.csv", "--size", "wide"}, "expected a size"},
      {{"gvs", "calibrate", "--board", bay().file("board.csv")}, "needs --images"},
      {{"gvs", "calibrate", "--board", bay().file("points.csv"), "--images", empty}, "lacks the column 'id'"},
      {{"gvs", "calibrate", "--board", bay().file("board.csv"), "--images", empty}, "contains no images"},
      {{"gvs", "track"}, "--calibration is required"},
      {{"gvs", "track", "--calibration", out.path() + "/cal.json", "--images", empty},
       "cal.json: expected a JSON object"},
      {{"gvs", "render", "--aivs", "80", "--out", empty}, "has room for"},
      {{"gvs", "render", "--zone", "nowhere", "--out", empty}, "nowhere"},
      {{"gvs", "render", "--tag-height", "5", "--out", empty}, "lies not below the camera"},
  };
  for (const Case& one : cases) {
    const CommandOutput output = cosiva(one.standard_error);
    EXPECT_EQ(output.status, 2) << one.message;
    EXPECT_THAT(output.standard_error, HasSubstr(one.message));
  }
}

TEST(Gvs, tracking_refuses_bad_folders_and_images) {
  const Scratch out;
  ASSERT_EQ(cosiva(bay().calibrate(out.path())).status, 0);
  const std::string images = out.path() + "/images";
  std::filesystem::create_directories(images);
  const auto track = [&] {
    return cosiva({"gvs", "track", "--calibration", out.path() + "/calibration.json", "--images", images});
  };
  EXPECT_THAT(track().standard_error, HasSubstr("contains no images"));
  ASSERT_TRUE(adapters::write_file(images + "/a.pgm", "P5\n1200 1200\n255\ntoo short"));
  CommandOutput output = track();
  EXPECT_EQ(output.status, 2);
  EXPECT_THAT(output.standard_error, HasSubstr("a.pgm: ends too early"));
  ASSERT_TRUE(adapters::write_file(images + "/a.pgm", write_pgm(vision::Image::filled({64, 64}, 7))));
  EXPECT_THAT(track().standard_error, HasSubstr("a.pgm: is 64 x 64 pixels large"));
  ASSERT_TRUE(adapters::write_file(images + "/a.pgm", write_pgm(vision::Image::filled({1200, 1200}, 7))));
  output = track();
  EXPECT_EQ(output.status, 1);
  EXPECT_THAT(output.standard_error, HasSubstr("no vehicle was detected"));
  ASSERT_TRUE(adapters::write_file(images + "/stamps.csv", "file,stamp_s\nb.pgm,0\n"));
  EXPECT_THAT(track().standard_error, HasSubstr("has no stamp for"));
  ASSERT_TRUE(adapters::write_file(images + "/stamps.csv", "file,stamp_s\na.pgm,soon\n"));
  EXPECT_THAT(track().standard_error, HasSubstr("stamps.csv:2: expected 'file,stamp_s'"));
}

}  // namespace
}  // namespace cosiva::app
