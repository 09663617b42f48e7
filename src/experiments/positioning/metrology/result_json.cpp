#include "cosiva/experiments/positioning/metrology/result_json.h"

#include <cmath>

#include "cosiva/base/json_writer.h"

namespace cosiva::experiments {
namespace {

void write_interval(JsonWriter& json, std::string_view name, const std::optional<statistics::Interval>& interval) {
  json.key(name);
  if (!interval) {
    json.null();
    return;
  }
  json.begin_array().value(interval->low).value(interval->high).end_array();
}

void write_figure(JsonWriter& json, const std::string& name, const std::string& unit, const Figure& figure) {
  json.field(name + unit, figure.value);
  write_interval(json, name + "_interval" + unit, figure.interval);
}

template <typename T>
void write_optional(JsonWriter& json, std::string_view name, const std::optional<T>& value) {
  json.key(name);
  if (value)
    json.value(*value);
  else
    json.null();
}

/// Points of the distribution of all errors, fifty at most: `ratio[i]` of them are at most `error_m[i]`.
void write_cdf(JsonWriter& json, const statistics::Cdf& cdf) {
  const std::size_t points = std::min<std::size_t>(50, cdf.value.size());
  const auto write = [&](std::string_view key, const std::vector<double>& values) {
    json.key(key).begin_array();
    for (std::size_t i = 1; i <= points; ++i) json.value(values[i * values.size() / points - 1]);
    json.end_array();
  };
  json.key("cdf").begin_object();
  write("error_m", cdf.value);
  write("ratio", cdf.ratio);
  json.end_object();
}

void write_part(JsonWriter& json, const Part& part) {
  json.field("iterations", part.iterations).field("rmse_m", part.rmse_m()).end_object();
}

void write_splits(JsonWriter& json, const Qualified& one) {
  json.key("along").begin_object().field("rmse_m", one.along_rmse_m).field("bias_m", one.along_bias_m).end_object();
  json.key("across").begin_object().field("rmse_m", one.across_rmse_m).field("bias_m", one.across_bias_m).end_object();
  json.key("by_section").begin_array();
  for (std::size_t k = 0; k < one.by_section.size(); ++k) {
    if (one.by_section[k].iterations == 0) continue;
    json.begin_object().field("kind", zone::to_string(static_cast<zone::SectionKind>(k)));
    write_part(json, one.by_section[k]);
  }
  json.end_array().key("by_distance_since_fiducial").begin_array();
  for (std::size_t k = 0; k < one.by_distance.size(); ++k) {
    if (one.by_distance[k].iterations == 0) continue;
    json.begin_object().field("from_m", k == 0 ? 0.0 : since_fiducial_m[k - 1]).key("to_m");
    if (k < since_fiducial_m.size())
      json.value(since_fiducial_m[k]);
    else
      json.null();
    write_part(json, one.by_distance[k]);
  }
  json.end_array();
}

void write_consistency(JsonWriter& json, const Qualified& one) {
  json.key("nees").begin_object().field("mean", one.nees).field("expected", 2.0);
  write_interval(json, "band_95", one.nees_band);
  json.field("inside_band", one.nees >= one.nees_band.low && one.nees <= one.nees_band.high).end_object();
  json.key("coverage").begin_array();
  for (std::size_t k = 0; k < region_ratios.size(); ++k)
    json.begin_object().field("stated", region_ratios[k]).field("covered", one.covered[k]).end_object();
  json.end_array().key("nis").begin_object().field("mean_per_dimension", one.nis).field("expected", 1.0);
  json.field("dimensions", one.nis_dimensions);
  write_interval(json, "band_95", one.nis_band);
  const auto inside = [&](const statistics::Interval& band) { return one.nis >= band.low && one.nis <= band.high; };
  write_optional(json, "inside_band", one.nis_band ? std::optional{inside(*one.nis_band)} : std::nullopt);
  json.end_object();
  json.field("refused", one.refused);
}

void write_algorithm(JsonWriter& json, const Qualification& all, std::size_t index) {
  const Qualified& one = all.algorithms[index];
  json.begin_object().field("name", one.name).field("what", one.what).field("backtracks", one.backtracks);
  if (one.failed) {
    json.key("failed").begin_object().field("code", one.failed->code).field("message", to_string(*one.failed));
    json.end_object().end_object();
    return;
  }
  json.key("failed").null();
  json.field("runs", one.runs.size()).field("iterations", one.iterations).field("effective_size", one.worth);
  write_figure(json, "rmse", "_m", one.rmse_m);
  write_figure(json, "mean", "_m", one.mean_m);
  json.field("variance_m2", one.variance_m2);
  write_figure(json, "precision", "", one.precision);
  json.field("precision_threshold_m", all.options.threshold_m);
  json.field("p50_m", one.p50_m).field("p90_m", one.p90_m).field("p95_m", one.p95_m).field("p99_m", one.p99_m);
  write_cdf(json, one.cdf);
  json.field("max_m", one.max_m).field("heading_rmse_rad", one.heading_rmse_rad);
  json.field("rmse_without_reference_m", without_reference_m(one.rmse_m.value, all.options.reference.total_m()));
  write_splits(json, one);
  write_consistency(json, one);
  write_optional(json, "limit_m", one.limit_m);
  write_optional(json, "gap_percent", one.gap_percent);
  json.field("limit_assumed", one.limit_assumed).field("leak", one.leak);
  json.key("success").begin_object().field("tolerance_m", all.options.tolerance_m);
  json.field("reliability", all.options.reliability).field("confidence", all.options.confidence);
  json.field("runs", one.passes.runs).field("passed", one.passes.passed).field("in_a_row", one.passes.in_a_row);
  json.field("needed_in_a_row", one.passes.needed).field("shown", one.passes.in_a_row >= one.passes.needed);
  json.field("reliability_shown", one.passes.reliability_shown);
  json.field("tolerance_passed_m", one.passes.tolerance_passed_m).end_object();
  if (!one.alignments.empty()) {
    json.key("alignment_by_run").begin_array();
    for (const Pose2& move : one.alignments)
      json.begin_object()
          .field("turn_rad", move.heading_rad)
          .field("x_m", move.x_m)
          .field("y_m", move.y_m)
          .end_object();
    json.end_array();
  }
  json.key("rmse_by_run_m").begin_array();
  for (const RunMetrics& run : one.runs) json.value(std::sqrt(run.mse_m2));
  json.end_array().end_object();
}

void write_comparisons(JsonWriter& json, const Qualification& all) {
  json.key("comparisons").begin_array();
  for (const Comparison& comparison : all.comparisons) {
    json.begin_object().field("a", all.algorithms[comparison.a].name).field("b", all.algorithms[comparison.b].name);
    write_figure(json, "rmse_difference", "_m", comparison.rmse_difference_m);
    write_figure(json, "precision_difference", "", comparison.precision_difference);
    json.field("p", comparison.p).field("p_holm", comparison.p_holm);
    json.field("verdict", to_string(comparison.verdict));
    write_optional(json, "runs_to_decide", comparison.runs_to_decide);
    json.end_object();
  }
  json.end_array().key("ranks");
  if (!all.ranks) {
    json.null();
    return;
  }
  json.begin_object().field("chi_squared", all.ranks->chi_squared).field("p", all.ranks->p).key("mean").begin_array();
  for (std::size_t i = 0; i < all.ranked.size(); ++i) {
    json.begin_object().field("name", all.algorithms[all.ranked[i]].name);
    json.field("rank", all.ranks->mean_ranks[i]).end_object();
  }
  json.end_array().end_object();
}

}  // namespace

std::string to_json(const Qualification& all, const Conditions& conditions) {
  JsonWriter json{2};
  json.begin_object().field("what", conditions.what).field("runs", all.runs);
  json.field("align", to_string(all.options.alignment));
  json.field("aligned", all.options.alignment != Alignment::none);
  json.key("algorithms").begin_array();
  for (std::size_t i = 0; i < all.algorithms.size(); ++i) write_algorithm(json, all, i);
  json.end_array();
  write_comparisons(json, all);
  json.key("reference").begin_object();
  write_fields(json, all.options.reference);
  json.end_object();
  json.key("conditions").begin_object();
  for (const auto& [name, value] : conditions.settings) json.field(name, value);
  json.end_object().key("diagnostics").begin_array();
  for (const std::string& diagnostic : conditions.diagnostics) json.value(diagnostic);
  json.end_array().field("command", conditions.command).field("digest", all.digest.hex()).end_object();
  return json.take();
}

}  // namespace cosiva::experiments
