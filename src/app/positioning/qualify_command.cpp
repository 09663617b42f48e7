#include "cosiva/app/positioning/qualify_command.h"

#include <chrono>

#include "cosiva/adapters/files.h"
#include "cosiva/adapters/thread_pool.h"
#include "cosiva/app/cli/console.h"
#include "cosiva/app/cli/progress.h"
#include "cosiva/app/positioning/qualify_candidates.h"
#include "cosiva/app/positioning/qualify_moves.h"
#include "cosiva/app/positioning/qualify_runs.h"
#include "cosiva/app/positioning/qualify_trajectories.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/experiments/positioning/metrology/evo_zip.h"
#include "cosiva/experiments/positioning/metrology/result_json.h"
#include "cosiva/experiments/positioning/metrology/result_page.h"
#include "cosiva/experiments/positioning/metrology/result_text.h"
#include "cosiva/experiments/positioning/recording/trajectory.h"

namespace cosiva::app {
namespace {

using experiments::Qualification;

int list_algorithms(const estimation::Registry& registry, bool as_json) {
  JsonWriter json;
  std::string text;
  json.begin_object().key("algorithms").begin_array();
  for (const estimation::Registered& one : registry.all()) {
    json.begin_object().field("name", one.name).field("what", one.what).field("needs_track", one.needs_track);
    json.field("backtracks", one.backtracks).end_object();
    text += (text.empty() ? "" : "\n") + one.name + std::string(18 - std::min<std::size_t>(17, one.name.size()), ' ') +
            one.what + (one.needs_track ? "; needs a path" : "");
  }
  json.end_array().end_object();
  print(as_json ? json.text() : text);
  return exit_done;
}

/// Prints "12 of 30 runs" once per second, during longer evaluations.
class RunsDone {
 public:
  explicit RunsDone(std::size_t runs) : runs_{runs} {}
  /// Whether the evaluation is to pause, so that the progress can be printed.
  [[nodiscard]] bool time_is_up() const { return std::chrono::steady_clock::now() >= until_; }
  void at(std::size_t done) {
    until_ = std::chrono::steady_clock::now() + round_time;
    if (done == runs_ || !ticker_.ticks()) return;
    print_info("cosiva: " + std::to_string(done) + " of " + std::to_string(runs_) + " runs");
  }

 private:
  static constexpr std::chrono::milliseconds round_time{500};
  std::size_t runs_;
  std::chrono::steady_clock::time_point until_{std::chrono::steady_clock::now() + round_time};
  SecondsTicker ticker_;
};

Result<void> write_all(const std::string& folder, const Qualification& all, const experiments::Conditions& conditions,
                       const std::vector<std::pair<std::string, std::string>>& further) {
  const auto tum = [&](const std::string& name, const std::vector<Pose2>& path) {
    experiments::Trajectory trajectory{name, {}};
    for (std::size_t i = 0; i < path.size(); ++i)
      trajectory.poses.push_back(experiments::stamped(all.times_s[i], path[i]));
    return experiments::write_tum(trajectory);
  };
  std::vector<std::pair<std::string, std::string>> files{{"report.html", to_html(all, conditions)},
                                                         {"result.json", to_json(all, conditions) + "\n"},
                                                         {"runs.csv", to_csv(all)},
                                                         {"ground_truth.tum", tum("ground_truth", all.ground_truth)}};
  files.insert(files.end(), further.begin(), further.end());
  for (const experiments::Qualified& one : all.algorithms) {
    if (one.failed) continue;
    std::vector<double> errors;
    for (std::size_t i = 0; i < one.path.size(); ++i) errors.push_back(distance(one.path[i], all.ground_truth[i]));
    files.emplace_back(one.name + ".tum", tum(one.name, one.path));
    files.emplace_back(one.name + ".zip", experiments::evo_zip(one.name, all.times_s, errors, all.options.alignment));
  }
  if (auto written = adapters::write_files(folder, files); !written) return written;
  print_info("written into " + folder);
  return {};
}

/// The delay of each estimate against the ground truth, over the first run: reported, and not corrected. A ground truth
/// with a clock of its own causes an error along the path that no algorithm can avoid.
std::string lateness_of(const Qualification& all) {
  std::string text;
  for (const experiments::Qualified& one : all.algorithms) {
    if (one.failed) continue;
    std::vector<experiments::Pair> pairs;
    pairs.reserve(one.path.size());
    for (std::size_t i = 0; i < one.path.size(); ++i)
      pairs.push_back({experiments::stamped(all.times_s[i], all.ground_truth[i]),
                       experiments::stamped(all.times_s[i], one.path[i])});
    text += (text.empty() ? "" : ", ") + one.name + " " + decimals(1e3 * experiments::time_offset_s(pairs), 1) + " ms";
  }
  return text;
}

int run_either(const QualifyArguments& arguments, std::size_t at_least) {
  const estimation::Registry registry;
  if (arguments.list) return list_algorithms(registry, arguments.json);
  if (predicts_then_moves(arguments)) return run_moves(arguments, at_least);
  if (!arguments.reference.empty() || !arguments.estimates.empty()) return run_trajectories(arguments);
  const auto alignment = alignment_of(arguments);
  if (alignment != experiments::Alignment::none && arguments.recordings.empty())
    return report_error({"compare.align",
                         "in virtual time all algorithms use the ground truth's frame: there is nothing to align",
                         "--align " + arguments.align});
  if (alignment == experiments::Alignment::se3)
    return report_error({"compare.align", "a recording is planar: use se2 or origin", "--align se3"});
  auto reference = reference_of(arguments);
  if (!reference) return report_error(reference.error());
  auto runs = arguments.recordings.empty() ? virtual_runs(arguments) : recorded_runs(arguments);
  if (!runs) return report_error(runs.error());
  const auto candidates =
      candidates_of(arguments, registry, runs->on_track, usual_algorithms(arguments, runs->on_track, at_least));
  if (!candidates) return report_error(candidates.error());
  if (candidates->size() < at_least)
    return report_error({"compare.few", "a comparison needs at least two", "algorithms"});
  return evaluate(arguments, *candidates, *runs, std::move(*reference));
}

/// The run's own checks: every algorithm responded, and no algorithm is better than the limit.
bool check(const Qualification& all) {
  bool fine = true;
  for (const experiments::Qualified& one : all.algorithms) {
    if (one.failed) print_info("cosiva: " + one.name + " failed: " + to_string(*one.failed));
    if (one.leak)
      print_info("cosiva: " + one.name +
                 " is below the limit: the algorithm uses information that it cannot have, or the limit is wrong");
    fine = fine && !one.failed && !one.leak;
  }
  return fine;
}

}  // namespace

int evaluate(const QualifyArguments& arguments, const std::vector<experiments::Candidate>& candidates, const Runs& runs,
             experiments::ReferenceBudget reference) {
  experiments::QualificationOptions options;
  options.threshold_m = arguments.threshold_m;
  options.tolerance_m = arguments.tolerance_m;
  options.reliability = arguments.reliability;
  options.confidence = arguments.confidence;
  options.alignment = alignment_of(arguments);
  options.reference = std::move(reference);
  options.bootstrap.seed = arguments.seed;
  adapters::ThreadPool workers{threads_for(arguments)};
  RunsDone runs_done{runs.count};
  const auto all = experiments::qualify(
      candidates, runs.count, runs.source, options, workers, [&] { return runs_done.time_is_up(); },
      [&](std::size_t done) { runs_done.at(done); });
  if (!all) return report_error(all.error());
  experiments::Conditions conditions = runs.conditions;
  if (!arguments.recordings.empty())
    conditions.settings.emplace_back("estimated delay against the ground truth, first run (not corrected)",
                                     lateness_of(*all));
  if (!arguments.out_folder.empty()) {
    if (auto written = write_all(arguments.out_folder, *all, conditions, runs.files); !written)
      return report_error(written.error());
  }
  std::string text = arguments.json ? to_json(*all, conditions) : to_text(*all);
  while (text.ends_with('\n')) text.pop_back();  // print ends the line
  print(text);
  for (const std::string& diagnostic : runs.complete ? std::vector<std::string>{} : runs.conditions.diagnostics)
    print_info("cosiva: " + diagnostic);
  return check(*all) && runs.complete ? exit_done : exit_check_failed;
}

int run_qualify(const QualifyArguments& arguments) { return run_either(arguments, 1); }
int run_compare(const QualifyArguments& arguments) { return run_either(arguments, 2); }

}  // namespace cosiva::app
