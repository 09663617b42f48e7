#include "cosiva/app/vehicle/line_tracking_command.h"

#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <string>
#include <utility>

#include "cosiva/adapters/files.h"
#include "cosiva/app/cli/console.h"
#include "cosiva/app/resources/zone_files.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/experiments/reporting/chart.h"
#include "cosiva/physical/plant/line_trial.h"

namespace cosiva::app {
namespace {

struct Row {
  std::string algorithm;
  double speed_mps;
  physical::LineTrial trial;
};

std::string line_of(const Row& row) {
  char text[120];
  const int length = std::snprintf(text, sizeof text, "%-14s %6.2f m/s  rms %6.3f mm  greatest %6.3f mm%s",
                                   row.algorithm.c_str(), row.speed_mps, 1e3 * row.trial.rms_m, 1e3 * row.trial.worst_m,
                                   row.trial.line_lost ? "  line lost" : "");
  return {text, static_cast<std::size_t>(length)};
}

std::string to_json(const std::vector<Row>& rows) {
  JsonWriter json;
  json.begin_array();
  for (const Row& row : rows) {
    json.begin_object().field("algorithm", row.algorithm).field("speed_mps", row.speed_mps);
    json.field("rms_mm", 1e3 * row.trial.rms_m).field("greatest_mm", 1e3 * row.trial.worst_m);
    json.field("line_lost", row.trial.line_lost).end_object();
  }
  json.end_array();
  return json.take();
}

/// The offsets at the last of the speeds.
std::string chart_of(const std::vector<Row>& rows) {
  experiments::Chart chart{{"distance [m]", {}, {}}, {"offset to the left [mm]", {}, {}}, {}};
  for (const Row& row : rows) {
    if (row.speed_mps != rows.back().speed_mps) continue;
    experiments::Series series{row.algorithm, row.trial.distance_m, {}};
    for (const double offset_m : row.trial.offset_m) series.y.push_back(1e3 * offset_m);
    chart.series.push_back(std::move(series));
  }
  return experiments::to_svg(chart);
}

}  // namespace

int run_line_tracking(const LineTrackingArguments& arguments) {
  const auto rtm = open_zone(arguments.zone, {});
  if (!rtm) return report_error(rtm.error());
  const std::vector<std::string> names =
      arguments.algorithms.empty() ? physical::line_trackings() : arguments.algorithms;
  std::vector<Row> rows;
  for (const double speed_mps : arguments.speeds_mps) {
    for (const std::string& name : names) {
      auto trial = physical::run_line_trial(
          rtm->zone(), {name, speed_mps, arguments.distance_m, 1e-3 * arguments.unevenness_mm, arguments.seed});
      if (!trial) return report_error(trial.error());
      rows.push_back({name, speed_mps, std::move(*trial)});
    }
  }
  if (arguments.json) {
    print(to_json(rows));
  } else {
    for (const Row& row : rows) print(line_of(row));
  }
  if (arguments.out_file.empty()) return exit_done;
  if (auto written = adapters::write_file(arguments.out_file, chart_of(rows)); !written)
    return report_error(written.error());
  print_info("drawn into " + arguments.out_file);
  return exit_done;
}

}  // namespace cosiva::app
