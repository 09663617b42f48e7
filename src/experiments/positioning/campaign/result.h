#pragma once

#include <string>
#include <vector>

#include "cosiva/experiments/positioning/campaign/summary.h"
#include "cosiva/experiments/positioning/campaign/table.h"

/// A campaign as others read it. No time, machine or number of processes is in it: the same plan gives the same files.
namespace cosiva::experiments {

struct CampaignResult {
  const CampaignWork& work;
  const std::vector<UnitRecord>& records;
  const CampaignSummary& summary;
};

/// A row per run and algorithm: factors, algorithm, seed, rmse_m, … What it refers to outlives it.
[[nodiscard]] Table runs_table(const CampaignResult& result);
/// A row per cell.
[[nodiscard]] Table cells_table(const CampaignResult& result);
/// A row per algorithm and surrounding: the widest pitch that meets the tolerance.
[[nodiscard]] Table pitches_table(const CampaignResult& result);
/// key, value: the plan.
[[nodiscard]] Table campaign_table(const CampaignResult& result);

/// One JSON document: `plan`, `cells[]`, `pitches[]`, `leaks`, `digest`.
[[nodiscard]] std::string to_json(const CampaignResult& result);
/// A few lines for a terminal.
[[nodiscard]] std::string to_text(const CampaignResult& result);
/// One HTML page that needs nothing else.
/// @param plan_text  as it was read, to be shown
[[nodiscard]] std::string to_html(const CampaignResult& result, const std::string& plan_text);

/// "2.61", "under 0.1", "over 4": metres of pitch.
[[nodiscard]] std::string to_string(const Crossing& crossing);
/// Of a selection the factors that the plan sweeps: "missed_share = 0.3"; empty where it leaves all open.
[[nodiscard]] std::string to_string(const CampaignPlan& plan, const Selection& selection);

}  // namespace cosiva::experiments
