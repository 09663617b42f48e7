#include "cosiva/experiments/positioning/metrology/evaluation.h"

#include <algorithm>
#include <memory>
#include <numeric>

#include "cosiva/experiments/positioning/metrology/planar_limit.h"

namespace cosiva::experiments {
namespace {

/// With fewer runs than this, each algorithm on each run is a separate part: even one recording occupies all workers.
constexpr std::size_t few_runs = 16;
/// Otherwise a part is several consecutive runs, whose memory is reused, limited so that all workers end at about the
/// same time.
constexpr std::size_t part_runs_most = 16;
constexpr std::size_t parts_wanted = 64;

template <typename What>
bool has(const Trial& trial) {
  return std::ranges::any_of(trial.events, [](const Event& event) { return std::holds_alternative<What>(event); });
}

/// On a path the limit along it, from readings; on the plane from all measurements. On a path with ranges there is no
/// limit: the first limit does not use ranges, and the second does not use the path.
std::optional<RunLimit> limit_of_run(const Trial& trial) {
  if (trial.setting.track != nullptr) {
    if (!has<estimation::Reading>(trial) || has<estimation::Range>(trial)) return std::nullopt;
    return limit_of(trial);
  }
  if (trial.moments.empty() || !trial.setting.start_known) return std::nullopt;
  return planar_limit_of(trial);
}

/// Consecutive runs, and what to evaluate on them.
struct Part {
  std::size_t first_run;
  std::size_t runs;
  bool own;                 ///< whether the part records the metrics of the runs themselves
  std::size_t first, last;  ///< candidates from the first to before the last
};

class Evaluation {
 public:
  Evaluation(const std::vector<Candidate>& candidates, std::size_t runs, const TrialSource& source,
             const QualificationOptions& options)
      : candidates_{candidates}, source_{source}, options_{options}, runs_(runs), failed_in_(candidates.size(), runs) {
    for (EvaluatedRun& run : runs_) run.algorithms.resize(candidates.size());
    const bool alone = runs < few_runs;
    const std::size_t size = alone ? 1 : std::clamp<std::size_t>(runs / parts_wanted, 1, part_runs_most);
    for (std::size_t run = 0; run < runs; run += size) {
      const std::size_t count = std::min(size, runs - run);
      parts_.push_back({run, count, true, 0, alone ? 0 : candidates.size()});
      for (std::size_t i = 0; alone && i < candidates.size(); ++i) parts_.push_back({run, count, false, i, i + 1});
    }
  }

  /// Proceeds in rounds: parts that are not begun when time is up are left for the next round, and the progress is
  /// reported between rounds.
  Result<std::vector<EvaluatedRun>> on(Workers& workers, const TimeIsUp& time_is_up, const Progress& progress) {
    std::vector<std::size_t> left(parts_.size());
    std::iota(left.begin(), left.end(), std::size_t{0});
    while (!left.empty()) {
      // A separate byte for each part in the list: no two threads write to the same byte.
      std::vector<unsigned char> done(left.size(), 0);
      workers.for_each(left.size(), [&](std::size_t i) {
        if (i > 0 && time_is_up && time_is_up()) return;
        go(parts_[left[i]]);
        done[i] = 1;
      });
      find_faults();
      std::vector<std::size_t> next;
      for (std::size_t i = 0; i < left.size(); ++i) {
        if (done[i] == 0 && parts_[left[i]].first_run <= no_run_) next.push_back(left[i]);
      }
      left = std::move(next);
      if (progress) progress(left.empty() ? runs_.size() : parts_[left.front()].first_run);
    }
    if (no_run_ < runs_.size()) return tl::unexpected(*runs_[no_run_].failed);
    return std::move(runs_);
  }

 private:
  void go(const Part& part) {
    Trial room;
    Trace trace;
    for (std::size_t index = part.first_run; index < part.first_run + part.runs; ++index) {
      const auto trial = source_(index, room);
      if (!trial) {
        // Of all parts of a run a single one records the run's failure.
        if (part.own) runs_[index].failed = trial.error();
        continue;
      }
      if (part.own) evaluate_at(index, **trial);
      for (std::size_t i = part.first; i < part.last; ++i) evaluate(i, index, **trial, trace);
    }
  }

  /// Called between two rounds. Parts behind a fault are not needed any more, but those before it are: therefore the
  /// reported fault does not depend on the order of evaluation.
  void find_faults() {
    for (std::size_t index = runs_.size(); index-- > 0;) {
      if (runs_[index].failed) no_run_ = index;
      for (std::size_t i = 0; i < candidates_.size(); ++i) {
        if (runs_[index].algorithms[i].failed) failed_in_[i] = index;
      }
    }
  }

  /// Records the metrics of the run itself.
  void evaluate_at(std::size_t index, const Trial& trial) {
    EvaluatedRun& run = runs_[index];
    if (options_.alignment == Alignment::none) run.limit = limit_of_run(trial);
    run.sensors_assumed = trial.sensors_assumed;
    if (index > 0) return;
    for (const Moment& moment : trial.moments) {
      run.times_s.push_back(moment.t_s);
      run.ground_truth.push_back(moment.ground_truth);
    }
  }

  void evaluate(std::size_t i, std::size_t index, const Trial& trial, Trace& trace) {
    if (failed_in_[i] < index) return;
    Evaluated& one = runs_[index].algorithms[i];
    auto algorithm = candidates_[i].make(trial.setting);
    if (!algorithm) {
      one.failed = algorithm.error();
    } else if (auto fine = apply(**algorithm, trial, trace); !fine) {
      one.failed = fine.error();
      one.failed->message += " (in run " + std::to_string(index + 1) + ")";
    } else if (options_.alignment != Alignment::none) {
      const auto aligned = align(options_.alignment, trial, trace);
      if (aligned)
        one.alignment = *aligned;
      else
        one.failed = aligned.error();
    }
    if (one.failed) return;
    one.metrics = metrics_of(trial, trace, options_.threshold_m);
    one.errors_m.reserve(trace.error_m.size());
    for (const double e : trace.error_m) one.errors_m.push_back(static_cast<float>(e));
    if (index < worth_runs_most) {
      one.worth = worth_of(trace.error_m);
      one.nees_worth = worth_of(trace.nees);
    }
    if (index == 0) keep_first(one, trial, trace);
  }

  static void keep_first(Evaluated& one, const Trial& trial, const Trace& trace) {
    const std::size_t stride = std::max<std::size_t>(1, trial.moments.size() / 1500);
    for (std::size_t k = 0; k < trial.moments.size(); ++k) {
      one.path.push_back(trace.estimates[k].pose);
      one.squares_m2.push_back(trace.error_m[k] * trace.error_m[k]);
      if (k % stride == 0) one.over_distance.emplace_back(trial.moments[k].travelled_m, trace.error_m[k]);
    }
  }

  const std::vector<Candidate>& candidates_;
  const TrialSource& source_;
  const QualificationOptions& options_;
  std::vector<EvaluatedRun> runs_;
  std::vector<std::size_t>
      failed_in_;  ///< of each candidate the first run known to have failed; the number of runs: none
  std::size_t no_run_{runs_.size()};  ///< likewise the first missing run
  std::vector<Part> parts_;
};

}  // namespace

Result<std::vector<EvaluatedRun>> evaluate_all(const std::vector<Candidate>& candidates, std::size_t runs,
                                               const TrialSource& source, const QualificationOptions& options,
                                               Workers& workers, const TimeIsUp& time_is_up, const Progress& progress) {
  return Evaluation{candidates, runs, source, options}.on(workers, time_is_up, progress);
}

}  // namespace cosiva::experiments
