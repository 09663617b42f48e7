#include "cosiva/app/gvs/gvs_track_command.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <map>
#include <optional>

#include "cosiva/adapters/files.h"
#include "cosiva/app/cli/console.h"
#include "cosiva/app/cli/progress.h"
#include "cosiva/app/gvs/images.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/base/text.h"
#include "cosiva/experiments/positioning/recording/trajectory.h"
#include "cosiva/physical/vision/calibration_json.h"
#include "cosiva/physical/vision/time_offset.h"
#include "cosiva/physical/vision/tracker.h"

namespace cosiva::app {
namespace {

struct Timing {
  std::string frame;
  double stamp_s;
  std::size_t fixes;
  double took_ms;  ///< processor time
};

struct Tracked {
  std::map<int, std::vector<vision::Fix>> fixes;
  std::vector<Timing> timing;
  vision::Tracker::Metrics metrics;
  double uncertainty_mean_m{0.0};
};

double processor_ms() { return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

Result<std::unique_ptr<ImageSource>> source_of(const GvsTrackArguments& a) {
  if (!a.images_folder.empty()) return folder_images(a.images_folder, a.rate_hz);
  if (!a.video_file.empty()) return video_images(a.video_file);
  if (a.camera) return camera_images(*a.camera);
  return fail("gvs.images", "the source of the images is missing: --images DIR, --video FILE or --camera N",
              "gvs track");
}

Result<Tracked> track(const GvsTrackArguments& a, const vision::Calibration& calibration, ImageSource& images) {
  vision::TrackerOptions options;
  options.exposure_s = 1e-3 * a.exposure_ms;
  options.line_s = 1e-6 * a.line_us;
  options.side_m = a.tag_side_m;
  options.expected = a.expected;
  vision::Tracker tracker{calibration, options};
  Tracked tracked;
  SecondsTicker ticker;
  while (a.images_max == 0 || tracked.timing.size() < a.images_max) {
    auto frame = images.next();
    if (!frame) return tl::unexpected(frame.error());
    if (!*frame) break;
    const double began_ms = processor_ms();
    const auto fixes = tracker.see((*frame)->image, (*frame)->stamp_s);
    if (!fixes) {
      Error error = fixes.error();
      error.location = (*frame)->name;
      return tl::unexpected(error);
    }
    tracked.timing.push_back({(*frame)->name, (*frame)->stamp_s, fixes->size(), processor_ms() - began_ms});
    for (const vision::Fix& fix : *fixes) {
      tracked.fixes[fix.tag].push_back(fix);
      tracked.uncertainty_mean_m += fix.uncertainty_m;
    }
    if (ticker.ticks()) print_info("cosiva: " + std::to_string(tracked.timing.size()) + " images");
  }
  tracked.metrics = tracker.metrics();
  if (tracked.metrics.fixes > 0) tracked.uncertainty_mean_m /= static_cast<double>(tracked.metrics.fixes);
  return tracked;
}

struct Offset {
  int tag;
  Result<vision::TimeOffset> found;
};

Result<std::vector<vision::Timed>> reference_of(const std::string& file) {
  const auto text = adapters::read_file(file);
  if (!text) return tl::unexpected(text.error());
  const auto trajectory = experiments::read_trajectory(file, *text);
  if (!trajectory) return tl::unexpected(trajectory.error());
  std::vector<vision::Timed> timed;
  for (const experiments::Stamped& pose : trajectory->poses) timed.push_back({pose.t_s, pose.pose()});
  return timed;
}

/// The file of each tag's reference.
Result<std::map<int, std::string>> references_of(const GvsTrackArguments& a, const Tracked& tracked) {
  std::map<int, std::string> files;
  for (const std::string& against : a.against) {
    std::error_code error;
    if (std::filesystem::is_directory(against, error)) {
      for (const auto& [tag, fixes] : tracked.fixes) {
        const std::string file = against + "/tag_" + std::to_string(tag) + ".tum";
        if (std::filesystem::exists(file, error)) files[tag] = file;
      }
      continue;
    }
    const std::size_t equals = against.find('=');
    const auto tag = number_of<int>(std::string_view{against}.substr(0, equals));
    if (equals == std::string::npos || !tag)
      return fail("gvs.against", "expected TAG=FILE or a folder of tag_N.tum, found '" + against + "'", "--against");
    if (!tracked.fixes.contains(*tag))
      return fail("gvs.against", "tag " + std::to_string(*tag) + " was never detected", "--against");
    files[*tag] = against.substr(equals + 1);
  }
  if (files.empty() && !a.against.empty())
    return fail("gvs.against", "holds no tag_N.tum of a detected tag", a.against[0]);
  return files;
}

Result<std::vector<Offset>> offsets_of(const GvsTrackArguments& a, const Tracked& tracked) {
  const auto files = references_of(a, tracked);
  if (!files) return tl::unexpected(files.error());
  std::vector<Offset> offsets;
  for (const auto& [tag, file] : *files) {
    const auto reference = reference_of(file);
    if (!reference) return tl::unexpected(reference.error());
    std::vector<vision::Timed> detected;
    for (const vision::Fix& fix : tracked.fixes.at(tag)) detected.push_back({fix.t_s, fix.X_MB});
    offsets.push_back({tag, vision::time_offset(detected, *reference)});
  }
  return offsets;
}

/// The mean offset of all vehicles, weighted by certainty; nothing where no offset could be estimated.
std::optional<std::pair<double, double>> mean_offset(const std::vector<Offset>& offsets) {
  double weights = 0.0;
  double sum = 0.0;
  for (const Offset& offset : offsets) {
    if (!offset.found) continue;
    const double sd = std::max(1e-5, offset.found->standard_error_s);
    weights += 1.0 / (sd * sd);
    sum += offset.found->offset_s / (sd * sd);
  }
  if (weights == 0.0) return std::nullopt;
  return std::pair{sum / weights, 1.0 / std::sqrt(weights)};
}

double median_ms(const std::vector<Timing>& timing) {
  if (timing.empty()) return 0.0;
  std::vector<double> all;
  all.reserve(timing.size());
  for (const Timing& one : timing) all.push_back(one.took_ms);
  std::ranges::nth_element(all, all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2));
  return all[all.size() / 2];
}

std::string json_of(const Tracked& tracked, const std::vector<Offset>& offsets) {
  JsonWriter json{2};
  json.begin_object().field("images", tracked.metrics.images).field("fixes", tracked.metrics.fixes);
  json.field("lost", tracked.metrics.lost).field("strange", tracked.metrics.strange);
  json.field("median_ms", median_ms(tracked.timing)).field("uncertainty_mean_mm", 1e3 * tracked.uncertainty_mean_m);
  json.key("vehicles").begin_array();
  for (const auto& [tag, fixes] : tracked.fixes)
    json.begin_object().field("tag", tag).field("fixes", fixes.size()).end_object();
  json.end_array().key("time_offset").begin_object().field("applied", false);
  const auto mean = mean_offset(offsets);
  json.key("late_ms");
  mean ? json.value(1e3 * mean->first) : json.null();
  json.key("standard_error_ms");
  mean ? json.value(1e3 * mean->second) : json.null();
  json.key("vehicles").begin_array();
  for (const Offset& offset : offsets) {
    json.begin_object().field("tag", offset.tag);
    if (offset.found) {
      json.field("late_ms", 1e3 * offset.found->offset_s)
          .field("standard_error_ms", 1e3 * offset.found->standard_error_s);
      json.field("rms_mm", 1e3 * offset.found->before_rms_m)
          .field("rms_without_offset_mm", 1e3 * offset.found->after_rms_m);
      json.field("lever_x_mm", 1e3 * offset.found->lever.x_m).field("lever_y_mm", 1e3 * offset.found->lever.y_m);
    } else {
      json.field("why_not", offset.found.error().message);
    }
    json.end_object();
  }
  json.end_array().end_object().end_object();
  return json.take();
}

std::string text_of(const Tracked& tracked, const std::vector<Offset>& offsets) {
  std::string text = std::to_string(tracked.fixes.size()) + " vehicles, " + std::to_string(tracked.metrics.fixes) +
                     " fixes in " + std::to_string(tracked.metrics.images) + " images; " +
                     decimals(median_ms(tracked.timing), 1) + " ms of processor time per image (median)\n";
  text += "uncertainty " + decimals(1e3 * tracked.uncertainty_mean_m, 2) + " mm on average (calibration and tags); " +
          std::to_string(tracked.metrics.lost) + " times a vehicle was lost, " +
          std::to_string(tracked.metrics.strange) + " false tags";
  if (const auto mean = mean_offset(offsets)) {
    text += "\nstamps are delayed by " + decimals(1e3 * mean->first, 2) + " ± " + decimals(1e3 * mean->second, 2) +
            " ms against the references; not applied: poses are as the camera stamped them";
  }
  for (const Offset& offset : offsets) {
    text += "\n  tag " + std::to_string(offset.tag) + ": ";
    text +=
        offset.found
            ? decimals(1e3 * offset.found->offset_s, 2) + " ± " + decimals(1e3 * offset.found->standard_error_s, 2) +
                  " ms; off by " + decimals(1e3 * offset.found->before_rms_m, 2) + " mm rms, " +
                  decimals(1e3 * offset.found->after_rms_m, 2) + " with the delay removed; lever " +
                  decimals(1e3 * offset.found->lever.x_m, 1) + ", " + decimals(1e3 * offset.found->lever.y_m, 1) + " mm"
            : offset.found.error().message;
  }
  return text;
}

std::string number(double value) {
  JsonWriter json;
  return json.value(value).take();
}

Result<void> write_all(const std::string& folder, const Tracked& tracked, const std::string& result) {
  std::string poses = "t_s,tag,x_m,y_m,heading_rad,uncertainty_m,image_x_px,image_y_px\n";
  std::vector<std::pair<std::string, std::string>> files;
  for (const auto& [tag, fixes] : tracked.fixes) {
    experiments::Trajectory trajectory{"tag_" + std::to_string(tag), {}};
    for (const vision::Fix& fix : fixes) {
      // Two rows of a rolling shutter may have the same time; a trajectory's stamps must rise.
      if (!trajectory.poses.empty() && !(fix.t_s > trajectory.poses.back().t_s)) continue;
      trajectory.poses.push_back(experiments::stamped(fix.t_s, fix.X_MB));
      poses += number(fix.t_s) + "," + std::to_string(tag) + "," + number(fix.X_MB.x_m) + "," + number(fix.X_MB.y_m) +
               "," + number(fix.X_MB.heading_rad) + "," + number(fix.uncertainty_m) + "," + number(fix.centre.u) + "," +
               number(fix.centre.v) + "\n";
    }
    files.emplace_back(trajectory.name + ".tum", experiments::write_tum(trajectory));
  }
  std::string timing = "image,stamp_s,fixes,processor_ms\n";
  for (const Timing& one : tracked.timing)
    timing +=
        one.frame + "," + number(one.stamp_s) + "," + std::to_string(one.fixes) + "," + number(one.took_ms) + "\n";
  files.emplace_back("poses.csv", poses);
  files.emplace_back("timing.csv", timing);
  files.emplace_back("result.json", result + "\n");
  return adapters::write_files(folder, files);
}

}  // namespace

int run_gvs_track(const GvsTrackArguments& a) {
  const auto text = adapters::read_file(a.calibration_file);
  if (!text) return report_error(text.error());
  const auto calibration = vision::read_calibration(*text, a.calibration_file);
  if (!calibration) return report_error(calibration.error());
  auto images = source_of(a);
  if (!images) return report_error(images.error());
  const auto tracked = track(a, *calibration, **images);
  if (!tracked) return report_error(tracked.error());
  const auto offsets = offsets_of(a, *tracked);
  if (!offsets) return report_error(offsets.error());
  const std::string result = json_of(*tracked, *offsets);
  if (!a.out_folder.empty()) {
    if (auto written = write_all(a.out_folder, *tracked, result); !written) return report_error(written.error());
    print_info("written into " + a.out_folder);
  }
  print(a.json ? result : text_of(*tracked, *offsets));
  // The run's own check: images without a vehicle prove nothing.
  if (tracked->metrics.fixes == 0) {
    print_info("cosiva: no vehicle was detected in any image");
    return exit_check_failed;
  }
  return exit_done;
}

}  // namespace cosiva::app
