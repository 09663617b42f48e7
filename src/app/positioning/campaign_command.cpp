#include "cosiva/app/positioning/campaign_command.h"

#include <chrono>
#include <filesystem>

#include "cosiva/adapters/append_file.h"
#include "cosiva/adapters/files.h"
#include "cosiva/adapters/thread_pool.h"
#include "cosiva/app/cli/console.h"
#include "cosiva/app/cli/progress.h"
#include "cosiva/app/positioning/loop_track.h"
#include "cosiva/app/resources/ranks.h"
#include "cosiva/experiments/positioning/campaign/campaign_run.h"
#include "cosiva/experiments/positioning/campaign/result.h"
#include "cosiva/experiments/positioning/campaign/result_json.h"
#include "cosiva/experiments/positioning/campaign/result_page.h"
#include "cosiva/experiments/positioning/campaign/result_tables.h"
#include "cosiva/experiments/positioning/campaign/result_text.h"
#include "cosiva/experiments/positioning/campaign/table_sqlite.h"

namespace cosiva::app {
namespace {

using experiments::CampaignPlan;
using experiments::CampaignResult;
using experiments::CampaignRun;
using experiments::CampaignWork;
using experiments::UnitRecord;

/// Period after which all ranks synchronise and finished units are stored: the most work that a killed process loses.
constexpr std::chrono::milliseconds round_time{500};

struct Prepared {
  std::string plan_text;
  CampaignWork work;
};

Result<Prepared> prepare(const CampaignArguments& arguments) {
  auto text = adapters::read_file(arguments.plan_file);
  if (!text) return tl::unexpected(text.error());
  auto plan = experiments::read_campaign_plan(*text, arguments.plan_file);
  if (!plan) return tl::unexpected(plan.error());
  // A zone file's path is relative to the plan's folder.
  const auto local_path = std::filesystem::path(arguments.plan_file).parent_path() / plan->zone;
  auto loop = loop_of(std::filesystem::exists(local_path) ? local_path.string() : plan->zone);
  if (!loop) return tl::unexpected(loop.error());
  auto work = CampaignWork::make(std::move(*plan), {loop->zone, loop->track});
  if (!work) {
    work.error().location = arguments.plan_file + (work.error().location.empty() ? "" : ": " + work.error().location);
    return tl::unexpected(work.error());
  }
  return Prepared{std::move(*text), std::move(*work)};
}

/// The files that rank 0 keeps in the folder while the campaign runs.
class Kept {
 public:
  /// Reads the units that are already finished.
  Result<std::vector<UnitRecord>> open(const CampaignArguments& arguments, const CampaignWork& work) {
    if (arguments.out_folder.empty()) return std::vector<UnitRecord>{};
    path_ = (std::filesystem::path(arguments.out_folder) / "campaign.state").string();
    auto file = adapters::AppendFile::open(path_);
    if (!file) return tl::unexpected(file.error());
    file_ = std::move(*file);
    auto bytes = arguments.anew ? Result<std::string>{std::string{}} : adapters::read_file(path_);
    if (!bytes) return tl::unexpected(bytes.error());
    auto state = experiments::read_state(*bytes, work, path_);
    if (!state) return tl::unexpected(state.error());
    if (auto cut = file_->cut(state->whole_bytes); !cut) return tl::unexpected(cut.error());
    if (state->whole_bytes == 0)
      if (auto begun = file_->append(experiments::state_header(work)); !begun) return tl::unexpected(begun.error());
    return std::move(state->records);
  }
  [[nodiscard]] Result<void> append(std::string_view lines) {
    if (!file_) return {};
    auto written = file_->append(lines);
    if (!written)
      written.error().message += "; finished units are preserved, start the campaign again when there is space";
    return written;
  }
  /// All units are finished: writes them in the order of the list, so that the same plan makes the same file.
  [[nodiscard]] Result<void> warm_up(const CampaignWork& work, const std::vector<UnitRecord>& records) const {
    if (!file_) return {};
    std::string text = experiments::state_header(work);
    for (const UnitRecord& record : records) text += experiments::state_line(record);
    return adapters::write_file(path_, text);
  }

 private:
  std::string path_;
  std::unique_ptr<adapters::AppendFile> file_;
};

/// Prints "campaign 43 % done, 12 s left" once per second.
class TimeLeft {
 public:
  explicit TimeLeft(const CampaignRun& run) : before_{run.cost_done()} {}
  void report(const CampaignRun& run) {
    if (!ticker_.ticks() || run.cost_done() <= before_) return;
    const double rate = (run.cost_done() - before_) / passed_s();
    print_info("campaign " + decimals(100.0 * run.cost_done() / run.cost_all(), 0) + " % done, " +
               decimals((run.cost_all() - run.cost_done()) / rate, 0) + " s left");
  }
  [[nodiscard]] double passed_s() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  double before_;
  std::chrono::steady_clock::time_point start_{std::chrono::steady_clock::now()};
  SecondsTicker ticker_;
};

Result<void> write_all(const std::string& folder, const CampaignResult& result, const std::string& plan_text) {
  const auto runs = experiments::runs_table(result);
  const auto cells = experiments::cells_table(result);
  const auto database =
      experiments::to_sqlite({experiments::campaign_table(result), runs, cells, experiments::pitches_table(result)});
  if (!database) return tl::unexpected(database.error());
  if (auto written = adapters::write_files(folder, {{"runs.csv", to_csv(runs)},
                                                    {"cells.csv", to_csv(cells)},
                                                    {"campaign.sqlite", *database},
                                                    {"report.html", to_html(result, plan_text)},
                                                    {"result.json", to_json(result) + "\n"}});
      !written)
    return written;
  print_info("report: " + folder + "/report.html");
  return {};
}

int print_amount(const CampaignArguments& arguments, const CampaignWork& work) {
  const CampaignPlan& plan = work.plan();
  std::size_t finished = 0;
  if (const std::string path = arguments.out_folder + "/campaign.state";
      !arguments.out_folder.empty() && !arguments.anew && std::filesystem::exists(path)) {
    const auto bytes = adapters::read_file(path);
    if (!bytes) return report_error(bytes.error());
    const auto state = experiments::read_state(*bytes, work, path);
    if (!state) return report_error(state.error());
    finished = state->records.size();
  }
  std::string text = plan.name + ": " + std::to_string(plan.environments()) + " environments, " +
                     std::to_string(plan.algorithms.size()) + " algorithms, " + std::to_string(plan.runs) +
                     " runs each: " + std::to_string(plan.votes()) + " runs of " + decimals(plan.distance_m, 1) + " m";
  for (const experiments::Swept swept : plan.swept())
    text += "\n  " + std::string(experiments::info_of(swept).key) + ": " + std::to_string(plan.of(swept).size()) +
            " values";
  print(text + "\n  " + std::to_string(work.units()) + " units of work, " + std::to_string(finished) + " finished");
  return exit_done;
}

int print_result(const CampaignArguments& arguments, const Prepared& prepared, const std::vector<UnitRecord>& records,
                 const Kept& kept, Workers& workers) {
  const auto summary = experiments::sum_up(prepared.work, records, workers);
  const CampaignResult result{prepared.work, records, summary};
  if (!arguments.out_folder.empty()) {
    if (auto synchronised = kept.warm_up(prepared.work, records); !synchronised)
      return report_error(synchronised.error());
    if (auto written = write_all(arguments.out_folder, result, prepared.plan_text); !written)
      return report_error(written.error());
  }
  std::string text = arguments.json ? to_json(result) : to_text(result);
  while (text.ends_with('\n')) text.pop_back();  // print ends the line
  print(text);
  return summary.leaks == 0 ? exit_done : exit_check_failed;
}

}  // namespace

int run_campaign(const CampaignArguments& arguments) {
  // File errors are found before MPI begins, because then each rank can end by itself.
  const auto prepared = prepare(arguments);
  if (!prepared) return report_error(prepared.error());
  const CampaignWork& work = prepared->work;
  if (arguments.dry_run) return print_amount(arguments, work);
  auto ranks = start_ranks();
  if (!ranks) return report_error(ranks.error());
  const bool speaks = (*ranks)->rank() == 0;
  Kept kept;
  auto known = speaks ? kept.open(arguments, work) : Result<std::vector<UnitRecord>>{std::vector<UnitRecord>{}};
  auto run = CampaignRun::make(work, std::move(known), **ranks);
  if (!run) return speaks ? report_error(run.error()) : exit_bad_input;
  if (speaks && run->units_done() > 0)
    print_info("campaign continues: " + std::to_string(run->units_done()) + " of " + std::to_string(work.units()) +
               " units are finished");
  adapters::ThreadPool workers{arguments.threads > 0 ? arguments.threads : threads_for_each_rank()};
  TimeLeft time_left{*run};
  const double cost_before = run->cost_done();
  for (bool more = true; more;) {
    const auto until = std::chrono::steady_clock::now() + round_time;
    const auto round = run->advance(
        workers, [until] { return std::chrono::steady_clock::now() >= until; },
        [&](std::string_view lines) { return kept.append(lines); });
    if (!round) return speaks ? report_error(round.error()) : exit_bad_input;
    more = *round;
    if (speaks && more) time_left.report(*run);
  }
  if (!speaks) return exit_done;
  const double took_s = time_left.passed_s();
  const double ratio = (run->cost_all() - cost_before) / run->cost_all();
  const double runs = ratio * static_cast<double>(work.plan().votes());
  if (runs > 0.0)
    print_info("campaign took " + decimals(took_s, 2) + " s on " + std::to_string((*ranks)->size()) + " × " +
               std::to_string(workers.threads()) + " threads, " + decimals(1e3 * took_s / runs, 3) + " ms a run");
  return print_result(arguments, *prepared, run->take_records(), kept, workers);
}

}  // namespace cosiva::app
