#include "cosiva/app/positioning/qualify_runs.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "cosiva/adapters/files.h"
#include "cosiva/app/cli/console.h"
#include "cosiva/app/positioning/loop_track.h"
#include "cosiva/experiments/positioning/metrology/simulate.h"
#include "cosiva/experiments/positioning/recording/recording.h"
#include "cosiva/experiments/positioning/recording/replayed.h"

namespace cosiva::app {
namespace {

using experiments::Simulation;
using experiments::Trial;

/// The centre line of each of the zone's sections: straights by their ends, others with a resolution sufficient for a
/// page.
std::vector<std::vector<Point2>> lines_of(const zone::TrafficZone& zone) {
  constexpr double apart_m = 0.1;
  constexpr double most = 200.0;
  std::vector<std::vector<Point2>> lines;
  for (zone::SectionId id = 0; id < zone.circuit.size(); ++id) {
    const zone::Section& section = zone.circuit.section(id);
    const bool straight = section.kind() == zone::SectionKind::straight;
    const double pieces = straight ? 1.0 : std::clamp(std::ceil(section.length_m() / apart_m), 1.0, most);
    std::vector<Point2>& line = lines.emplace_back();
    for (double i = 0.0; i <= pieces; i += 1.0)
      line.push_back(position(section.pose_at(i / pieces * section.length_m())));
  }
  return lines;
}

Result<void> lay_fiducials(const QualifyArguments& arguments, const LoopTrack& loop, Simulation& simulation) {
  if (arguments.fiducials == "pitch") return {};
  if (arguments.fiducials == "tags") {
    simulation.fiducials = experiments::fiducials_of(*loop.track, *loop.zone);
  } else if (loop.zone->beacons) {
    simulation.fiducials = experiments::fiducials_of(*loop.track, *loop.zone->beacons, arguments.reach_m);
  }
  if (!simulation.fiducials.empty()) return {};
  return fail("simulation.fiducials",
              "the path passes over none of its " + arguments.fiducials +
                  (arguments.fiducials == "beacons" ? " within " + decimals(1e3 * arguments.reach_m, 1) + " mm" : ""),
              loop.zone->name);
}

experiments::Conditions conditions_of(const QualifyArguments& arguments, const LoopTrack& loop,
                                      const Simulation& simulation) {
  const auto mm = [](double metres) { return decimals(1e3 * metres, 2) + " mm"; };
  experiments::Conditions conditions{arguments.command, "virtual time on " + loop.zone->name, {}, {}};
  auto& settings = conditions.settings;
  settings.emplace_back("zone", loop.zone->name);
  settings.emplace_back("distance of each run", decimals(arguments.distance_m, 1) + " m");
  settings.emplace_back("fiducials", arguments.fiducials == "pitch"
                                         ? "one every " + decimals(arguments.pitch_m, 3) + " m of the path"
                                         : std::to_string(simulation.fiducials.size()) + " " + arguments.fiducials +
                                               " per loop of " + decimals(loop.track->length_m(), 2) + " m");
  settings.emplace_back("odometry", mm(arguments.odometry_m) + " after 1 m, " + decimals(arguments.rate_hz, 1) + " Hz");
  settings.emplace_back("reading", mm(arguments.reading_m));
  settings.emplace_back("missed", decimals(100.0 * arguments.missed, 1) + " %");
  settings.emplace_back("scale error", decimals(100.0 * arguments.scale, 2) + " %");
  settings.emplace_back("survey error", mm(arguments.survey_m));
  settings.emplace_back("speed", decimals(arguments.speed_mps, 2) + " m/s");
  settings.emplace_back("seeds", "from " + std::to_string(arguments.seed));
  conditions.lines = lines_of(*loop.zone);
  return conditions;
}

/// The files of a folder that a recording may consist of.
Result<experiments::RecordingFiles> files_of(const std::string& folder) {
  std::error_code error;
  experiments::RecordingFiles files;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    if (!entry.is_regular_file() || !(name.ends_with(".csv") || name.ends_with(".txt"))) continue;
    auto bytes = adapters::read_file(entry.path().string());
    if (!bytes) return tl::unexpected(bytes.error());
    files[name] = std::move(*bytes);
  }
  if (error) return fail("recording.folder", "cannot read the folder: " + error.message(), folder);
  return files;
}

Result<Trial> trial_of(const std::string& folder, const QualifyArguments& arguments,
                       const std::optional<LoopTrack>& loop, experiments::Conditions& conditions) {
  const auto files = files_of(folder);
  if (!files) return tl::unexpected(files.error());
  const auto recording = experiments::read_recording(folder, *files);
  if (!recording) {
    // Several folders may contain files of the same names.
    Error error = recording.error();
    if (!error.location.starts_with(folder)) error.location = (std::filesystem::path(folder) / error.location).string();
    return tl::unexpected(std::move(error));
  }
  auto trial = experiments::replayed(*recording, {arguments.gap_s, 0.05, 0.05});
  if (!trial) return trial;
  for (const std::string& diagnostic : recording->diagnostics) {
    std::string inputs = std::string(folder).append(": ").append(diagnostic).append(".");
    // Diagnostics of a recording are also printed: they may indicate errors in the files.
    print_info("cosiva: " + inputs);
    conditions.diagnostics.push_back(std::move(inputs));
  }
  if (loop) {
    trial->setting.track = loop->track;
    const auto along_m = loop->track->foot(position(trial->setting.start), 0.5 * loop->track->length_m(),
                                           0.5 * loop->track->length_m(), 0.5);
    if (!along_m) return fail("recording.line", "the recording does not begin on the zone's loop", folder);
    trial->setting.start_along_m = *along_m;
  }
  return trial;
}

}  // namespace

Result<Runs> virtual_runs(const QualifyArguments& arguments) {
  auto loop = loop_of(arguments.zone.empty() ? "lacet4" : arguments.zone);
  if (!loop) return tl::unexpected(loop.error());
  auto kept = std::make_shared<Simulation>();
  Simulation& simulation = *kept;
  simulation.track = loop->track;
  simulation.distance_m = arguments.distance_m;
  simulation.speed_mps = arguments.speed_mps;
  simulation.odometry_hz = arguments.rate_hz;
  simulation.pitch_m = arguments.pitch_m;
  simulation.read_ratio = 1.0 - arguments.missed;
  simulation.survey_sigma_m = arguments.survey_m;
  simulation.scale_sigma = arguments.scale;
  simulation.sensors.distance_variance_per_m = arguments.odometry_m * arguments.odometry_m;
  simulation.sensors.fiducial_along_sigma_m = simulation.sensors.fiducial_across_sigma_m = arguments.reading_m;
  if (auto laid = lay_fiducials(arguments, *loop, simulation); !laid) return tl::unexpected(laid.error());
  if (auto fine = experiments::check(simulation); !fine) return tl::unexpected(fine.error());
  Runs runs;
  runs.count = arguments.runs;
  runs.on_track = true;
  runs.conditions = conditions_of(arguments, *loop, simulation);
  runs.source = [kept = kept.get(), seed = arguments.seed](std::size_t index, Trial& room) -> Result<const Trial*> {
    experiments::simulate(*kept, seed + index, room);
    return &room;
  };
  runs.kept = std::move(kept);
  return runs;
}

Result<Runs> recorded_runs(const QualifyArguments& arguments) {
  std::optional<LoopTrack> loop;
  if (!arguments.zone.empty()) {
    auto found = loop_of(arguments.zone);
    if (!found) return tl::unexpected(found.error());
    loop = std::move(*found);
  }
  Runs runs;
  runs.conditions = {arguments.command, arguments.recordings.size() == 1 ? "a recording" : "recordings", {}, {}};
  if (loop) runs.conditions.lines = lines_of(*loop->zone);
  auto trials = std::make_shared<std::vector<Trial>>();
  for (const std::string& folder : arguments.recordings) {
    auto trial = trial_of(folder, arguments, loop, runs.conditions);
    if (!trial) return tl::unexpected(trial.error());
    const auto& sensors = trial->setting.sensors;
    runs.conditions.settings.emplace_back(folder, std::to_string(trial->moments.size()) + " moments, odometry " +
                                                      decimals(std::sqrt(sensors.distance_variance_per_m), 3) +
                                                      " m after 1 m, ranges " + decimals(sensors.range_sigma_m, 3) +
                                                      " m");
    if (trial->sensors_assumed)
      runs.conditions.diagnostics.push_back(
          folder +
          " has no sensors.csv: the limit is that of the assumed values, and an algorithm below "
          "the limit is no leak, but shows that "
          "the sensors are better than that.");
    trials->push_back(std::move(*trial));
  }
  runs.conditions.settings.emplace_back("longest gap of the ground truth", decimals(arguments.gap_s, 3) + " s");
  if (arguments.recordings.size() == 1)
    runs.conditions.diagnostics.emplace_back(
        "One run is one vote: its interval describes variations of this drive, not other drives, and no difference can "
        "be "
        "shown with fewer than six.");
  runs.count = trials->size();
  runs.on_track = loop.has_value();
  runs.source = [trials = trials.get()](std::size_t index, Trial&) -> Result<const Trial*> {
    return &(*trials)[index];
  };
  runs.kept = std::move(trials);
  return runs;
}

}  // namespace cosiva::app
