// The options of `cosiva gvs`, with their help texts.
#include "cosiva/app/gvs/command_line_gvs.h"

#include "cosiva/app/cli/common_options.h"
#include "cosiva/physical/vision/calibration.h"
#include "cosiva/physical/vision/tags.h"

namespace cosiva::app {
namespace {

constexpr const char* examples =
    "Examples, the complete procedure without a camera:\n"
    "  cosiva gvs render --zone lacet4 --aivs 20 --out bay                 images, floor points, and the ground truth\n"
    "  cosiva gvs calibrate --points bay/points.csv --camera-height 3.3 --camera-foot 0,0 --tag-height 0.1 --out cal\n"
    "  cosiva gvs track --calibration cal/calibration.json --images bay/images --exposure 4 --tag-side 0.08 "
    "--against bay/ground_truth --out seen\n"
    "  cosiva compare --reference seen/tag_1.tum --estimate my_estimate.tum\n"
    "\n"
    "by a vehicle at surveyed poses, a grid of 2 x 2 positions with eight headings each:\n"
    "  cosiva gvs calibrate --points floor.csv --poses stands.txt --pose-xs 0.6,3.9 --pose-ys 0.6,3.4 --out cal\n"
    "\n"
    "and on a running platform:\n"
    "  cosiva up --gvs\n"
    "  cosiva up --gvs --gvs-camera 0 --gvs-calibration cal/calibration.json --gvs-exposure 4 --gvs-tag-side 0.08\n"
    "\n"
    "docs/guide/gvs.md explains the procedure with a real camera.";

void describe_render(Command command, GvsRenderArguments& a) {
  command.add_option("--zone", a.zone, "where the AIVs drive: a ready zone's name or a file")
      .value_name("NAME|FILE")
      .show_default();
  command.add_option("--aivs", a.aivs, "how many; AIV n carries tag n of family 36h11")
      .value_name("N")
      .in_range(1, 80)
      .show_default();
  command.add_option("--warm-up", a.warm_up_s, "seconds of driving that are not rendered; all AIVs start at standstill")
      .value_name("S")
      .in_range(0.0, 3600.0)
      .show_default();
  command.add_option("--seconds", a.seconds, "of driving").value_name("S").in_range(0.001, 3600.0).show_default();
  command.add_option("--rate", a.rate_hz, "images per second").value_name("HZ").in_range(5.0, 1000.0).show_default();
  command.add_option("--size", a.size_px, "width and height of the images")
      .value_name("PX")
      .in_range(128, 8192)
      .show_default();
  command.add_option("--height", a.height_m, "of the camera above the floor")
      .value_name("M")
      .in_range(0.5, 100.0)
      .show_default();
  command.add_option("--tag-height", a.tag_height_m, "of the tags above the floor")
      .value_name("M")
      .in_range(0.0, 10.0)
      .show_default();
  command.add_option("--tag-side", a.tag_side_m, "of the tags' black square")
      .value_name("M")
      .in_range(0.01, 5.0)
      .show_default();
  command.add_option("--exposure", a.exposure_ms, "motion during the exposure is blurred")
      .value_name("MS")
      .in_range(0.0, 1000.0)
      .show_default();
  command
      .add_option("--rolling", a.rolling_ms,
                  "rolling shutter: from the first row's beginning to the last one's; 0: global")
      .value_name("MS")
      .in_range(0.0, 1000.0)
      .show_default();
  command.add_option("--noise", a.noise_grey, "standard deviation of a pixel, in grey levels")
      .value_name("GREY")
      .in_range(0.0, 100.0)
      .show_default();
  command.add_option("--brightness", a.brightness, "of the light; 1: white paper is 215 of 255")
      .value_name("RATIO")
      .in_range(0.01, 10.0)
      .show_default();
  command.add_option("--late", a.late_ms, "delay of the stamps, for trying `track --against`")
      .value_name("MS")
      .in_range(-1000.0, 1000.0)
      .show_default();
  command.add_option("--seed", a.seed, "of noise and floor: the same seed, the same bytes")
      .value_name("S")
      .show_default();
  command.add_option("--out", a.out_folder, "writes pictures/, board/, board.csv, points.csv, truth/")
      .value_name("DIR")
      .required();
  command.add_flag("--json", a.json, "print what was made as JSON");
}

void describe_calibrate(Command command, GvsCalibrateArguments& a) {
  const Option points =
      command
          .add_option("--points", a.points_file, "floor points: CSV with world_x; world_y [m]; image_x; image_y [px]")
          .value_name("FILE");
  command.add_option("--board", a.board_file, "tags on the floor: CSV with id; x; y; heading_deg; side [m]")
      .value_name("FILE")
      .excludes(points);
  command.add_option("--images", a.images_folder, "images of those tags").value_name("DIR");
  command
      .add_option("--size", a.size, "of the images that the points were read from; a board's images contain their size")
      .value_name("WxH")
      .show_default();
  command.add_option("--model", a.model, "of the floor; best: the model whose left-out blocks fit best")
      .one_of({"best", "homography", "lens", "polynomial", "lens_polynomial"})
      .show_default();
  command.add_option("--degree", a.degree, "of a polynomial")
      .value_name("N")
      .in_range(std::size_t{2}, vision::degree_max)
      .show_default();
  command.add_option("--block", a.block_m, "side of the squares of floor that are left out in turn")
      .value_name("M")
      .in_range(0.01, 1000.0)
      .show_default();
  command
      .add_option("--camera-height", a.camera_height_m,
                  "above the floor, by a tape measure; without: no tag is corrected")
      .value_name("M")
      .in_range(0.1, 1000.0);
  command
      .add_option("--camera-foot", a.camera_foot_m,
                  "the position vertically below it, by a plumb line; without: computed")
      .value_name("X,Y")
      .separator(',')
      .value_count(2);
  command.add_option("--tag-height", a.tag_height_m, "of the vehicles' tags above the floor")
      .value_name("M")
      .in_range(0.0, 100.0);
  command
      .add_option("--tag-height-error", a.tag_height_error_m,
                  "standard deviation of that height, for reference_budget.json")
      .value_name("M")
      .in_range(0.0, 1.0);
  command.add_option("--mount-error", a.mount_error_m, "standard deviation of the tag's position on its vehicle")
      .value_name("M")
      .in_range(0.0, 1.0);
  command.add_option("--mount", a.mount, "the tag's pose on its vehicle: x forward, y left [m], heading [degrees]")
      .value_name("X,Y,DEG")
      .separator(',')
      .value_count(3);
  command
      .add_option(
          "--poses", a.poses_file,
          "a vehicle at surveyed poses: CSV true_x; true_y; true_heading_deg; seen_x; seen_y; seen_heading_deg, or, "
          "with --pose-xs, samples x, y, cos, sin, 1, one pose after the other")
      .value_name("FILE");
  command.add_option("--pose-xs", a.pose_xs_m, "of a grid of poses: y slowest, then x, heading fastest")
      .value_name("X,X")
      .separator(',');
  command.add_option("--pose-ys", a.pose_ys_m, "of that grid").value_name("Y,Y").separator(',');
  command.add_option("--pose-headings", a.pose_headings, "of that grid, evenly round from 0")
      .value_name("N")
      .in_range(1, 360)
      .show_default();
  command.add_option("--name", a.name, "of the camera").value_name("TEXT");
  command.add_option("--out", a.out_folder, "writes calibration.json, residual_map.svg, report.html").value_name("DIR");
  command.add_flag("--json", a.json, "print the metrics as JSON");
}

void describe_track(Command command, GvsTrackArguments& a) {
  command.add_option("--calibration", a.calibration_file, "what `gvs calibrate` wrote").value_name("FILE").required();
  const Option images =
      command
          .add_option("--images", a.images_folder,
                      "images in the order of their names, with stamps.csv (file,stamp_s) if there is one")
          .value_name("DIR");
  const Option video = command.add_option("--video", a.video_file, "a video file").value_name("FILE").excludes(images);
  command.add_option("--camera", a.camera, "a camera: N of /dev/videoN")
      .value_name("N")
      .in_range(0, 255)
      .excludes(images)
      .excludes(video);
  command.add_option("--rate", a.rate_hz, "images per second of a folder without stamps")
      .value_name("HZ")
      .in_range(1e-3, 1e5)
      .show_default();
  command.add_option("--image-count", a.images_max, "maximum number of images; 0: all").value_name("N").show_default();
  command.add_option("--exposure", a.exposure_ms, "of a row: fixes are stamped at mid-exposure")
      .value_name("MS")
      .in_range(0.0, 1000.0)
      .show_default();
  command.add_option("--line", a.line_us, "rolling shutter: from a row's beginning to the next one's")
      .value_name("US")
      .in_range(0.0, 1e5)
      .show_default();
  command
      .add_option("--tag-side", a.tag_side_m, "of the black square; tags of other sizes are not vehicles. Without: any")
      .value_name("M")
      .in_range(0.005, 10.0);
  command
      .add_option("--expect", a.expected, "tags of the vehicles; the search pauses while all are tracked. Without: any")
      .value_name("N,N")
      .separator(',')
      .in_range(0, vision::tags_in_family - 1);
  command
      .add_option("--against", a.against,
                  "a trajectory of one vehicle, or a folder of tag_N.tum: estimates the delay of the camera's stamps; "
                  "no pose is "
                  "shifted by it. May be repeated")
      .value_name("N=FILE|DIR")
      .one_value_each();
  command.add_option("--out", a.out_folder, "writes poses.csv, tag_N.tum, timing.csv, result.json").value_name("DIR");
  command.add_flag("--json", a.json, "print the metrics as JSON");
}

/// The options in common with the platform's other parts; the camera records no journal, because it decides
/// nothing.
void add_watch_part(Command command, PartArguments& part) {
  add_broker(command, part.broker, "127.0.0.1:1883");
  command.add_option("--duration", part.duration_s, "end after this number of seconds")
      .value_name("S")
      .in_range(0.001, 1e9);
  command.add_flag("--json", part.json, "print the number of detections at the end as JSON");
  command.add_flag("--announce", part.announce).hidden();
}

constexpr const char* watch_examples =
    "Examples:\n"
    "  cosiva gvs watch --broker 127.0.0.1:1883             the emulated world's camera, with a running plant\n"
    "  cosiva gvs watch --camera 0 --calibration cal/calibration.json --exposure 4 --tag-side 0.08 --vehicle "
    "12=CoSiVA/AIV1";

}  // namespace

void add_gvs_source(Command command, GvsSource& source, const std::string& prefix) {
  command.add_option(prefix + "calibration", source.calibration_file, "of a real camera: what `gvs calibrate` wrote")
      .value_name("FILE");
  const Option images =
      command
          .add_option(prefix + "images", source.images_folder,
                      "images in the order of their names, with stamps.csv, shown once at their recorded rate")
          .value_name("DIR");
  const Option video =
      command.add_option(prefix + "video", source.video_file, "a video file, shown once at its recorded rate")
          .value_name("FILE")
          .excludes(images);
  command.add_option(prefix + "camera", source.camera, "a camera: N of /dev/videoN")
      .value_name("N")
      .in_range(0, 255)
      .excludes(images)
      .excludes(video);
  command.add_option(prefix + "rate", source.rate_hz, "number of images that are processed per second")
      .value_name("HZ")
      .in_range(0.1, 100.0)
      .show_default();
  command.add_option(prefix + "exposure", source.exposure_ms, "of a row: vehicles are stamped at mid-exposure")
      .value_name("MS")
      .in_range(0.0, 1000.0);
  command.add_option(prefix + "line", source.line_us, "rolling shutter: from a row's beginning to the next one's")
      .value_name("US")
      .in_range(0.0, 1e5);
  command
      .add_option(prefix + "tag-side", source.tag_side_m, "of the black square; tags of other sizes are not vehicles")
      .value_name("M")
      .in_range(0.005, 10.0);
  command
      .add_option(prefix + "vehicle", source.vehicles,
                  "vehicle of a tag, such as 7=CoSiVA/AIV1; without: tag n is CoSiVA/AIVn's. May be repeated")
      .value_name("TAG=NAME")
      .one_value_each();
}

GvsCommands describe_gvs(Command root, GvsArguments& gvs) {
  GvsCommands commands{};
  commands.gvs = root.add_subcommand("gvs", "Global vision: the vehicles' actual positions, by a camera over the zone");
  commands.calibrate =
      commands.gvs.add_subcommand("calibrate", "Fit lens and floor, evaluated by points that were left out of the fit");
  commands.track = commands.gvs.add_subcommand("track", "Track vehicles by their tags, in images, a video or a camera");
  commands.render = commands.gvs.add_subcommand("render", "Render images of the emulated world, with the ground truth");
  commands.watch = commands.gvs.add_subcommand(
      "watch", "Watch a running platform, and publish each vehicle's actual position; `cosiva up --gvs` runs it");
  commands.gvs.at_most_one_subcommand();
  add_gvs_source(commands.watch, gvs.watch.source, "--");
  add_watch_part(commands.watch, gvs.watch.part);
  describe_calibrate(commands.calibrate, gvs.calibrate);
  describe_track(commands.track, gvs.track);
  describe_render(commands.render, gvs.render);
  for (const Command command : {commands.gvs, commands.calibrate, commands.track, commands.render})
    command.footer(examples);
  commands.watch.footer(watch_examples);
  return commands;
}

std::optional<int> run_gvs_command(const GvsCommands& commands, const GvsArguments& gvs) {
  if (commands.calibrate.chosen()) return run_gvs_calibrate(gvs.calibrate);
  if (commands.track.chosen()) return run_gvs_track(gvs.track);
  if (commands.render.chosen()) return run_gvs_render(gvs.render);
  if (commands.watch.chosen()) return run_gvs_watch(gvs.watch);
  return std::nullopt;
}

}  // namespace cosiva::app
