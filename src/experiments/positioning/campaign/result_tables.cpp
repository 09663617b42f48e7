#include "cosiva/experiments/positioning/campaign/result_tables.h"

#include <cmath>
#include <limits>

#include "cosiva/experiments/positioning/campaign/result_text.h"
#include "cosiva/experiments/runs/scenario/toml_entry.h"
#include "cosiva/zone/toml/toml_node.h"

namespace cosiva::experiments {
namespace {

using zone::toml_number;

using Kind = ResultTable::Column::Kind;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// The environment's factors, all of them: joins of tables need the same columns every time.
void add_factors(ResultTable& table, const CampaignPlan& plan,
                 const std::function<std::size_t(std::size_t)>& environment) {
  for (std::size_t i = 0; i < swept_count; ++i) {
    const auto swept = static_cast<Swept>(i);
    table.columns.push_back(
        {std::string(info_of(swept).key), Kind::number, [&plan, environment, swept](std::size_t row) {
           return TableValue{value_of(plan.environment(environment(row)), swept)};
         }});
  }
}

/// In a pitch's table a crossing is a number; beyond the swept pitches it is an open end: NULL.
double low_end(const Crossing& crossing) { return crossing.where == Crossing::Where::under ? nan : crossing.x; }

double number_of(const std::optional<Crossing>& crossing) {
  return crossing && crossing->where == Crossing::Where::at ? crossing->x : nan;
}

}  // namespace

ResultTable runs_table(const CampaignResult& result) {
  const CampaignPlan& plan = result.work.plan();
  const std::size_t algorithms = plan.algorithms.size();
  const std::size_t per_environment = plan.runs * algorithms;
  ResultTable table{"runs", {}, plan.votes()};
  const auto whole = [&](const char* name, const std::function<std::size_t(std::size_t)>& of) {
    table.columns.push_back(
        {name, Kind::whole, [of](std::size_t row) { return TableValue{static_cast<std::int64_t>(of(row))}; }});
  };
  const auto environment = [per_environment](std::size_t row) { return row / per_environment; };
  const auto run = [=](std::size_t row) { return row % per_environment / algorithms; };
  whole("cell", [=](std::size_t row) { return environment(row) * algorithms + row % algorithms + 1; });
  whole("run", [=](std::size_t row) { return run(row) + 1; });
  whole("seed", [run, seed = plan.seed](std::size_t row) { return seed + run(row); });
  add_factors(table, plan, environment);
  table.columns.push_back({"algorithm", Kind::text, [&plan, algorithms](std::size_t row) {
                             return TableValue{plan.algorithms[row % algorithms]};
                           }});
  const Votes votes{result.work, result.records};
  const auto number = [&](const char* name, double (*get)(const Vote&)) {
    table.columns.push_back({name, Kind::number, [=](std::size_t row) {
                               return TableValue{get(votes.of(environment(row), run(row), row % algorithms))};
                             }});
  };
  number("rmse_m", [](const Vote& vote) { return std::sqrt(vote.mse_m2); });
  number("limit_m", [](const Vote& vote) { return std::sqrt(vote.limit_m2); });
  number("mean_m", [](const Vote& vote) { return vote.mean_m; });
  number("p95_m", [](const Vote& vote) { return vote.p95_m; });
  number("max_m", [](const Vote& vote) { return vote.max_m; });
  number("precision_ratio", [](const Vote& vote) { return vote.precision; });
  number("covered95_ratio", [](const Vote& vote) { return vote.covered; });
  number("nees", [](const Vote& vote) { return vote.nees; });
  number("refused_readings", [](const Vote& vote) { return vote.refused; });
  return table;
}

ResultTable cells_table(const CampaignResult& result) {
  const CampaignPlan& plan = result.work.plan();
  const std::vector<CellMetrics>& cells = result.summary.cells;
  ResultTable table{"cells", {}, cells.size()};
  table.columns.push_back(
      {"cell", Kind::whole, [](std::size_t row) { return TableValue{static_cast<std::int64_t>(row + 1)}; }});
  add_factors(table, plan, [&cells](std::size_t row) { return cells[row].environment; });
  table.columns.push_back(
      {"algorithm", Kind::text, [&](std::size_t row) { return TableValue{plan.algorithms[cells[row].algorithm]}; }});
  const auto number = [&](const char* name, double (*get)(const CellMetrics&)) {
    table.columns.push_back(
        {name, Kind::number, [&cells, get](std::size_t row) { return TableValue{get(cells[row])}; }});
  };
  number("rmse_m", [](const CellMetrics& c) { return c.rmse_m.value; });
  number("rmse_low_m", [](const CellMetrics& c) { return c.rmse_m.interval ? c.rmse_m.interval->low : nan; });
  number("rmse_high_m", [](const CellMetrics& c) { return c.rmse_m.interval ? c.rmse_m.interval->high : nan; });
  number("limit_m", [](const CellMetrics& c) { return c.limit_m; });
  number("gap_percent", [](const CellMetrics& c) { return c.gap_percent; });
  number("mean_m", [](const CellMetrics& c) { return c.mean_m; });
  number("p95_m", [](const CellMetrics& c) { return c.p95_m.value; });
  number("p95_low_m", [](const CellMetrics& c) { return c.p95_m.interval ? c.p95_m.interval->low : nan; });
  number("p95_high_m", [](const CellMetrics& c) { return c.p95_m.interval ? c.p95_m.interval->high : nan; });
  number("max_m", [](const CellMetrics& c) { return c.max_m; });
  number("precision_ratio", [](const CellMetrics& c) { return c.precision; });
  number("covered95_ratio", [](const CellMetrics& c) { return c.covered; });
  number("nees", [](const CellMetrics& c) { return c.nees; });
  number("refused_readings", [](const CellMetrics& c) { return c.refused; });
  number("spacing_m", [](const CellMetrics& c) { return c.fiducials.spacing_m; });
  number("longest_unread_m", [](const CellMetrics& c) { return c.fiducials.longest_unread_m; });
  number("leak", [](const CellMetrics& c) { return c.leak ? 1.0 : 0.0; });
  return table;
}

ResultTable pitches_table(const CampaignResult& result) {
  const CampaignPlan& plan = result.work.plan();
  const std::vector<PitchMet>& met = result.summary.pitches_met;
  ResultTable table{"pitches", {}, met.size()};
  for (const Swept swept : {Swept::speed, Swept::odometry_noise, Swept::reading_noise, Swept::missed,
                            Swept::scale_error, Swept::survey_error}) {
    table.columns.push_back({std::string(info_of(swept).key), Kind::number, [&plan, &met, swept](std::size_t row) {
                               return TableValue{
                                   plan.of(swept)[met[row].at[static_cast<std::size_t>(swept)].value_or(0)]};
                             }});
  }
  table.columns.push_back(
      {"algorithm", Kind::text, [&](std::size_t row) { return TableValue{plan.algorithms[met[row].algorithm]}; }});
  table.columns.push_back({"tolerance_m", Kind::number, [&plan](std::size_t) { return TableValue{plan.tolerance_m}; }});
  const auto number = [&](const char* name, double (*get)(const PitchMet&)) {
    table.columns.push_back({name, Kind::number, [&met, get](std::size_t row) { return TableValue{get(met[row])}; }});
  };
  number("pitch_m", [](const PitchMet& m) { return number_of(m.pitch); });
  number("pitch_low_m", [](const PitchMet& m) { return number_of(m.low); });
  number("pitch_high_m", [](const PitchMet& m) { return number_of(m.high); });
  number("pitch_at_least_m", [](const PitchMet& m) { return low_end(m.pitch); });
  number("worst_placement_pitch_m", [](const PitchMet& m) { return number_of(m.worst); });
  number("limit_pitch_m", [](const PitchMet& m) { return number_of(m.limit); });
  return table;
}

ResultTable campaign_table(const CampaignResult& result) {
  const CampaignPlan& plan = result.work.plan();
  std::vector<std::pair<std::string, std::string>> rows{
      {"name", plan.name},
      {"zone", result.work.ground().zone->name},
      {"runs", std::to_string(plan.runs)},
      {"seed", std::to_string(plan.seed)},
      {"distance_m", toml_number(plan.distance_m)},
      {"rate_hz", toml_number(plan.rate_hz)},
      {"fiducials", plan.fiducials == Fiducials::grid ? "grid" : "line"},
      {"reach_m", toml_number(plan.reach_m)},
      {"threshold_m", toml_number(plan.threshold_m)},
      {"tolerance_m", toml_number(plan.tolerance_m)},
      {"tolerance_of", plan.evaluated == EvaluatedQuantity::p95 ? "p95" : "rmse"},
      {"digest", result.summary.digest},
  };
  ResultTable table{"campaign", {}, rows.size()};
  table.columns.push_back({"key", Kind::text, [rows](std::size_t row) { return TableValue{rows[row].first}; }});
  table.columns.push_back({"value", Kind::text, [rows](std::size_t row) { return TableValue{rows[row].second}; }});
  return table;
}

}  // namespace cosiva::experiments
