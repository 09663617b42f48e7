#include "cosiva/app/positioning/qualify_trajectories.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "cosiva/adapters/files.h"
#include "cosiva/adapters/thread_pool.h"
#include "cosiva/app/cli/console.h"
#include "cosiva/app/positioning/qualify_candidates.h"
#include "cosiva/app/positioning/trajectory_report.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/base/math.h"
#include "cosiva/experiments/positioning/recording/alignment.h"
#include "cosiva/experiments/positioning/recording/trajectory.h"
#include "cosiva/experiments/statistics/interval.h"
#include "cosiva/experiments/statistics/sample.h"

namespace cosiva::app {
namespace {

using experiments::ReferenceBudget;
using experiments::Trajectory;

Result<Trajectory> load(const std::string& file) {
  const auto bytes = adapters::read_file(file);
  if (!bytes) return tl::unexpected(bytes.error());
  return experiments::read_trajectory(file, *bytes);
}

/// The parts of a file's name in small letters, separated by anything but letters.
std::vector<std::string> text_of(const std::string& file) {
  std::vector<std::string> tokens(1);
  for (const char c : std::filesystem::path(file).filename().string()) {
    const char small = c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c;
    if (small >= 'a' && small <= 'z')
      tokens.back() += small;
    else if (!tokens.back().empty())
      tokens.emplace_back();
  }
  return tokens;
}

/// Whether a file's name indicates a ground truth.
bool called_ground_truth(const std::string& file) {
  return std::ranges::any_of(text_of(file), [](const std::string& word) {
    return word == "gt" || word == "ref" || word.find("truth") != std::string::npos ||
           word.find("reference") != std::string::npos;
  });
}

/// Whether a file's name indicates an estimate.
bool called_estimate(const std::string& file) {
  return std::ranges::any_of(text_of(file),
                             [](const std::string& word) { return word == "est" || word.starts_with("estimat"); });
}

double root(double v) { return std::sqrt(v); }

using Evaluated = EvaluatedTrajectory;

Evaluated evaluate(const Trajectory& reference, const std::string& file, const QualifyArguments& arguments) {
  Evaluated evaluated;
  evaluated.name = std::filesystem::path(file).stem().string();
  const auto estimate = load(file);
  if (!estimate) {
    evaluated.failed = estimate.error();
    return evaluated;
  }
  const bool nearest = arguments.associate == "nearest";
  auto pairs =
      experiments::associate(reference, *estimate,
                             {nearest ? experiments::Association::nearest : experiments::Association::interpolate,
                              nearest ? 0.01 : arguments.gap_s});
  if (!pairs) {
    evaluated.failed = pairs.error();
    return evaluated;
  }
  if (const auto how = alignment_of(arguments); how != experiments::Alignment::none) {
    const auto motion = experiments::alignment_of(how, *pairs);
    if (!motion) {
      evaluated.failed = Error{motion.error().code, motion.error().message, file};
      return evaluated;
    }
    for (experiments::Pair& pair : *pairs) pair.estimate = *motion * pair.estimate;
    evaluated.alignment = *motion;
  }
  evaluated.ape = experiments::ape(*pairs);
  evaluated.unpaired = estimate->poses.size() - std::min(estimate->poses.size(), pairs->size());
  evaluated.offset_s = experiments::time_offset_s(*pairs);
  std::vector<double> errors;
  std::vector<double> squares;
  for (const experiments::Pair& pair : *pairs) {
    const double x = pair.estimate.p_m[0] - pair.reference.p_m[0];
    const double y = pair.estimate.p_m[1] - pair.reference.p_m[1];
    const double z = pair.estimate.p_m[2] - pair.reference.p_m[2];
    squares.push_back(x * x + y * y + z * z);
    errors.push_back(std::sqrt(squares.back()));
  }
  evaluated.variance_m2 = statistics::variance(errors);
  evaluated.precision = statistics::ratio_below(errors, arguments.threshold_m);
  evaluated.p90_m = statistics::percentile(errors, 0.90);
  evaluated.p95_m = statistics::percentile(errors, 0.95);
  evaluated.p99_m = statistics::percentile(errors, 0.99);
  evaluated.interval = statistics::block_bootstrap(squares, {}, root);
  evaluated.pairs = std::move(*pairs);
  return evaluated;
}

/// How estimates were moved: p becomes R(q)·p + shift.
void write(JsonWriter& json, const experiments::RigidMotion& motion) {
  json.begin_object().field("turn_rad", motion.turn_rad()).key("quaternion_xyzw").begin_array();
  for (const double v : motion.q) json.value(v);
  json.end_array().key("shift_m").begin_array();
  for (const double v : motion.shift_m) json.value(v);
  json.end_array().end_object();
}

/// Files of two programs may have the same name in different folders, and one may be named like the reference's copy.
void name_apart(std::vector<Evaluated>& all) {
  std::vector<std::string> taken{"reference"};
  for (Evaluated& one : all) {
    const std::string name = one.name;
    for (int k = 2; std::ranges::find(taken, one.name) != taken.end(); ++k) one.name = name + "_" + std::to_string(k);
    taken.push_back(one.name);
  }
}

template <typename Take>
void each_pair(const std::vector<Evaluated>& all, const Take& take) {
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t k = i + 1; k < all.size(); ++k) {
      if (!all[i].failed && !all[k].failed) take(all[i], all[k]);
    }
  }
}

void write_reference(JsonWriter& json, const std::vector<Evaluated>& all, const ReferenceBudget& reference) {
  json.key("comparisons").begin_array();
  each_pair(all, [&](const Evaluated& a, const Evaluated& b) {
    json.begin_object().field("a", a.name).field("b", b.name).field("rmse_difference_m", b.ape.rmse - a.ape.rmse);
    json.field("verdict", to_string(unresolved(a, b, reference) ? experiments::Verdict::unresolved
                                                                : experiments::Verdict::not_shown_different));
    json.end_object();
  });
  json.end_array().key("reference_error").begin_object();
  write_fields(json, reference);
  json.end_object();
}

std::string to_json(const std::vector<Evaluated>& all, const QualifyArguments& arguments,
                    const ReferenceBudget& reference) {
  JsonWriter json{2};
  json.begin_object().field("what", "trajectories").field("reference", arguments.reference);
  json.field("associate", arguments.associate).field("align", arguments.align);
  json.field("aligned", arguments.align != "none").key("algorithms").begin_array();
  for (const Evaluated& one : all) {
    json.begin_object().field("name", one.name);
    if (one.failed) {
      json.key("failed").begin_object().field("code", one.failed->code).field("message", to_string(*one.failed));
      json.end_object().end_object();
      continue;
    }
    json.key("failed").null();
    json.field("pairs", one.ape.pairs).field("unpaired", one.unpaired).field("rmse_m", one.ape.rmse);
    json.field("rmse_without_reference_m", experiments::without_reference_m(one.ape.rmse, reference.total_m()));
    json.key("rmse_interval_m");
    if (one.interval)
      json.begin_array().value(one.interval->interval.low).value(one.interval->interval.high).end_array();
    else
      json.null();
    json.field("mean_m", one.ape.mean).field("variance_m2", one.variance_m2).field("precision", one.precision);
    json.field("precision_threshold_m", arguments.threshold_m).field("median_m", one.ape.median);
    json.field("std_m", one.ape.std).field("min_m", one.ape.min).field("max_m", one.ape.max);
    json.field("sse_m2", one.ape.sse).field("p90_m", one.p90_m).field("p95_m", one.p95_m).field("p99_m", one.p99_m);
    json.field("time_offset_s", one.offset_s).key("alignment");
    if (one.alignment)
      write(json, *one.alignment);
    else
      json.null();
    json.end_object();
  }
  json.end_array();
  write_reference(json, all, reference);
  json.end_object();
  return json.take();
}

std::string to_text(const std::vector<Evaluated>& all, experiments::Alignment alignment,
                    const ReferenceBudget& reference) {
  std::string text;
  if (alignment != experiments::Alignment::none)
    text =
        "Aligned (" + std::string(to_string(alignment)) + "): estimates were " + std::string(text_of(alignment)) + ".";
  for (const Evaluated& one : all) {
    text += text.empty() ? "" : "\n";
    if (one.failed) {
      text += one.name + ": failed: " + to_string(*one.failed);
      continue;
    }
    text += one.name + ": rmse " + decimals(one.ape.rmse, 4) + " m";
    if (one.interval)
      text += " (" + decimals(one.interval->interval.low, 4) + " to " + decimals(one.interval->interval.high, 4) +
              "; equivalent to " + decimals(one.interval->effective_size, 0) + " independent errors)";
    text += ", mean " + decimals(one.ape.mean, 4) + ", median " + decimals(one.ape.median, 4) + ", p95 " +
            decimals(one.p95_m, 4) + ", max " + decimals(one.ape.max, 4) + "; " + std::to_string(one.ape.pairs) +
            " pairs, " + std::to_string(one.unpaired) + " poses without a pair; estimated delay " +
            decimals(1e3 * one.offset_s, 1) + " ms (not corrected)";
    if (one.alignment)
      text += "; turned by " + decimals(one.alignment->turn_rad() * 180.0 / pi, 3) + " degrees, shifted by (" +
              decimals(one.alignment->shift_m[0], 4) + ", " + decimals(one.alignment->shift_m[1], 4) + ", " +
              decimals(one.alignment->shift_m[2], 4) + ") m";
  }
  if (reference.parts.empty()) return text;
  text += "\nThe reference's own error: " + text_of(reference) + " [mm]";
  each_pair(all, [&](const Evaluated& a, const Evaluated& b) {
    if (unresolved(a, b, reference))
      text += "\n" + b.name + " − " + a.name + ": " + decimals(1e3 * (b.ape.rmse - a.ape.rmse), 2) + " mm, unresolved";
  });
  return text;
}

}  // namespace

int run_trajectories(const QualifyArguments& arguments) {
  if (arguments.reference.empty() || arguments.estimates.empty())
    return report_error(
        {"compare.trajectories", "both --reference and --estimate are required", "--reference, --estimate"});
  for (const std::string& file : arguments.estimates) {
    if (called_ground_truth(file) && !called_ground_truth(arguments.reference))
      return report_error(
          {"compare.swapped",
           "by its name this is the reference, and " + arguments.reference + " an estimate: they seem to be swapped",
           file});
    if (called_estimate(arguments.reference) && !called_ground_truth(arguments.reference) && !called_estimate(file))
      return report_error(
          {"compare.swapped",
           "by its name this is an estimate, and it is given as the reference of " + file + ": they seem to be swapped",
           arguments.reference});
  }
  const auto budget = reference_of(arguments);
  if (!budget) return report_error(budget.error());
  const auto reference = load(arguments.reference);
  if (!reference) return report_error(reference.error());
  std::vector<Evaluated> all(arguments.estimates.size());
  adapters::ThreadPool workers{threads_for(arguments)};
  workers.for_each(all.size(),
                   [&](std::size_t i) { all[i] = evaluate(*reference, arguments.estimates[i], arguments); });
  name_apart(all);
  const std::string json = to_json(all, arguments, *budget);
  if (!arguments.out_folder.empty()) {
    if (auto written = write_trajectories(all, *reference, arguments, *budget, json); !written)
      return report_error(written.error());
  }
  print(arguments.json ? json : to_text(all, alignment_of(arguments), *budget));
  bool fine = true;
  for (const Evaluated& one : all) {
    if (one.failed) print_info("cosiva: " + one.name + " failed: " + to_string(*one.failed));
    fine = fine && !one.failed;
  }
  if (!fine && all.size() == 1) return exit_bad_input;
  return fine ? exit_done : exit_check_failed;
}

}  // namespace cosiva::app
