#include "cosiva/experiments/positioning/campaign/result_json.h"

#include "cosiva/base/json_writer.h"

namespace cosiva::experiments {
namespace {

void write(JsonWriter& json, std::string_view name, const Figure& figure) {
  json.key(name).begin_object().field("value", figure.value).key("interval");
  if (figure.interval)
    json.begin_array().value(figure.interval->low).value(figure.interval->high).end_array();
  else
    json.null();
  json.end_object();
}

void write(JsonWriter& json, std::string_view name, const std::optional<Crossing>& crossing) {
  json.key(name);
  if (!crossing) {
    json.null();
    return;
  }
  static constexpr std::string_view terms[] = {"at", "under", "over"};
  json.begin_object().field("m", crossing->x).field("is", terms[static_cast<std::size_t>(crossing->where)]);
  json.end_object();
}

void write_plan(JsonWriter& json, const CampaignResult& result) {
  const CampaignPlan& plan = result.work.plan();
  json.key("plan").begin_object().field("name", plan.name).field("zone", result.work.ground().zone->name);
  json.field("runs", plan.runs)
      .field("seed", plan.seed)
      .field("distance_m", plan.distance_m)
      .field("rate_hz", plan.rate_hz);
  json.field("fiducials", plan.fiducials == Fiducials::grid ? "grid" : "line").field("reach_m", plan.reach_m);
  json.field("threshold_m", plan.threshold_m).field("tolerance_m", plan.tolerance_m);
  json.field("tolerance_of", plan.evaluated == EvaluatedQuantity::p95 ? "p95" : "rmse");
  json.key("vary").begin_object().key("algorithm").begin_array();
  for (const std::string& name : plan.algorithms) json.value(name);
  json.end_array();
  for (std::size_t i = 0; i < swept_count; ++i) {
    json.key(info_of(static_cast<Swept>(i)).key).begin_array();
    for (const double value : plan.values[i]) json.value(value);
    json.end_array();
  }
  json.end_object().end_object();
}

void write_cell(JsonWriter& json, const CampaignPlan& plan, const CellMetrics& cell) {
  json.begin_object().field("algorithm", plan.algorithms[cell.algorithm]);
  const SweptValues values = plan.environment(cell.environment);
  for (std::size_t i = 0; i < swept_count; ++i) json.field(info_of(static_cast<Swept>(i)).key, values[i]);
  write(json, "rmse_m", cell.rmse_m);
  write(json, "p95_m", cell.p95_m);
  json.field("limit_m", cell.limit_m).field("gap_percent", cell.gap_percent).field("leak", cell.leak);
  json.field("mean_m", cell.mean_m).field("max_m", cell.max_m).field("precision_ratio", cell.precision);
  json.field("covered95_ratio", cell.covered).field("nees", cell.nees).field("refused_readings", cell.refused);
  json.field("spacing_m", cell.fiducials.spacing_m)
      .field("longest_unread_m", cell.fiducials.longest_unread_m)
      .end_object();
}

}  // namespace

std::string to_json(const CampaignResult& result) {
  const CampaignPlan& plan = result.work.plan();
  JsonWriter json;
  json.begin_object();
  write_plan(json, result);
  json.field("digest", result.summary.digest).field("leaks", result.summary.leaks).key("pitches").begin_array();
  for (const PitchMet& met : result.summary.pitches_met) {
    json.begin_object().field("algorithm", plan.algorithms[met.algorithm]);
    for (std::size_t i = 0; i < swept_count; ++i)
      if (met.at[i]) json.field(info_of(static_cast<Swept>(i)).key, plan.values[i][*met.at[i]]);
    write(json, "pitch", met.pitch);
    write(json, "low", met.low);
    write(json, "high", met.high);
    write(json, "worst_placement", met.worst);
    write(json, "limit", met.limit);
    json.end_object();
  }
  json.end_array().key("cells").begin_array();
  for (const CellMetrics& cell : result.summary.cells) write_cell(json, plan, cell);
  json.end_array().end_object();
  return json.take();
}

}  // namespace cosiva::experiments
