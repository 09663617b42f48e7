#include "cosiva/experiments/positioning/campaign/result_text.h"

#include <algorithm>

#include "cosiva/experiments/reporting/chart.h"

namespace cosiva::experiments {
namespace {

std::string mm(double metres) { return readable(1e3 * metres, 2); }

std::string padded(std::string text, std::size_t width) {
  text.resize(std::max(width, text.size() + 1), ' ');
  return text;
}

/// Largest number of lines of a terminal's table; files contain all lines.
constexpr std::size_t lines_max = 24;

std::string pitches_text(const CampaignPlan& plan, const std::vector<PitchMet>& all) {
  if (all.empty()) return {};
  std::string text = "  pitch at which " +
                     std::string(plan.evaluated == EvaluatedQuantity::p95 ? "95 % of errors stay" : "rmse stays") +
                     " within " + mm(plan.tolerance_m) + " mm:\n";
  for (std::size_t i = 0; i < std::min(all.size(), lines_max); ++i) {
    const PitchMet& met = all[i];
    text += "    " + padded(plan.algorithms[met.algorithm], 18) + to_string(met.pitch) + " m";
    if (met.low && met.high) text += " (" + to_string(*met.low) + " … " + to_string(*met.high) + ")";
    if (met.limit) text += ", limit " + to_string(*met.limit) + " m";
    if (plan.fiducials == Fiducials::grid) text += ", worst placement " + to_string(met.worst) + " m";
    if (const std::string at = to_string(plan, met.at); !at.empty()) text += "; " + at;
    text += "\n";
  }
  if (all.size() > lines_max) text += "    and " + std::to_string(all.size() - lines_max) + " more in the files\n";
  return text;
}

std::string cells_text(const CampaignPlan& plan, const std::vector<CellMetrics>& cells) {
  std::string text = "  rmse [mm] (95 %), limit:\n";
  for (std::size_t i = 0; i < std::min(cells.size(), lines_max); ++i) {
    const CellMetrics& cell = cells[i];
    std::string rmse = mm(cell.rmse_m.value);
    if (cell.rmse_m.interval) rmse += " (" + mm(cell.rmse_m.interval->low) + "–" + mm(cell.rmse_m.interval->high) + ")";
    text += "    " + padded(plan.algorithms[cell.algorithm], 18) + padded(rmse, 24) + padded(mm(cell.limit_m), 9) +
            to_string(plan, plan.environment(cell.environment)) + (cell.leak ? "  LEAK" : "") + "\n";
  }
  if (cells.size() > lines_max) text += "    and " + std::to_string(cells.size() - lines_max) + " more in the files\n";
  return text;
}

}  // namespace

std::string to_string(const Crossing& crossing) {
  std::string at = readable(crossing.x, 3);
  switch (crossing.where) {
    case Crossing::Where::at: return at;
    case Crossing::Where::under: return "under " + at;
    case Crossing::Where::over: return "over " + at;
  }
  return at;
}

std::string to_string(const CampaignPlan& plan, const Selection& selection) {
  std::string text;
  for (const Swept swept : plan.swept()) {
    const auto which = selection[static_cast<std::size_t>(swept)];
    if (!which) continue;
    text.append(text.empty() ? "" : ", ").append(info_of(swept).key).append(" = ");
    text += readable(plan.of(swept)[*which], 6);
  }
  return text;
}

std::string to_text(const CampaignResult& result) {
  const CampaignPlan& plan = result.work.plan();
  std::string text = plan.name + ": " + std::to_string(plan.cells()) + " cells, " + std::to_string(plan.runs) +
                     " runs each of " + readable(plan.distance_m, 1) + " m\n";
  text += cells_text(plan, result.summary.cells);
  text += pitches_text(plan, result.summary.pitches_met);
  if (result.summary.leaks > 0)
    text += "  " + std::to_string(result.summary.leaks) +
            " cells are below the limit: an algorithm uses information that it cannot have, or the limit is wrong\n";
  return text + "  digest " + result.summary.digest + "\n";
}

}  // namespace cosiva::experiments
