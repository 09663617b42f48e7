#include "cosiva/app/battery/battery_analyse_command.h"

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "cosiva/adapters/files.h"
#include "cosiva/app/battery/battery_text.h"
#include "cosiva/app/cli/console.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/base/text.h"
#include "cosiva/experiments/battery/analysis.h"
#include "cosiva/experiments/battery/autonomy_output.h"
#include "cosiva/experiments/battery/autonomy_report.h"
#include "cosiva/experiments/battery/recorded.h"

namespace cosiva::app {
namespace {

using experiments::AutonomyMetrics;
using experiments::RecordedSeries;

Result<std::vector<RecordedSeries>> load(const BatteryAnalyseArguments& arguments) {
  std::vector<RecordedSeries> all;
  std::vector<experiments::RecordedFile> results;
  for (const std::string& file : arguments.files) {
    auto text = adapters::read_file(file);
    if (!text) return tl::unexpected(text.error());
    if (trimmed(*text, " \t\r\n").starts_with('{')) {
      results.push_back({std::move(*text), file});
      continue;
    }
    auto series =
        experiments::read_recorded(*text, file, {arguments.time, arguments.battery, arguments.vehicle, arguments.run});
    if (!series) return tl::unexpected(series.error());
    std::ranges::move(*series, std::back_inserter(all));
  }
  if (!results.empty()) {
    auto one = experiments::read_results(results);
    if (!one) return tl::unexpected(one.error());
    all.push_back(std::move(*one));
  }
  if (arguments.only.empty()) return all;
  std::vector<RecordedSeries> wanted;
  std::string there;
  for (RecordedSeries& one : all) {
    there += (there.empty() ? "" : ", ") + one.name;
    if (std::ranges::find(arguments.only, one.name) != arguments.only.end()) wanted.push_back(std::move(one));
  }
  if (wanted.size() != arguments.only.size())
    return fail("recorded.series", "not all of these series exist; available: " + there, "--only");
  return wanted;
}

/// "6=2000": battery 6 was ended after 2000 s by another cause.
Result<void> end_early(std::vector<RecordedSeries>& all, const std::vector<std::string>& failed) {
  for (const std::string& one : failed) {
    const std::size_t at = one.rfind('=');
    const auto after_s = at == std::string::npos ? std::nullopt : number_of<double>(one.substr(at + 1));
    if (!after_s) return fail("recorded.failed", "'" + one + "' is not BATTERY=SECONDS", "--failed");
    if (all.size() != 1) return fail("recorded.failed", "select one series with --only", "--failed");
    if (auto done = experiments::end_early(all.front(), one.substr(0, at), *after_s); !done) return done;
  }
  return {};
}

std::string again(const BatteryAnalyseArguments& arguments) {
  std::string text = "cosiva battery analyse";
  for (const std::string& file : arguments.files) text += " " + file;
  for (const std::string& one : arguments.only) text += " --only " + one;
  for (const std::string& one : arguments.failed) text += " --failed " + one;
  for (const auto& [option, value] : {std::pair{" --time ", &arguments.time},
                                      {" --battery ", &arguments.battery},
                                      {" --vehicle ", &arguments.vehicle},
                                      {" --run ", &arguments.run}})
    if (!value->empty()) text += option + *value;
  return text;
}

Result<void> write_report(const BatteryAnalyseArguments& arguments, const std::string& directory,
                          const RecordedSeries& series, const AutonomyMetrics& metrics, const std::string& json) {
  const experiments::ReportMetadata metadata{series.name,      again(arguments),     "as the measurements'",
                                             again(arguments), "as it was measured", std::nullopt};
  return adapters::write_files(
      directory,
      {{"result.json", json}, {"report.html", experiments::report_html(metrics, series.records, {}, metadata)}});
}

}  // namespace

int run_battery_analyse(const BatteryAnalyseArguments& arguments) {
  auto all = load(arguments);
  if (!all) return report_error(all.error());
  if (auto done = end_early(*all, arguments.failed); !done) return report_error(done.error());
  JsonWriter json;
  if (all->size() > 1) json.begin_object().key("series").begin_array();
  std::string text;
  for (const RecordedSeries& series : *all) {
    const AutonomyMetrics metrics =
        experiments::analyse(series.records, series.batteries, 0.01 * arguments.half_width_percent, arguments.seed);
    const std::string own = experiments::to_json(metrics, series.records, {});
    if (all->size() > 1)
      json.begin_object().field("name", series.name).key("result").raw(own).end_object();
    else
      json.raw(own);
    text += (text.empty() ? "" : "\n\n") + series.name + ": " + experiments::to_text(metrics, series.records);
    if (arguments.half_width_percent > 0.0)
      text += "\n" + stop_text(metrics.stopped_after, arguments.half_width_percent);
    if (arguments.out_directory.empty()) continue;
    const std::string directory = all->size() > 1
                                      ? (std::filesystem::path{arguments.out_directory} / series.name).string()
                                      : arguments.out_directory;
    if (auto written = write_report(arguments, directory, series, metrics, own); !written)
      return report_error(written.error());
    print_info("written to " + directory + ": report.html, result.json");
  }
  if (all->size() > 1) json.end_array().end_object();
  print(arguments.json ? json.text() : text);
  return exit_done;
}

}  // namespace cosiva::app
