#include "cosiva/experiments/agents/rule_search_report.h"

#include <utility>

#include "cosiva/experiments/agents/fixed_text.h"
#include "cosiva/experiments/reporting/chart.h"
#include "cosiva/experiments/reporting/report.h"

namespace cosiva::experiments {
namespace {

std::vector<std::string> row_of(const std::string& name, const TrainingCase& one) {
  return {name,
          std::to_string(one.vehicles),
          std::to_string(one.persons),
          fixed_text(one.laps_ratio, 3),
          fixed_text(one.stops_ratio, 3),
          fixed_text(one.energy_ratio, 3)};
}

Chart cost_chart(const SearchResult& result) {
  Series all;
  all.name = "candidates";
  all.form = Series::Form::points;
  Series best;
  best.name = "lowest";
  best.form = Series::Form::steps;
  double lowest = result.candidates.front().cost;
  for (const RuleCandidate& candidate : result.candidates) {
    if (candidate.accepted) lowest = candidate.cost;
    all.x.push_back(candidate.number);
    all.y.push_back(candidate.cost);
    best.x.push_back(candidate.number);
    best.y.push_back(lowest);
  }
  Chart chart;
  chart.x.label = "candidate";
  chart.y.label = "cost";
  chart.series = {std::move(all), std::move(best)};
  return chart;
}

}  // namespace

void write_json(JsonWriter& json, const SearchPlan& plan, const SearchResult& result) {
  json.begin_object().field("zone", plan.rtm->zone().name).field("origin", plan.origin);
  json.field("minutes", to_seconds(plan.duration) / 60.0).field("first_seed", plan.first_seed);
  json.field("last_seed", plan.last_seed).field("seed", plan.seed).field("budget", plan.budget);
  json.field("offspring", plan.offspring).field("refused", result.refused);
  json.field("best", result.candidates[result.best].number).key("knots").begin_array();
  for (std::size_t k = 0; k < result.knots.size(); ++k) {
    json.begin_object().field("variable", result.knots[k].variable).field("initial", result.knots[k].value);
    json.field("best", result.candidates[result.best].values[k]).end_object();
  }
  json.end_array().key("candidates").begin_array();
  for (const RuleCandidate& candidate : result.candidates) {
    json.begin_object().field("number", candidate.number).field("cost", candidate.cost);
    json.field("accepted", candidate.accepted).key("values").begin_array();
    for (const double value : candidate.values) json.value(value);
    json.end_array().key("cases").begin_array();
    for (const TrainingCase& one : candidate.cases) {
      json.begin_object().field("vehicles", one.vehicles).field("persons", one.persons);
      json.field("laps", one.laps_ratio).field("stops", one.stops_ratio);
      json.field("energy_per_lap", one.energy_ratio).end_object();
    }
    json.end_array().end_object();
  }
  json.end_array().end_object();
}

std::string to_html(const SearchPlan& plan, const SearchResult& result, const std::string& command) {
  const RuleCandidate& initial = result.candidates.front();
  const RuleCandidate& best = result.candidates[result.best];
  Report report{"Search for better rules of the agents", plan.origin + " on " + plan.rtm->zone().name};
  report.metadata({{fixed_text(initial.cost, 3), "cost of the initial rules"},
                   {fixed_text(best.cost, 3), "cost of the best rules"},
                   {std::to_string(result.candidates.size() - 1), "candidates run"}});
  report.paragraph(
      "The cost is the mean over the cases of the ratio of stops to those of the crisp rules with the same seeds, half "
      "of the ratio of energy per lap, and twenty times the laps that are missing to half a percent more than theirs.");
  std::vector<std::vector<std::string>> rows;
  for (const TrainingCase& one : initial.cases) rows.push_back(row_of("initial", one));
  for (const TrainingCase& one : best.cases) rows.push_back(row_of("best", one));
  report.heading("Training cases, relative to the crisp rules");
  report.table({"rules", "vehicles", "persons", "laps", "stops", "energy per lap"}, rows);
  report.figure(to_svg(cost_chart(result)), "Cost of each candidate, and the lowest so far.");
  report.heading("Numbers of the rules");
  rows.clear();
  for (std::size_t k = 0; k < result.knots.size(); ++k)
    rows.push_back({result.knots[k].variable, fixed_text(initial.values[k], 2), fixed_text(best.values[k], 2)});
  report.table({"variable", "initial", "best"}, rows);
  report.heading("Repeat");
  report.verbatim(command);
  return report.html();
}

}  // namespace cosiva::experiments
